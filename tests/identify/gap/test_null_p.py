"""The p of compare-model where the model is right, whatever noise a camera writes: as often below 0.05 as is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from calibration import consistent
from scipy.signal import lfilter

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.estimation.fit import Block, Fitted
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import off_the_mirror, solve
from identify.estimation.observation import RunRelease, View, observe
from identify.gap.compare import compare
from identify.gap.gap_test import _release_p, gap_test
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
    own = MODEL.nuisance
    release = RunRelease(
        tuple(chance.normal(0.0, own.release_position_m, 3).tolist()),
        tuple(chance.normal(0.0, own.release_theta_rad, 3).tolist()),
        float(chance.normal(0.0, own.release_instant_s)),
        stored_force_fraction=float(chance.normal(0.0, 0.01 * own.stored_force_percent)),
    )
    return film_of(release, kind, chance, number)


def film_of(release, kind, chance, number):
    """One film of the rig as it was released."""
    time = np.arange(FRAMES) / RATE_HZ
    shown = observe(View(replace(MODEL, simulation=Simulation(0.6, 1000.0, 5e-5)), time, release))
    values = {name: shown[name] + sigma * noise(kind, chance, FRAMES) for name, sigma in SIGMA.items()}
    if kind == "quantised":
        values = {name: 2.0 * SIGMA[name] * np.round(of / (2.0 * SIGMA[name])) for name, of in values.items()}
    if kind == "30 % missing":
        gone = chance.random(FRAMES) < 0.3
        values = {name: np.where(gone, np.nan, of) for name, of in values.items()}
    return Run(Trajectory(time, values, {name: np.full(FRAMES, sigma) for name, sigma in SIGMA.items()}, name=f"{number}.csv"))


def compared(kind, seed):
    """Two films compared with the model that made them."""
    chance = np.random.default_rng(seed)
    return compare(MODEL, [deployment(kind, chance, number) for number in range(2)]).test


@pytest.mark.parametrize("kind", ["memory 0.8", "quantised"])
def test_a_right_model_is_no_gap(kind):
    assert min(compared(kind, [71, number]).p_value for number in range(2)) > 1e-3


@pytest.mark.slow
def test_releases_are_as_improbable_as_is_said_although_a_film_shows_but_some_of_their_numbers():
    found = np.array([compared("white", [83, number]).release_p for number in range(40)])
    assert 8 <= np.sum(found < 0.5) <= 28  # half of them, within three standard deviations
    assert found.min() > 1e-4


def fitted_release(chance, rho, shown, unseen=False):
    """A release of as many numbers as `shown` says how strongly a film shows, drawn from its spreads and found by least squares."""
    count, k = 200, len(shown)
    columns = np.cos(np.outer(np.linspace(0.0, np.pi, count), np.arange(1, k + 1))) / np.sqrt(0.5 * count) * shown
    gaps = columns @ chance.normal(size=k) + np.sqrt(1.0 - rho**2) * lfilter([1.0], [1.0, -rho], chance.normal(size=count + 50))[50:]
    jacobian = np.vstack([-columns, np.eye(k)])
    q = np.linalg.solve(jacobian.T @ jacobian, columns.T @ gaps)
    no = np.zeros(k, dtype=bool)
    problem = SimpleNamespace(
        blocks=(Block("film", "z_m", slice(0, count), np.arange(count)),),
        parameters=[SimpleNamespace(spread=1.0)] * k,
        bounds=(np.full(k, -np.inf), np.full(k, np.inf)),
        turned=lambda q, gaps: np.zeros(len(gaps)),
        **{"measured": count, "first_nuisance": 0, "first_zero": k, "held": no, "unseen": no | unseen, "films": (), "loops": ()},
    )
    posed: Any = problem
    return Fitted(posed, q, np.concatenate([gaps - columns @ q, q]), jacobian, True)


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_a_release_is_as_improbable_as_is_said_whether_its_numbers_show_or_not(rho):
    """Counted in full, numbers that hardly show would leave hardly any below 0.05; counted as under white noise, too many."""
    chance = np.random.default_rng(86)
    shown = np.array([30.0, 10.0, 2.0, 1.0, 0.3, 0.1, 0.01])
    found = [_release_p(fitted_release(chance, rho, shown)) for _ in range(1000)]
    assert 0.025 <= np.mean(np.array(found) < 0.05) <= 0.085
    assert np.mean(found) == pytest.approx(0.5, abs=0.07)


def test_what_shows_by_its_square_alone_counts_in_full():
    fits = [fitted_release(np.random.default_rng(87), 0.0, np.array([2.0, 1.0, 0.5]), unseen) for unseen in (False, True)]
    directly, by_square = map(_release_p, fits)
    assert by_square > 1.5 * directly


def test_a_fit_leaves_the_place_where_mirror_images_meet():
    """What no camera shows of a release acts by its square: a fit that begins at nought stays there and leaves a gap."""
    run = film_of(RunRelease(theta_rad=(-0.0045, 0.0, -0.006)), "white", np.random.default_rng(85), 0)
    problem = problem_of(MODEL, [run])
    own = range(problem.first_nuisance, problem.first_effect)
    at_nought = solve(problem, free=own)
    assert gap_test(at_nought).p_value < 1e-4
    for found in (off_the_mirror(at_nought), solve_from_afar(problem, free=own)):
        assert gap_test(found).p_value > 1e-3
    assert compare(MODEL, [run]).test.p_value > 1e-3


def test_a_release_far_off_is_improbable_and_one_taken_to_the_letter_is_none():
    run = deployment("white", np.random.default_rng(84), 0)
    far = replace(MODEL, release=replace(MODEL.release, position_m=(6.0 * MODEL.nuisance.release_position_m, 0.0, 0.0)))
    assert compare(far, [run]).test.release_p < 1e-4 < compare(MODEL, [run]).test.release_p
    assert compare(MODEL, [run], fit_release=False).test.release_p == 1.0


@pytest.mark.calibrate
@pytest.mark.parametrize("kind", KINDS)
def test_p_is_below_five_hundredths_in_three_to_eight_of_a_hundred_draws(kind, calibration_seed, share_of, validation_table):
    draws = share_of(200)
    found = np.array([compared(kind, [calibration_seed, number]).p_value for number in range(draws)])
    below = int(np.sum(found < 0.05))
    row = {"noise": kind, "draws": draws, "p below 0.05": below, "share, %": 100.0 * below / draws, "least p": float(found.min())}
    validation_table("p of compare-model under the null hypothesis", [row], "Two films of a right model, releases fitted; aim 3 to 8 %.")
    assert consistent(below, draws, 0.03, 0.08), row
