"""The model file, values set by name, and effects from a file of the user."""
