"""A model as plain data: base quantities, effects, responses."""
