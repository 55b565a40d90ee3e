"""Tables that a simulation wrote, without noise: what two integrators or a rounded number differ by is no gap."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identify.campaign.noiseless import with_noise_where_none
from identify.campaign.run import Run
from identify.gap.compare import compare
from identify.report.result import result_of
from identify.selection.explain import explain
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.deployment.deploy import deploy
from simulate.effects import CATALOGUE, HubInertia
from simulate.files.model_file import read_model
from simulate.loop import loop_force
from simulate.model.model import Simulation


@pytest.fixture
def model():
    return read_model(Path(__file__).resolve().parents[1].joinpath("rig.toml"))


def computed(model, step_s=2.5e-4, places=12):
    """A deployment as `simulate-deployment` writes it: every channel, no noise, a step of its own."""
    run = deploy(replace(model, simulation=Simulation(0.5, 500.0, step_s)))
    return Trajectory(run.time_s, {name: np.round(values, places) for name, values in run.channels.items()}, name="computed")


def shaken(model, frequency_Hz):
    time, omega = np.linspace(0.0, 3 / frequency_Hz, 601), 2 * np.pi * frequency_Hz
    u, v = 0.02 * np.sin(omega * time), 0.02 * omega * np.cos(omega * time)
    law = model.actuator
    lines = np.array([law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m])
    return Run(Loop(time, u, loop_force(lines, time, u, v, -(omega**2) * u, 2.8, model.effects)), name=f"{frequency_Hz:g} Hz")


FEW = {name: CATALOGUE[name] for name in ("hub-inertia", "viscous-friction", "gravity-imbalance")}


@pytest.mark.parametrize(
    ("places", "catalogue"),
    [(12, FEW), (4, FEW), *(pytest.param(places, CATALOGUE, marks=pytest.mark.calibrate) for places in (12, 5, 4))],
    ids=lambda given: str(given) if isinstance(given, int) else "few" if given is FEW else "all",
)
def test_a_simulation_with_another_step_or_rounded_numbers_is_no_gap(model, places, catalogue):
    found = explain(model, [Run(computed(model, places=places))], catalogue)
    assert found.verdict == "no-gap"
    assert "x_m" in {one.channel for one in found.noise_added}


def test_loops_that_were_computed_are_no_gap_and_what_acts_in_them_is_found(model):
    assert explain(model, [shaken(model, f) for f in (0.3, 3.0)]).verdict == "no-gap"
    found = explain(model, [shaken(model.with_effect(HubInertia(0.01)), f) for f in (0.3, 3.0)])
    assert "hub-inertia" in {name for finding in found.findings for name in (finding.name, *finding.equivalents)}
    assert {row["channel"] for row in result_of(found)["noise_added"]} == {"force_N"}


def test_what_was_measured_is_left_as_it_is(model):
    chance, table = np.random.default_rng(0), computed(model)
    noise = {name: 4e-6 if name.endswith("_m") else 6e-5 for name in table.channels}
    channels = {name: values + chance.normal(0.0, noise[name], len(values)) for name, values in table.channels.items()}
    measured = Run(replace(table, channels=channels))
    runs, added = with_noise_where_none([measured])
    assert runs[0] is measured
    assert not added


def test_a_tracker_that_says_how_sure_it_is_is_believed_however_sure(model):
    table = computed(model)
    chance, quiet = np.random.default_rng(1), {name: 3e-7 if name.endswith("_m") else 1e-6 for name in table.channels}
    channels = {name: values + chance.normal(0.0, quiet[name], len(values)) for name, values in table.channels.items()}
    tracked = Run(replace(table, channels=channels, sigma={name: np.full(len(table.time_s), sigma) for name, sigma in quiet.items()}))
    assert with_noise_where_none([tracked]) == ((tracked,), ())


def test_the_noise_hangs_neither_on_the_order_of_the_runs_nor_on_the_clock(model):
    first, second = computed(model), computed(model, places=6)
    late = replace(first, time_s=first.time_s + 3.0)
    noisy = [run.table for run in with_noise_where_none([Run(first), Run(second)])[0]]
    again = [run.table for run in with_noise_where_none([Run(second), Run(late)])[0]]
    for table, same in zip(noisy, reversed(again), strict=True):
        assert isinstance(table, Trajectory)
        assert isinstance(same, Trajectory)
        assert all(np.array_equal(table.channels[name], same.channels[name]) for name in table.channels)


def test_a_comparison_gives_the_plain_difference_of_what_was_computed(model):
    table = computed(model)
    found = compare(model, [Run(table)])
    assert found.gap_is_noise
    assert found.fit.rms < 0.5
    z = next(curve for curve in found.curves if curve.channel == "z_m")
    assert np.array_equal(z.measured, table.channels["z_m"])
    assert z.numbers["rmse"] < 2e-6
