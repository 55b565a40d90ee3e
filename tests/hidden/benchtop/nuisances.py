"""What a laboratory has wrong without knowing: the model file within its tolerances, or beyond them where that is what is hidden."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from board.bench import Bench

from simulate.model.model import Model

Chance = np.random.Generator
Array = np.ndarray

MASS, INERTIA, CENTRE_M, JOINTS_M, STOPS, FORCE = 0.005, 0.05, 5e-4, 3e-4, 0.3, 0.005
"""Tolerances, one standard deviation each: those of `[nuisance]` in a model file that says nothing."""
_SIGN = (-1.0, 1.0)
FORCES = "stored-force-per-run"


def as_built(model: Model, hidden: str, chance: Chance) -> Model:
    """The rig as it really is: each quantity off within its tolerance, the hidden one by more; not one that an effect changes."""
    mass = chance.normal(0.0, MASS) if hidden != "platform-mass" else chance.choice(_SIGN) * chance.uniform(0.02, 0.05)
    inertia = chance.normal(0.0, INERTIA, 3) if hidden != "platform-inertia" else np.full(3, 0.2 * chance.choice(_SIGN))
    joints = chance.normal(0.0, JOINTS_M if hidden != "geometry-error" else 1e-3, (12, 3))
    stops = np.exp(chance.normal(0.0, STOPS, 2))
    if hidden == "stop-stiffness":
        stops[0] = np.exp(chance.choice(_SIGN) * chance.uniform(1.0, 2.0))
    if hidden == "end-stop-dissipation":
        stops[1] = 1.0
    centre_m = chance.normal(0.0, CENTRE_M, 3) * (hidden != "centre-of-mass-offset")
    model = with_mass(model, mass)
    model = with_inertia(model, inertia)
    model = with_centre(model, centre_m)
    return with_stops(with_joints(model, joints), stops)


def forces_of_runs(hidden: str, runs: int, chance: Chance) -> Array:
    """By what part the stored force of all legs is off in each run, (runs,)."""
    if hidden != FORCES:
        return chance.normal(0.0, FORCE, runs)
    off = chance.uniform(0.02, 0.05, runs) * chance.choice(_SIGN, runs)
    off[chance.integers(runs)] = 0.0
    return off


def alone(model: Model, built: Model, hidden: str, share: float) -> Model:
    """A model with a share of one error of the rig as it was built, and no other."""
    if hidden == "geometry-error":
        return with_joints(model, share * (joints_of(built) - joints_of(model)))
    if hidden == "stop-stiffness":
        return with_stops(model, np.array([(built.end_stop.stiffness_N_per_m / model.end_stop.stiffness_N_per_m) ** share, 1.0]))
    if hidden == "platform-mass":
        return with_mass(model, share * (built.platform.mass_kg / model.platform.mass_kg - 1.0))
    return with_inertia(model, share * (np.asarray(built.platform.inertia_kg_m2) / np.asarray(model.platform.inertia_kg_m2) - 1.0))


def in_tolerances(model: Model, built: Model, forces: Array, hidden: str) -> Array:
    """How far off the model file an error is, (n,), in the tolerances of what it is an error of."""
    if hidden == FORCES:
        return forces / FORCE
    if hidden == "geometry-error":
        return (joints_of(built) - joints_of(model)).ravel() / JOINTS_M
    if hidden == "stop-stiffness":
        return np.atleast_1d(np.log(built.end_stop.stiffness_N_per_m / model.end_stop.stiffness_N_per_m) / STOPS)
    if hidden == "platform-mass":
        return np.atleast_1d((built.platform.mass_kg / model.platform.mass_kg - 1.0) / MASS)
    return (np.asarray(built.platform.inertia_kg_m2) / np.asarray(model.platform.inertia_kg_m2) - 1.0) / INERTIA


def tolerance_of(effect: str, model: Model) -> float:
    """What the model file may be wrong by in what an effect changes, one standard deviation; nothing where it states none."""
    return {"end-stop-dissipation": STOPS * model.end_stop.damping_N_s_per_m, "centre-of-mass-offset": CENTRE_M}.get(effect, 0.0)


def joints_of(model: Model) -> Array:
    """All joints, (12, 3), those of the base first."""
    assert model.geometry is not None
    return np.vstack([model.geometry.base_joints_m, model.geometry.platform_joints_m])


def with_mass(model: Model, part: float) -> Model:
    """The platform heavier by a part of its mass."""
    return replace(model, platform=replace(model.platform, mass_kg=model.platform.mass_kg * (1.0 + float(part))))


def with_inertia(model: Model, part: Array) -> Model:
    """Each principal moment larger by a part of itself, as far as a rigid body can have them."""
    across, along, vertical = (np.asarray(model.platform.inertia_kg_m2) * (1.0 + part)).tolist()
    vertical = min(max(vertical, 1.001 * abs(across - along)), 0.999 * (across + along))
    return replace(model, platform=replace(model.platform, inertia_kg_m2=(across, along, vertical)))


def with_centre(model: Model, shift_m: Array) -> Model:
    """The centre of mass elsewhere."""
    x, y, z = (np.asarray(model.platform.centre_of_mass_m) + shift_m).tolist()
    return replace(model, platform=replace(model.platform, centre_of_mass_m=(x, y, z)))


def with_joints(model: Model, shift_m: Array) -> Model:
    """Each joint elsewhere, (12, 3), base joints first."""
    at = model.geometry
    assert at is not None
    base, platform = (
        tuple(map(tuple, (np.asarray(joints) + shift).tolist()))
        for joints, shift in ((at.base_joints_m, shift_m[:6]), (at.platform_joints_m, shift_m[6:]))
    )
    return replace(model, geometry=replace(at, base_joints_m=base, platform_joints_m=platform))


def with_stops(model: Model, factors: Array) -> Model:
    """Stiffness and damping of the stops times these."""
    stop, (k, c) = model.end_stop, factors.tolist()
    return replace(
        model, end_stop=replace(stop, stiffness_N_per_m=k * stop.stiffness_N_per_m, damping_N_s_per_m=c * stop.damping_N_s_per_m)
    )


def tolerances(bench: Bench) -> list[Bench]:
    """The bench with one thing of the model file off by a thousandth of its tolerance, for each thing."""
    true, e = bench.rig.true, 1e-3
    changes: list[Callable[[Model], Model]] = [lambda m: with_mass(m, e * MASS)]
    changes += [lambda m, row=row: with_inertia(m, e * INERTIA * row) for row in np.eye(3)]
    changes += [lambda m, row=row: with_centre(m, e * CENTRE_M * row) for row in np.eye(3)]
    changes += [lambda m, row=row: with_joints(m, e * JOINTS_M * row.reshape(12, 3)) for row in np.eye(36)]
    changes += [lambda m, row=row: with_stops(m, 1.0 + e * STOPS * row) for row in np.eye(2)]
    return [bench.with_model(change(true)) for change in changes]
