"""Pages of a film that are looked at in a browser: one for choosing by eye, one with the result."""
