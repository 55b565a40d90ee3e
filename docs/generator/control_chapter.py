"""The numbers of the chapter on control: laws on the paper's design, run by `python docs/generator/control_chapter.py [--all]`."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.control.eddy_damper import EddyDamper
from simulate.control.mechanical_link import MechanicalLink
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.control.trials import deployed
from simulate.files.model_file import read_model
from simulate.model import responses
from simulate.model.control import Controller
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import paper_factors
from simulate.sweeps.sweep import Sweep

ROOT = Path(__file__).resolve().parents[2]
_SAMPLE = 512
_HEAD = (
    "| what acts | beyond 30 deg, % | before the first stop, % | largest, deg | full height, % | force, N | energy, J | stops, N |\n|"
    + " --- |" * 8
)

_SOFT = Synchronise(stiffness_N_per_m=1000.0, damping_N_s_per_m=20.0, force_limit_N=1.0)
_SENSED: dict[str, Any] = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4, "observer_Hz": 40.0}
_LATE: dict[str, Any] = {"sample_rate_Hz": 250.0, "delay_s": 0.008, "lag_s": 0.005, "sensor_noise_rad": 1e-3}
_CAMERA: dict[str, Any] = {**_LATE, "observer_Hz": 20.0, "sensor": "camera"}
CASES: dict[str, Controller | None] = {
    "nothing": None,
    "dampers of 2 N s/m": EddyDamper(damping_N_s_per_m=2.0),
    "dampers of 5 N s/m": EddyDamper(damping_N_s_per_m=5.0),
    "dampers of 20 N s/m": EddyDamper(damping_N_s_per_m=20.0),
    "clutches of 10 N": OneWay(clutch_force_N=10.0),
    "a link of 2000 N/m": MechanicalLink(stiffness_N_per_m=2000.0),
    "synchronised brakes, k 1000 N/m, d 20 N s/m, 1 N": _SOFT,
    "the same, k 5000 N/m, d 50 N s/m": replace(_SOFT, stiffness_N_per_m=5000.0, damping_N_s_per_m=50.0),
    "the first, sampled at 1 kHz, 0.1 mm noise, 2 ms delay, 5 ms lag": replace(_SOFT, **_SENSED),
    "the same, k 100 N/m": replace(_SOFT, stiffness_N_per_m=100.0, damping_N_s_per_m=2.0, **_SENSED),
    "by a camera of 250 Hz, 8 ms late": replace(_SOFT, **_CAMERA),
    "a profile of 1 s, brakes of 5 N": Profile(duration_s=1.0, stiffness_N_per_m=5000.0, damping_N_s_per_m=50.0, force_limit_N=5.0),
}


def row(name: str, answers: Array) -> str:
    """A row of the table from the responses of all runs."""
    turned, early = (np.abs(np.degrees(answers[:, place])) for place in (responses.THETA_Z, responses.BEFORE_STOP))
    force, energy = np.max(answers[:, responses.CONTROL_FORCE]), np.max(answers[:, responses.CONTROL_ENERGY])
    shares = f"{100 * np.mean(turned > 30.0):.1f} | {100 * np.mean(early > 30.0):.1f}"
    reached, stops = 100 * np.mean(deployed(answers)), np.max(answers[:, responses.STOP_FORCE])
    return f"| {name} | {shares} | {np.max(turned):.3g} | {reached:.0f} | {force:.2f} | {energy:.2f} | {stops:.0f} |"


def main() -> None:
    """Print the table."""
    model = read_model(ROOT / "datasets" / "prototype.toml")
    factors = tuple(paper_factors(model))
    design = design_of("full", len(factors), None, 0)
    kept = np.arange(design.runs) if "--all" in sys.argv else np.random.default_rng(1).permutation(design.runs)[:_SAMPLE]
    levels = design.piece(0, design.runs)[kept]
    print(_HEAD)
    for name, controller in CASES.items():
        # a profile of a second has to be seen to its end
        longer = replace(model.simulation, duration_s=1.5) if isinstance(controller, Profile) else model.simulation
        rig = replace(model, controller=controller, simulation=longer)
        print(row(name, Sweep(rig, factors, design).responses_at(levels)), flush=True)


if __name__ == "__main__":
    main()
