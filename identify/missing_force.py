"""The force that is missing where no known effect fits: estimated as it ran in time, with its band.

The force is unknown input to the six-leg model: a table of vertical and lateral values at fixed instants after the
release, straight lines between. It is an effect like any other, so it is fitted together with base and releases and is
the same in every run; but it has no physics and is never a name.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from measure.tables import Array
from simulate.effect import PlatformEffect, parameter

from .fit import Fit, solve

KNOTS, SPACING_S = 16, 0.05
_BAND = 3.0


@dataclass(frozen=True)
class ForceHistory(PlatformEffect):
    """A force on the platform that runs in time: F_z and F_x at 0, 0.05, 0.1 ... s after the release, linear between.

    Behind the last instant it stays.
    """

    name = "missing-force"
    vertical_N: tuple[float, ...] = parameter((0.0,) * KNOTS, low=-1e3, high=1e3, typical=0.02, doc="F_z at the instants")
    lateral_N: tuple[float, ...] = parameter((0.0,) * KNOTS, low=-1e3, high=1e3, typical=0.02, doc="F_x at the instants")

    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the force of this instant, N."""
        place = min(max(t / 0.05, 0.0), 14.999999)
        left = int(place)
        share = place - left
        wrench[2] += p[left] + share * (p[left + 1] - p[left])
        wrench[0] += p[16 + left] + share * (p[17 + left] - p[16 + left])


@dataclass(frozen=True)
class MissingForce:
    """The estimated force: time_s (KNOTS,), force and one standard deviation (KNOTS, 2), vertical and lateral, N."""

    time_s: Array
    force_N: Array
    sigma_N: Array
    fit: Fit

    @property
    def sentence(self) -> str:
        """What the force does, for a person to act on."""
        words = [w for w in (self._axis(0, "upwards", "downwards"), self._axis(1, "to the right", "to the left")) if w]
        return "The missing force " + " and ".join(words) + "." if words else "No missing force stands out of its band at any instant."

    @property
    def columns(self) -> dict[str, Array]:
        """The table that is written: instants, force and band."""
        return {
            "time_s": self.time_s,
            "vertical_force_N": self.force_N[:, 0],
            "sigma_vertical_force_N": self.sigma_N[:, 0],
            "lateral_force_N": self.force_N[:, 1],
            "sigma_lateral_force_N": self.sigma_N[:, 1],
        }

    def _axis(self, axis: int, positive: str, negative: str) -> str:
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
        side = positive if force[peak] > 0 else negative
        return (
            f"acts {side} on the platform between {self.time_s[first]:.2f} and {self.time_s[last]:.2f} s after the release, "
            f"{abs(force[peak]):.3g} +- {sigma[peak]:.2g} N at its largest ({self.time_s[peak]:.2f} s)"
        )


def estimate(before: Fit) -> MissingForce:
    """Fit a force history on top of base and releases, in the first films' time range.

    Knots behind the last frame stay at zero.
    """
    problem = before.problem.with_effects((*before.problem.effects, ForceHistory()))
    last = max(float(film.time_s[-1]) for film in problem.films)
    seen = np.arange(KNOTS) * SPACING_S <= last
    first = len(problem.knobs) - 2 * KNOTS
    free = [*range(first), *(first + np.flatnonzero(np.tile(seen, 2)))]
    found = solve(problem, np.concatenate([before.q, np.zeros(2 * KNOTS)]), free=free, most_steps=15)
    sigma = np.full(len(problem.knobs), np.nan)
    sigma[free] = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    scale = problem.scales[first:]
    values = (found.q[first:] * scale).reshape(2, KNOTS).T
    return MissingForce(np.arange(KNOTS)[seen] * SPACING_S, values[seen], (sigma[first:] * scale).reshape(2, KNOTS).T[seen], found)
