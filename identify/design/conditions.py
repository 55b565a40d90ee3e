"""Further tests that could be made with these runs: what is done differently, and the empty measurement that would come of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from identify.campaign.prepared import Film, LoopRun
from identify.campaign.run import Run
from identify.design.further_test import Condition
from identify.estimation.problem import Problem
from identify.loops.harmonics import harmonic_motion
from identify.loops.prepare import prepare
from measure.common.arrays import Array
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.model.model import Geometry, Model
from simulate.model.rig import longest_arm

_FURTHER = 0.2  # of the stroke that is left, above the start heights there are
_HEAVIER = (1.25, 2.0)
_OFF_CENTRE_M, _TILT_RAD, _TURN_RAD = (0.01, 0.03), (0.03, 0.1), (0.05, 0.15)
_FASTER, _WIDER = 2.0, 2.0
_FREE_LOOP = (1.0, 0.1, 1e-3, 1e-5)  # frequency in Hz, amplitude over the stroke, noise over the force and in m, where no loop was measured
_SAMPLES, _CYCLES = 400, 4
_FREE_FILM = (500.0, 1e-4, 5e-4)  # frames/s, noise in m and rad, where no film was taken


def deployments(problem: Problem) -> list[Condition]:
    """Deployments that differ from those there are; where there are none, a plain one too."""
    g = problem.model.geometry
    if g is None:
        return []
    models = [film.model for film in problem.films] or [problem.model]
    heights = [model.geometry.stowed_height_m for model in models if model.geometry is not None]
    masses = [model.platform.mass_kg for model in models]
    height = max(heights) + _FURTHER * (g.deployed_height_m - max(heights))
    ballasts = [max(masses) * factor for factor in _HEAVIER]
    return [
        *_as_it_is(problem),
        Condition(f"a deployment from a start height of {height:.3f} m", _at_height(height)),
        *(Condition(f"a deployment with a platform of {kg:.2f} kg", _weighing(kg)) for kg in ballasts),
        *(
            Condition(f"a deployment from {height:.3f} m with a platform of {kg:.2f} kg", {**_at_height(height), **_weighing(kg)})
            for kg in ballasts
        ),
        *(Condition(f"a deployment released {1e3 * x:.0f} mm off the centre", _released(position_m=[x, 0.0, 0.0])) for x in _OFF_CENTRE_M),
        *(Condition(f"a deployment released with a tilt of {tilt:g} rad", _released(theta_rad=[0.0, tilt, 0.0])) for tilt in _TILT_RAD),
        *(Condition(f"a deployment released turned by {turn:g} rad", _released(theta_rad=[0.0, 0.0, turn])) for turn in _TURN_RAD),
        Condition("a deployment with the legs moved on by a third of a turn", {"geometry": _third_of_a_turn(g)}),
    ]


def _as_it_is(problem: Problem) -> list[Condition]:
    """A first deployment, or other films of the one there is."""
    if not problem.films:
        return [Condition("a deployment as the model describes it")]
    return [
        Condition("a film twice as long, with the free bounce on the stops", longer=2.0),
        Condition("a film of the same deployment from the side", channels=("y_m", "z_m", "theta_x_rad")),
    ]


def _released(**pose: list[float]) -> dict[str, Any]:
    return {"release": pose}


def _at_height(height_m: float) -> dict[str, Any]:
    return {"geometry": {"stowed_height_m": height_m}}


def _weighing(mass_kg: float) -> dict[str, Any]:
    return {"platform": {"mass_kg": mass_kg}}


def _third_of_a_turn(g: Geometry) -> dict[str, Any]:
    """Each leg with its joints where the leg two places on had them."""
    return {key: [list(joint) for joint in (*joints[2:], *joints[:2])] for key, joints in _joints(g).items()}


def _joints(g: Geometry) -> dict[str, Any]:
    return {"base_joints_m": g.base_joints_m, "platform_joints_m": g.platform_joints_m}


def loops(problem: Problem) -> list[Condition]:
    """Loops that differ from those there are; where there are none, a plain one."""
    if not problem.loops:
        stroke = (
            0.4 if problem.model.geometry is None else problem.model.geometry.deployed_height_m - problem.model.geometry.stowed_height_m
        )
        return [_loop(_FREE_LOOP[0], _FREE_LOOP[1] * stroke), _loop(3 * _FREE_LOOP[0], _FREE_LOOP[1] * stroke)]
    seen = [(loop.data.frequency_Hz, float(np.ptp(loop.data.elongation_m)) / 2) for loop in problem.loops]
    fastest, slowest = max(f for f, _ in seen), min(f for f, _ in seen)
    widest, narrowest = max(a for _, a in seen), min(a for _, a in seen)
    return [
        _loop(_FASTER * fastest, widest),
        _loop(_FASTER * fastest, narrowest),
        _loop(slowest, _WIDER * widest),
        _loop(fastest, _WIDER * widest),
    ]


def _loop(frequency_Hz: float, amplitude_m: float) -> Condition:
    words = f"a loop at {frequency_Hz:.3g} Hz with an amplitude of {1e3 * amplitude_m:.3g} mm"
    return Condition(words, frequency_Hz=frequency_Hz, amplitude_m=amplitude_m)


def blank_film(problem: Problem, condition: Condition) -> Film:
    """A film like the first one, under another condition, that has seen nothing yet."""
    like = problem.films[0] if problem.films else _plain_film(problem.model)
    channels = condition.channels or like.channels
    step = float(np.median(np.diff(like.time_s)))
    time = like.time_s[0] + step * np.arange(round(condition.longer * len(like.time_s)))
    run = Run(Trajectory(time, {name: np.zeros(len(time)) for name in channels}), condition.changes, name="further")
    model = run.model(problem.model)
    sigma = np.array([_typical_sigma(problem.films or (like,), name, longest_arm(model)) for name in channels])
    nominal = np.array([model.geometry.stowed_height_m if name == "z_m" and model.geometry else 0.0 for name in channels])
    zeroed = np.full(len(channels), bool(like.zeroed.any()))
    blank = np.zeros((len(channels), len(time)))
    noise, counts = blank + sigma[:, None], blank == 0.0
    return Film(run, model, time, channels, blank, noise, counts, nominal, zeroed, like.expected_s, by_onset=like.by_onset)


def _plain_film(model: Model) -> Film:
    """A film as a first one would be, seen from the front and counted from its first frame."""
    rate, length, angle = _FREE_FILM
    time = np.arange(round(rate * model.simulation.duration_s)) / rate
    channels = ("x_m", "z_m", "theta_y_rad")
    sigma = np.outer([length, length, angle], np.ones(len(time)))
    run = Run(Trajectory(time, {name: np.zeros(len(time)) for name in channels}), name="further")
    return Film(run, model, time, channels, 0.0 * sigma, sigma, sigma > 0.0, np.zeros(3), np.ones(3, dtype=bool), 0.0)


def _typical_sigma(films: Sequence[Film], channel: str, arm_m: float) -> float:
    """The noise of a channel as of those of its kind in these films, m or rad.

    Where only the other kind was measured, a rotation is as sure as a length over the arm at which marks can stand, the platform's own.
    """
    rows: dict[str, list[Array]] = {"m": [], "rad": []}
    for film in films:
        for i, name in enumerate(film.channels):
            rows[name.rpartition("_")[2]].append(film.sigma[i])
    kind = channel.rpartition("_")[2]
    if rows[kind]:
        return float(np.nanmedian(np.concatenate(rows[kind])))
    other = float(np.nanmedian(np.concatenate(rows["rad" if kind == "m" else "m"])))
    return other * arm_m if kind == "m" else other / arm_m


def blank_loop(problem: Problem, condition: Condition) -> LoopRun:
    """A loop on a shaker that has seen no force yet; its first cycle does not count, for nobody knows with what force it will start."""
    time = np.linspace(0.0, _CYCLES / condition.frequency_Hz, _SAMPLES * _CYCLES + 1)
    middle = float(np.mean([np.mean(loop.data.elongation_m) for loop in problem.loops])) if problem.loops else condition.amplitude_m
    turn = 2 * np.pi * condition.frequency_Hz * time
    level = float(np.mean(problem.model.actuator.b_l_N))
    blank = Loop(time, middle + condition.amplitude_m * np.sin(turn), level * (1.0 + 0.01 * np.cos(turn)), name="further")
    data = prepare(blank)
    sigmas = [(loop.data.force_sigma_N, loop.data.elongation_sigma_m) for loop in problem.loops]
    force_sigma_N, sigma_m = np.median(sigmas, axis=0) if sigmas else (_FREE_LOOP[2] * abs(level), _FREE_LOOP[3])
    moved = harmonic_motion(time, blank.elongation_m, sigma_m)
    assert moved is not None
    used = data.used & (time > 1.0 / condition.frequency_Hz)
    predicted = replace(data, force_sigma_N=float(force_sigma_N), motion_errors=moved[1], used=used)
    return LoopRun(Run(blank, name="further"), problem.model, predicted)
