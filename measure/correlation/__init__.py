"""Digital image correlation: where each mark is in each picture."""
