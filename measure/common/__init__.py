"""Errors, the command line, output, limits: what all rooms of measure use."""
