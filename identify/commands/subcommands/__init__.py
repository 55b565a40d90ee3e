"""What `unspool` does, one task a file: `main` takes the words behind the task's name and returns the exit status."""
