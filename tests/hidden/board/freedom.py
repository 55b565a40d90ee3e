"""What a case leaves free: the force law, how each run was let go, and what camera and laser do not know of themselves.

Each thing that is free is counted in its spread, which is its prior.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from simulate.model.model import LEGS, Model, Nuisance, with_value

from .bench import Bench, seen
from .campaigns import LASER_SIGMA_M, Campaign, Deployment, Shaking

Array = np.ndarray
Run = Deployment | Shaking

LAW = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")
WEAK_FORCE, WEAK_BETA = 0.2, 0.8  # what a model file is trusted with, in parts of the force and of beta
CAMERA_DISTANCE_M = 2.0  # a release nearer by its spread makes a film's lengths longer by spread over distance
_START_N = 1e3  # a loop's first force is not known at all
_STARTED_S = 0.05  # a camera that counts from its first frame was started by hand
_NUDGE = 1e-3

FreeParameter = Callable[[Bench, float], Bench]  # the bench with one thing that is free moved by so many spreads


def free_parameters(bench: Bench) -> list[FreeParameter]:
    """The force law, and of each run that takes part how it was let go and how well its path is known."""
    own = [_of_run(i, moved) for i, run in enumerate(bench.runs) for moved in _ways(run, bench.rig.known.nuisance)]
    return [*(_of_law(key, size) for key, size in _law_sizes(bench.rig.true).items()), *own]


def _law_sizes(model: Model) -> dict[str, float]:
    law = model.actuator
    force = WEAK_FORCE * float(np.mean(law.b_l_N))
    sizes = dict.fromkeys(LAW, force)
    sizes |= {"a_l_N_per_m": 2 * force / 0.4, "a_u_N_per_m": 2 * force / 0.4}
    return sizes | {"beta_per_m": WEAK_BETA * float(np.mean(law.beta_per_m))}


def _of_law(key: str, size: float) -> FreeParameter:
    def moved(bench: Bench, amount: float) -> Bench:
        model = bench.rig.true
        at = getattr(model.actuator, key)
        there = at * np.exp(np.clip(amount * size / at, -3.0, 3.0)) if key == "beta_per_m" else at + amount * size  # beta is positive
        return bench.with_model(with_value(model, f"actuator.{key}", there))

    return moved


def _of_run(number: int, moved: Callable[[Run, float], Run]) -> FreeParameter:
    def moved_bench(bench: Bench, amount: float) -> Bench:
        runs = [moved(run, amount) if i == number else run for i, run in enumerate(bench.runs)]
        films = tuple(run for run in runs if isinstance(run, Deployment))
        return replace(bench, campaign=Campaign(films, tuple(run for run in runs if isinstance(run, Shaking))))

    return moved_bench


def _ways(run: Run, spread: Nuisance) -> Iterator[Callable[[Run, float], Run]]:
    """A film let go elsewhere, turned, with other legs, later; a loop from another force, its path off as white noise leaves it."""
    if isinstance(run, Deployment):
        for key, count, size in (
            ("position_m", 3, spread.release_position_m),
            ("theta_rad", 3, spread.release_theta_rad),
            ("legs_N", LEGS if spread.stored_force_N > 0 else 0, spread.stored_force_N),
        ):
            yield from (_along(key, size * np.eye(count)[axis]) for axis in range(count))
        yield _along("instant_s", _STARTED_S if run.zeroed else spread.release_instant_s)
        return
    white = LASER_SIGMA_M / np.sqrt(len(run.time_s))
    in_time = np.sqrt(2.0) * white / run.amplitude_m / (2.0 * np.pi * run.frequency_Hz)
    for key, size in (("start_force_N", _START_N), ("mean_m", white), ("amplitude_m", np.sqrt(2.0) * white), ("late_s", in_time)):
        yield _along(key, size)


def _along(key: str, size: float | Array) -> Callable[[Run, float], Run]:
    return lambda run, amount: replace(run, **{key: getattr(run, key) + amount * size})


def moved(bench: Bench, ways: Sequence[FreeParameter], x: Array) -> Bench:
    """The bench with every free parameter moved, x in spreads."""
    for parameter, amount in zip(ways, x, strict=True):
        bench = parameter(bench, float(amount))
    return bench


def columns(bench: Bench, ways: Sequence[FreeParameter]) -> Array:
    """What each free parameter changes in all measured values, by spread, (m, n); only the runs that it touches are simulated."""
    nudged = [parameter(bench, _NUDGE) for parameter in ways]
    touched = [(k, i) for k, other in enumerate(nudged) for i, run in enumerate(other.runs) if _differs(other, bench, i, run)]
    made = np.zeros((len(bench.here), len(ways)))
    values = seen([(nudged[k].rig.true, nudged[k].runs[i]) for k, i in touched])
    for (k, i), value in zip(touched, values, strict=True):
        made[bench.rows[i], k] = (value - bench.here[bench.rows[i]]) / _NUDGE
    return made


def _differs(other: Bench, bench: Bench, number: int, run: Run) -> bool:
    return other.rig is not bench.rig or run is not bench.runs[number]


def shown_besides(bench: Bench) -> Array:
    """What cameras add, by spread, (m, k): a film counts from its first frame, whose error stands in all others, and has a scale."""
    made = []
    for run, rows in zip(bench.runs, bench.rows, strict=True):
        if isinstance(run, Deployment) and run.zeroed:
            made += [_placed(bench, rows, column) for column in _datum_and_scale(run, bench.here[rows], bench.rig.known)]
    return np.stack(made, axis=1) if made else np.empty((len(bench.here), 0))


def _datum_and_scale(run: Deployment, here: Array, known: Model) -> list[Array]:
    n = len(run.time_s)
    made = [np.where(np.arange(len(here)) // n == i, 1.0, 0.0) for i in range(len(run.channels))]
    lengths = np.repeat([name.endswith("_m") for name in run.channels], n)
    made.append(np.where(lengths, here, 0.0) * known.nuisance.release_position_m / CAMERA_DISTANCE_M)
    return made


def _placed(bench: Bench, rows: slice, values: Array) -> Array:
    column = np.zeros(len(bench.here))
    column[rows] = values
    return column
