"""One file for each kind of film file."""
