"""Whether what a fit leaves is more than noise: its slow parts against its fast ones."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft, stats

from identify.criteria import FAST_NOISE
from identify.estimation.fit import Fit
from measure.common.arrays import Array

GAP_P = 1e-3  # less likely than this as noise: a gap
_LOW_SHARE = 0.25
_LEAST_SAMPLES = 16
_LEAST_FLOAT = 1e-300
_LEAST_NOISE = 0.1  # of the noise that a measurement is taken to have


@dataclass(frozen=True)
class GapTest:
    """Whether what is left is more than noise: probabilities of as much if it were noise.

    slow_p : slow parts of the gap against its fast parts (F test). release_p : the releases against their priors (chi^2).
    excess : sum of squares of the slow parts beyond what the fast ones say that noise has.
    """

    slow_p: float
    release_p: float
    rms_over_noise: float
    excess: float

    @property
    def p_value(self) -> float:
        """The smaller one, both having been looked at."""
        return float(min(1.0, 2.0 * min(self.slow_p, self.release_p)))


def p_words(value: float) -> str:
    """A probability as people read it; one too small for a float is not called nought."""
    return f"p = {value:.2g}" if value >= _LEAST_FLOAT else f"p < {_LEAST_FLOAT:.0e}"


def gap_test(fit: Fit) -> GapTest:
    """Test a fit for a gap beyond noise.

    White noise shakes every frequency alike, a missing effect moves the slow ones. The gap of each run and channel is taken apart by a
    cosine transform; the power of the slow quarter, for each degree of freedom that the fit has left, is compared with that of the rest. A
    noise level is hardly assumed, so a sigma that is off cannot fake a gap; only what lies below a tenth of the noise is none, whatever its
    course.
    """
    powers = [power for block in fit.problem.blocks if (power := power_of(fit.part(block))) is not None]
    slow, fast = sum(power.slow for power in powers), sum(power.fast for power in powers)
    slow_n, fast_n = sum(power.slow_n for power in powers), sum(power.fast_n for power in powers)
    freedom = max(slow_n - len(fit.q), 1)
    noise = max(fast / max(fast_n, 1), _LEAST_NOISE**2)
    slow_p = float(stats.f.sf(slow / freedom / noise, freedom, fast_n)) if fast_n else 1.0
    excess = max(0.0, slow - freedom * noise) if fast_n else 0.0
    return GapTest(slow_p, _release_p(fit), fit.rms, excess)


@dataclass(frozen=True)
class Power:
    """Sum of squares of the slow and of the fast part of a series, and how many coefficients each has."""

    slow: float
    fast: float
    slow_n: int
    fast_n: int

    @property
    def ratio(self) -> float:
        """Slow power over fast power, one where the series is white."""
        return (self.slow / self.slow_n) / max(self.fast / self.fast_n, 1e-300)

    @property
    def p_value(self) -> float:
        """How likely as much is, were the series white (F test)."""
        return float(stats.f.sf(self.ratio, self.slow_n, self.fast_n))


def power_of(series: Array) -> Power | None:
    """The slow quarter against the rest of a series (n,), or None of one that is too short to tell."""
    if len(series) < _LEAST_SAMPLES:
        return None
    power = np.asarray(fft.dct(series, norm="ortho")) ** 2
    cut = max(4, int(_LOW_SHARE * len(series)))
    return Power(float(power[:cut].sum()), float(power[cut:].sum()), cut, len(series) - cut)


def is_noise(innovations: Sequence[Array]) -> bool:
    """Whether what is left of each channel, whitened, is noise: no slow part stands out by chance and by its size."""
    powers = [power for series in innovations if (power := power_of(series)) is not None]
    return not any(power.p_value < GAP_P and power.ratio > FAST_NOISE**2 for power in powers)


def _release_p(fit: Fit) -> float:
    """How likely releases as far from the planned one are, if they follow their priors."""
    problem = fit.problem
    q = fit.q[problem.first_nuisance : problem.first_zero]
    return float(stats.chi2.sf(q @ q, len(q))) if len(q) else 1.0
