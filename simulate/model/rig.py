"""The rig as plain data: everything of a model but its effects.

The names, units and defaults are those of the model file. Everything that can be checked on a value alone is checked
when the value is made.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from measure.common.arrays import Array
from measure.common.errors import InputError

LEGS = 6

CHECKED = ConfigDict(extra="forbid", arbitrary_types_allowed=True, allow_inf_nan=False, use_attribute_docstrings=True)

# Numbers are written as numbers: no true, no "1.0".
Number = Annotated[float, Field(strict=True)]
Positive = Annotated[float, Field(strict=True, gt=0)]
NotNegative = Annotated[float, Field(strict=True, ge=0)]
Vector = tuple[Number, Number, Number]
PerLeg = Number | tuple[Number, Number, Number, Number, Number, Number]
Joints = tuple[Vector, Vector, Vector, Vector, Vector, Vector]


T = TypeVar("T")


def altered(one: T, **values: Any) -> T:
    """A dataclass with some of its fields changed and nothing checked anew, for values that a fit works out some hundred thousand times.

    Parameters
    ----------
    one : an instance of a dataclass without slots. values : new values by field, of the kinds that the fields have.
    """
    made, kept = object.__new__(type(one)), one.__dict__
    fields: dict[str, Any] = type(one).__dataclass_fields__  # type: ignore[attr-defined]
    if len(kept) != len(fields):  # what was worked out from the fields is not theirs
        kept = {name: kept[name] for name in fields}
    made.__dict__.update(kept, **values)
    return made


@dataclass(frozen=True, config=CHECKED)
class Platform:
    """The rigid body that six legs push: mass, principal inertia at the centre of mass, and where that is."""

    mass_kg: Positive = 0.8
    """mass of the bare platform"""
    inertia_kg_m2: tuple[Positive, Positive, Positive] = (0.006, 0.006, 0.010)
    """its principal moments of inertia about x, y, z at the centre of mass"""
    centre_of_mass_m: Vector = (0.0, 0.0, 0.0)
    """centre of mass in the platform frame"""


@dataclass(frozen=True, config=CHECKED)
class Geometry:
    """Where the legs are joined: base joints in the world frame (z up), platform joints in the platform frame."""

    base_joints_m: Joints
    """six points [x, y, z] in the world frame, one a leg; z is up"""
    platform_joints_m: Joints
    """six points in the platform frame; leg i goes from base joint i to platform joint i"""
    stowed_height_m: Number = 0.252
    """height of the platform frame's origin while all strip is coiled, centred and upright"""
    deployed_height_m: Number = 0.652
    """the same at the upper stops"""

    @model_validator(mode="after")
    def _stands_up(self) -> Geometry:
        if self.deployed_height_m <= self.stowed_height_m:
            raise ValueError("deployed_height_m must be above stowed_height_m")
        return self


@dataclass(frozen=True, config=CHECKED)
class Rate:
    """Asymptotes that follow the rate: polynomials, lowest power first, of a frequency or of a speed."""

    abscissa: Literal["frequency_Hz", "speed_m_per_s"]
    """what the polynomials are of: frequency_Hz of a cycle, or speed_m_per_s, its largest"""
    a_l: tuple[Number, ...] = ()
    """polynomial of a_l, lowest power first, N/m; empty: a_l_N_per_m"""
    b_l: tuple[Number, ...] = ()
    """polynomial of b_l, N; empty: b_l_N"""
    a_u: tuple[Number, ...] = ()
    """polynomial of a_u, N/m; empty: a_u_N_per_m"""
    b_u: tuple[Number, ...] = ()
    """polynomial of b_u, N; empty: b_u_N"""
    frequency_Hz: tuple[Positive, ...] = ()
    """frequency of each loop that they were fitted to"""
    stroke_m: tuple[Positive, ...] = ()
    """stroke of each loop from turning point to turning point, twice its amplitude A"""
    mid_stroke_speed_m_per_s: tuple[Positive, ...] = ()
    """speed of each loop in the middle of its stroke, 2 pi f A"""

    @model_validator(mode="after")
    def _is_of_the_same_loops(self) -> Rate:
        lengths = {len(of) for of in (self.frequency_Hz, self.stroke_m, self.mid_stroke_speed_m_per_s) if of}
        if len(lengths) > 1:
            raise ValueError("frequency_Hz, stroke_m and mid_stroke_speed_m_per_s must hold one number for each loop")
        return self

    @property
    def speed_per_Hz(self) -> float | None:
        """Speed at mid-stroke over frequency, 2 pi A, m: the one that fits all loops best; None where no stroke is known."""
        f, v = np.array(self.frequency_Hz), np.array(self.mid_stroke_speed_m_per_s)
        if len(f) and len(v):
            return float(f @ v / (f @ f))
        return float(np.pi * np.mean(self.stroke_m)) if self.stroke_m else None


@dataclass(frozen=True, config=CHECKED)
class Covariance:
    """How well the fitted parameters are known: their names and the covariance matrix, in their units."""

    names: tuple[str, ...]
    """names of the fitted parameters"""
    matrix: tuple[tuple[Number, ...], ...]
    """their covariance, a row for each, in the products of their units"""

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
    """slope of the lower asymptote h_l, which the force approaches while the strip uncoils"""
    b_l_N: PerLeg
    """stored force: h_l at elongation 0; positive pushes the platform up"""
    a_u_N_per_m: PerLeg
    """slope of the upper asymptote h_u, which the force approaches while the strip is coiled"""
    b_u_N: PerLeg
    """h_u at elongation 0; above b_l_N, as a loop turns energy into heat"""
    beta_per_m: Positive | tuple[Positive, Positive, Positive, Positive, Positive, Positive]
    """how fast the force approaches the asymptote: by a factor e within 1/beta of elongation"""
    initial_force_N: PerLeg
    """force of the leg at the release"""
    rate: Rate | None = None
    """asymptotes that follow the rate; absent: they do not"""
    covariance: Covariance | None = None
    """how well fitted parameters are known; fit-actuator writes it"""

    def shifted(self, force_N: tuple[float, ...]) -> Actuator:
        """The same law with both asymptotes and the initial force of each leg shifted by `force_N` (six)."""
        moved = {name: tuple((per_leg(getattr(self, name)) + force_N).tolist()) for name in ("b_l_N", "b_u_N", "initial_force_N")}
        return altered(self, **moved)


@dataclass(frozen=True, config=CHECKED)
class EndStop:
    """A spring and a damper at full length of each leg, eased in by an error function of the penetration."""

    stiffness_N_per_m: NotNegative = 2.0e4
    """stiffness of the stop of a leg at full length, and of the one at its stowed length"""
    damping_N_s_per_m: NotNegative = 40.0
    """damping of the stop while it is touched"""
    smoothing_m: Positive = 1.0e-3
    """way over which the stop's force sets in"""


@dataclass(frozen=True, config=CHECKED)
class Gravity:
    """Gravity left over, and what the counterweight does to mass and inertia (the paper: times two)."""

    acceleration_m_per_s2: Number = 0.0
    """gravity that is left over, downwards; 0 where a counterweight carries the platform, 9.81 where nothing does"""
    mass_factor: Positive = 2.0
    """what the counterweight makes of mass and inertia: 2 for one as heavy as the platform, 1 for none"""


@dataclass(frozen=True, config=CHECKED)
class Release:
    """Pose and velocity at the release, relative to the centred stowed pose; theta is a rotation vector."""

    position_m: Vector = (0.0, 0.0, 0.0)
    """shift of the platform frame's origin, world axes"""
    theta_rad: Vector = (0.0, 0.0, 0.0)
    """rotation vector, world axes"""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """velocity of the origin"""
    angular_velocity_rad_per_s: Vector = (0.0, 0.0, 0.0)
    """angular velocity, world axes"""


@dataclass(frozen=True, config=CHECKED)
class Simulation:
    """How long, and how often a sample is kept; the step is the solver's business unless given."""

    duration_s: Positive = 1.0
    """how long the deployment is followed"""
    sample_rate_Hz: Positive = 1000.0
    """how often a sample is kept; the step of integration is chosen apart"""
    step_s: Positive | None = None
    """step of integration; absent: chosen from stiffness, damping and beta"""


@dataclass(frozen=True, config=CHECKED)
class Nuisance:
    """What may differ without meaning anything, one standard deviation each: first from run to run, then in the model file itself.

    stored_force_N is each leg's by itself, stored_force_percent that of all legs together; both are drawn anew for each run.
    """

    release_position_m: NotNegative = 0.001
    """where the platform stands at the release, each axis"""
    release_theta_rad: NotNegative = 0.002
    """how it is turned at the release, each axis"""
    release_instant_s: NotNegative = 0.004
    """when it is let go, on the clock of the table"""
    stored_force_N: NotNegative = 0.0
    """stored force of each leg by itself; 0: the legs repeat"""
    stored_force_percent: NotNegative = 0.5
    """stored force of all legs together"""
    platform_mass_percent: NotNegative = 0.5
    """mass of the platform in this file; the same in all runs"""
    inertia_percent: NotNegative = 5.0
    """each principal moment of inertia in this file"""
    centre_of_mass_m: NotNegative = 0.0005
    """each coordinate of the centre of mass in this file"""
    joints_m: NotNegative = 0.0003
    """each coordinate of each joint in this file"""
    end_stop_percent: NotNegative = 30.0
    """stiffness and damping of the stops in this file"""
    camera_scale_percent: NotNegative = 0.0
    """scale of the film beyond what the tables say"""


@dataclass(frozen=True, config=CHECKED)
class Rig:
    """The base parameters of a model: everything but its effects. Effects that change the model are given one and return one."""

    actuator: Actuator
    name: str = "model"
    """name of the model, in reports"""
    platform: Platform = Platform()
    geometry: Geometry | None = None
    """Where the legs are joined, base joints in the world frame, platform joints in the platform's; absent: good for loops only."""
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
    return np.array(value, dtype=float) if isinstance(value, tuple) else np.full(LEGS, value, dtype=float)


_NO_GEOMETRY = """\
fit-actuator LOOPS --model MODEL puts a force law into a model that has one; or add
[geometry]
base_joints_m = [[x, y, z], ...]      # six, world frame, z up
platform_joints_m = [[x, y, z], ...]  # six, platform frame; leg i joins base joint i to platform joint i
stowed_height_m = 0.252
deployed_height_m = 0.652"""


def geometry_of(rig: Rig) -> Geometry:
    """The geometry of a rig that is to be deployed.

    Raises
    ------
    InputError
        It has none.
    """
    if rig.geometry is None:
        raise InputError(f'model "{rig.name}": no [geometry] table, which a deployment needs. {_NO_GEOMETRY}')
    return rig.geometry


def leg_lengths(base: Array, joints: Array, height_m: Array | float) -> Array:
    """Lengths of the legs with the platform centred and upright.

    Parameters
    ----------
    base, joints : (..., 6, 3) base joints in the world frame, platform joints in the platform frame, m.
    height_m : (...) of the origin of the platform frame.

    Returns
    -------
    (..., 6) m.
    """
    away = np.subtract(joints, base, dtype=float)
    away[..., 2] += np.asarray(height_m)[..., None]
    return np.linalg.norm(away, axis=-1)


def stroke_of(rig: Rig) -> Array:
    """(6,) elongation of each leg at its upper stop, m: its length at the deployed height less that at the stowed height."""
    g = geometry_of(rig)
    base, joints = np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m)
    return leg_lengths(base, joints, g.deployed_height_m) - leg_lengths(base, joints, g.stowed_height_m)


def longest_arm(rig: Rig) -> float:
    """How far the platform's farthest joint is from its origin, m; zero without a geometry."""
    geometry = rig.geometry
    return 0.0 if geometry is None else float(np.max(np.linalg.norm(np.asarray(geometry.platform_joints_m), axis=1)))
