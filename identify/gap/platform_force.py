"""The force that is missing on the platform, with its band: along time, along the height or along the speed.

The force is unknown input to the six-leg model: a table of what a film in the plane x, z can see, two forces and a moment, at
fixed places of an abscissa, straight lines between. It is an effect like any other, so it is estimated together with base and
releases and is the same in every run; but it has no physics and is never a name. Which abscissa suits all runs best says what
the force goes with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import ROUGHLY, before_the_stops, laid_out, solve
from identify.estimation.problem import Problem
from identify.selection.gap_test import GAP_P, gap_test
from identify.selection.null_hypothesis import chance_of_columns
from measure.common.arrays import Array
from simulate.model.effect import PlatformEffect, parameter
from simulate.model.rig import Rig

KNOTS, SPACING_S = 16, 0.05
_MOVES = ("z_m", "x_m", "theta_y_rad")  # what vertical force, lateral force and moment move
AXES = len(_MOVES)
_BAND = 3.0
_CLEAR_LEAD = 0.25
_STROKES_PER_S = 4.0  # the fastest knot
_MOST_STEPS = 12
_SHOWN = 1e-2  # of the best seen combination of knots: what shows less is not told from a straight line's own error


def _table(typical: float, doc: str) -> Any:
    return parameter((0.0,) * KNOTS, low=-1e3, high=1e3, typical=typical, doc=doc)


@dataclass(frozen=True)
class ForceTable(PlatformEffect):
    """A force on the platform along an abscissa: F_z, F_x and M_y at evenly spaced places, linear between, steady beyond.

    The abscissa is time since the release, height, or upward speed, by its code 0, 1, 2; its origin and spacing follow.
    """

    name = "missing-force"
    constants = 3
    vertical_N: tuple[float, ...] = _table(0.02, "F_z at the places")
    lateral_N: tuple[float, ...] = _table(0.02, "F_x at the places")
    moment_N_m: tuple[float, ...] = _table(0.001, "M_y at the places")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the force of this instant, height or speed, N and N m."""
        at = t if p[48] < 0.5 else (pose[2] if p[48] < 1.5 else twist[2])
        place = min(max((at - p[49]) / p[50], 0.0), 14.999999)
        left = int(place)
        share = place - left
        wrench[2] += p[left] + share * (p[left + 1] - p[left])
        wrench[0] += p[16 + left] + share * (p[17 + left] - p[16 + left])
        wrench[4] += p[32 + left] + share * (p[33 + left] - p[32 + left])

    @classmethod
    def places(cls, model: Rig) -> Array:
        """The places of the table, (KNOTS,), in the abscissa's own unit."""
        _, origin, spacing = cls().constants_of(model)
        return origin + spacing * np.arange(KNOTS)


@dataclass(frozen=True)
class ForceAlongTime(ForceTable):
    """At 0, 0.05, 0.1 ... s after the release."""

    name = "missing-force-along-time"

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """Code, first instant and spacing, s."""
        del model
        return 0.0, 0.0, SPACING_S


@dataclass(frozen=True)
class ForceAlongHeight(ForceTable):
    """From the lowest start to full height."""

    name = "missing-force-along-height"

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """Code, lowest height and spacing, m."""
        g = model.geometry
        low, high = (0.0, 1.0) if g is None else (g.stowed_height_m, g.deployed_height_m)
        return 1.0, low, (high - low) / (KNOTS - 1)


@dataclass(frozen=True)
class ForceAlongSpeed(ForceTable):
    """From rest to four strokes a second."""

    name = "missing-force-along-speed"

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """Code, rest and spacing, m/s."""
        g = model.geometry
        stroke = 1.0 if g is None else g.deployed_height_m - g.stowed_height_m
        return 2.0, 0.0, _STROKES_PER_S * stroke / (KNOTS - 1)


Along = type[ForceTable]
_WORDS: dict[Along, tuple[str, str, str]] = {
    ForceAlongTime: ("time_s", "s after the release", "time"),
    ForceAlongHeight: ("height_m", "m of height", "height"),
    ForceAlongSpeed: ("speed_m_per_s", "m/s of upward speed", "speed"),
}
ALONGS: tuple[Along, ...] = tuple(_WORDS)
_DOES = (
    ("acts upwards on the platform", "acts downwards on the platform", "N"),
    ("acts to the right on the platform", "acts to the left on the platform", "N"),
    ("turns the platform about +y", "turns the platform about -y", "N m"),
)


@dataclass(frozen=True)
class MissingForce:
    """The estimated force: places (n,) of its abscissa, force and one standard deviation (n, 3): vertical and lateral, N; moment, N m.

    leads : what the same table along each other abscissa leaves of what this one closes, by name. A table is coarse, so only a
    clear lead says anything.
    """

    along: Along
    places: Array
    force_N: Array
    sigma_N: Array
    fit: Fit
    leads: dict[str, float]

    @property
    def sentence(self) -> str:
        """What the force does, for a person to act on."""
        words = [w for axis, (up, down, unit) in enumerate(_DOES) if (w := self._axis(axis, up, down, unit))]
        if not words:
            return "No missing force on the platform stands out of its band anywhere."
        return "The missing force " + " and ".join(words) + "; " + self.goes_with + "."

    @property
    def goes_with(self) -> str:
        """What the force goes with, as far as these runs can tell."""
        own = _WORDS[self.along][2]
        near = [name for name, lead in self.leads.items() if lead < _CLEAR_LEAD]
        if not self.leads:
            return f"estimated along {own} only"
        if near:
            return f"whether it goes with {', '.join([own, *near])} these runs cannot tell"
        return f"it goes with the {own}, whatever the " + " and the ".join(self.leads)

    @property
    def columns(self) -> dict[str, Array]:
        """The table that is written: places, force and band."""
        return {
            _WORDS[self.along][0]: self.places,
            "vertical_force_N": self.force_N[:, 0],
            "sigma_vertical_force_N": self.sigma_N[:, 0],
            "lateral_force_N": self.force_N[:, 1],
            "sigma_lateral_force_N": self.sigma_N[:, 1],
            "moment_N_m": self.force_N[:, 2],
            "sigma_moment_N_m": self.sigma_N[:, 2],
        }

    @property
    def label(self) -> str:
        """The abscissa with its unit, for a figure."""
        return {"time": "time after the release, s", "height": "height, m", "speed": "upward speed, m/s"}[_WORDS[self.along][2]]

    @property
    def spacing(self) -> float:
        """From one place of the table to the next: beyond its neighbours a force at a single place has no part."""
        return self.along().constants_of(self.fit.problem.model)[2]

    def _axis(self, axis: int, positive: str, negative: str, force_unit: str) -> str:
        force, sigma = self.force_N[:, axis], self.sigma_N[:, axis]
        strong = np.abs(force) > _BAND * sigma
        if not strong.any():
            return ""
        peak = int(np.argmax(np.where(strong, np.abs(force), 0.0)))
        same = strong & (np.sign(force) == np.sign(force[peak]))
        first = last = peak
        while first > 0 and same[first - 1]:
            first -= 1
        while last < len(force) - 1 and same[last + 1]:
            last += 1
        side, unit = positive if force[peak] > 0 else negative, _WORDS[self.along][1]
        size = f"{abs(force[peak]):.3g} +- {sigma[peak]:.2g} {force_unit}"
        if len(force) == 1:
            return f"{side} about {self.places[peak]:.2f} {unit}, {size}"
        return (
            f"{side} between {self.places[first]:.2f} and {self.places[last]:.2f} {unit}, {size} at its largest ({self.places[peak]:.2f})"
        )


def estimate(before: Fit) -> MissingForce:
    """The missing force along that abscissa which suits all runs best, on top of base and releases.

    The abscissas are compared up to the stops, where the motion is steady, if the gap shows there.
    """
    early = before_the_stops(before.problem)
    hint = before if early is before.problem else solve(early, before.q)
    hint = hint if gap_test(hint).p_value < GAP_P else before
    costs = {along: fitted(hint, along, seen_parameters(hint, along)).cost for along in _WORDS}
    best = min(costs, key=lambda along: costs[along])
    leads = named_leads(best, {along: cost - costs[best] for along, cost in costs.items()}, hint.cost - costs[best])
    return read(fitted(before, best, seen_parameters(before, best)), best, leads)


def named_leads(best: Along, short: Mapping[Along, float], closed: float) -> dict[str, float]:
    """What the other abscissas leave of what the best one closes, by name."""
    return {_WORDS[along][2]: left / max(closed, 1e-12) for along, left in short.items() if along is not best}


def at_once(before: Fit) -> MissingForce:
    """The missing force along time by a single step along a fit's straight lines: where the gap is, before anything is named."""
    problem, start = with_table(before, ForceAlongTime)
    free = seen_parameters(before, ForceAlongTime)
    new = [i for i in free if i >= len(before.q)]
    jacobian = np.hstack([before.jacobian, problem.jacobian(start, new, before.gaps)[1]])
    step = np.linalg.lstsq(jacobian, -before.gaps, rcond=1e-12)[0]
    start[free] += step
    return read(Fit(problem, start, before.gaps + jacobian @ step, _spread_out(jacobian, free, len(start)), False), ForceAlongTime, {})


def chance_of_force(fit: Fit) -> float:
    """How likely a force along time gains as much as it does if what is left is noise; one without films.

    It is keener than the test of slow against fast parts, for it looks only at what a force on the platform can do.
    """
    if not fit.problem.films:
        return 1.0
    found = at_once(fit).fit
    return chance_of_columns(fit, fit.free_of_parameters(found.jacobian[:, len(fit.q) :]))


def _spread_out(jacobian: Array, columns: list[int], size: int) -> Array:
    whole = np.zeros((len(jacobian), size))
    whole[:, columns] = jacobian
    return whole


def with_table(before: Fit, along: Along) -> tuple[Problem, Array]:
    """The problem with a table that is unknown, and its parameters where the table is zero."""
    problem = before.problem.with_another(along())
    return problem, laid_out(before, problem)


def fitted(before: Fit, along: Along, free: list[int]) -> Fit:
    """A table fitted with base and releases; only the parameters `free` may move."""
    problem, start = with_table(before, along)
    found = solve(problem, start, free=free, most_steps=_MOST_STEPS, enough=ROUGHLY)
    return replace(found, jacobian=_spread_out(found.jacobian, free, len(found.q)), moved=None)


def seen_parameters(before: Fit, along: Along) -> list[int]:
    """All parameters that were there, and of the table those behind which a film still runs, of the axes along which films tell the motion.

    A moment moves the platform sideways as a lateral force does; without its rotation the two would only stand against each other.
    """
    last = max(float(film.time_s[film.time_s <= before.problem.until_s][-1]) for film in before.problem.films)
    seen = np.arange(KNOTS) * SPACING_S <= last if along is ForceAlongTime else np.ones(KNOTS, dtype=bool)
    told = {channel for film in before.problem.films for channel in film.channels}
    axes = np.array([channel in told for channel in _MOVES])
    return [*range(len(before.q)), *(len(before.q) + np.flatnonzero(np.outer(axes, seen))).tolist()]


def read(found: Fit, along: Along, leads: dict[str, float]) -> MissingForce:
    """A table that was fitted, from the first to the last place that had a say; what was not estimated there has no band (NaN)."""
    first = len(found.q) - AXES * KNOTS
    estimated = (np.linalg.norm(found.jacobian[:, first:], axis=0) > 0).reshape(AXES, KNOTS).T
    had_a_say = np.flatnonzero(estimated.any(axis=1))
    used = slice(had_a_say[0], had_a_say[-1] + 1) if len(had_a_say) else slice(0)
    spread = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    scale = found.problem.scales[first:]
    values, sigma = ((row[first:] * scale).reshape(AXES, KNOTS).T for row in (found.q, spread))
    band = np.where(estimated, sigma, np.nan)
    return MissingForce(along, along.places(found.problem.model)[used], values[used], band[used], found, leads)
