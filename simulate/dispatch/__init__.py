"""Formulas of effects as addresses that compiled kernels call."""
