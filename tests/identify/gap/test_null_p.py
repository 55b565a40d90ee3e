"""The p of compare-model where the model is right, whatever noise a camera writes: as often below 0.05 as is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration import consistent
from scipy.signal import lfilter

from identify.campaign.run import Run
from identify.estimation.observation import RunRelease, View, observe
from identify.gap.compare import compare
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import read_model
from simulate.model.model import Simulation

MODEL = read_model(Path(__file__).resolve().parents[1].joinpath("rig.toml"))
KINDS = ("white", "memory 0.5", "memory 0.8", "heavy tails", "quantised", "30 % missing")
SIGMA = {"x_m": 4e-5, "z_m": 4e-5, "theta_y_rad": 3e-4}
FRAMES, RATE_HZ = 150, 250.0


def noise(kind, chance, count):
    """A channel's noise of unit standard deviation."""
    rho = {"memory 0.5": 0.5, "memory 0.8": 0.8}.get(kind, 0.0)
    drawn = chance.standard_t(3, count + 50) / np.sqrt(3.0) if kind == "heavy tails" else chance.normal(size=count + 50)
    return np.sqrt(1.0 - rho**2) * np.asarray(lfilter([1.0], [1.0, -rho], drawn))[50:]


def deployment(kind, chance, number):
    """One film of the rig, released somewhere within its spreads."""
    time = np.arange(FRAMES) / RATE_HZ
    release = RunRelease(
        tuple(chance.normal(0.0, 1e-3, 3).tolist()), tuple(chance.normal(0.0, 2e-3, 3).tolist()), float(chance.normal(0.0, 4e-3))
    )
    shown = observe(View(replace(MODEL, simulation=Simulation(0.6, 1000.0, 5e-5)), time, release))
    values = {name: shown[name] + sigma * noise(kind, chance, FRAMES) for name, sigma in SIGMA.items()}
    if kind == "quantised":
        values = {name: 2.0 * SIGMA[name] * np.round(of / (2.0 * SIGMA[name])) for name, of in values.items()}
    if kind == "30 % missing":
        gone = chance.random(FRAMES) < 0.3
        values = {name: np.where(gone, np.nan, of) for name, of in values.items()}
    return Run(Trajectory(time, values, {name: np.full(FRAMES, sigma) for name, sigma in SIGMA.items()}, name=f"{number}.csv"))


def p_value(kind, seed):
    """Of two films compared with the model that made them."""
    chance = np.random.default_rng(seed)
    return compare(MODEL, [deployment(kind, chance, number) for number in range(2)]).test.p_value


@pytest.mark.parametrize("kind", ["memory 0.8", "quantised"])
def test_a_right_model_is_no_gap(kind):
    assert min(p_value(kind, [71, number]) for number in range(2)) > 1e-3


@pytest.mark.calibrate
@pytest.mark.parametrize("kind", KINDS)
def test_p_is_below_five_hundredths_in_three_to_eight_of_a_hundred_draws(kind, calibration_seed, share_of, validation_table):
    draws = share_of(200)
    found = np.array([p_value(kind, [calibration_seed, number]) for number in range(draws)])
    below = int(np.sum(found < 0.05))
    row = {"noise": kind, "draws": draws, "p below 0.05": below, "share, %": 100.0 * below / draws, "least p": float(found.min())}
    validation_table("p of compare-model under the null hypothesis", [row], "Two films of a right model, releases fitted; aim 3 to 8 %.")
    assert consistent(below, draws, 0.03, 0.08), row
