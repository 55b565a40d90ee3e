"""Which further test would tell rivals apart."""
