"""Formats other than text, one module each: vectors of numbers out of a file, and the process in which risky libraries read it."""
