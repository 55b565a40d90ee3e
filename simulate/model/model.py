"""A model is plain data: the rig and a tuple of effects, frozen; every value of it has a name, that of the model file."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from typing import Any

from pydantic.dataclasses import dataclass

from simulate.model.control import Controller
from simulate.model.effect import Effect
from simulate.model.radii import RADII, radius_of, with_radius
from simulate.model.rig import (
    CHECKED,
    LEGS,
    Actuator,
    Covariance,
    EndStop,
    Geometry,
    Gravity,
    Nuisance,
    Platform,
    Rate,
    Release,
    Rig,
    Simulation,
    altered,
    geometry_of,
    leg_lengths,
    longest_arm,
    per_leg,
    stroke_of,
)

__all__ = [
    "LEGS",
    "Actuator",
    "Covariance",
    "EndStop",
    "Geometry",
    "Gravity",
    "Model",
    "Nuisance",
    "Platform",
    "Rate",
    "Release",
    "Rig",
    "Simulation",
    "geometry_of",
    "leg_lengths",
    "longest_arm",
    "per_leg",
    "stroke_of",
    "value_of",
    "with_value",
]

STORED_FORCE = "actuator.stored_force_N"
"""The stored force under its own name: b_l, b_u and the initial force of a leg, moved together; its value is that of b_l."""
_BESIDE_B_L = ("b_u_N", "initial_force_N")


@dataclass(frozen=True, config=CHECKED)
class Model(Rig):
    """Everything a deployment is computed from, or, without geometry, everything a loop is computed from."""

    effects: tuple[Effect, ...] = ()
    controller: Controller | None = None

    def with_effect(self, effect: Effect) -> Model:
        """The model with this effect in place of the one of the same name, or behind the others."""
        names = [known.name for known in self.effects]
        if effect.name not in names:
            return altered(self, effects=(*self.effects, effect))
        return altered(self, effects=tuple(effect if known.name == effect.name else known for known in self.effects))

    def effect(self, kind: type[Effect]) -> Effect:
        """The model's effect of this kind, or the kind switched off."""
        return next((known for known in self.effects if known.name == kind.name), kind())

    def adjusted(self) -> Model:
        """The base model as all its effects change it."""
        return reduce(lambda model, effect: effect.adjust(model), self.effects, self)


def with_value(model: Any, key: str, value: Any) -> Any:
    """The model with one value changed, named as in the model file: `platform.mass_kg`, `actuator.b_l_N[0]`.

    A parameter of an effect is `effect.NAME.PARAMETER`. An index on a value that serves all legs gives each leg its own first.
    Each key moves alone, but for `actuator.stored_force_N`, which moves b_l, b_u and the initial force by the same amount, and
    `geometry.base_radius_m` and `geometry.platform_radius_m`, which move all joints of a ring.

    Raises
    ------
    KeyError
        There is no such value.
    """
    if isinstance(model, Model) and key.startswith("effect."):
        effect, parameter = _effect_at(model, key)
        return model.with_effect(with_value(effect, parameter, value))
    if isinstance(model, Model) and is_stored_force(key):
        return _with_stored_force(model, key.removeprefix(STORED_FORCE), value)
    if isinstance(model, Model) and key in RADII:
        return replace(model, geometry=with_radius(_geometry(model, key), RADII[key], value))
    head, _, rest = key.partition(".")
    name, _, index = head.partition("[")
    current = getattr(model, name, None) if name in getattr(type(model), "__dataclass_fields__", {}) else None
    if current is None:
        raise KeyError(head)
    if rest:
        return replace(model, **{name: with_value(current, rest, value)})
    if not index:
        return replace(model, **{name: value})
    entries = list(current) if isinstance(current, tuple) else [float(v) for v in per_leg(current)]
    entries[_index(index, len(entries), key)] = value
    return replace(model, **{name: tuple(entries)})


def value_of(model: Any, key: str) -> float:
    """One number of the model, named as in `with_value`."""
    if isinstance(model, Model) and key.startswith("effect."):
        return value_of(*_effect_at(model, key))
    if isinstance(model, Model) and is_stored_force(key):
        return value_of(model.actuator, "b_l_N" + key.removeprefix(STORED_FORCE))
    if isinstance(model, Model) and key in RADII:
        return radius_of(_geometry(model, key), RADII[key])
    head, _, rest = key.partition(".")
    name, _, index = head.partition("[")
    if name not in getattr(type(model), "__dataclass_fields__", {}):
        raise KeyError(head)
    current = getattr(model, name)
    if rest:
        return value_of(current, rest)
    if not index:
        if isinstance(current, bool) or not isinstance(current, int | float):
            raise KeyError(head)
        return float(current)
    entries = current if isinstance(current, tuple) else per_leg(current)
    return float(entries[_index(index, len(entries), key)])


def is_stored_force(key: str) -> bool:
    """Whether a key names the stored force, of one leg or of all."""
    return key.partition("[")[0] == STORED_FORCE


def _geometry(model: Model, key: str) -> Geometry:
    if model.geometry is None:
        raise KeyError(key)
    return model.geometry


def _with_stored_force(model: Model, index: str, value: Any) -> Model:
    law, there = model.actuator, "b_l_N" + index
    if index:
        shift = value - value_of(law, there)
        for name in _BESIDE_B_L:
            law = with_value(law, name + index, value_of(law, name + index) + shift)
    else:
        law = replace(law, **{name: _moved(getattr(law, name), value, law.b_l_N) for name in _BESIDE_B_L})
    return replace(model, actuator=with_value(law, there, value))


def _moved(current: Any, to: Any, since: Any) -> Any:
    """A value, or one a leg, moved by what the stored force is moved by."""
    moved = per_leg(current) + (per_leg(to) - per_leg(since))
    return tuple(moved.tolist()) if any(isinstance(known, tuple) for known in (current, to, since)) else float(moved[0])


def _effect_at(model: Model, key: str) -> tuple[Effect, str]:
    _, name, parameter = (*key.split(".", 2), "", "")[:3]
    found = next((effect for effect in model.effects if effect.name == name), None)
    if found is None or not parameter:
        raise KeyError(key)
    return found, parameter


def _index(text: str, size: int, key: str) -> int:
    try:
        place = int(text.rstrip("]"))
    except ValueError:
        raise KeyError(key) from None
    if not 0 <= place < size:
        raise KeyError(key)
    return place
