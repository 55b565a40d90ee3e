"""How an effect is drawn: its shape by chance, its amount by what the runs can detect; and the shapes a rival could take.

parameters = off + amount * direction
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from simulate.effects import CATALOGUE
from simulate.model.effect import Effect
from simulate.model.model import Model

from .outside import KINDS as OUTSIDE

Array = np.ndarray
Chance = np.random.Generator

ONE_SIGN = (
    *("hub-inertia", "viscous-friction", "power-law-friction", "stribeck-friction", "force-relaxation", "backlash", "leg-mass"),
    *("joint-friction", "counterweight-inertia", "pulley-inertia", "pulley-friction", "cable-pendulum", "air-drag", "handrail-contact"),
    *("snag", "base-excitation", "series-play", "eddy-damping", "sensor-filter", "hardening-cable"),
)
# Shape parameters: drawn and not scaled. All others are amounts.
SHAPE = {
    "power-law-friction": ("exponent",),
    "stribeck-friction": ("speed_m_per_s",),
    "eddy-damping": ("speed_m_per_s",),
    "ripple": ("period_m", "phase_rad"),
    "lens-distortion": ("centre_m",),
    "transition-zone": ("length_m",),
    "force-relaxation": ("time_s",),
    "handrail-contact": ("clearance_m",),
    "base-excitation": ("frequency_Hz", "phase_rad", "axis[0]", "axis[1]", "axis[2]"),
}
# An amplitude times an axis or a sign, and where no force is left a phase, are not numbers of their own.
NOT_A_SIZE = {
    "ripple": ("force_N", "phase_rad"),
    "base-excitation": ("acceleration_m_per_s2", "phase_rad", "axis[0]", "axis[1]", "axis[2]"),
}


@dataclass(frozen=True)
class Hidden:
    """An effect along a line: off + amount * direction, both over the flat parameters.

    low, high : bounds of the flat parameters. linear : whether its force grows in proportion to the amount.
    """

    kind: type[Effect]
    off: Array
    direction: Array
    low: Array
    high: Array

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.kind.name

    @property
    def parameters(self) -> int:
        """How many numbers a fit of this effect has."""
        return len(self.off)

    @property
    def most(self) -> float:
        """The largest amount within the bounds."""
        room = np.where(self.direction > 0, self.high - self.off, self.low - self.off)[self.direction != 0]
        return float(np.min(room / self.direction[self.direction != 0]))

    def at(self, amount: float) -> Effect:
        """The effect of this amount."""
        return self.kind().with_flat(np.clip(self.off + amount * self.direction, self.low, self.high))


def line(kind: type[Effect], model: Model, off: Array, direction: Array) -> Hidden:
    """An effect along a line from what the model already has of it."""
    bounds = np.array(list(kind.bounds(model).values()))
    return Hidden(kind, off, direction, bounds[:, 0], bounds[:, 1])


def is_shape(kind: type[Effect]) -> Array:
    """Which flat parameters are shape."""
    return np.array([name in SHAPE.get(kind.name, ()) for name in kind.flat_names()])


def drawn(name: str, model: Model, reach_m: float, chance: Chance) -> Hidden:
    """An effect of this name with its shape and direction drawn; reach_m is how far the platform strays sideways at most."""
    kind = {**CATALOGUE, **OUTSIDE}[name]
    off = model.effect(kind).flat()
    shape = is_shape(kind)
    direction = np.where(shape, 0.0, kind.typical() * chance.normal(0.0, 1.0, len(off)))
    if len(off) - int(shape.sum()) == 1:
        direction = np.where(shape, 0.0, kind.typical() * chance.choice([-1.0, 1.0]))
    if name in ONE_SIGN:
        direction = np.abs(direction)
    off, direction = _own_ways(name, model, off, direction, reach_m, chance)
    return line(kind, model, off, direction)


def _own_ways(name: str, model: Model, off: Array, direction: Array, reach_m: float, chance: Chance) -> tuple[Array, Array]:
    """What is particular to one effect."""
    draws: dict[str, Callable[[], list[float]]] = {
        "power-law-friction": lambda: [chance.choice([chance.uniform(0.35, 0.75), chance.uniform(1.5, 2.8)])],
        "stribeck-friction": lambda: [float(np.exp(chance.uniform(np.log(0.03), np.log(0.3))))],
        "eddy-damping": lambda: [float(np.exp(chance.uniform(np.log(0.03), np.log(0.3))))],
        "ripple": lambda: [float(np.exp(chance.uniform(np.log(0.01), np.log(0.1)))), chance.uniform(-3.0, 3.0)],
        "lens-distortion": lambda: [chance.uniform(0.35, 0.55)],
        "transition-zone": lambda: [chance.uniform(0.04, 0.15)],
        "force-relaxation": lambda: [float(np.exp(chance.uniform(np.log(0.1), np.log(1.0))))],
        "handrail-contact": lambda: [chance.uniform(0.3, 0.7) * reach_m],
        "base-excitation": lambda: [chance.uniform(3.0, 25.0), chance.uniform(-3.0, 3.0), *_axis(chance)],
    }
    if name in draws:
        off = off.copy()
        off[is_shape({**CATALOGUE}[name])] = draws[name]()
    if name == "leg-disparity":
        direction = direction - direction.mean()
    if name == "end-stop-dissipation":
        direction = np.sign(direction) * 0.2 * model.end_stop.damping_N_s_per_m
    if name == "counterweight-inertia":
        direction = -0.05 * np.ones(1)
    return off, direction


def _axis(chance: Chance) -> tuple[float, float, float]:
    """In the picture's plane, so that one camera sees it."""
    angle = chance.uniform(0.0, 2.0 * np.pi)
    return float(np.cos(angle)), 0.0, float(np.sin(angle))


def rivals(kind: type[Effect], model: Model, reach_m: float) -> Iterator[tuple[Hidden, ...]]:
    """The shapes that an effect could take in a fit: for each, one line for every amount that it is free to choose."""
    off = model.effect(kind).flat()
    shape = is_shape(kind)
    for values in _grid(kind.name, reach_m):
        at = off.copy()
        at[shape] = values[0] if values else []
        units = [np.where(np.arange(len(off)) == i, kind.typical(), 0.0) for i in np.flatnonzero(~shape)]
        if kind.name == "counterweight-inertia":
            units = [np.array([-0.05])]
        lines = [line(kind, model, at, unit) for unit in units]
        if len(values) > 1:
            other = off.copy()
            other[shape] = values[1]
            lines += [line(kind, model, other, unit) for unit in units]
        yield tuple(lines)


def _grid(name: str, reach_m: float) -> list[tuple[list[float], ...]]:
    """Shape parameters of the rivals; two of them side by side where a phase is free."""
    rows: dict[str, list[float]] = {
        "power-law-friction": [0.3, 0.5, 0.8, 1.3, 1.6, 2.0, 2.5, 3.0],
        "stribeck-friction": [0.02, 0.05, 0.1, 0.2, 0.4, 0.8],
        "eddy-damping": [0.02, 0.05, 0.1, 0.2, 0.4, 0.8],
        "lens-distortion": [0.25, 0.35, 0.45, 0.55, 0.7],
        "transition-zone": [0.02, 0.04, 0.07, 0.1, 0.15, 0.25, 0.5],
        "force-relaxation": [0.05, 0.1, 0.2, 0.4, 0.8, 2.0, 10.0],
        "handrail-contact": [part * reach_m for part in (0.2, 0.35, 0.5, 0.65, 0.8)],
    }
    if name in rows:
        return [([value],) for value in rows[name]]
    if name == "ripple":
        return [([1.0 / k, 0.0], [1.0 / k, np.pi / 2]) for k in (*range(4, 61, 8), *range(72, 300, 28))]
    if name == "base-excitation":
        axes = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
        return [([f, 0.0, *axis], [f, np.pi / 2, *axis]) for f in (1.0, 2.0, *np.arange(3.5, 24.0, 1.5)) for axis in axes]
    return [()]
