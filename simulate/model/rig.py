"""The rig as plain data: everything of a model but its effects.

The names, units and defaults are those of the model file. Everything that can be checked on a value alone is checked
when the value is made.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from measure.common.arrays import Array
from measure.common.errors import InputError

LEGS = 6

CHECKED = ConfigDict(extra="forbid", arbitrary_types_allowed=True, allow_inf_nan=False)

# Numbers are written as numbers: no true, no "1.0".
Number = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0)]
NotNegative = Annotated[float, Field(strict=True, ge=0)]
Vector = tuple[Number, Number, Number]
PerLeg = Number | tuple[Number, Number, Number, Number, Number, Number]
Joints = tuple[Vector, Vector, Vector, Vector, Vector, Vector]


@dataclass(frozen=True, config=CHECKED)
class Platform:
    """The rigid body that six legs push: mass, principal inertia at the centre of mass, and where that is."""

    mass_kg: Positive = 0.8
    inertia_kg_m2: tuple[Positive, Positive, Positive] = (0.006, 0.006, 0.010)
    centre_of_mass_m: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, config=CHECKED)
class Geometry:
    """Where the legs are joined: base joints in the world frame (z up), platform joints in the platform frame."""

    base_joints_m: Joints
    platform_joints_m: Joints
    stowed_height_m: Number = 0.252
    deployed_height_m: Number = 0.652

    @model_validator(mode="after")
    def _stands_up(self) -> Geometry:
        if self.deployed_height_m <= self.stowed_height_m:
            raise ValueError("deployed_height_m must be above stowed_height_m")
        return self


@dataclass(frozen=True, config=CHECKED)
class Rate:
    """Asymptotes that follow the rate: polynomials, lowest power first, of a frequency or of a speed."""

    abscissa: Literal["frequency_Hz", "speed_m_per_s"]
    a_l: tuple[Number, ...] = ()
    b_l: tuple[Number, ...] = ()
    a_u: tuple[Number, ...] = ()
    b_u: tuple[Number, ...] = ()


@dataclass(frozen=True, config=CHECKED)
class Covariance:
    """How well the fitted parameters are known: their names and the covariance matrix, in their units."""

    names: tuple[str, ...]
    matrix: tuple[tuple[Number, ...], ...]

    @model_validator(mode="after")
    def _is_a_covariance(self) -> Covariance:
        matrix = np.array(self.matrix, dtype=float)
        if matrix.shape != (len(self.names), len(self.names)):
            raise ValueError(f"the matrix must be {len(self.names)} x {len(self.names)}, one row for each name")
        if not np.allclose(matrix, matrix.T, rtol=1e-6, atol=0.0):
            raise ValueError("the matrix must be symmetric")
        return self


@dataclass(frozen=True, config=CHECKED)
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


@dataclass(frozen=True, config=CHECKED)
class EndStop:
    """A spring and a damper at full length of each leg, eased in by an error function of the penetration."""

    stiffness_N_per_m: NotNegative = 2.0e4
    damping_N_s_per_m: NotNegative = 40.0
    smoothing_m: Positive = 1.0e-3


@dataclass(frozen=True, config=CHECKED)
class Gravity:
    """Gravity left over, and what the counterweight does to mass and inertia (the paper: times two)."""

    acceleration_m_per_s2: Number = 0.0
    mass_factor: Positive = 2.0


@dataclass(frozen=True, config=CHECKED)
class Release:
    """Pose and velocity at the release, relative to the centred stowed pose; theta is a rotation vector."""

    position_m: Vector = (0.0, 0.0, 0.0)
    theta_rad: Vector = (0.0, 0.0, 0.0)
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    angular_velocity_rad_per_s: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, config=CHECKED)
class Simulation:
    """How long, and how often a sample is kept; the step is the solver's business unless given."""

    duration_s: Positive = 1.0
    sample_rate_Hz: Positive = 1000.0
    step_s: Positive | None = None


@dataclass(frozen=True, config=CHECKED)
class Nuisance:
    """What may differ from run to run without meaning anything: one standard deviation each."""

    release_position_m: NotNegative = 0.001
    release_theta_rad: NotNegative = 0.002
    release_instant_s: NotNegative = 0.004
    stored_force_N: NotNegative = 0.0


@dataclass(frozen=True, config=CHECKED)
class Rig:
    """The base parameters of a model: everything but its effects. Effects that change the model are given one and return one."""

    actuator: Actuator
    name: str = "model"
    platform: Platform = Platform()
    geometry: Geometry | None = None
    end_stop: EndStop = EndStop()
    gravity: Gravity = Gravity()
    release: Release = Release()
    simulation: Simulation = Simulation()
    nuisance: Nuisance = Nuisance()

    @property
    def moving_mass_kg(self) -> float:
        """Mass that the legs accelerate, kg: the platform's, times what the counterweight makes of it."""
        return self.platform.mass_kg * self.gravity.mass_factor


def per_leg(value: PerLeg) -> np.ndarray:
    """Six values, whether one or six were given."""
    return np.broadcast_to(np.asarray(value, dtype=float), LEGS).copy()


def geometry_of(rig: Rig) -> Geometry:
    """The geometry of a rig that is to be deployed.

    Raises
    ------
    InputError
        It has none.
    """
    if rig.geometry is None:
        raise InputError(f'model "{rig.name}": no [geometry] table, which a deployment needs. Add base and platform joints.')
    return rig.geometry


def leg_lengths(base: Array, joints: Array, height_m: float) -> Array:
    """Lengths of the legs with the platform centred and upright.

    Parameters
    ----------
    base, joints : (6, 3) base joints in the world frame, platform joints in the platform frame, m.
    height_m : of the origin of the platform frame.

    Returns
    -------
    (6,) m.
    """
    return np.linalg.norm(joints + np.array([0.0, 0.0, height_m]) - base, axis=1)


def stroke_of(rig: Rig) -> Array:
    """(6,) elongation of each leg at its upper stop, m: its length at the deployed height less that at the stowed height."""
    g = geometry_of(rig)
    base, joints = np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m)
    return leg_lengths(base, joints, g.deployed_height_m) - leg_lengths(base, joints, g.stowed_height_m)


def longest_arm(rig: Rig) -> float:
    """How far the platform's farthest joint is from its origin, m; zero without a geometry."""
    geometry = rig.geometry
    return 0.0 if geometry is None else float(np.max(np.linalg.norm(np.asarray(geometry.platform_joints_m), axis=1)))
