"""A rig drawn by chance: what its engineer knows of it, and what it really is.

Geometry, mass, inertia and stops are drawn around the two rigs that the project ships, and are known. The force law that the
engineer wrote down is a guess of a few per cent; the true one is kept apart. No effect is hidden here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simulate.effects import HubInertia, ViscousFriction
from simulate.model.model import (
    Actuator,
    EndStop,
    Geometry,
    Gravity,
    Model,
    Nuisance,
    Platform,
    Simulation,
)

Chance = np.random.Generator


@dataclass(frozen=True)
class Rig:
    """known : the model file. true : the same rig with its true force law, still without anything hidden."""

    known: Model
    true: Model


def drawn_rig(chance: Chance) -> Rig:
    """Heavy spools, grease and soft stops as in the prototype, or light, dry and firm as in the demonstration."""
    prototype = chance.random() < 0.5
    law = _law(chance)
    known = Model(
        law,
        name="rig",
        platform=_platform(chance),
        geometry=_geometry(chance),
        end_stop=_soft_stops(chance) if prototype else _firm_stops(chance),
        gravity=Gravity(0.0, 2.0),
        simulation=Simulation(0.6),
        nuisance=_nuisance(chance),
        effects=_known_effects(chance) if prototype else (),
    )
    return Rig(known, replace(known, actuator=_true_law(law, chance)))


def _law(chance: Chance) -> Actuator:
    slope, level = round(chance.uniform(-0.25, 0.0), 3), round(chance.uniform(2.5, 3.1), 3)
    return Actuator(slope, level, slope, round(level + chance.uniform(0.08, 0.15), 3), round(chance.uniform(250.0, 500.0), 1), level)


def _true_law(law: Actuator, chance: Chance) -> Actuator:
    """Forces off by some two per cent, slopes by 0.05 N/m, beta by a sixth; asymptotes that stay a band apart."""
    slope = float(law.a_l_N_per_m) + chance.normal(0.0, 0.05)  # type: ignore[arg-type]
    level = float(law.b_l_N) + chance.normal(0.0, 0.05)  # type: ignore[arg-type]
    band = chance.uniform(0.08, 0.15)
    first = level + chance.uniform(0.0, 0.2)
    beta = float(law.beta_per_m) * np.exp(chance.normal(0.0, 0.15))  # type: ignore[arg-type]
    return Actuator(slope, level, slope + chance.uniform(-0.03, 0.03), level + band, float(beta), first)


def _platform(chance: Chance) -> Platform:
    """Inertias that a rigid body can have: about the vertical no more than the sum of the others."""
    mass = chance.uniform(0.7, 1.0)
    across, along = chance.uniform(0.0015, 0.0035, 2)
    vertical = chance.uniform(0.75, 0.98) * (across + along)
    return Platform(round(mass, 3), tuple(round(float(v), 6) for v in (across, along, vertical)))  # type: ignore[arg-type]


def _geometry(chance: Chance) -> Geometry:
    """Rings of six joints in three pairs around those of the prototype, each joint off by up to a millimetre and known to be."""
    third = np.repeat(120.0 * np.arange(3), 2)
    base_angle, joint_angle = 41.4 + chance.uniform(-3, 3), 59.46 - chance.uniform(0.0, 8.0)
    base = _ring(chance.uniform(0.48, 0.58), third + np.tile([base_angle, 120.0 - base_angle], 3), chance)
    joints = _ring(chance.uniform(0.06, 0.09), third + 60.0 + np.tile([-joint_angle, joint_angle], 3), chance)
    stowed = round(chance.uniform(0.245, 0.265), 3)
    return Geometry(base, joints, stowed, round(stowed + 0.4, 3))


def _ring(radius_m: float, angles_deg: np.ndarray, chance: Chance) -> Any:
    a = np.radians(angles_deg)
    points = np.column_stack([radius_m * np.cos(a), radius_m * np.sin(a), np.zeros(6)]) + chance.uniform(-1e-3, 1e-3, (6, 3))
    return tuple(tuple(round(float(v), 6) for v in row) for row in points)


def _soft_stops(chance: Chance) -> EndStop:
    return EndStop(round(chance.uniform(700.0, 1500.0), 1), round(chance.uniform(1.0, 4.0), 2), 1e-3)


def _firm_stops(chance: Chance) -> EndStop:
    return EndStop(round(chance.uniform(2500.0, 6000.0), 1), round(chance.uniform(20.0, 50.0), 2), 1e-3)


def _known_effects(chance: Chance) -> tuple[HubInertia, ViscousFriction]:
    return HubInertia(round(chance.uniform(0.3, 0.8), 3)), ViscousFriction(round(chance.uniform(0.03, 0.1), 4))


def _nuisance(chance: Chance) -> Nuisance:
    """Between a careful release and the defaults of the model file; now and then the legs differ a little from day to day."""
    spread = float(np.exp(chance.uniform(np.log(0.3), 0.0)))
    legs = 1e-3 if chance.random() < 1 / 6 else 0.0
    return Nuisance(round(1e-3 * spread, 6), round(2e-3 * spread, 6), 4e-3, legs)
