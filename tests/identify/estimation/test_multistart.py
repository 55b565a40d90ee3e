"""Behind the stops a release has several local minima; the right one is found again from a wrong one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.campaign.runs import read_campaign
from identify.criteria import GAP_P, NEAR
from identify.estimation import multistart
from identify.estimation.horizons import before_the_stops, solve_from_afar
from identify.estimation.least_squares import solve
from identify.estimation.multistart import Minima, from_elsewhere, released_again
from identify.estimation.problem import Fit
from identify.gap.gap_test import gap_test
from measure.readers.measurement import read_measurement
from simulate.files.model_file import read_model

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"


def wrong_minima(problem, own, draws):
    """Fits that end in a wrong local minimum, from releases drawn as the motion before the stops allows; base as it is."""
    early = solve(before_the_stops(problem), free=own)
    chance = np.random.default_rng(1)
    for _ in range(draws):
        start = early.q.copy()
        start[own] = chance.multivariate_normal(early.q[own], early.covariance)
        fit = solve(problem, start, free=own, most_steps=60)
        if gap_test(fit).p_value < GAP_P:
            yield fit


def second_deployment(made_by):
    """Of the demonstration, with the very model that it was made with."""
    start = {"geometry": {"stowed_height_m": 0.30}}
    model = replace(made_by.truth(), simulation=made_by.rig().simulation)
    return problem_of(model, [Run(read_measurement(DEMO / "deployment-2.csv"), start)])


@pytest.mark.slow
def test_a_release_in_a_wrong_minimum_is_brought_into_the_right_one(made_by):
    problem = second_deployment(made_by)
    own = list(range(problem.first_nuisance, problem.first_effect))
    wrong = list(wrong_minima(problem, own, 9))
    assert len(wrong) >= 2
    known: Minima = {}
    for fit in wrong:
        for again in (released_again(fit, own), released_again(fit, own, known)):
            assert gap_test(again).p_value > GAP_P
            assert again.cost < 0.95 * fit.cost
    (minima,) = known.values()
    assert 1 <= len(minima) <= 4


def test_minima_that_are_known_are_tried_and_no_others(made_by, monkeypatch):
    problem = second_deployment(made_by)
    own = list(range(problem.first_nuisance, problem.first_effect))
    right = solve_from_afar(problem, free=own)
    q = right.q.copy()
    q[own] += 0.3
    astray = replace(right, q=q, gaps=problem.gaps(q))
    monkeypatch.setattr(multistart, "_places", lambda *_: pytest.fail("draws from anew"))
    known: Minima = {problem.films[0].run.name: [right.q[own]]}
    again = from_elsewhere(astray, 0, right.q, np.eye(len(right.q)), own, known)
    assert again.cost < right.cost + NEAR


def test_a_film_that_a_fit_misses_before_its_stops_too_is_looked_for_again(made_by):
    """Runs fitted together can leave one of them far off from its release on; alone, up to the stops, it would be met."""
    problem = second_deployment(made_by)
    own = list(range(problem.first_nuisance, problem.first_effect))
    q = solve(before_the_stops(problem), free=own).q
    q[own] += 0.5
    gaps, slopes = problem.jacobian(q, own, problem.gaps(q))
    far_off = Fit(problem, q, gaps, slopes, converged=True, moved=tuple(own))
    early = np.concatenate([far_off.part(block)[: len(far_off.part(block)) // 2] for block in problem.blocks])
    assert np.sqrt(np.mean(early**2)) > 2.0
    assert gap_test(released_again(far_off, own)).p_value > GAP_P


PLANAR = {"position_x_m": 0.3, "position_z_m": 0.2, "theta_y_rad": -0.5, "instant_s": 0.1}


def released(problem, **across):
    """Parameters of a problem with one film: a release in its spreads, `across` what one camera does not see of it."""
    values = PLANAR | across
    return np.array([values.get(parameter.key, 0.0) for parameter in problem.parameters])


def shown_by(problem, q, chance):
    """The same problem with a film that shows the release `q`, with noise."""
    film, gaps = problem.films[0], problem.gaps(q)
    values = film.values + film.sigma * chance.normal(size=film.values.shape)
    for block in problem.blocks:
        channel = film.channels.index(block.channel)
        values[channel, block.samples] -= gaps[block.rows] * film.sigma[channel, block.samples]
    return replace(problem, films=(replace(film, values=values),))


@pytest.mark.parametrize("wrong", [(-1.7, 2.9, 0.4), pytest.param((0.7, 1.5, -2.9), marks=pytest.mark.slow)])
def test_a_release_across_the_camera_is_found_from_where_it_is_as_far_off_another_way(campaign, wrong):
    """Though what the motion before the stops says of it leads nowhere else."""
    folder = campaign(None, 641, loops=(), deployments=({"geometry.stowed_height_m": 0.30},), hold_out=False)
    model_alone = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    truth = released(model_alone, position_y_m=-3.0, theta_x_rad=-1.5, theta_z_rad=0.0)
    problem = shown_by(model_alone, truth, np.random.default_rng(3))
    own = list(range(problem.first_nuisance, problem.first_effect))
    right = solve(problem, truth, free=own)
    start = released(problem, **dict(zip(("position_y_m", "theta_x_rad", "theta_z_rad"), wrong, strict=True)))
    stuck = solve(problem, start, free=own, most_steps=60)
    assert stuck.cost > right.cost + 300.0
    assert from_elsewhere(stuck, 0, stuck.q, np.zeros((len(stuck.q), len(stuck.q)))).cost < right.cost
    early = solve(before_the_stops(problem), stuck.q)
    assert from_elsewhere(stuck, 0, early.q, early.covariance).cost < right.cost


@pytest.mark.parametrize(
    "known", [("release_position_m", "release_theta_rad"), ("release_position_m", "release_theta_rad", "release_instant_s")]
)
def test_a_release_that_is_known_has_no_other_minimum(campaign, known):
    folder = campaign(None, 642, loops=(), deployments=({},), hold_out=False)
    model = read_model(folder / "model.toml")
    exact = replace(model, nuisance=replace(model.nuisance, **dict.fromkeys(known, 0.0)))
    fit = solve(problem_of(exact, read_campaign([folder / "campaign.toml"])))
    early = solve(before_the_stops(fit.problem), fit.q)
    assert from_elsewhere(fit, 0, early.q, early.covariance).cost == pytest.approx(fit.cost, rel=1e-3)
