"""A measured loop made ready: differentiation, segments, sign, covariates."""
