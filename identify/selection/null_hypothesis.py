"""What chance alone would do: noise like the one that is left, sent through the same decisions again.

A parametric bootstrap of the procedure in its local, linear form: around a fit the gaps follow the parameters in straight lines, so
a fit to redrawn noise is a projection, and thousands of them cost less than one simulation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import fft, stats

from identify.estimation.fit import Fit
from identify.selection.gap_test import Signature
from measure.common.arrays import Array

DRAWS, LIKENESS_DRAWS, SEED = 500, 20000, 2009
_FASTER_HALF = 0.5
_SHOWN = 1e-2  # of the best seen combination of columns: what shows less is not told from a straight line's own error


def noise_like(fit: Fit, draws: int = DRAWS, seed: int = SEED) -> Array:
    """Redrawn noise, (m, draws), with the power that a fit's gap has left in each octave of frequency; priors get their own spread.

    Gaussian coefficients of a cosine transform, run by run and channel by channel. What the fit took from the slow octaves
    is put back: none of them gets less than the faster half has, for noise is seldom quieter there.
    """
    chance = np.random.default_rng(seed)
    drawn = chance.normal(size=(len(fit.gaps), draws))
    for block in fit.problem.blocks:
        part = fit.part(block)
        drawn[block.rows] = np.asarray(fft.idct(_octave_sizes(part)[:, None] * drawn[block.rows], norm="ortho", axis=0))
    return drawn


def _octave_sizes(part: Array) -> Array:
    """Standard deviation of each coefficient of the cosine transform, (n,), the same within an octave."""
    n = len(part)
    power = np.asarray(fft.dct(part, norm="ortho")) ** 2
    sizes = np.empty(n)
    floor = float(power[int(_FASTER_HALF * n) :].mean()) if n > 1 else 1.0
    end = n
    while end > 0:
        start = end // 2 if end > 4 else 0
        sizes[start:end] = max(float(power[start:end].mean()), floor)
        end = start
    return np.sqrt(sizes)


def gained_by(columns: Array, noise: Array) -> Array:
    """How much columns that are free of the rest take off the sum of squares of each noise vector, (draws,)."""
    norms = np.linalg.norm(columns, axis=0)
    if not np.any(norms > 0):
        return np.zeros(noise.shape[1])
    left, sizes, _ = np.linalg.svd(columns[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return np.sum((left[:, sizes > 1e-8].T @ noise) ** 2, axis=0)


def chance_of_columns(fit: Fit, free: Array) -> float:
    """How likely columns (m, k) that are free of a fit's parameters gain as much from its gaps as they do, were these noise."""
    left, sizes, _ = np.linalg.svd(free / np.maximum(np.linalg.norm(free, axis=0), 1e-300), full_matrices=False)
    shown = left[:, sizes > _SHOWN]
    unit = max(1.0, float(np.mean(gained_by(shown, noise_like(fit)))) / max(shown.shape[1], 1))
    return float(stats.chi2.sf(float(np.sum((shown.T @ fit.gaps) ** 2)) / unit, max(shown.shape[1], 1)))


def inflation(after: Fit, parameters: int, noise: Array) -> float:
    """How much more than chi-squared the last `parameters` parameters of a fit gain from its noise, as a factor; never below one.

    Neighbouring samples of a gap that is slow count for less than they are; this is by how much, for the effect in question.
    """
    free = after.beyond(len(after.q) - parameters)
    shown = int(np.sum(np.linalg.norm(free, axis=0) > 0))
    return max(1.0, float(np.mean(gained_by(free, noise))) / max(shown, 1))


def chance_of_likeness(before: Fit, best: Fit, rival: Fit, slack: float) -> float:
    """How often a rival with more parameters would look so much like the best one if it were the truth.

    Were it the truth, its parameters could have pointed anywhere, and the best one could have followed only a part of what they do:

        lead = r^2 + 2 r e + chi^2,   r^2 = S |P_best F z|^2 / |F z|^2        against the one that was seen

    F what the rival's parameters do beyond base and releases, each in its typical size, z a random direction, S its strength as it was
    found, e and chi^2 what noise adds, with a degree of freedom for each further parameter. A parameter that hardly shows
    gives the rival no room to differ, and is not held against it, as a price by the number of parameters would.

    Parameters
    ----------
    before : without either. slack : how far the sums of squares may be off.
    """
    unit = best.variance_inflation * max(1.0, best.rms**2)
    strength, lead = (before.cost - rival.cost) / unit, (best.cost - rival.cost + slack) / unit
    if strength <= 0.0:
        return 1.0
    free = rival.beyond(len(before.q))
    left = best.free_of_parameters(free)
    chance = np.random.default_rng(SEED)
    z = chance.normal(size=(free.shape[1], LIKENESS_DRAWS))
    whole, rest = (np.einsum("id,ij,jd->d", z, columns.T @ columns, z) for columns in (free, left))
    missed = strength * np.divide(rest, whole, out=np.zeros_like(rest), where=whole > 0.0)
    by_noise = chance.chisquare(len(rival.q) - len(best.q), LIKENESS_DRAWS)
    seen = missed + 2.0 * np.sqrt(np.maximum(missed, 0.0)) * chance.normal(size=LIKENESS_DRAWS) + by_noise
    return float(np.mean(seen <= lead))


@dataclass(frozen=True)
class Family:
    """How many independent tests a look at many effects amounts to."""

    tests: float

    def p_value(self, single: float) -> float:
        """Chance that the best of all that were looked at is as good as one whose own chance is `single`."""
        return float(-np.expm1(self.tests * np.log1p(-min(single, 1.0 - 1e-12))))


def family(signatures: Sequence[Signature], noise: Array) -> Family:
    """Count independent tests from what the best of all signatures reaches in noise: its median chance is 1 - 0.5^(1/tests)."""
    shown = [s for s in signatures if s.parameters]
    if not shown:
        return Family(1.0)
    smallest = np.ones(noise.shape[1])
    for signature in shown:
        gained = gained_by(signature.columns, noise)
        scale = max(float(gained.mean()) / signature.parameters, 1e-12)
        smallest = np.minimum(smallest, stats.chi2.sf(gained / scale, signature.parameters))
    median = float(np.clip(np.median(smallest), 1e-12, 0.5))
    return Family(max(1.0, float(np.log(0.5) / np.log1p(-median))))


def chance_of_lead(best: Fit, rival: Fit, noise: Array) -> float:
    """How often the best would lead the rival by as much as it does if the rival were the truth.

        lead = |P_rival e|^2 - |P_best (g_best - g_rival + e)|^2        against the one that was seen

    g the gaps that both leave of the same measurements, so that g_best - g_rival is what the best one's model misses of the
    rival's; P frees of each one's parameters (the non-nested test of Cox, by the bootstrap of Williams 1970).
    """
    missed = best.gaps[:, None] - rival.gaps[:, None]
    best_left = np.sum(best.free_of_parameters(missed + noise) ** 2, axis=0)
    rival_left = np.sum(rival.free_of_parameters(noise) ** 2, axis=0)
    lead = rival_left - best_left
    return (1.0 + float(np.sum(lead >= rival.cost - best.cost))) / (1.0 + len(lead))
