"""Footage, marks and geometry to the platform's trajectory, and what is shown of it."""
