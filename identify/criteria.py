"""Every level that decides something, with its derivation, the calibration run that set it, or the reason in words."""

from __future__ import annotations

# ---------------------------------------------------------------- estimation: parameters and their priors

WEAK_PRIOR = 2.0
"""Standard deviations, in scales, of the force law where films alone are there: a tenth of its forces each. It keeps a law that a film
hardly tells the kind of spring that the model file has; twice as wide, a base bends so far that it hides an effect."""

FORCES_DIFFER = 6.0
"""Tolerances of [nuisance], one standard deviation of the stored force of a run where forces may differ: 3 % by default."""

CAMERA_DISTANCE_M = 2.0
"""A release nearer to the camera by its spread makes every length of the film longer by spread over distance. The distance of a camera that
sees a rig of half a metre whole with a usual lens; a film's own scale is a nuisance parameter, so that only its prior follows from this."""

FARTHEST_OFF_ZERO = 0.05
"""Of a loop's largest force: one standard deviation of what a load cell that was set to zero anew is off by. A larger one is a fault."""

# ---------------------------------------------------------------- estimation: when a fit ends

ENOUGH, ROUGHLY = 0.05, 1.0
"""Fall of the sum of squares, in units of the noise squared, at which a fit stops: a fifth of a standard error of one parameter, and one
standard error where fits are only compared."""

NEAR = 50.0
"""Sums of squares, in the same unit, or log evidence, so close that either of two fits may be the better one when taken to its end."""

CLOSE = 1.5
"""Root mean square of the gap over the noise below which straight lines lead where they say, and a fit is worth being taken to its end."""

HARDLY, TO_COMPARE = 0.5, 10
"""Log probability that a step must bring for a place not to be settled, and steps after which places can be compared with each other."""

SAME = 0.03
"""Change of a log likelihood at which rounds end that estimate noise and parameters in turn: a hundredth of what decides anything."""

DEGREES = 5.0
"""Degrees of freedom of Student's t for the noise: heavy enough for one outlier in a hundred, and finite in its fourth moment nearly."""

EFFECT_SPREAD, STATED_SPREAD = 10.0, 100.0
"""Prior of an effect's parameter, one standard deviation in noticeable sizes; of a surely larger one its size, see `as_wide`. The second
is for numbers that are stated: so wide that it hardly moves them."""

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

ANYWHERE = 1e4
"""Standard deviations, in its scale, of a loop's zero or another parameter that nothing tells beforehand: wide enough to say nothing."""

ZEROS_DIFFER = 3.0
"""Standard errors, root mean square over the loops, from which on their zeros differ: by chance once in a thousand for two loops."""

# ---------------------------------------------------------------- loops: faults of a channel

BY_CHANCE = 1e-6
"""How often a sound channel may be called faulty: once in a million, for a campaign has hundreds of files and each several tests."""

NO_NOISE = 1e-5
"""Noise in parts of a channel's range below which a record comes from a simulation, not from a converter of 16 bits, 1.5e-5."""

MAINS_HZ = 50.0, 60.0
"""Frequencies of the mains."""

HUM_ABOVE_NOISE = 25.0
"""Power of a line over the median of the power beside it. For white noise the power is exponential, so a line of one frequency exceeds
25 medians once in 2^25 = 3e7 times; some tens of frequencies are looked at, which makes BY_CHANCE."""

HUM_ABOVE_LINES = 4.0
"""Power of a line of the mains over that of the largest line beside it: the loop's own harmonics fall off slowly, and two neighbours differ
by far less than by a factor of two in amplitude."""

SPIKE = 6.0
"""Standard deviations of the noise by which one sample jumps from both neighbours: by chance once in 2e6 samples, sqrt(1.5) sigma each."""

MOST_SPIKES = 0.01
"""Share of the samples up to which spikes are left out. More of them are a property of the record; it wants a robust fit."""

STANDS_STILL = 4.0
"""Standard deviations of the elongation's noise within which a drive stands still: one sample in 16 000 is farther off."""

BENT_DWELL = 30.0
"""Sum of squares, in units of the noise, that a parabola takes from a level stretch: chi squared with two degrees exceeds 28 once in
BY_CHANCE."""

LEAST_STEPS = 2.5
"""Steps of a converter in a loop's height, below which a law of five parameters is not seen: each step that a branch crosses gives one
place, two branches cross twice as many, and five places are needed."""

COARSE_STEP = 0.5
"""Step of a channel in its noise from which on rounding is no longer white noise: below, the noise carries every value to several steps."""

SAME_UNIT = 3.0
"""Factor around 1000 within which the strokes of two files differ by a unit and not by design."""

LONGEST_STROKE_M = 10.0
"""No shaker moves farther; a longer stroke has most likely another unit."""

# ---------------------------------------------------------------- actuator

SAME_STROKE = 0.05
"""Relative difference of amplitudes that count as one: shakers reach what they are told to a few per cent."""

SAME_RATE = 0.02
"""Relative difference of frequencies that count as one: a clock is right to far less, a period read from few samples is not."""

WORTH_AN_ORDER = 0.03
"""Relative gain of the error on frequencies left out that justifies one order more: what a few loops' noise makes of it by chance."""

LARGEST_MISFIT = 1.0 / 3.0
"""Misfit, root mean square of what comes again in every cycle, in parts of half a loop's height, above which the law has another shape than
the loop: it leaves more than a ninth of the variance that the hysteresis makes. An ellipse laid over a rectangle leaves 0.47."""

STRUCTURED_MISFIT, STRUCTURED_SHARE = 0.1, 0.4
"""Misfit in the same parts, and share of the residual that one quantity explains, above which an effect is missing: a hundredth of the
variance, and most of it by one cause."""

SLIGHT_MISFIT = 0.01
"""Misfit below which a law is called right as far as it goes: load cells and gauges are linear to a hundredth of a loop's half height."""

LOUD = 0.1
"""Noise of a sample in parts of a loop's height from which on it is named: as large as the misfit that would be a missing effect."""

SURE_MISFIT = 4.0
"""Standard deviations of noise from which on a misfit is one: by chance once in 30 000 fits, and in 1000 for its longer tail."""

SURE_EFFECT = 0.01
"""How often an effect may be named that is not there, all that are tried taken together."""

DISAGREE = 1e-3
"""How often loops that agree may be said to differ in a quantity; three are tested, with a covariance that is itself an estimate."""

MOVES = 1.0
"""Standard errors by which an effect that is there may move a number without that being said: its interval holds as well then."""

NO_AREA = 10.0, 0.005
"""A loop encloses nothing where its height, area over stroke, is below ten sigma / sqrt(n) (four standard errors of 2.2 sigma / sqrt(n)
and some) and below a two-hundredth of the force range."""

OTHER_RATE, STIFFNESS_CHANGE = 1.2, 0.10
"""Ratio of frequencies from which on friction is judged, and relative change of the effective stiffness over them that matters."""

STRAIGHT_FROM = 0.5
"""Part of a stroke behind which a branch is taken for straight, in the paper's recipe by eye."""

# ---------------------------------------------------------------- gap

GAP_P = 1e-3
"""Less likely than this as noise is called a gap, if no other local minimum closes it: a model is compared more often than it is wrong."""

UNUSUAL_P = 0.05
"""The usual level of a test: a base, releases and errors of the model file that are less likely are looked for elsewhere, too."""

DRAGGED = 10.0
"""Standard deviations of what is known beforehand beyond which a fit that moved a release or a law has met another rig, table or clock: by
chance never, and by an effect that is missing seldom."""

LAW_LOST = 0.5
"""Standard error of a number of the law, in parts of what the model file has, from which on a fit knows it worse than the file does."""

CLEAR_LEAD = 3.0
"""Log evidence, one to twenty, from which on one variable says better than another what a force goes with."""

# ---------------------------------------------------------------- selection: probabilities

CREDIBLE = 0.95
"""The smallest set of hypotheses that holds so much of the probability is what may be said; the usual level of an interval."""

EQUAL = 0.9
"""Part of the largest probability from which on two hypotheses count as equally probable: a tenth of a unit of log evidence."""

NOTHING, WITHIN = 0.5, 0.1
"""Prior probability that nothing is missing, and that the model file is wrong by no more than its tolerances."""

WRONG_DRAWING = 0.15
"""Prior probability that something of the model file is wrong by more than its tolerance, all kinds together."""

LOSES = 3.0
"""Log evidence below the best first look, or below nothing, from which on a hypothesis is not looked at more closely."""

SLIGHT = 2.0
"""Tolerances, root mean square over the parameters that show, up to which an error of the model file is no finding but stands with what was
moved within them: a tolerance is itself known to a factor of two at best."""

NO_WORSE = 1.02
"""Times the gap of a run that was held out, up to which names do not make it worse: its simulation and release are exact to a percent."""

NOISE_AGAIN = 2.0**0.5
"""Root mean square over the noise above which a run held out is left with more than noise: the gap beside the noise is as large as it."""

UNNAMED = 0.02
"""Prior probability of a force that no catalogue holds, all tables together."""

ANOTHER = 0.25
"""Prior probability of a second name beside a first one; of a third beside a second."""

FAST_NOISE = 2.0
"""Slow part of what is left of a channel, whitened, over its fast part, above which it is no noise. A gap as large as the noise beside it
makes sqrt(2); a memory of 0.95, where 0.85 is the most that the noise model has, makes 1.4, and 2.1 in the slowest twentieth."""

LARGER_PART = 0.5
"""Share of the gap that names must close to be mentioned where something else is left beside them."""

FARTHEST_SPREADS = 3.0
"""Standard deviations of their prior, root mean square over the parameters of an effect, beyond which an estimate contradicts it: one is
expected, and three of a single parameter happen once in 370 times."""

HALF = 0.5
"""Share of what is left beyond the noise below which a further name, or zeros of the loops' own, must bring it for more to be looked for:
where nothing halves the gap the missing physics is none of the catalogue."""

FEW_PARAMETERS = 3
"""An effect with more parameters than this is never named alone from films alone: six legs can push the platform any way there is."""

# ---------------------------------------------------------------- design: further tests

RIVAL_P = 0.01
"""A further test excludes a rival whose truth would let the lead be so long this rarely."""

STRONG_BIC = 10.0
"""A lead in the sum of squares from which evidence counts as very strong (Kass and Raftery 1995, table 1)."""

LIKELY = 0.8
"""A test that splits off a rival less often than this is not worth being recommended: the usual power of a design."""
