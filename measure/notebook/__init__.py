"""Results in a notebook: how they show themselves, and progress."""
