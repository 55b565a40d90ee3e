"""Effective stiffness against frequency: whether the friction is dry or viscous (Aridon 2009, eq. (5), Fig. 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.actuator.rates_and_strokes import strokes
from identify.criteria import INERTIA_APART, OTHER_RATE, STIFFNESS_CHANGE
from identify.loops.loop_data import LoopData, acceleration_apart, inertia
from measure.common.arrays import Array
from simulate.model.effect import Effect

Word = Literal["dry", "viscous", "cannot tell"]


@dataclass(frozen=True)
class Friction:
    """What the effective stiffness says about the friction, and in which words."""

    word: Word
    sentence: str


def stiffness_of_cycles(data: LoopData, effects: tuple[Effect, ...] = ()) -> Array:
    """Force range over elongation range of each full cycle, N/m, the inertia of these effects taken out.

        K_eff = (F_max - F_min) / (X_max - X_min)

    Source: Aridon 2009, eq. (5).
    """
    force = data.force_N + inertia(data, effects)
    return np.array([np.ptp(force[a:b]) / np.ptp(data.elongation_m[a:b]) for a, b in data.cycles.spans])


def effective_stiffness(data: LoopData, effects: tuple[Effect, ...] = ()) -> float:
    """Median over the full cycles, N/m; NaN where there is none."""
    ratios = stiffness_of_cycles(data, effects)
    return float(np.median(ratios)) if len(ratios) else float("nan")


def friction_of(loops: Sequence[LoopData], effects: tuple[Effect, ...] = ()) -> Friction:
    """Dry where K_eff at one stroke does not change with the frequency, viscous where it grows, else "cannot tell".

    Cycles of loops of one stroke are compared by a line through their relative stiffness against the logarithm of the
    frequency; the change over the frequencies seen is judged with its 95 % interval. Only loops of equal stroke say
    something: with dry friction, too, a longer stroke is softer.
    """
    x, y = _relative(loops, effects)
    if len(x) < 4:
        return Friction(
            "cannot tell", "cannot tell dry from viscous: no two frequencies at one stroke; record one more loop at the same stroke"
        )
    span = float(np.ptp(x))
    slope, error = _line(x, y)
    change, doubt = 100.0 * slope * span, 200.0 * error * span
    said = (
        f"the effective stiffness at one stroke changes by {change:+.0f} +- {doubt:.0f} % over a factor of {np.exp(span):.1f} in frequency"
    )
    if change - doubt > 0.0 and change > 100.0 * STIFFNESS_CHANGE:
        return Friction("viscous", f"viscous: {said}")
    if abs(change) + doubt < 100.0 * STIFFNESS_CHANGE:
        return Friction("dry", f"dry: {said}")
    return Friction("cannot tell", f"cannot tell dry from viscous: {said}")


def friction_without_inertia(loops: Sequence[LoopData], effects: tuple[Effect, ...], missing: str) -> Friction:
    """The same, but no word where an inertia is missing from the fit: it turns loops with the frequency, and changes their stiffness."""
    if not missing:
        return friction_of(loops, effects)
    return Friction("cannot tell", f"cannot tell dry from viscous while an inertia is missing: fit --effect {missing} first")


def slopes_and_inertia(loops: Sequence[LoopData], effects: Sequence[Effect], slope_stderr_N_per_m: float) -> str:
    """What loops of one frequency cannot tell: a slope from an inertia. Nothing where they can, or where the inertia is fitted.

    In a sine the acceleration is -omega^2 times the elongation, so that a mass m adds m omega^2 to both slopes.
    """
    known = [data for data in loops if data.cycles.spans]
    if not known or any(effect.leg_mass is not None for effect in effects) or acceleration_apart(loops) > INERTIA_APART:
        return ""
    turns = (2.0 * np.pi * float(np.median([data.frequency_Hz for data in known]))) ** 2
    return (
        "all loops have one frequency, at which slope and inertia look alike: "
        f"each kg of moving mass adds {turns:.3g} N/m to a_l and a_u, "
        f"so that their errors hold for a mass far below {slope_stderr_N_per_m / turns:.2g} kg only. "
        "Record a second frequency at this stroke"
    )


def _relative(loops: Sequence[LoopData], effects: tuple[Effect, ...]) -> tuple[Array, Array]:
    """Logarithm of the frequency and relative stiffness of every cycle that has a partner of equal stroke, both centred."""
    known = [data for data in loops if data.cycles.spans]
    xs, ys = [], []
    for group in strokes(known):
        frequencies = np.array([data.frequency_Hz for data in group])
        if frequencies.max() < OTHER_RATE * frequencies.min():
            continue
        parts = [stiffness_of_cycles(data, effects) for data in group]
        x = np.concatenate([np.full(len(part), np.log(f)) for part, f in zip(parts, frequencies, strict=True)])
        y = np.concatenate(parts)
        xs.append(x - x.mean())
        ys.append(y / y.mean() - 1.0)
    return (np.concatenate(xs), np.concatenate(ys)) if xs else (np.empty(0), np.empty(0))


def _line(x: Array, y: Array) -> tuple[float, float]:
    """Slope through the origin of centred data, and its standard error."""
    power = float(x @ x)
    slope = float(x @ y) / power
    left = y - slope * x
    return slope, float(np.sqrt(left @ left / max(len(x) - 2, 1) / power))
