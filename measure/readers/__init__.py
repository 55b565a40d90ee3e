"""A laboratory's loop file to columns of numbers."""
