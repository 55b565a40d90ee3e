"""Levels that decide how marks are tracked: what is the same mark, what is covered, what is ambiguous, what has converged.

Where a level was measured, the script and the figures are named; the others are conventions or bounds that hold with a
wide margin on the films of `tests/benchmarks`.
"""

from __future__ import annotations

BLUR_PX = 0.6
"""Standard deviation of the blur before interpolation. Measured by bench_tracking.py on fine speckle: at 0.8 px the error is
1.14 times the Cramer-Rao bound, at 0.6 px 1.05 times, with the same bias."""

SETTLED_PX = 2e-3
"""Step of Gauss-Newton, at the farthest pixel, from which it has converged: below the bound of any mark here (0.003 px)."""

LEAST_ZNCC = 0.80
"""Correlation below which two images are not of the same mark."""

NOTHING_LEFT = 0.3
"""Correlation below which nothing of the mark is left at a place."""

DISTINCT = 0.93
"""Share of the best correlation from which another place looks like the mark."""

MOST_HIDDEN = 0.25
"""Share of a subset that may be covered before the mark counts as occluded."""

HARDLY_HIDDEN = 0.02
"""Share of a subset that may be covered while its present look still serves for the search."""

UNEXPLAINED = 0.02
"""Share of the variance that the reference image may leave unexplained in a mark that is found again: a ZNCC of 0.99."""

UNEVEN_LIGHT = 3.0
"""Times white noise that light changing across the mark must explain; a few per cent of frames with even light exceed it at random."""

STRANGE = 10.0
"""Times the expected noise that may remain under robust weights; more is another picture, of which a few pixels agree."""

MOST_BENT = 0.05
"""Share of the variance beyond which what the bending images explain is not a bent motion of the same mark."""

TUKEY = 4.685
"""Distance in standard deviations at which a pixel loses all weight: 95 % efficiency on normal noise (Huber, Robust Statistics)."""

TEXTURE_OVER_NOISE = 2.0
"""Times the slopes of noise that the texture's slopes must reach to determine a direction of the warp."""

TEXTURE_SHARE = 0.03
"""Share of what the texture's slopes give along a shift that they must give to determine another direction of the warp. The
pixels' steps along the edge of a dot that should not determine its rotation give 0.005; quadrants give 0.011 along their edges."""

LEAST_BLUR_PX = 0.75
"""Motion during the exposure that still looks like rest."""

LONGEST_BLUR_PX = 24.0
"""Motion during the exposure that is modelled at most."""

REST_SIGMAS = 2.0
"""Standard deviations that the marks, all together, may have moved while the platform counts as at rest."""
