"""A model is plain data: base quantities and a tuple of effects, frozen.

The names, units and defaults are those of the model file. Everything that can be checked on a value alone is checked
when the value is made.
"""

from __future__ import annotations

from dataclasses import replace
from functools import reduce
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from simulate.model.effect import Effect

LEGS = 6

_CONFIG = ConfigDict(extra="forbid", arbitrary_types_allowed=True, allow_inf_nan=False)

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]
PerLeg = float | tuple[float, float, float, float, float, float]
Joints = tuple[Vector, Vector, Vector, Vector, Vector, Vector]


@dataclass(frozen=True, config=_CONFIG)
class Platform:
    """The rigid body that six legs push: mass, principal inertia at the centre of mass, and where that is."""

    mass_kg: Positive = 0.8
    inertia_kg_m2: tuple[Positive, Positive, Positive] = (0.006, 0.006, 0.010)
    centre_of_mass_m: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, config=_CONFIG)
class Geometry:
    """Where the legs are joined: base joints in the world frame (z up), platform joints in the platform frame."""

    base_joints_m: Joints
    platform_joints_m: Joints
    stowed_height_m: float = 0.252
    deployed_height_m: float = 0.652

    @model_validator(mode="after")
    def _stands_up(self) -> Geometry:
        if self.deployed_height_m <= self.stowed_height_m:
            raise ValueError("deployed_height_m must be above stowed_height_m")
        return self


@dataclass(frozen=True, config=_CONFIG)
class Rate:
    """Asymptotes that follow the rate: polynomials, lowest power first, of a frequency or of a speed."""

    abscissa: Literal["frequency_Hz", "speed_m_per_s"]
    a_l: tuple[float, ...] = ()
    b_l: tuple[float, ...] = ()
    a_u: tuple[float, ...] = ()
    b_u: tuple[float, ...] = ()


@dataclass(frozen=True, config=_CONFIG)
class Covariance:
    """How well the fitted parameters are known: their names and the covariance matrix, in their units."""

    names: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]

    @model_validator(mode="after")
    def _is_a_covariance(self) -> Covariance:
        matrix = np.array(self.matrix, dtype=float)
        if matrix.shape != (len(self.names), len(self.names)):
            raise ValueError(f"the matrix must be {len(self.names)} x {len(self.names)}, one row for each name")
        if not np.allclose(matrix, matrix.T, rtol=1e-6, atol=0.0):
            raise ValueError("the matrix must be symmetric")
        return self


@dataclass(frozen=True, config=_CONFIG)
class Actuator:
    """The force law of a leg: h_l = a_l u + b_l while uncoiling, h_u = a_u u + b_u while coiling, beta between them.

    A number serves all legs, a tuple of six one each.
    """

    a_l_N_per_m: PerLeg
    b_l_N: PerLeg
    a_u_N_per_m: PerLeg
    b_u_N: PerLeg
    beta_per_m: Positive | tuple[Positive, Positive, Positive, Positive, Positive, Positive]
    initial_force_N: PerLeg
    rate: Rate | None = None
    covariance: Covariance | None = None

    def shifted(self, force_N: tuple[float, ...]) -> Actuator:
        """The same law with both asymptotes and the initial force of each leg shifted by `force_N` (six)."""
        moved = {
            name: tuple(float(v) for v in np.broadcast_to(getattr(self, name), LEGS) + np.asarray(force_N))
            for name in ("b_l_N", "b_u_N", "initial_force_N")
        }
        return replace(self, **moved)  # type: ignore[arg-type]


@dataclass(frozen=True, config=_CONFIG)
class EndStop:
    """A spring and a damper at full length of each leg, eased in by an error function of the penetration."""

    stiffness_N_per_m: NotNegative = 2.0e4
    damping_N_s_per_m: NotNegative = 40.0
    smoothing_m: Positive = 1.0e-3


@dataclass(frozen=True, config=_CONFIG)
class Gravity:
    """Gravity left over, and what the counterweight does to mass and inertia (the paper: times two)."""

    acceleration_m_per_s2: float = 0.0
    mass_factor: Positive = 2.0


@dataclass(frozen=True, config=_CONFIG)
class Release:
    """Pose and velocity at the release, relative to the centred stowed pose; theta is a rotation vector."""

    position_m: Vector = (0.0, 0.0, 0.0)
    theta_rad: Vector = (0.0, 0.0, 0.0)
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    angular_velocity_rad_per_s: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, config=_CONFIG)
class Simulation:
    """How long, and how often a sample is kept; the step is the solver's business unless given."""

    duration_s: Positive = 1.0
    sample_rate_Hz: Positive = 1000.0
    step_s: Positive | None = None


@dataclass(frozen=True, config=_CONFIG)
class Nuisance:
    """What may differ from run to run without meaning anything: one standard deviation each."""

    release_position_m: NotNegative = 0.001
    release_theta_rad: NotNegative = 0.002
    release_instant_s: NotNegative = 0.004
    stored_force_N: NotNegative = 0.0


@dataclass(frozen=True, config=_CONFIG)
class Model:
    """Everything a deployment is computed from, or, without geometry, everything a loop is computed from."""

    actuator: Actuator
    name: str = "model"
    platform: Platform = Platform()
    geometry: Geometry | None = None
    end_stop: EndStop = EndStop()
    gravity: Gravity = Gravity()
    release: Release = Release()
    simulation: Simulation = Simulation()
    nuisance: Nuisance = Nuisance()
    effects: tuple[Effect, ...] = ()

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


def per_leg(value: PerLeg) -> np.ndarray:
    """Six values, whether one or six were given."""
    return np.broadcast_to(np.asarray(value, dtype=float), LEGS).copy()


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
