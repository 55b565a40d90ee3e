"""What a model would do."""
