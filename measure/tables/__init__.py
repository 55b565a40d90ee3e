"""The tables that everybody exchanges, their units and their CSV files."""
