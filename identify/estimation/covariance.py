"""What a fit of loops knows and does not know: covariance, intervals, and parameters that nothing determines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from identify.actuator.layout import BETA_NAME, Layout
from identify.loops.corners import SIDE
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array

Word = Literal["ok", "at-bound", "not-identifiable", "did-not-converge", "data-bad", "model-does-not-apply"]

OWN_SHARE = 0.02  # of a parameter's signature that no other parameter can imitate, below which it is not identifiable
_TWO_SIDED_95 = 1.96  # standard deviations
_REACH = 6  # frequencies of a doubled transform, half as many independent ones
_LIKE_A_SLOPE = 0.1  # of the acceleration, that no slope of the force can imitate, below which no inertia is told from one
_OVER = 3.0  # lengths 1 / beta after which the force is on its asymptote, to 5 %


@dataclass(frozen=True)
class Estimate:
    """A fitted number: value, one standard deviation, 95 % interval, and whether the data determine it."""

    value: float
    stderr: float
    ci95: tuple[float, float]
    verdict: Word


@dataclass(frozen=True)
class BetaDoubt:
    """What the covariance of log beta does not show.

    turns : the part of its standard deviation that comes from the motion. An error of the turning points adds to the length 1 / beta
    and not to its logarithm. open : whether far larger or smaller betas fit nearly as well, see `beta_profile.is_open`.
    """

    turns: float
    open: bool

    def interval(self, beta: float, error: float, reach: float) -> tuple[float, float]:
        """`reach` standard deviations to each side, `error` being one of log beta; without an end above where 1 / beta may be nothing."""
        turns, noise = reach * self.turns, reach * np.sqrt(max(error**2 - self.turns**2, 0.0))
        up = np.hypot(noise, -np.log1p(-turns)) if turns < 1.0 else np.inf
        return beta * float(np.exp(-min(np.hypot(noise, np.log1p(turns)), 50.0))), beta * float(np.exp(min(up, 50.0)))

    @property
    def undetermined(self) -> bool:
        """Whether beta counts as not identifiable."""
        return self.open or self.turns >= 1.0 / _TWO_SIDED_95


def jacobians(residuals: Callable[[Array], tuple[Array, ...]], theta: Array, low: Array, high: Array) -> tuple[Array, ...]:
    """Derivative of each loop's residual with respect to the vector, (n, p), by central differences inside the bounds."""
    columns: list[list[Array]] = [[] for _ in residuals(theta)]
    for k in range(len(theta)):
        size = 1e-5 * max(abs(theta[k]), 1e-3)
        up, down = theta.copy(), theta.copy()
        up[k], down[k] = min(theta[k] + size, high[k]), max(theta[k] - size, low[k])
        for column, after, before in zip(columns, residuals(up), residuals(down), strict=True):
            column.append((after - before) / (up[k] - down[k]))
    return tuple(np.stack(column, axis=1) for column in columns)


def covariance_of(tables: Sequence[Array], residuals: Sequence[Array], free: NDArray[np.bool_]) -> Array:
    """Covariance of the vector, zero for what stands at a bound.

        C = N^-1 (sum_k J_k' W_k J_k) N^-1,   N = sum_k J_k' J_k,   W_k the covariance of the residual of loop k

    W is stationary and taken from the residual's smoothed spectrum, so a slow drift makes levels uncertain and leaves beta,
    which the reversals tell, nearly as it was. Each parameter gets its own effective number of samples in this way.
    """
    size = tables[0].shape[1]
    kept = np.flatnonzero(free)
    scale = np.sqrt(np.sum([np.sum(table[:, kept] ** 2, axis=0) for table in tables], axis=0))
    scale = np.where(scale > 0.0, scale, 1.0)
    scaled = [table[:, kept] / scale for table in tables]
    inverse = np.linalg.pinv(np.sum([table.T @ table for table in scaled], axis=0), rcond=1e-12, hermitian=True)
    samples = sum(len(r) for r in residuals)
    scattered = np.sum([_scatter(table, r) for table, r in zip(scaled, residuals, strict=True)], axis=0)
    middle = scattered * samples / max(samples - len(kept), 1)
    whole = np.zeros((size, size))
    whole[np.ix_(kept, kept)] = inverse @ middle @ inverse / np.outer(scale, scale)
    return whole


def covariance_of_motion(tables: Sequence[Array], turned: Sequence[Array], swayed: Sequence[Array], free: NDArray[np.bool_]) -> Array:
    """What the motion's own errors add to the covariance; a fit bends to them, so no residual shows them.

        C = G G',   G = N^-1 [sum_k J_k' t_k, J_1' S_1, J_2' S_2 ...]

    Parameters
    ----------
    turned : (n_k,) for each loop, the change t_k of its residual where all turning points are off by one standard deviation.
    swayed : (n_k, m_k) for each loop, its changes S_k with errors of its own, each of one standard deviation.
    """
    kept = np.flatnonzero(free)
    size = np.sqrt(np.sum([np.sum(table[:, kept] ** 2, axis=0) for table in tables], axis=0))
    scale = np.where(size > 0.0, size, 1.0)
    scaled = [table[:, kept] / scale for table in tables]
    normal = np.sum([table.T @ table for table in scaled], axis=0)
    common = np.sum([table.T @ change for table, change in zip(scaled, turned, strict=True)], axis=0)
    own = [table.T @ changes for table, changes in zip(scaled, swayed, strict=True)]
    shift = np.zeros((len(free), 1 + sum(part.shape[1] for part in own)))
    shift[kept] = np.linalg.pinv(normal, rcond=1e-12, hermitian=True) @ np.column_stack([common, *own]) / scale[:, None]
    return shift @ shift.T


def clipped(residuals: Sequence[Array]) -> tuple[Array, ...]:
    """Residuals cut off at three robust standard deviations, for a covariance that outliers do not make."""
    most = 3.0 * 1.4826 * float(np.median(np.abs(np.concatenate(residuals))))
    return tuple(np.clip(r, -most, most) for r in residuals)


def _scatter(table: Array, residual: Array) -> Array:
    """J' W J of one loop, from the spectra of its columns and of its residual."""
    n = len(residual)
    waves = np.fft.rfft(table, 2 * n, axis=0)
    power = smoothed_power(residual)
    weight = np.where((np.arange(n + 1) == 0) | (np.arange(n + 1) == n), 1.0, 2.0) * power / (2 * n)
    return np.real((waves * weight[:, None]).conj().T @ waves)


def smoothed_power(residual: Array) -> Array:
    """Power of a residual (sine taper) at the n + 1 frequencies of a transform of twice its length; its mean is the variance.

    Each value is the mean over a neighbourhood of at least four independent frequencies and a fifth of the frequency itself,
    because a fit has taken out of its residual what its own parameters can imitate at just their frequencies. A neighbourhood
    is averaged over its upper and lower side, and the larger mean counts.
    """
    n = len(residual)
    taper = np.sin(np.pi * (np.arange(n) + 0.5) / n)
    power = np.abs(np.fft.rfft(residual * taper, 2 * n)) ** 2 / np.sum(taper**2)
    total = np.concatenate([[0.0], np.cumsum(power)])
    k = np.arange(n + 1)
    reach = np.maximum(_REACH, k // 5)
    below, above = np.maximum(k - reach, 0), np.minimum(k + reach + 1, n + 1)
    lower = (total[k + 1] - total[below]) / (k + 1 - below)
    upper = (total[above] - total[k]) / (above - k)
    both = (total[above] - total[below]) / (above - below)
    return np.where(k < reach, np.maximum(both, np.minimum(lower, upper)), both)


def estimates_of(
    shape: Layout,
    theta: Array,
    covariance: Array,
    free: NDArray[np.bool_],
    tables: Sequence[Array],
    freedom: float,
    loops: Sequence[LoopData],
    doubt: BetaDoubt,
) -> dict[str, Estimate]:
    """Value, error, interval and verdict of everything that goes into a model file.

    The interval is Student's with `freedom` effective degrees; for that of beta see `BetaDoubt`. A beta with which the force
    is on its asymptote again by the second sample behind a reversal is not determined, nor is an inertia where the acceleration
    follows the elongation: the acceleration comes from the elongation and its small errors would decide.
    """
    from scipy.stats import t as student

    reach = float(student.ppf(0.975, max(freedom, 2.0)))
    slopes = shape.slopes(theta)
    errors = np.sqrt(np.maximum(np.diag(slopes @ covariance @ slopes.T), 0.0))
    words = _words(shape, theta, free, tables, loops, doubt)
    made = {}
    for row, (name, value) in enumerate(zip(shape.names(), shape.values(theta), strict=True)):
        error = float(errors[row])
        interval = (value - reach * error, value + reach * error)
        if name == BETA_NAME:
            interval = doubt.interval(float(value), error / float(value), reach)
        made[name] = Estimate(float(value), error, (float(interval[0]), float(interval[1])), words[row])
    return made


def _words(
    shape: Layout, theta: Array, free: NDArray[np.bool_], tables: Sequence[Array], loops: Sequence[LoopData], doubt: BetaDoubt
) -> list[Word]:
    own = own_shares(tables)
    m = shape.order + 1
    groups = [slice(0, m), slice(0, 2 * m), slice(2 * m, 3 * m), slice(2 * m, 4 * m)]
    words: list[Word] = ["not-identifiable" if own[group].min() < OWN_SHARE else "ok" for group in groups]
    at_beta = shape.line_values
    finest_way = min(data.finest_way_m for data in loops)
    unknown = doubt.undetermined or np.exp(theta[at_beta]) * finest_way > _OVER
    words.append("at-bound" if not free[at_beta] else "not-identifiable" if unknown else "ok")
    inertia = [kind.leg_mass is not None for kind in shape.kinds for _ in kind.flat_names()]
    own[at_beta + 1 :] = np.minimum(own[at_beta + 1 :], own_shares(_away_from_turns(tables, loops))[at_beta + 1 :])
    own[at_beta + 1 : at_beta + 1 + len(inertia)] *= ~np.array(inertia, dtype=bool) | (acceleration_apart(loops) > _LIKE_A_SLOPE)
    return [*words, *(_effect_word(own[k], bool(free[k])) for k in range(at_beta + 1, len(theta)))]


def _away_from_turns(tables: Sequence[Array], loops: Sequence[LoopData]) -> list[Array]:
    """The tables without the samples beside a reversal, where a motion that turns sharply is not known; half of a stroke stays at least.

    A viscous friction in triangles of one speed, for one, differs from a greater height of the loop in these samples alone.
    """
    kept = []
    for table, data in zip(tables, loops, strict=True):
        far = np.ones(len(data.force_N), dtype=bool)
        turns = data.cycles.reversals
        for turn in turns:
            beside = min([SIDE, *(abs(other - turn) // 4 for other in turns if other != turn)])
            far[max(turn - beside, 0) : turn + beside + 1] = False
        kept.append(table[far[data.used]])
    return kept


def acceleration_apart(loops: Sequence[LoopData]) -> float:
    """Share of the acceleration of all loops that is no multiple of the elongation, 0 to 1, each loop centred.

    Zero for sinusoids of one frequency; the larger, the more frequencies differ.
    """
    seen = [np.stack([d.elongation_m, d.acceleration_m_per_s2])[:, d.used] for d in loops]
    u, a = np.concatenate([pair - pair.mean(axis=1, keepdims=True) for pair in seen], axis=1)
    power = float(u @ u) * float(a @ a)
    return float(np.sqrt(max(1.0 - float(u @ a) ** 2 / power, 0.0))) if power > 0.0 else 0.0


def _effect_word(own: float, free: bool) -> Word:
    return "not-identifiable" if own < OWN_SHARE else "ok" if free else "at-bound"


def own_shares(tables: Sequence[Array]) -> Array:
    """Which share of each parameter's signature no combination of the others can imitate, 0 to 1.

    A hub's inertia in sinusoids of one frequency, for one, looks like a slope of both asymptotes: its share is zero, and
    whatever value a fit returns for it is an accident of the noise.
    """
    normal = np.sum([table.T @ table for table in tables], axis=0)
    size = np.sqrt(np.diag(normal))
    known = size > 0.0
    shares = np.zeros(len(size))
    scaled = normal[np.ix_(known, known)] / np.outer(size[known], size[known])
    shares[known] = 1.0 / np.sqrt(np.maximum(np.diag(np.linalg.pinv(scaled, rcond=1e-13, hermitian=True)), 1.0))
    return shares
