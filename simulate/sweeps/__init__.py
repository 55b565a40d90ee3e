"""Many deployments of one model: designs, factors, regression, tolerances."""
