"""What a sweep may be, and how far it goes."""

DESIGNS = ("full", "fractional", "latin-hypercube", "sobol", "random")
INDICES = ("sobol", "morris")
FEWEST_RARE = 100  # runs a level of a subset simulation
FAILURE_DEG = 30.0  # the paper's failure: a run that turns farther about the vertical
FARTHEST = 6.0  # standard deviations; a normal spread ends there
MOST_FULL_FACTORS = 20  # of a full factorial design, a million runs
