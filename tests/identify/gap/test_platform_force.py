"""The force that no effect explains: where it acts, what it goes with, and in what words."""

from __future__ import annotations

import numpy as np
import pytest
from board.outside import Gust

from identify.gap.formula import described
from identify.gap.platform_force import ForceAlongSpeed, ForceAlongTime, MissingForce, at_once, estimate
from identify.selection.unknown_force import unnamed_forces
from identify.selection.weighing import weighed
from simulate.effects import GravityImbalance


@pytest.mark.slow
def test_a_force_that_comes_at_its_time_is_best_told_along_time(campaign, fitted):
    """Three start heights are at different heights and speeds when it comes."""
    heights = ({}, {"geometry.stowed_height_m": 0.35}, {"geometry.stowed_height_m": 0.45}, {})
    found = [one for one in unnamed_forces(weighed(fitted(campaign(Gust(0.15), 91, deployments=heights)))) if one.in_legs is None]
    assert isinstance(found[0].table, ForceAlongTime)
    assert found[0].log_z > found[1].log_z + 3.0
    missing = estimate(fitted(campaign(Gust(0.15), 98, deployments=heights)), ForceAlongTime, {"height": 5.0, "speed": 5.0})
    assert "acts upwards on the platform" in missing.sentence
    assert "at its largest (0.20)" in missing.sentence


@pytest.mark.slow
def test_one_run_cannot_tell_what_a_force_goes_with(campaign, fitted):
    """In one deployment time, height and speed run together."""
    missing = estimate(fitted(campaign(Gust(0.15), 95, deployments=({},))), ForceAlongTime, {"height": 1.0, "speed": 0.5})
    assert "these runs cannot tell" in missing.sentence


def test_one_look_along_time_shows_a_constant_force_for_what_it_is(campaign, fitted):
    """A steady weight shows as a steady force, within its band at nearly every instant."""
    found = at_once(fitted(campaign(GravityImbalance(0.02), 92, deployments=({}, {"geometry.stowed_height_m": 0.30}))))
    assert found.along is ForceAlongTime
    force, sigma = found.force_N[:, 0], found.sigma_N[:, 0]
    known = sigma < 0.1
    assert known.sum() > 4
    assert np.mean(np.abs(force[known] - 0.02) < 3.0 * sigma[known]) > 0.8


def test_without_rotations_a_lateral_force_is_told_and_no_moment_that_would_stand_against_it(campaign, fitted):
    runs = ({}, {"geometry.stowed_height_m": 0.30})
    found = at_once(fitted(campaign(GravityImbalance(0.02), 97, deployments=runs, channels=("x_m", "z_m"))))
    assert np.isnan(found.sigma_N[:, 2]).all()
    assert np.nanmedian(found.sigma_N[:, 1]) < 0.1  # newtons; some newtons where a moment was estimated beside it


def test_a_drag_is_described_by_the_square_of_the_speed(campaign, fitted):
    """A table along the speed that is -0.2 v |v| is written as that, and as no more."""
    (film,) = fitted(campaign(None, 93, loops=(), deployments=({},))).problem.films
    speed = np.linspace(0.1, 1.2, 12)
    force = np.stack([-0.2 * speed**2, np.zeros(12), np.zeros(12)], axis=1)
    text = described(MissingForce(ForceAlongSpeed, speed, force, np.full((12, 3), 2e-3), None, {}, 0.1), film)  # type: ignore[arg-type]
    assert text is not None
    assert "-0.2" in text
    assert "v |v|" in text
    assert "not a cause" in text


def test_places_that_were_not_estimated_are_no_part_of_a_formula(campaign, fitted):
    """A table with holes is described by the rest; a push at a few places is no curve, and gets no formula."""
    (film,) = fitted(campaign(None, 96, loops=(), deployments=({},))).problem.films
    speed = np.linspace(0.1, 1.2, 12)
    force = np.stack([-0.2 * speed**2, np.zeros(12), np.zeros(12)], axis=1)
    sigma = np.full((12, 3), 2e-3)
    sigma[3] = np.nan
    text = described(MissingForce(ForceAlongSpeed, speed, force, sigma, None, {}, 0.1), film)  # type: ignore[arg-type]
    assert text is not None
    assert "-0.2" in text
    sigma[2:10] = np.nan
    assert described(MissingForce(ForceAlongSpeed, speed, force, sigma, None, {}, 0.1), film) is None  # type: ignore[arg-type]


def test_a_force_within_its_band_is_not_described(campaign, fitted):
    (film,) = fitted(campaign(None, 94, loops=(), deployments=({},))).problem.films
    speed = np.linspace(0.1, 1.2, 12)
    force = np.stack([-0.2 * speed**2, np.zeros(12), np.zeros(12)], axis=1)
    missing = MissingForce(ForceAlongSpeed, speed, force, np.full((12, 3), 1.0), None, {}, 0.1)  # type: ignore[arg-type]
    assert described(missing, film) is None
    assert "No missing force" in missing.sentence
