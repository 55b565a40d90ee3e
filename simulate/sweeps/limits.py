"""How far a sweep goes."""

FARTHEST = 6.0  # standard deviations; a normal spread ends there
MOST_FULL_FACTORS = 20  # of a full factorial design, a million runs
