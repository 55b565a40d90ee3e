"""Geometry, stops, law and tolerances chosen by optimisation on the batch kernel."""
