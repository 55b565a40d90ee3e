"""A model is plain data: the rig and a tuple of effects, frozen; every value of it has a name, that of the model file."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from typing import Any

from pydantic.dataclasses import dataclass

from simulate.model.control import Controller
from simulate.model.effect import Effect
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


@dataclass(frozen=True, config=CHECKED)
class Model(Rig):
    """Everything a deployment is computed from, or, without geometry, everything a loop is computed from."""

    effects: tuple[Effect, ...] = ()
    controller: Controller | None = None

    def with_effect(self, effect: Effect) -> Model:
        """The model with this effect in place of the one of the same name, or behind the others."""
        names = [known.name for known in self.effects]
        if effect.name not in names:
            return replace(self, effects=(*self.effects, effect))
        return replace(self, effects=tuple(effect if known.name == effect.name else known for known in self.effects))

    def effect(self, kind: type[Effect]) -> Effect:
        """The model's effect of this kind, or the kind switched off."""
        return next((known for known in self.effects if known.name == kind.name), kind())

    def adjusted(self) -> Model:
        """The base model as all its effects change it."""
        return reduce(lambda model, effect: effect.adjust(model), self.effects, self)


def with_value(model: Any, key: str, value: Any) -> Any:
    """The model with one value changed, named as in the model file: `platform.mass_kg`, `actuator.b_l_N[0]`.

    A parameter of an effect is `effect.NAME.PARAMETER`. An index on a value that serves all legs gives each leg its own first.

    Raises
    ------
    KeyError
        There is no such value.
    """
    if isinstance(model, Model) and key.startswith("effect."):
        effect, parameter = _effect_at(model, key)
        return model.with_effect(with_value(effect, parameter, value))
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
