"""What goes on while a command runs: how it is stopped, and how long it will take."""
