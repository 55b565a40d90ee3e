"""The search: candidates spread over all bounds first, then a local search, and the best one tried on draws that it has not seen.

Differential evolution keeps a population and prefers, of two candidates, the one that breaks the limits less (Lampinen 2002,
doi:10.1109/CEC.2002.1004459); COBYLA then goes on from the best one by linear models. Both are scipy's, on variables between 0 and 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.design.measures import FAILED, Scenarios
from simulate.design.problem import TOLERANCE, Problem
from simulate.model.model import Model
from simulate.sweeps.sweep import wilson

_POPULATION = 8  # candidates of a generation for each value that is free
_LOCAL_SHARE = 0.25  # of all evaluations
_FRESH = 1024
_AT_BOUND = 1e-3  # of the range
_REACH = 0.05  # of the range, within which the local search begins


@dataclass(frozen=True)
class Found:
    """The best candidate: its values, its measures on the draws of the search and on fresh ones, and those of what was given."""

    problem: Problem
    values: Array
    before: Array
    searched: Array
    fresh: Array
    fresh_runs: int
    evaluations: int

    @property
    def model(self) -> Model:
        """The model with the values found."""
        sweep = self.problem.candidate(self.values)
        return self.problem.model if sweep is None else sweep.model

    @property
    def verdict(self) -> str:
        """found; not-kept: a limit does not hold on fresh draws; none-feasible: on no candidate that was tried."""
        limits = self.problem.limits
        if not all(limit.kept(value) for limit, value in zip(limits, self.searched[1:], strict=True)):
            return "none-feasible"
        return "found" if all(limit.kept(value) for limit, value in zip(limits, self.fresh[1:], strict=True)) else "not-kept"

    @property
    def report(self) -> dict[str, Any]:
        """As the command's JSON gives it."""
        problem = self.problem
        measures = zip(problem.limits, self.before[1:], self.searched[1:], self.fresh[1:], strict=True)
        return {
            "verdict": self.verdict,
            "free": [
                {"key": f.key, "low": f.low, "high": f.high, "before": before, "value": value, "at_bound": _bound(f.low, f.high, value)}
                for f, before, value in zip(problem.free, problem.given.tolist(), self.values.tolist(), strict=True)
            ],
            "objective": {"measure": str(problem.objective), **self._stages(0), **self._interval(str(problem.objective), self.fresh[0])},
            "limits": [
                {
                    "measure": str(limit.measure),
                    "below" if limit.below else "above": limit.limit,
                    "before": before,
                    "searched": searched,
                    "fresh": fresh,
                    "kept": limit.kept(fresh),
                    **self._interval(str(limit.measure), fresh),
                }
                for limit, before, searched, fresh in measures
            ],
            "factors": [{"key": f.key, "low": f.low, "high": f.high, "normal": f.normal} for f in problem.factors],
            "draws": problem.draws if problem.factors else 0,
            "fresh_draws": self.fresh_runs,
            "evaluations": self.evaluations,
        }

    def _stages(self, place: int) -> dict[str, float]:
        return {"before": self.before[place], "searched": self.searched[place], "fresh": self.fresh[place]}

    def _interval(self, measure: str, value: float) -> dict[str, Any]:
        """Of a share, its 95 % interval on the fresh draws."""
        if measure != FAILED or not self.fresh_runs:
            return {}
        low, high = wilson(round(value / 100.0 * self.fresh_runs), self.fresh_runs)
        return {"interval_percent": [100.0 * low, 100.0 * high]}


def design_deployment(problem: Problem, evaluations: int = 400, progress: Callable[[int], object] | None = None) -> Found:
    """Search the bounds for the values with the least objective that keep all limits.

    Parameters
    ----------
    evaluations : about as many candidates are tried, each on all scenarios. progress : called with the number tried so far.

    Raises
    ------
    InputError
        A problem that cannot be posed; see `Problem.require_usable`.
    """
    problem.require_usable()
    tried = _Tried(problem, progress)
    best = _over_all(tried, evaluations)
    best = _nearby(tried, best, evaluations)
    values = tried.values_of(best)
    fresh = problem.drawn(_FRESH, problem.seed + 1) if problem.factors else problem.scenarios
    measured = problem.measured(values, fresh)
    return Found(problem, values, problem.measured(problem.given), tried.at(best), measured, _draws(problem, fresh), len(tried.known))


class _Tried:
    """Candidates that were tried, each once; places are between 0 and 1."""

    def __init__(self, problem: Problem, progress: Callable[[int], object] | None) -> None:
        self.problem, self.progress = problem, progress
        self.known: dict[bytes, Array] = {}
        self.low, self.high = np.array([free.low for free in problem.free]), np.array([free.high for free in problem.free])
        # a tolerance may go over decades
        self.by_size = np.array([free.key.startswith(TOLERANCE) for free in problem.free])

    def values_of(self, place: Array) -> Array:
        """What is free, from a place."""
        place = np.clip(place, 0.0, 1.0)
        even = self.low + place * (self.high - self.low)
        with np.errstate(divide="ignore", invalid="ignore"):
            sized = self.low * (self.high / self.low) ** place
        return np.where(self.by_size, sized, even)

    def place_of(self, values: Array) -> Array:
        """A place, from what is free; outside the bounds at the nearest end."""
        within = np.clip(values, self.low, self.high)
        with np.errstate(divide="ignore", invalid="ignore"):
            sized = np.log(within / self.low) / np.log(self.high / self.low)
        return np.where(self.by_size, sized, (within - self.low) / (self.high - self.low))

    def at(self, place: Array) -> Array:
        """Objective and measures at a place."""
        key = np.clip(place, 0.0, 1.0).tobytes()
        if key not in self.known:
            self.known[key] = self.problem.measured(self.values_of(place))
            if self.progress is not None:
                self.progress(len(self.known))
        return self.known[key]

    def excess(self, place: Array) -> Array:
        """By how much each limit is broken; below zero where it is kept."""
        measured = self.at(place)[1:]
        return np.array([limit.excess(value) for limit, value in zip(self.problem.limits, measured, strict=True)])

    def best(self, places: Sequence[Array]) -> Array:
        """Of some places the one with the least objective among those that keep the limits, else the one that breaks them least."""

        def rank(place: Array) -> tuple[float, float]:
            return float(np.sum(np.maximum(self.excess(place), 0.0))) if self.problem.limits else 0.0, float(self.at(place)[0])

        return min(places, key=rank)


def _over_all(tried: _Tried, evaluations: int) -> Array:
    """The best place of a population that has evolved, and of where the search stands from the outset."""
    from scipy.optimize import NonlinearConstraint, differential_evolution

    size = len(tried.problem.free)
    generations = max(1, int((1.0 - _LOCAL_SHARE) * evaluations / (_POPULATION * size)) - 1)
    limits = [NonlinearConstraint(tried.excess, -np.inf, 0.0)] if tried.problem.limits else []
    start = tried.place_of(tried.problem.given)
    found = differential_evolution(
        lambda place: float(tried.at(place)[0]),
        [(0.0, 1.0)] * size,
        maxiter=generations,
        popsize=_POPULATION,
        rng=np.random.default_rng([tried.problem.seed, 13]),
        constraints=limits or (),
        init="sobol",
        x0=start,
        polish=False,
        tol=1e-6,
    )
    return tried.best([start, np.asarray(found.x)])


def _nearby(tried: _Tried, start: Array, evaluations: int) -> Array:
    """The best place of a local search from there."""
    from scipy.optimize import minimize

    size = abs(float(tried.at(start)[0])) or 1.0
    limits = {"type": "ineq", "fun": lambda place: -tried.excess(place)}
    found = minimize(
        lambda place: float(tried.at(place)[0]) / size,
        start,
        method="COBYLA",
        bounds=[(0.0, 1.0)] * len(start),
        constraints=[limits] if tried.problem.limits else (),
        options={"rhobeg": _REACH, "maxiter": max(10, int(_LOCAL_SHARE * evaluations)), "tol": 1e-6},
    )
    kept = [np.frombuffer(key) for key in tried.known]
    return tried.best([start, np.clip(np.asarray(found.x), 0.0, 1.0), *kept])


def _draws(problem: Problem, scenarios: Scenarios) -> int:
    return scenarios.draws if problem.factors else 0


def _bound(low: float, high: float, value: float) -> str | None:
    if value - low < _AT_BOUND * (high - low):
        return "low"
    return "high" if high - value < _AT_BOUND * (high - low) else None
