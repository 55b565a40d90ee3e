"""Four deployments and six loops explained, and a single deployment; beside scipy's solve_ivp, as one would write it.

OPENBLAS_NUM_THREADS=1 .venv/bin/python tests/benchmarks/bench_explain.py

The aims on two cores: a campaign under a minute, a single deployment under 20 s, kernels compiled. One evaluation of the gaps of
all four films is timed both ways; the whole fit over solve_ivp would take that ratio longer.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "hidden"))

from board.platform_ode import moved_by_ode

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.observation import RunRelease, View, observe
from identify.selection.explain import explain
from identify.selection.explanation import Explanation
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.effects import GravityImbalance
from simulate.files.model_file import read_model
from simulate.loop import loop_force
from simulate.model.model import Model, with_value

ROOT = Path(__file__).resolve().parents[2]
HIGH, HEAVY = {"geometry": {"stowed_height_m": 0.3}}, {"platform": {"mass_kg": 1.0}}
CONDITIONS = ({}, HIGH, HEAVY, {**HIGH, **HEAVY})
SIGMA = {"x_m": 2e-5, "z_m": 2e-5, "theta_y_rad": 1e-4}


def deployments(model: Model, chance: np.random.Generator) -> list[Run]:
    """Two start heights, two ballasts, a weight that the counterweight does not quite balance."""
    runs = []
    for i, changes in enumerate(CONDITIONS):
        truth = model.with_effect(GravityImbalance(0.05))
        for table, row in changes.items():
            for key, value in row.items():
                truth = with_value(truth, f"{table}.{key}", value)
        time_s = np.arange(150) / 250.0
        release = RunRelease(tuple(chance.normal(0.0, 1e-3, 3)), tuple(chance.normal(0.0, 2e-3, 3)), float(chance.normal(0.0, 4e-3)))
        shown = observe(View(truth, time_s, release))
        noisy = {name: shown[name] + chance.normal(0.0, sigma, 150) for name, sigma in SIGMA.items()}
        runs.append(
            Run(Trajectory(time_s, noisy, {name: np.full(150, sigma) for name, sigma in SIGMA.items()}), changes, name=f"run {i + 1}")
        )
    return runs


def loops(model: Model, chance: np.random.Generator) -> list[Run]:
    """Three frequencies, two strokes."""
    law = model.actuator
    lines = np.array([law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m], dtype=float)
    runs = []
    for frequency in (0.2, 1.0, 3.0):
        for amplitude in (0.01, 0.04):
            t, w = np.linspace(0.0, 3.0 / frequency, 1001), 2 * np.pi * frequency
            u, v, a = 0.1 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
            force = loop_force(lines, t, u, v, a, 2.84, model.effects) + chance.normal(0.0, 2e-3, 1001)
            runs.append(Run(Loop(t, u + chance.normal(0.0, 1e-5, 1001), force, name=f"{frequency:g} Hz, {1e3 * amplitude:g} mm")))
    return runs


def timed(what: str, model: Model, runs: list[Run]) -> Explanation:
    explain(model, runs)  # compiles
    start, cpu = time.perf_counter(), time.process_time()
    found = explain(model, runs)
    took, spent = time.perf_counter() - start, time.process_time() - cpu
    names = ", ".join(" or ".join((f.name, *f.equivalents)) for f in found.findings)
    print(f"{what:<38} {took:6.1f} s   {spent:6.1f} processor seconds   {found.verdict} {names}")
    return found


def over_solve_ivp(model: Model) -> None:
    """One evaluation of all deployments: compiled, and with solve_ivp at a tolerance that a film's micrometres ask for."""
    start = time.perf_counter()
    moved_by_ode(model, np.arange(150) / 250.0, "RK45", 1e-8, 1e-9)
    slow = 4 * (time.perf_counter() - start)
    problem = problem_of(model, deployments(model, np.random.default_rng(2)))
    places = 1e-3 * np.random.default_rng(3).normal(size=(11, len(problem.parameters)))  # what was looked at once is remembered
    problem.gaps(places[0])
    start = time.perf_counter()
    for q in places[1:]:
        problem.gaps(q)
    fast = (time.perf_counter() - start) / 10
    print(f"one look at four deployments: {1e3 * fast:.0f} ms; solve_ivp (RK45, rtol 1e-8) {1e3 * slow:.0f} ms   ratio {slow / fast:.0f}")


def main() -> None:
    """Print the times and the ratio."""
    chance = np.random.default_rng(1)
    model = read_model(ROOT / "datasets" / "prototype.toml")
    films = deployments(model, chance)
    timed("four deployments, six loops", model, [*films, *loops(model, chance)])
    timed("a single deployment", model, films[:1])
    timed("nothing hidden, six loops", model, loops(model, chance))
    over_solve_ivp(model)


if __name__ == "__main__":
    main()
