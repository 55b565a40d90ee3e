"""Pages of the reference that are written from the code whenever the documentation is built."""
