"""What each way to model the rate does to a deployment and to the design: `python tests/benchmarks/bench_rate.py`.

One set of loops, the demonstration's, and its rig. The loops turn with the square of the frequency, because a hub inertia of 0.01 kg was
put into them. Prints the table of `docs/how-to/rate-dependence.md`; it takes half a minute.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from identify.actuator.fit_actuator import fit_actuator
from identify.actuator.verdict import pooled_error
from identify.loops.loop_data import LoopData
from identify.loops.prepare import prepare
from identify.report.loop_result import model_of
from measure.tables.loop import read_loop
from simulate.deployment.deploy import deploy_checked
from simulate.effects import HubInertia
from simulate.files.model_file import read_model
from simulate.model.model import Actuator, Model
from simulate.sweeps.tolerance import gradient_deg_per_N, spread_N

DEMO = Path(__file__).resolve().parents[2] / "datasets" / "demo"
PROBABILITY, ANGLE_DEG = 0.95, 5.0
INITIAL_FORCE_N = 2.987  # at the release, which no loop tells: the same for all
TRUTH = Actuator(-0.12, 2.79, -0.10, 2.89, 400.0, INITIAL_FORCE_N)
COLUMNS = (
    "way",
    "error on its loops, %",
    "full height after, ms",
    "fastest leg, m/s",
    "theta_z over one b_l, deg/N",
    "spread that keeps 5 deg, mN",
)
WAYS: dict[str, tuple[str, dict[str, Any]]] = {
    "law alone": ("*", {}),
    "`--rate frequency`, order 1": ("*", {"abscissa": "frequency_Hz", "order": 1}),
    "`--rate speed`, order 1": ("*", {"abscissa": "speed_m_per_s", "order": 1}),
    "`--rate speed`, order 2 (the paper's)": ("*", {"abscissa": "speed_m_per_s", "order": 2}),
    "`--rate speed`, order 2, loops of 80 mm": ("*-80mm", {"abscissa": "speed_m_per_s", "order": 2}),
    "`--rate speed`, order 2, loops of 20 mm": ("*-20mm", {"abscissa": "speed_m_per_s", "order": 2}),
    "`--effect hub-inertia`": ("*", {"kinds": (HubInertia,)}),
}


def loops(pattern: str) -> list[LoopData]:
    """The demonstration's loops whose names fit."""
    return [prepare(read_loop(path)) for path in sorted((DEMO / "loops").glob(f"{pattern}.csv"))]


def row_of(name: str, model: Model, error: float) -> str:
    """A row of the table: error on the loops, time to full height, fastest leg, theta_z over stored force, spread that keeps 5 deg."""
    run = deploy_checked(model)
    whole = run.diverged_at_s is None
    gradient = gradient_deg_per_N(model) if whole else np.full(6, np.nan)
    fastest = float(np.nanmax(np.abs(np.gradient(run.elongation_m, run.time_s, axis=0))))
    shown = [
        f"{100.0 * error:.1f}",
        f"{1e3 * run.time_to_full_height_s:.0f}" if run.time_to_full_height_s else "-",
        f"{fastest:.2f}" if whole else f"diverges at {run.diverged_at_s:g} s",
        f"{np.max(np.abs(gradient)):.0f}" if whole else "-",
        f"{1e3 * spread_N(gradient, ANGLE_DEG, PROBABILITY):.2f}" if whole else "-",
    ]
    return f"| {name} | {' | '.join(shown)} |"


def main() -> None:
    """Print the table."""
    rig = read_model(DEMO / "rig.toml")
    print(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}")
    for name, (pattern, options) in WAYS.items():
        data = loops(pattern)
        fit = fit_actuator(data, suggest=False, **options)
        model = model_of(fit, rig)
        started = replace(model, actuator=replace(model.actuator, initial_force_N=INITIAL_FORCE_N))
        print(row_of(name, started, pooled_error(data, fit.residuals)), flush=True)
    print(row_of("what was put into the loops", replace(rig, actuator=TRUTH).with_effect(HubInertia(0.01)), float("nan")))


if __name__ == "__main__":
    main()
