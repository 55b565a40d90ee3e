"""The unknowns of a problem: force law, releases and effects, each a number in units of its own scale; and what a fit says of one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.measures import Measures
from simulate.model.model import Model, per_leg

LINE_NAMES = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N")
BETA_NAME = "beta_per_m"
BASE = (*LINE_NAMES, BETA_NAME, "initial_force_N")
POSE = (*(f"position_{axis}_m" for axis in "xyz"), *(f"theta_{axis}_rad" for axis in "xyz"))
STORED_FORCE = "stored_force_fraction"


@dataclass(frozen=True)
class Parameter:
    """One unknown: a number q in units of its own scale, zero where the model file has it.

    name : as users see it: `beta_per_m`, `hub-inertia.mass_kg`, `test2.release.theta_z_rad`, `loop-1Hz.zero_N`.
    scale : in its own unit. spread : one standard deviation of its prior, in scales; infinite where there is none.
    low, high : bounds, in scales. run : the run whose own it is, nothing where it is common to all.
    start : its value where q is zero. log : whether q counts its logarithm, value = start exp(q scale / start).
    vary : whether a fit moves it.
    """

    name: str
    scale: float
    spread: float
    low: float
    high: float
    run: str = ""
    start: float = 0.0
    log: bool = False
    vary: bool = True

    @cached_property
    def key(self) -> str:
        """The last part of the name: what it is, without whose."""
        return self.name.rpartition(".")[2]

    def shift(self, q: float) -> float:
        """How far a value is from the start, in the parameter's unit."""
        way = q * self.scale
        return self.start * float(np.expm1(np.clip(way / self.start, -30.0, 30.0))) if self.log else way

    def value(self, q: float) -> float:
        """The value in the parameter's own unit."""
        return self.start + self.shift(q)

    def slope(self, q: float) -> float:
        """Change of the value with q."""
        return self.scale * (self.value(q) / self.start if self.log else 1.0)

    def place_of_shift(self, shift: float) -> float:
        """The q at which the value is so far from the start."""
        if not self.log or not np.isfinite(shift):
            return shift / self.scale
        return self.start * float(np.log1p(shift / self.start)) / self.scale if shift > -self.start else -np.inf

    def place(self, value: float) -> float:
        """The q at which the parameter has this value."""
        return self.place_of_shift(value - self.start)


@dataclass(frozen=True)
class Change:
    """What a user wants of a parameter: that it is held, kept within bounds, or begins at a value, each in its own unit."""

    name: str
    value: float | None = None
    held: bool = False
    low: float | None = None
    high: float | None = None

    def to(self, parameter: Parameter) -> Parameter:
        """The parameter so changed; where a search begins is the problem's business."""
        low = parameter.low if self.low is None else parameter.place(self.low)
        high = parameter.high if self.high is None else parameter.place(self.high)
        return replace(parameter, low=low, high=high, vary=parameter.vary and not self.held)


def changed(parameters: Sequence[Parameter], changes: Sequence[Change]) -> tuple[Parameter, ...]:
    """The parameters as a user wants them; a change of a name that is not there changes nothing."""
    by_name: dict[str, list[Change]] = {}
    for change in changes:
        by_name.setdefault(change.name, []).append(change)
    made = []
    for parameter in parameters:
        for change in by_name.get(parameter.name, ()):
            parameter = change.to(parameter)
        made.append(parameter)
    return tuple(made)


def lines_of(model: Model) -> Array:
    """Force law of the actuator on the shaker, (5,) a_l, b_l, a_u, b_u, beta: the mean where the legs differ."""
    return np.array([float(np.mean(per_leg(getattr(model.actuator, name)))) for name in BASE[:5]])


def rate_parameters(lines: Sequence[Parameter], order: int) -> list[Parameter]:
    """How the four lines follow the rate: the coefficients of z, z^2 ... behind the constant one, z from -1 to 1 over the rates seen."""
    return [Parameter(f"rate.{line.name}[{j}]", line.scale, np.inf, -np.inf, np.inf) for line in lines for j in range(1, order + 1)]


def effect_parameters(effect: Effect, model: Model, measures: Measures, spread: float) -> list[Parameter]:
    """The parameters of an effect within their bounds on a rig of these measures; zero is where the effect has them."""
    bounds = effect.own_bounds(model, measures).values()
    rows = zip(effect.flat_names(), effect.flat(), effect.typical(measures), bounds, strict=True)
    narrowest = min(spread, effect.prior_spread(model, measures))
    return [
        Parameter(f"{effect.name}.{name}", float(t), narrowest, float((low - value) / t), float((high - value) / t), start=float(value))
        for name, value, t, (low, high) in rows
    ]


def amplitudes_of(kind: type[Effect]) -> tuple[list[bool], list[bool]]:
    """Of each flat parameter, whether it is an amplitude and not a shape; and whether the effect grows in proportion to it."""
    rows = [(not meta["starts"], meta["linear"]) for meta in _metadata_of(kind)]
    return [amplitude for amplitude, _ in rows], [amplitude and linear for amplitude, linear in rows]


def sizes_unknown(kind: type[Effect]) -> list[bool]:
    """Of each flat parameter, whether only measurements tell how large it is: an amplitude to which the effect grows in proportion.

    A shape is known as far as its effect makes sense. Of values of the legs the common part is the law's own.
    """
    of_legs = [meta["mirror"] == "legs" for meta in _metadata_of(kind)]
    return [free and not legs for free, legs in zip(amplitudes_of(kind)[1], of_legs, strict=True)]


def _metadata_of(kind: type[Effect]) -> list[Mapping[str, Any]]:
    """What a class says of each parameter, laid flat."""
    by_name = {item.name: item.metadata for item in fields(kind)}
    return [by_name[name.partition("[")[0]] for name in kind.flat_names()]


Word = Literal[
    "ok", "approximate", "at-bound", "not-identifiable", "loops-disagree", "did-not-converge", "data-bad", "model-does-not-apply"
]


@dataclass(frozen=True)
class Estimate:
    """A fitted number: value, one standard deviation, 95 % interval, and whether the data determine it."""

    value: float
    stderr: float
    ci95: tuple[float, float]
    verdict: Word
