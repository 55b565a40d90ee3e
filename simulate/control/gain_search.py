"""Gains of a law that keep abs(theta_z) within what is required, on the corners of what differs: least force first, then least energy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field
from typing import Any, NamedTuple

import numpy as np

from measure.common.arrays import Array
from simulate.control.task import LIMIT, Requirement
from simulate.control.trials import Trials, deployed, turned_deg
from simulate.model import responses
from simulate.model.control import Controller, SampledController
from simulate.model.model import Model
from simulate.model.rig import per_leg, stroke_of

OBSERVER = "observer_Hz"
_COARSE, _FINE, _LEVELS, _AT_A_LEVEL, _FOR_ENERGY = 32, 16, 5, 10, 12  # the first a power of two, as Sobol points want
_LEAST_SHARE = 0.05  # of the force limit that is allowed, below which no limit is tried
_BEYOND = 1e6  # what stands for a run that diverged


class Scales(NamedTuple):
    """By what the ranges of gains follow from the rig: by how much two legs may differ, stored force, stroke, time to full height, and
    the time in which that has to be reached."""

    gap_N: float
    force_N: float
    stroke_m: float
    rise_s: float
    duration_s: float


def scales_of(model: Model, disparity: float, rise_s: float) -> Scales:
    """The scales of a rig whose stored forces may be off by a share of them."""
    force = float(np.mean(np.abs(per_leg(model.actuator.b_l_N))))
    return Scales(2.0 * disparity * force, force, float(np.mean(stroke_of(model))), rise_s, model.simulation.duration_s)


def ranges_of(kind: type[Controller], scales: Scales, fixed: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    """Between what each gain of a law is searched, by the unit in its name; gains with a default, or that are given, stay."""
    speed = scales.stroke_m / scales.rise_s
    by_unit = {
        "_N_per_m": (20.0 * scales.gap_N / scales.stroke_m, 5000.0 * scales.gap_N / scales.stroke_m),
        "_N_s_per_m": (0.1 * scales.gap_N / speed, 10.0 * scales.force_N / speed),
        "_N": (0.2 * scales.gap_N, 4.0 * scales.force_N),
        "_s": (scales.rise_s, max(scales.duration_s, 1.1 * scales.rise_s)),
    }
    fields = kind.__dataclass_fields__
    free = [name for name in kind.gains() if fields[name].default is MISSING and name not in fixed]
    found = {name: next((limits for unit, limits in by_unit.items() if name.endswith(unit)), (1e-3, 1e3)) for name in free}
    rate = fixed.get("sample_rate_Hz")
    if issubclass(kind, SampledController) and rate and OBSERVER not in fixed:
        found[OBSERVER] = (2.0 / scales.rise_s, rate / 5.0)
    return found


class Found(NamedTuple):
    """A controller that was tried: how far it is from what is required (at most 1 is enough), and the mean energy it takes out."""

    controller: Controller
    shortfall: float
    energy_J: float


@dataclass
class Search:
    """The search for the gains of one law; every controller that was tried stands in `tried`.

    reserve : the angles are required to be smaller by this factor on the corners.
    """

    kind: type[Controller]
    fixed: Mapping[str, Any]
    ranges: Mapping[str, tuple[float, float]]
    trials: Trials
    requirements: Sequence[Requirement]
    reserve: float = 1.0
    tried: list[Found] = field(default_factory=list)

    def least(self, most_N: float, seed: int) -> Found | None:
        """The controller with the least force limit up to `most_N`, and of those the least energy; None where none is good enough."""
        self.best(most_N, seed)
        return self._least_energy(self._least_force(most_N)) if self._good(most_N) else None

    @property
    def most_tries(self) -> int:
        """About how many controllers `least` tries, each on all rigs."""
        return _COARSE + _FINE + _LEVELS * _AT_A_LEVEL + _FOR_ENERGY

    def best(self, limit_N: float | None, seed: int, points: int = _COARSE, fine: int = _FINE) -> Found:
        """The controller that comes nearest to what is required at a force limit: points spread over the ranges, then downhill."""
        from scipy.stats import qmc

        spread = qmc.Sobol(max(len(self.ranges), 1), rng=seed).random(points) if self.ranges else np.empty((1, 0))
        coarse = [self._try(x, limit_N) for x in spread]
        start = spread[int(np.argmin([found.shortfall for found in coarse]))]
        self._downhill(start, limit_N, fine, lambda found: found.shortfall)
        return min(self.tried, key=lambda found: found.shortfall)

    def untold(self, limit_N: float) -> None:
        """One try, in the middle of the ranges, that is not kept: how long it takes is asked."""
        self._try(np.full(len(self.ranges), 0.5), limit_N)
        self.tried.pop()

    def nearest(self) -> Found:
        """Of all that were tried, the one that came nearest."""
        return min(self.tried, key=lambda found: found.shortfall)

    def _good(self, limit_N: float) -> list[Found]:
        return [f for f in self.tried if f.shortfall <= 1.0 and _limit(f) <= limit_N * (1.0 + 1e-9)]

    def _least_force(self, most_N: float) -> float:
        """The least force limit that was found to be enough, by halving the range of its logarithm."""
        low, high = _LEAST_SHARE * most_N, most_N
        for _ in range(_LEVELS):
            middle = _rounded(math.sqrt(low * high))
            near = min(self._good(high), key=lambda f: f.shortfall)
            self._downhill(self._place(near.controller), middle, _AT_A_LEVEL, lambda found: found.shortfall)
            low, high = (low, middle) if self._good(middle) else (middle, high)
        return high

    def _least_energy(self, limit_N: float) -> Found:
        start = min(self._good(limit_N), key=lambda f: f.energy_J)
        scale = max(start.energy_J, 1e-12)
        self._downhill(
            self._place(start.controller), limit_N, _FOR_ENERGY, lambda f: f.energy_J / scale + 10.0 * max(f.shortfall - 1.0, 0.0)
        )
        return min(self._good(limit_N), key=lambda f: f.energy_J)

    def _downhill(self, start: Array, limit_N: float | None, tries: int, cost: Callable[[Found], float]) -> None:
        """Nelder and Mead from a place on; what it tries is kept."""
        from scipy.optimize import minimize

        if not self.ranges:
            return
        simplex = np.vstack([start, *(start + 0.15 * (1.0 if start[i] < 0.5 else -1.0) * row for i, row in enumerate(np.eye(len(start))))])
        minimize(lambda x: cost(self._try(x, limit_N)), start, method="Nelder-Mead", options={"maxfev": tries, "initial_simplex": simplex})

    def _place(self, controller: Controller) -> Array:
        """Where a controller stands in the ranges, each from 0 to 1 in its logarithm."""
        ends = [(getattr(controller, name), *self.ranges[name]) for name in self.ranges]
        return np.array([math.log(value / low) / math.log(high / low) for value, low, high in ends])

    def _try(self, place: Array, limit_N: float | None) -> Found:
        inside = np.clip(place, 0.0, 1.0)
        gains = {name: _rounded(low * (high / low) ** x) for x, (name, (low, high)) in zip(inside, self.ranges.items(), strict=True)}
        limit = {} if limit_N is None or self.kind.passive else {LIMIT: _rounded(limit_N)}
        controller = self.kind(**{**self.fixed, **gains, **limit})
        answers = self.trials.answers(controller)
        energy = float(np.nan_to_num(np.mean(answers[:, responses.CONTROL_ENERGY]), nan=_BEYOND))
        found = Found(controller, self.reserve * shortfall(answers, self.requirements), energy)
        self.tried.append(found)
        return found


def shortfall(answers: Array, requirements: Sequence[Requirement]) -> float:
    """The largest share of the required angles that is reached with the required probability: at most 1 where all is kept.

    A run that does not get to the full height has not kept anything.
    """
    turned = np.minimum(np.where(deployed(answers), turned_deg(answers), np.inf), _BEYOND)
    return max(float(np.quantile(turned, r.probability, method="higher")) / r.angle_deg for r in requirements)


def _limit(found: Found) -> float:
    return float(getattr(found.controller, LIMIT, 0.0))


def _rounded(value: float) -> float:
    """Three digits: nobody sets a gain more finely."""
    return float(f"{value:.3g}")
