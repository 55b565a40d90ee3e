"""One colour for each status of a mark, in the overlaid film and in the figures."""

from __future__ import annotations

from measure.correlation.marks import AMBIGUOUS, LOST, MISSING, OCCLUDED, OK, OUT

STATUS_COLOURS = {OK: "#1b9e77", OCCLUDED: "#d95f02", LOST: "#e7298a", AMBIGUOUS: "#7570b3", OUT: "#666666", MISSING: "#999999"}

RESIDUAL_COLOUR = "#e6ab02"

ENLARGED = 1000
"""Times by which the residual of a mark is drawn larger than it is; it would not be visible otherwise."""
