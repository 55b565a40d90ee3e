"""How far a fit of loops can be trusted, parameter by parameter and as a whole.

A fitting library's own word for success is not taken: it was seen to be given to start values and to parameters that no
sample depends on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from identify.criteria import LARGEST_ERROR, NO_AREA, STRUCTURED_ERROR, STRUCTURED_SHARE
from identify.estimation.estimate import Estimate, Word
from identify.loops.loop_data import LoopData, area
from identify.loops.residual_dependence import Dependence
from measure.common.arrays import Array


@dataclass(frozen=True)
class Verdict:
    """The word on a fit and the sentence that gives the reason."""

    word: Word
    reason: str


def verdict_of(
    lines: Sequence[Array],
    estimates: dict[str, Estimate],
    loops: Sequence[LoopData],
    residuals: Sequence[Array],
    left: Dependence,
    converged: bool,
    at_bounds: Mapping[str, str],
) -> Verdict:
    """The word on the whole fit: the first of these that is true, worst first.

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta of each loop. residuals : measured minus modelled of each loop's samples that count, N.
    left : what the residuals still follow. at_bounds : the bound of each parameter that ran to one.
    """
    closed = [data for data in loops if data.cycles.spans]
    empty = _encloses_nothing(closed)
    if empty:
        return Verdict("data-bad", empty)
    if not converged:
        return Verdict("did-not-converge", "the least-squares fit stopped before it had converged; the numbers are not a result")
    reason = _does_not_apply(lines, closed, loops, residuals) or _is_missing_something(loops, residuals, left)
    if reason:
        return Verdict("model-does-not-apply", reason)
    for word, because in (
        ("not-identifiable", "these loops do not determine {}: other parameters, or the noise, imitate it"),
        ("at-bound", "{} ran to the end of what is possible or of what these loops can tell"),
    ):
        named = [name for name, estimate in estimates.items() if estimate.verdict == word]
        if named:
            shown = [f"{name} (at its {at_bounds[name]})" if name in at_bounds else name for name in named]
            return Verdict(word, because.format(", ".join(shown)))  # type: ignore[arg-type]
    return Verdict("ok", f"pooled error {100 * pooled_error(loops, residuals):.2f} % of the force range{_beyond_noise(loops, residuals)}")


def _beyond_noise(loops: Sequence[LoopData], residuals: Sequence[Array]) -> str:
    noise = float(np.sqrt(np.mean([data.force_sigma_N**2 for data in loops])))
    ratio = float(np.sqrt(np.mean(np.concatenate(residuals) ** 2))) / max(noise, 1e-300)
    return "" if ratio < 2.0 else f"; the residual is {ratio:.1f} times the noise of the samples, so the law is not all there is"


def _does_not_apply(lines: Sequence[Array], closed: Sequence[LoopData], loops: Sequence[LoopData], residuals: Sequence[Array]) -> str:
    if not closed:
        return "there is no closed loop: no record holds a full cycle, and a drift or the start may pass for the law. Record more cycles"
    if all(area(data, data.force_N) <= 0.0 for data in closed):
        return "the loops run clockwise: the actuator gives energy instead of taking it. Check the signs of force and elongation"
    for data, (a_l, b_l, a_u, b_u, _) in zip(loops, lines, strict=True):
        ends = np.array([data.elongation_m[data.used].min(), data.elongation_m[data.used].max()])
        height = (a_u - a_l) * ends + b_u - b_l
        if np.any(height <= 0.0):
            where = float(ends[np.argmin(height)])
            return (
                f"{data.name}: the asymptotes cross within the elongations seen: upper minus lower is {height.min():.3g} N at {where:.4g} m"
            )
    error = pooled_error(loops, residuals)
    if error > LARGEST_ERROR:
        return f"the loop has another shape: the error is {100 * error:.1f} % of the force range{_spikes(residuals)}"
    return ""


def _encloses_nothing(loops: Sequence[LoopData]) -> str:
    """The sentence on loops without a height that stands out of the noise, or nothing.

    The height is the enclosed area over the stroke. Four of its standard errors, 2.2 sigma / sqrt(n) each, are asked of it,
    and a two-hundredth of the force range.
    """
    if not loops:
        return ""
    heights = [abs(area(data, data.force_N)) / (2.0 * data.amplitude_m) for data in loops]
    least = [max(NO_AREA[0] * d.force_sigma_N / np.sqrt(d.used.sum()), NO_AREA[1] * d.force_range_N) for d in loops]
    if any(height > limit for height, limit in zip(heights, least, strict=True)):
        return ""
    noise = max(data.force_sigma_N for data in loops)
    return f"the loops enclose no area: they are {max(heights):.2g} N high, with {noise:.2g} N of noise in a sample"


def _is_missing_something(loops: Sequence[LoopData], residuals: Sequence[Array], left: Dependence) -> str:
    """The sentence on a large residual that one quantity explains for the better part, or nothing."""
    error, share = pooled_error(loops, residuals), left.shares[left.strongest]
    if error < STRUCTURED_ERROR or share < STRUCTURED_SHARE:
        return ""
    return (
        f"something is missing that follows the {left.strongest}: the error is {100 * error:.1f} % of the force range, "
        f"and the {left.strongest} explains {100 * share:.0f} % of it. Fit the effect jointly with --effect"
    )


def _spikes(residuals: Sequence[Array]) -> str:
    """Advice where a few samples make the error."""
    left = np.concatenate(residuals)
    usual = 1.4826 * float(np.median(np.abs(left)))
    return ", but a few samples make most of it: try --robust" if np.sqrt(np.mean(left**2)) > 3.0 * usual else ""


def errors(loops: Sequence[LoopData], residuals: Sequence[Array]) -> list[float]:
    """RMS error of each loop in parts of its force range."""
    return [float(np.sqrt(np.mean(r**2)) / data.force_range_N) for data, r in zip(loops, residuals, strict=True)]


def pooled_error(loops: Sequence[LoopData], residuals: Sequence[Array]) -> float:
    """RMS over all samples of all loops in parts of the range of all their forces."""
    lowest, highest = min(data.force_N[data.used].min() for data in loops), max(data.force_N[data.used].max() for data in loops)
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)) / (highest - lowest))
