"""Every level that decides something, with its derivation, the calibration run that set it, or the reason in words."""

from __future__ import annotations

# ---------------------------------------------------------------- estimation: parameters and their priors

WEAK_PRIOR = 4.0
"""Standard deviations, in scales, of the force law where films alone are there: a tenth to a fifth of the law each. It keeps a law that a
film hardly tells the kind of spring that the model file has, and is too wide to bias one that it tells."""

CAMERA_DISTANCE_M = 2.0
"""A release nearer to the camera by its spread makes every length of the film longer by spread over distance. The distance of a camera that
sees a rig of half a metre whole with a usual lens; a film's own scale is a nuisance parameter, so that only its prior follows from this."""

FARTHEST_OFF_ZERO = 0.05
"""Of a loop's largest force: one standard deviation of what a load cell that was set to zero anew is off by. A larger one is a fault."""

# ---------------------------------------------------------------- estimation: what a fit is worth

OWN_SHARE = 0.02
"""Share of a parameter's signature that no other parameter can imitate, below which it is not identifiable: its standard error is fifty
times that which it would have alone, so that a fiftieth of the law's own error decides its value."""

INERTIA_APART = 0.1
"""Share of the acceleration that no slope of the force can imitate, below which an inertia is not told from one: the acceleration comes
from the elongation, whose error of a few per cent would be the inertia."""

ON_ASYMPTOTE = 3.0
"""Lengths 1 / beta after which the force is on its asymptote, exp(-3) = 5 %."""

OPEN_BETA = 3.0
"""Of log beta, a factor of twenty: where a beta so far off fits nearly as well, within three standard deviations, beta is open."""

BETA_PARABOLA = 0.15, 1.0
"""Standard deviations of log beta: below the first the sum of squares is near enough a parabola, above the second beta is open anyway."""

TWO_SIDED_95 = 1.96
"""Standard deviations to either end of a 95 % interval of a normal distribution."""

CHI2_95 = 3.841
"""95 % quantile of chi squared with one degree of freedom."""

ZEROS_DIFFER = 3.0
"""Standard errors, root mean square over the loops, from which on their zeros differ: by chance once in a thousand for two loops."""

# ---------------------------------------------------------------- actuator

SAME_STROKE = 0.05
"""Relative difference of amplitudes that count as one: shakers reach what they are told to a few per cent."""

SAME_RATE = 0.02
"""Relative difference of frequencies that count as one: a clock is right to far less, a period read from few samples is not."""

WORTH_AN_ORDER = 0.03
"""Relative gain of the error on frequencies left out that justifies one order more: what a few loops' noise makes of it by chance."""

STRUCTURED_ERROR, STRUCTURED_SHARE = 0.05, 0.4
"""Error in parts of the force range, and share of it that one quantity explains, above which an effect is missing."""

LARGEST_ERROR = 0.10
"""RMS error in parts of the force range above which the law has another shape than the loop: a sine laid over a rectangle has a quarter."""

NO_AREA = 10.0, 0.005
"""A loop encloses nothing where its height, area over stroke, is below ten sigma / sqrt(n) (four standard errors of 2.2 sigma / sqrt(n)
and some) and below a two-hundredth of the force range."""

OTHER_RATE, STIFFNESS_CHANGE = 1.2, 0.10
"""Ratio of frequencies from which on friction is judged, and relative change of the effective stiffness over them that matters."""
