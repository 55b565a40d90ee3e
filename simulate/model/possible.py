"""Rigs that no workshop builds: refused where a model is read; what is odd and yet can be is a warning that stands in the result."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from measure.common.arrays import Array
from simulate.model.rig import LEGS, Actuator, Geometry, Rig, longest_arm, per_leg, stroke_of

# From a milligram to a thousand tonnes, from a micrometre to a kilometre: what these keep out is 1e300, and units that are not meant.
_RANGES = {
    "platform.mass_kg": (1e-6, 1e6),
    "platform.inertia_kg_m2": (1e-12, 1e9),
    "platform.centre_of_mass_m": (-1e3, 1e3),
    "geometry.base_joints_m": (-1e3, 1e3),
    "geometry.platform_joints_m": (-1e3, 1e3),
    "geometry.stowed_height_m": (-1e3, 1e3),
    "geometry.deployed_height_m": (-1e3, 1e3),
    "actuator.a_l_N_per_m": (-1e9, 1e9),
    "actuator.b_l_N": (-1e6, 1e6),
    "actuator.a_u_N_per_m": (-1e9, 1e9),
    "actuator.b_u_N": (-1e6, 1e6),
    "actuator.beta_per_m": (1e-6, 1e9),
    "actuator.initial_force_N": (-1e6, 1e6),
    "end_stop.stiffness_N_per_m": (0.0, 1e15),
    "end_stop.damping_N_s_per_m": (0.0, 1e8),
    "end_stop.smoothing_m": (1e-9, 1.0),
    "gravity.acceleration_m_per_s2": (-1e4, 1e4),
    "gravity.mass_factor": (1e-3, 1e3),
    "release.position_m": (-1e3, 1e3),
    "release.theta_rad": (-6.3, 6.3),
    "release.velocity_m_per_s": (-1e3, 1e3),
    "release.angular_velocity_rad_per_s": (-1e3, 1e3),
    "simulation.duration_s": (1e-6, 1e6),
    "simulation.sample_rate_Hz": (1e-3, 1e7),
    "simulation.step_s": (1e-10, 1.0),
    "nuisance.release_position_m": (0.0, 10.0),
    "nuisance.release_theta_rad": (0.0, 3.2),
    "nuisance.release_instant_s": (0.0, 1e3),
    "nuisance.stored_force_N": (0.0, 1e6),
}
_LONGEST_NAME = 200
_ROUNDED = 1e-6  # of the largest inertia, by which a thin plate may be off
_MEASURED = 0.1  # of it, by which measured inertias may miss; beyond that they are of no body
_TOUCHING = 1e-6  # of the size of the rig, below which two joints are one
_IN_LINE = 1e-3  # of the length of a row of joints, below which it has no width
_LOST = 1e5  # condition number of the legs' directions, from which on one direction is lost
_POOR = 2e3  # and from which on it is held badly
_HEIGHTS = 21  # along the path


def impossible(rig: Rig | None) -> list[str]:
    """Why a rig cannot be, a sentence each; none where it can, or where there is none.

    A number that no rig has, inertia of no body, a platform below its base, joints on one spot or in one line, a step beyond reason.
    """
    if rig is None:
        return []
    wrong = [*_wrong_name(rig), *_out_of_range(rig)] or [*_wrong_inertia(rig), *_wrong_step(rig)]
    if rig.geometry is not None and not wrong:
        wrong += [*_wrong_joints(rig.geometry), *_wrong_heights(rig)]
    return wrong


def impossible_as_changed(rig: Rig) -> list[str]:
    """Why a rig that effects have changed cannot be, a sentence each: an error of the model file may take away more than there is."""
    return [f"with the model's effects, {sentence}" for sentence in _out_of_range(rig)]


def warnings_of(rig: Rig) -> list[str]:
    """What is odd about a rig and can be: sentences for its result.

    A loop that makes energy: coiling a leg takes less work than uncoiling gives. Legs that lose a direction: the matrix of their lines
    (n, r x n / arm), whose condition number is that of the forces the legs need against a load, is nearly singular there.
    """
    if rig.geometry is None:
        return []
    return [*_doubtful_inertia(rig), *_energy_made(rig), *_directions_lost(rig)]


def _wrong_name(rig: Rig) -> Iterator[str]:
    if len(rig.name) > _LONGEST_NAME:
        yield f"name: has {len(rig.name)} characters; give it at most {_LONGEST_NAME}."


def _out_of_range(rig: Rig) -> Iterator[str]:
    for key, (low, high) in _RANGES.items():
        table, name = key.split(".")
        value = getattr(getattr(rig, table), name, None)
        entries = np.atleast_1d(np.asarray(value, dtype=float)).ravel() if value is not None else np.empty(0)
        outside = entries[(entries < low) | (entries > high)]
        if len(outside):
            yield f'{key}: {outside[0]:g} is not between {low:g} and {high:g}; model "{rig.name}" cannot have it. Check its unit.'


def _wrong_inertia(rig: Rig) -> Iterator[str]:
    a, b, c = sorted(rig.platform.inertia_kg_m2)
    if c > (a + b) * (1.0 + _MEASURED):
        yield f"{_no_body(a, b, c)}. Each principal inertia is at most the sum of the other two."


def _no_body(a: float, b: float, c: float) -> str:
    return f"platform.inertia_kg_m2: {c:g} is more than {a:g} and {b:g} together; no rigid body is like that"


def _doubtful_inertia(rig: Rig) -> Iterator[str]:
    a, b, c = sorted(rig.platform.inertia_kg_m2)
    if c > (a + b) * (1.0 + _ROUNDED):
        yield f"{_no_body(a, b, c)}, though measured ones may be off by that much"


def _wrong_step(rig: Rig) -> Iterator[str]:
    simulation = rig.simulation
    if simulation.step_s is not None and simulation.step_s > simulation.duration_s:
        yield f"simulation.step_s: {simulation.step_s:g} s is longer than duration_s, {simulation.duration_s:g} s. Leave it out."


def _wrong_joints(geometry: Geometry) -> Iterator[str]:
    base, platform = np.asarray(geometry.base_joints_m), np.asarray(geometry.platform_joints_m)
    size = float(max(np.ptp(base, axis=0).max(), np.ptp(platform, axis=0).max()))
    for leg in range(LEGS):
        for other in range(leg):
            apart = max(np.linalg.norm(base[leg] - base[other]), np.linalg.norm(platform[leg] - platform[other]))
            if apart <= _TOUCHING * size:
                yield f"geometry: legs {other + 1} and {leg + 1} have the same two joints; they are one leg. Check the order of the joints."
    for name, joints in (("base", base), ("platform", platform)):
        length, width = np.linalg.svd(joints - joints.mean(axis=0), compute_uv=False)[:2]
        if width <= _IN_LINE * length:
            what = "on one spot" if length <= _TOUCHING * size else "in one line"
            yield f"geometry.{name}_joints_m: all six stand {what}; nothing holds the platform about it. Check the coordinates."


def _wrong_heights(rig: Rig) -> Iterator[str]:
    geometry = rig.geometry
    assert geometry is not None
    base, platform = (np.asarray(joints)[:, 2].mean() for joints in (geometry.base_joints_m, geometry.platform_joints_m))
    below = base - platform - geometry.stowed_height_m
    if below >= 0.0:
        yield (
            f"geometry.stowed_height_m: {geometry.stowed_height_m:g} m puts the platform's joints {below:.3g} m below those of the base; "
            "z points up and the legs push upwards. Check the heights and their signs."
        )
    stroke = stroke_of(rig)
    if np.any(stroke <= 0.0):
        leg = int(np.argmin(stroke)) + 1
        yield f"geometry: leg {leg} does not grow between stowed and deployed height; its stop is never reached. Check joints and heights."


def _energy_made(rig: Rig) -> Iterator[str]:
    for leg, made in enumerate(_work_of_a_loop(rig.actuator, stroke_of(rig))):
        if made < 0.0:
            yield f"leg {leg + 1}: a loop over its whole stroke makes {-made:.3g} J; its upper asymptote is to be above the lower one"


def _work_of_a_loop(law: Actuator, stroke: Array) -> Array:
    """(6,) J that a loop over the whole stroke takes: the branches are h_u - h_l + (a_u + a_l) / beta apart, in the middle."""
    a_l, b_l, a_u, b_u, beta = (per_leg(v) for v in (law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m))
    return stroke * ((a_u - a_l) * stroke / 2.0 + b_u - b_l + (a_u + a_l) / beta)


def _directions_lost(rig: Rig) -> Iterator[str]:
    assert rig.geometry is not None
    heights = np.linspace(rig.geometry.stowed_height_m, rig.geometry.deployed_height_m, _HEIGHTS)
    conditions = np.array([condition_at(rig, height) for height in heights])
    worst = int(np.argmax(conditions))
    if conditions[worst] > _POOR:
        held = "the legs lose a direction" if conditions[worst] > _LOST else "the legs hold one direction badly"
        best = f"{np.min(conditions):.2g} at best along the path"
        yield f"{held} at a height of {heights[worst]:.3f} m: condition number {conditions[worst]:.2g}, {best}"


def condition_at(rig: Rig, height_m: float) -> float:
    """Condition number of the legs' lines with the platform centred and upright at a height; infinite where a direction is lost.

    Rows are (n, r x n / arm): n the unit vector along a leg, r from the platform's centre to its joint, arm the longest r.
    """
    assert rig.geometry is not None
    joints = np.asarray(rig.geometry.platform_joints_m)
    along = joints + np.array([0.0, 0.0, height_m]) - np.asarray(rig.geometry.base_joints_m)
    n = along / np.linalg.norm(along, axis=1)[:, None]
    values = np.linalg.svd(np.hstack([n, np.cross(joints, n) / longest_arm(rig)]), compute_uv=False)
    return float(values[0] / values[-1]) if values[-1] > 0.0 else float("inf")
