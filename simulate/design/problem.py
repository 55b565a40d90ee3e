"""A design problem: what is free between which bounds, what varies, what is to be small and what must hold."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.design.measures import COST, FAILED, Limit, Measure, Scenarios
from simulate.model import responses
from simulate.model.model import Model, value_of, with_value
from simulate.model.possible import impossible
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import Factor
from simulate.sweeps.limits import FAILURE_DEG
from simulate.sweeps.sweep import Sweep

TOLERANCE = "tolerance."
_RANGE = re.compile(r"(?P<low>[-+0-9.eE]{1,40})\.\.(?P<high>[-+0-9.eE]{1,40})")
_MOST_CORNERS = 6  # factors whose corners are tried all
_WORST = 1e12  # stands for what cannot be

Responder = Callable[[Sweep, Array], Array]


def on_batch_kernel(sweep: Sweep, coded: Array) -> Array:
    """Responses (rows, responses.COUNT) of a candidate at coded levels of what varies."""
    return sweep.responses_at(coded)


@dataclass(frozen=True)
class Free:
    """A value of the model, or with `tolerance.` before it the spread of what varies, free between two bounds."""

    key: str
    low: float
    high: float

    @classmethod
    def of(cls, text: str) -> Free:
        """From `KEY=LOW..HIGH`.

        Raises
        ------
        InputError
            Bounds that cannot be read, or are none.
        """
        key, _, levels = (part.strip() for part in text.partition("="))
        found = _RANGE.fullmatch(levels)
        try:
            low, high = (float(found["low"]), float(found["high"])) if found else (np.nan, np.nan)
        except ValueError:
            low, high = np.nan, np.nan
        if not (np.isfinite([low, high]).all() and low < high):
            raise InputError(f'--free "{text}": is written KEY=LOW..HIGH with LOW below HIGH, such as end_stop.damping_N_s_per_m=5..80.')
        if key.startswith(TOLERANCE) and low <= 0.0:
            raise InputError(f"--free {text}: a tolerance is above zero.")
        return cls(key, low, high)


@dataclass(frozen=True)
class Problem:
    """What is to be designed. Plain data but for `respond`, which computes responses, by default on the batch kernel.

    factors : what varies from rig to rig and from run to run, as in a sweep. costs : of each tolerance that is free, one by default: the
        cost of all is the sum of cost x (tolerance as given) / tolerance. draws : of what varies, a power of two.
    """

    model: Model
    free: tuple[Free, ...]
    objective: Measure
    limits: tuple[Limit, ...] = ()
    factors: tuple[Factor, ...] = ()
    costs: Mapping[str, float] = field(default_factory=dict)
    draws: int = 64
    failure_deg: float = FAILURE_DEG
    seed: int = 0
    respond: Responder = on_batch_kernel

    def require_usable(self) -> None:
        """Refuse what cannot be designed, everything at once.

        Raises
        ------
        InputError
            A key that the model or its tolerances do not have, one that is named twice, a measure that nothing feeds.
        """
        wrong = [*self._wrong_keys(), *self._wrong_measures()]
        if wrong:
            raise InputError("\n".join(wrong))
        bounds = np.array([(free.low, free.high) for free in self.free])
        if all(self.candidate(corner) is None for corner in (bounds.mean(axis=1), bounds[:, 0], bounds[:, 1])):
            raise InputError("neither the middle nor the ends of what is --free is a model that can be; narrow the bounds.")

    def candidate(self, values: Array) -> Sweep | None:
        """The model with these values, and what varies about it; None where it cannot be."""
        model, factors = self.model, list(self.factors)
        try:
            for free, value in zip(self.free, values.tolist(), strict=True):
                if free.key.startswith(TOLERANCE):
                    place = self._places[free.key.removeprefix(TOLERANCE)]
                    middle = (factors[place].low + factors[place].high) / 2
                    factors[place] = replace(factors[place], low=middle - value, high=middle + value)
                else:
                    model = with_value(model, free.key, value)
            moved = tuple(self._about(model, factor) for factor in factors)
            sweep = Sweep(model, moved, design_of("random", max(len(moved), 1), 1, self.seed))
            return None if impossible(model) else sweep
        except (InputError, ValueError):
            return None

    def measured(self, values: Array, scenarios: Scenarios | None = None) -> Array:
        """Objective and measures of the limits of one candidate; very large where it cannot be."""
        sweep, of = self.candidate(values), scenarios or self.scenarios
        measures = [self.objective, *(limit.measure for limit in self.limits)]
        if sweep is None:
            return np.full(len(measures), _WORST)
        answers = np.empty((0, responses.COUNT))
        if any(measure.kind != COST for measure in measures):
            try:
                answers = self.respond(sweep, of.levels)
            except InputError:  # too stiff to be simulated, or what varies makes it none
                return np.full(len(measures), _WORST)
        found = [self.cost(values) if m.kind == COST else m.value(answers, of, self.failure_deg) for m in measures]
        return np.nan_to_num(np.array(found), nan=_WORST, posinf=_WORST)

    def cost(self, values: Array) -> float:
        """Of the tolerances: each in inverse proportion to its size, one as it was given."""
        total = 0.0
        for free, value in zip(self.free, values.tolist(), strict=True):
            if free.key.startswith(TOLERANCE):
                key = free.key.removeprefix(TOLERANCE)
                factor = self.factors[self._places[key]]
                total += self.costs.get(key, 1.0) * (factor.high - factor.low) / 2 / value
        return total

    @cached_property
    def scenarios(self) -> Scenarios:
        """What every candidate is tried on: the same for all, so that they are compared fairly."""
        return self.drawn(self.draws, self.seed)

    def drawn(self, draws: int, seed: int) -> Scenarios:
        """The middle, so many draws of what varies, and the corners of what has two ends."""
        count = len(self.factors)
        if not count:
            return Scenarios(np.zeros((1, 0)), 0)
        normal = [i for i, factor in enumerate(self.factors) if factor.normal]
        two_ended = [i for i in range(count) if i not in normal]
        drawn = design_of("sobol", count, draws, seed, normal).piece(0, draws)
        corners = np.zeros((0, count))
        if 0 < len(two_ended) <= _MOST_CORNERS:
            corners = np.zeros((2 ** len(two_ended), count))
            corners[:, two_ended] = list(product((-1.0, 1.0), repeat=len(two_ended)))
        return Scenarios(np.vstack([np.zeros((1, count)), drawn, corners]), draws)

    @cached_property
    def given(self) -> Array:
        """Values of what is free as the model and the tolerances stand."""
        return np.array([self._given(free) for free in self.free])

    def _given(self, free: Free) -> float:
        if free.key.startswith(TOLERANCE):
            factor = self.factors[self._places[free.key.removeprefix(TOLERANCE)]]
            return (factor.high - factor.low) / 2
        return value_of(self.model, free.key)

    def _about(self, model: Model, factor: Factor) -> Factor:
        """A factor about the candidate's own value, where it is given about the model's."""
        shift = value_of(model, factor.key) - value_of(self.model, factor.key)
        return replace(factor, low=factor.low + shift, high=factor.high + shift)

    @cached_property
    def _places(self) -> dict[str, int]:
        return {factor.key: i for i, factor in enumerate(self.factors)}

    def _wrong_keys(self) -> list[str]:
        keys, wrong = [free.key for free in self.free], []
        if not keys:
            wrong.append("nothing is free; give --free KEY=LOW..HIGH.")
        wrong += [f"--free {key} is given twice; keep one." for key in dict.fromkeys(keys) if keys.count(key) > 1]
        for key in keys:
            if key.startswith(TOLERANCE) and key.removeprefix(TOLERANCE) not in self._places:
                wrong.append(f"--free {key}: nothing varies by that name; give --factor {key.removeprefix(TOLERANCE)}=sigma:... too.")
            elif not key.startswith(TOLERANCE):
                try:
                    value_of(self.model, key)
                except KeyError:
                    wrong.append(f"--free {key}: is no number of the model. Name one as in the model file, such as platform.mass_kg.")
        wrong += [f"--cost {key}: its tolerance is not free." for key in self.costs if TOLERANCE + key not in keys]
        return wrong

    def _wrong_measures(self) -> list[str]:
        measures = [self.objective, *(limit.measure for limit in self.limits)]
        varies = any(m.kind in ("spread", "robust", FAILED) or m.kind.startswith("p") for m in measures)
        wrong = []
        if varies and not self.factors:
            wrong.append("a spread, a quantile or a share of failures asks for something that varies; give --factor.")
        if any(m.kind == COST for m in measures) and not any(free.key.startswith(TOLERANCE) for free in self.free):
            wrong.append("cost is that of tolerances; give --free tolerance.KEY=LOW..HIGH.")
        if self.objective.kind == COST and not self.limits:
            wrong.append("the least cost is no accuracy at all; give --subject-to too.")
        return wrong


def factor_costs(settings: Sequence[str]) -> dict[str, float]:
    """Costs of tolerances from `KEY=NUMBER`.

    Raises
    ------
    InputError
        It cannot be read.
    """
    found: dict[str, float] = {}
    for text in settings:
        key, _, number = (part.strip() for part in text.partition("="))
        try:
            found[key] = float(number)
        except ValueError:
            found[key] = np.nan
        if not (np.isfinite(found[key]) and found[key] > 0.0):
            raise InputError(f'--cost "{text}": is written KEY=NUMBER with a number above zero.')
    return found
