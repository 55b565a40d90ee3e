"""What explains what was seen."""
