"""Made campaigns with something hidden in them: files for the code under test, the truth under seal."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation.horizons import solve_from_afar
from identify.estimation.observation import RunRelease, View, observe
from identify.estimation.problem import Fit
from identify.selection.explain import explain
from identify.selection.explanation import Explanation
from measure.tables.loop import Loop, write_loop
from measure.tables.trajectory import Trajectory, write_trajectory
from simulate.files.model_file import read_model, write_model
from simulate.loop import loop_force
from simulate.model.effect import Effect
from simulate.model.model import Model, Simulation, with_value

SIGMA = {"x_m": 4e-6, "z_m": 4e-6, "theta_y_rad": 3e-5}
LOOPS = ((0.2, 0.01), (0.2, 0.04), (1.0, 0.01), (1.0, 0.04), (3.0, 0.01), (3.0, 0.04))


@pytest.fixture
def prototype() -> Model:
    """The shipped model of the paper's rig."""
    return read_model(Path(__file__).with_name("rig.toml"))


@pytest.fixture(scope="session")
def made_by() -> ModuleType:
    """The script that makes the shipped data, for what it put into them."""
    script = Path(__file__).resolve().parents[2] / "datasets" / "make_datasets.py"
    specification = importlib.util.spec_from_file_location("make_datasets", script)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture(scope="session")
def shaken() -> Explanation:
    """The demonstration's loops alone, explained: a shaker cannot tell a heavy hub from heavy legs."""
    demo = Path(__file__).resolve().parents[2] / "datasets" / "demo"
    return explain(read_model(demo / "rig.toml"), read_campaign(sorted((demo / "loops").glob("*.csv"))))


@pytest.fixture
def campaign(tmp_path: Path, prototype: Model) -> Callable[..., Path]:
    """Make a campaign in files: model.toml, campaign.toml, tables; what is hidden goes to a sealed file elsewhere.

    The truth is simulated with steps of 20 us.
    """

    def make(
        hidden: Effect | tuple[Effect, ...] | None,
        seed: int,
        *,
        loops: tuple[tuple[float, float], ...] = LOOPS,
        deployments: tuple[Mapping[str, Any], ...] = ({}, {"geometry.stowed_height_m": 0.30}, {"platform.mass_kg": 1.0}),
        hold_out: bool = True,
        channels: tuple[str, ...] = tuple(SIGMA),
        model: Model = prototype,
        loop_steps: int = 20_000,
    ) -> Path:
        chance = np.random.default_rng(seed)
        folder = tmp_path / f"campaign-{seed}"
        folder.mkdir()
        write_model(model, folder / "model.toml")
        truth = replace(model, simulation=Simulation(0.6, 1000.0, 2e-5))
        acting = hidden if isinstance(hidden, tuple) else (hidden,) if hidden else ()
        for effect in acting:
            truth = truth.with_effect(effect)
        rows = []
        for i, changes in enumerate(deployments):
            write_trajectory(_deployment(truth, changes, channels, chance), folder / f"deployment-{i + 1}.csv")
            out = hold_out and i == len(deployments) - 1 and i > 0
            changed = "".join(f"model.{key} = {value}\n" for key, value in changes.items())
            rows.append(f'[[run]]\nfile = "deployment-{i + 1}.csv"\nhold_out = {str(out).lower()}\n{changed}')
        for frequency, amplitude in loops:
            write_loop(_loop(truth, frequency, amplitude, chance, loop_steps), folder / f"loop-{frequency}-{amplitude}.csv")
            rows.append(f'[[run]]\nfile = "loop-{frequency}-{amplitude}.csv"\n')
        (folder / "campaign.toml").write_text("\n".join(rows))
        _seal(acting, tmp_path / "sealed" / f"{seed}.json")
        return folder

    return make


def _seal(acting: tuple[Effect, ...], file: Path) -> None:
    file.parent.mkdir(exist_ok=True)
    known = [{"name": effect.name, "values": dict(zip(effect.flat_names(), effect.flat().tolist(), strict=True))} for effect in acting]
    file.write_text(json.dumps(known[0] if len(known) == 1 else known))


@pytest.fixture(scope="session")
def fits() -> dict[str, Fit]:
    """Fits of campaigns by what stands in their files, so that tests of one campaign share it."""
    return {}


@pytest.fixture
def fitted(fits: dict[str, Fit]) -> Callable[[Path], Fit]:
    """The base of a campaign with its releases, fitted to the runs that are not held out."""

    def fit(folder: Path) -> Fit:
        files = [(path.name, path.read_bytes()) for path in sorted(folder.iterdir()) if path.is_file()]
        key = hashlib.sha256(repr(files).encode()).hexdigest()
        if key not in fits:
            runs = [run for run in read_campaign([folder / "campaign.toml"]) if not run.hold_out]
            fits[key] = solve_from_afar(problem_of(read_model(folder / "model.toml"), runs))
        return fits[key]

    return fit


@pytest.fixture
def unseal(tmp_path: Path) -> Callable[[int], dict[str, Any]]:
    """Read the truth of a campaign, once the answer has been given."""
    return lambda seed: json.loads((tmp_path / "sealed" / f"{seed}.json").read_text())


def _deployment(truth: Model, changes: Mapping[str, Any], channels: tuple[str, ...], chance: np.random.Generator) -> Trajectory:
    for key, value in changes.items():
        truth = with_value(truth, key, value)
    time = np.arange(150) / 250.0
    position, theta = chance.normal(0.0, 1e-3, 3), chance.normal(0.0, 2e-3, 3)
    release = RunRelease(tuple(position.tolist()), tuple(theta.tolist()), float(chance.normal(0.0, 4e-3)))
    shown = observe(View(truth, time, release))
    noisy = {name: shown[name] + chance.normal(0.0, SIGMA[name], 150) for name in channels}
    return Trajectory(time, noisy, {name: np.full(150, SIGMA[name]) for name in channels})


def _loop(truth: Model, frequency: float, amplitude: float, chance: np.random.Generator, steps: int) -> Loop:
    """Three cycles in a thousand samples; a play wants many steps, and a multiple of twelve, so that one ends at every turning point."""
    time = np.linspace(0.0, 3.0 / frequency, steps + 1)
    w = 2 * np.pi * frequency
    u, v, a = 0.1 + amplitude * np.sin(w * time), amplitude * w * np.cos(w * time), -amplitude * w**2 * np.sin(w * time)
    law = truth.actuator
    lines = np.array([law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m])
    force = loop_force(lines, time, u, v, a, 2.84, truth.effects)
    for effect in truth.effects:
        force = effect.observe_force(time, u, force)
    force = force[:: steps // 1000]
    return Loop(
        time[:: steps // 1000], u[:: steps // 1000] + chance.normal(0.0, 1e-5, len(force)), force + chance.normal(0.0, 2e-3, len(force))
    )
