"""How far a fit of loops can be trusted, parameter by parameter and as a whole.

A fitting library's own word for success is not taken: it was seen to be given to start values and to parameters that no
sample depends on. Nothing here depends on a load cell's zero, on units, or on the order of the files: errors are in parts of each loop's
own height.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from identify.actuator.actuator_fit import Disagreement, Verdict
from identify.actuator.rates_and_strokes import follows_frequency, what_differs
from identify.criteria import (
    LARGEST_MISFIT,
    LEAST_STEPS,
    LOUD,
    NO_AREA,
    SLIGHT_MISFIT,
    STRUCTURED_MISFIT,
    STRUCTURED_SHARE,
    SURE_MISFIT,
)
from identify.estimation.parameters import Estimate
from identify.gap.misfit import Misfit
from identify.loops.loop_data import Fault, LoopData, area
from identify.loops.residual_dependence import Dependence
from measure.common.arrays import Array


@dataclass(frozen=True)
class Evidence:
    """All that a verdict rests on.

    lines : (5,) a_l, b_l, a_u, b_u, beta of each loop. residuals : measured minus modelled of each loop's samples that count, N.
    left : what the residuals still follow. at_bounds : the bound of each parameter that ran to one. disagree : quantities in which the
    loops differ. better : a sentence on the effect that explains what is left, and whether it moves a number. robust : whether samples
    far off counted less.
    """

    lines: Sequence[Array]
    estimates: dict[str, Estimate]
    loops: Sequence[LoopData]
    residuals: Sequence[Array]
    left: Dependence
    misfit: Misfit
    faults: Sequence[Fault]
    converged: bool
    at_bounds: Mapping[str, str]
    disagree: Sequence[Disagreement] = ()
    better: str = ""
    moves: bool = False
    robust: bool = False

    @property
    def closed(self) -> list[LoopData]:
        """The loops with a full cycle."""
        return [data for data in self.loops if data.cycles.spans]


def verdict_of(seen: Evidence) -> Verdict:
    """The word on the whole fit: the first of these that is true, worst first."""
    rules = (
        ("data-bad", _refused),
        ("data-bad", _encloses_nothing),
        ("not-identifiable", _too_few_steps),
        ("did-not-converge", _not_converged),
        ("model-does-not-apply", _does_not_apply),
        ("at-bound", _at_bound),
        ("loops-disagree", _disagree),
        ("not-identifiable", _not_identifiable),
        ("approximate", _approximate),
    )
    for word, rule in rules:
        reason = rule(seen)
        if reason:
            return Verdict(word, reason + (f"; {seen.better}" if seen.better and seen.better not in reason else ""))  # type: ignore[arg-type]
    return Verdict("ok", f"pooled error {100 * pooled_error(seen.loops, seen.residuals):.2f} % of the force range{_beyond_noise(seen)}")


def _beyond_noise(seen: Evidence) -> str:
    noise = float(np.sqrt(np.mean([data.force_sigma_N**2 for data in seen.loops])))
    ratio = float(np.sqrt(np.mean(np.concatenate(seen.residuals) ** 2))) / max(noise, 1e-300)
    if ratio < 2.0:
        return _loud(noise, float(np.mean(seen.misfit.heights_N)))
    return f"; the residual is {ratio:.1f} times the noise of the samples, so the law is not all there is"


def _loud(noise_N: float, height_N: float) -> str:
    """A remark on noise that a good part of the loop's height could hide in."""
    share = noise_N / max(height_N, 1e-300)
    return "" if not share >= LOUD else f", which is noise: {1e3 * noise_N:.2g} mN a sample, {100 * share:.0f} % of the loops' height"


def _refused(seen: Evidence) -> str:
    return "; ".join(f"{Path(fault.loop).name}: {fault.sentence}" for fault in seen.faults if fault.consequence == "refused")


def _not_converged(seen: Evidence) -> str:
    return "" if seen.converged else "the least-squares fit stopped before it had converged; the numbers are not a result"


def _too_few_steps(seen: Evidence) -> str:
    """The sentence on a converter too coarse for the law, where that is so of every loop."""
    steps = [(data.force_step_N, float(h)) for data, h in zip(seen.loops, seen.misfit.heights_N, strict=True)]
    if not all(step > 0.0 and height < LEAST_STEPS * step for step, height in steps):
        return ""
    step, height = max(steps)
    return (
        f"steps of {1e3 * step:.3g} mN, {step / height:.2g} of the loop's height: too few of them to see the law's shape. Use a finer range"
    )


def _does_not_apply(seen: Evidence) -> str:
    if not seen.closed:
        return "there is no closed loop: no record holds a full cycle, and a drift or the start may pass for the law. Record more cycles"
    if all(area(data, data.force_N) <= 0.0 for data in seen.closed):
        return "the loops run clockwise: the actuator gives energy instead of taking it. Check the signs of force and elongation"
    return _cross(seen) or _is_missing_something(seen) or _another_shape(seen)


def _cross(seen: Evidence) -> str:
    """The sentence on branches that cross; a branch lies s a / beta beside its asymptote, so h_u - h_l + (a_u + a_l) / beta apart."""
    for data, (a_l, b_l, a_u, b_u, beta) in zip(seen.loops, seen.lines, strict=True):
        ends = np.array([data.elongation_m[data.used].min(), data.elongation_m[data.used].max()])
        height = (a_u - a_l) * ends + b_u - b_l + (a_u + a_l) / beta
        if np.any(height <= 0.0):
            where = float(ends[np.argmin(height)])
            return f"{data.name}: the asymptotes cross: the branches are {height.min():.3g} N apart at {where:.4g} m"
    return ""


def _another_shape(seen: Evidence) -> str:
    share = seen.misfit.pooled
    if share <= LARGEST_MISFIT or not _is_sure(seen):
        return ""
    return f"the loop has another shape: {100 * share:.0f} % of half its height is left in every cycle{_spikes(seen.residuals)}"


def _is_sure(seen: Evidence) -> bool:
    """Whether what is left comes again in every cycle; where no cycle does, that is not known and it is taken for so."""
    return not seen.misfit.significance < SURE_MISFIT


def _is_missing_something(seen: Evidence) -> str:
    """The sentence on a large misfit that one quantity explains for the better part, or nothing."""
    misfit, share = seen.misfit.pooled, seen.left.shares[seen.left.strongest]
    if misfit < STRUCTURED_MISFIT or share < STRUCTURED_SHARE or not _is_sure(seen):
        return ""
    return (
        f"something is missing that follows the {seen.left.strongest}: {100 * misfit:.1f} % of half the loops' height is left, "
        f"and the {seen.left.strongest} explains {100 * share:.0f} % of it. Fit the effect jointly with --effect"
    )


def _encloses_nothing(seen: Evidence) -> str:
    """The sentence on loops without a height that stands out of the noise, or nothing.

    The height is the enclosed area over the stroke. Four of its standard errors, 2.2 sigma / sqrt(n) each, are asked of it,
    and a two-hundredth of the force range.
    """
    if not seen.closed:
        return ""
    heights = [abs(area(data, data.force_N)) / (2.0 * data.amplitude_m) for data in seen.closed]
    least = [max(NO_AREA[0] * d.force_sigma_N / np.sqrt(d.used.sum()), NO_AREA[1] * d.force_range_N) for d in seen.closed]
    if any(height > limit for height, limit in zip(heights, least, strict=True)):
        return ""
    noise = max(data.force_sigma_N for data in seen.closed)
    return f"the loops enclose no area: they are {max(heights):.2g} N high, with {noise:.2g} N of noise in a sample"


def _disagree(seen: Evidence) -> str:
    if not seen.disagree:
        return ""
    names, first = [data.name for data in seen.loops], seen.disagree[0]
    differs = what_differs(seen.loops)
    tail = f"; they also differ in {', '.join(differs)}" if differs else "; nothing else that is known differs between them"
    if follows_frequency(seen.loops, first.values):
        tail += f". The {first.what} follows the frequency: try --rate frequency"
    elif any(text.startswith("column") for text in differs):
        tail += ". Where a condition explains it, --covariate fits its share"
    return f"the loops disagree: {'; '.join(one.sentence(names) for one in seen.disagree)}{tail}. Fit them apart, or find what changed"


def _named(seen: Evidence, word: str) -> str:
    named = [name for name, estimate in seen.estimates.items() if estimate.verdict == word]
    return ", ".join(f"{name} (at its {seen.at_bounds[name]})" if name in seen.at_bounds else name for name in named)


def _not_identifiable(seen: Evidence) -> str:
    named = _named(seen, "not-identifiable")
    return f"these loops do not determine {named}: other parameters, or the noise, imitate it" if named else ""


def _at_bound(seen: Evidence) -> str:
    named = _named(seen, "at-bound")
    return f"{named} ran to the end of what is possible or of what these loops can tell" if named else ""


def _approximate(seen: Evidence) -> str:
    """The sentence on a law that describes most of the loops, and what is left that matters."""
    share, goes = seen.misfit.pooled, seen.left.strongest
    spiky = [fault.sentence for fault in seen.faults if fault.word == "spikes" and fault.consequence == "named"]
    if spiky and not seen.robust:
        return f"the law describes most of the loops, but {spiky[0]}"
    structured = np.isfinite(seen.misfit.significance) and share > SLIGHT_MISFIT and _is_sure(seen)
    if not structured and not seen.moves:
        return ""
    explains = seen.left.shares[goes]
    with_what = f" and goes with the {goes} ({100 * explains:.0f} %)" if explains > 0.0 else ""
    said = f"{100 * share:.1f} % of half the loops' height is left in every cycle{with_what}" if structured else "an effect is missing"
    return f"the law describes most of the loops; {said}. The intervals are wider for it"


def _spikes(residuals: Sequence[Array]) -> str:
    """Advice where a few samples make the error."""
    left = np.concatenate(residuals)
    usual = 1.4826 * float(np.median(np.abs(left)))
    return ", but a few samples make most of it: try --robust" if np.sqrt(np.mean(left**2)) > 3.0 * usual else ""


def errors(loops: Sequence[LoopData], residuals: Sequence[Array]) -> list[float]:
    """RMS error of each loop in parts of its force range."""
    return [float(np.sqrt(np.mean(r**2)) / data.force_range_N) for data, r in zip(loops, residuals, strict=True)]


def pooled_error(loops: Sequence[LoopData], residuals: Sequence[Array]) -> float:
    """RMS over all samples of all loops in parts of the range of all their forces, each loop's counted from its own mean."""
    forces = [data.force_N[data.used] - data.force_N[data.used].mean() for data in loops]
    lowest, highest = min(force.min() for force in forces), max(force.max() for force in forces)
    return float(np.sqrt(np.mean(np.concatenate(residuals) ** 2)) / (highest - lowest))
