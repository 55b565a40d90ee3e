"""The force that no effect explains: where it acts, what it goes with, and in what words."""

from __future__ import annotations

import numpy as np
import pytest
from board.outside import Gust, Snag

from identify.gap.platform_force import KNOTS, ForceAlongHeight, ForceAlongSpeed, ForceAlongTime, MissingForce, seen_places
from identify.selection.unknown_force import simulated, unnamed_forces
from identify.selection.weighing import weighed
from simulate.effects import GravityImbalance

HEIGHTS = ({}, {"geometry.stowed_height_m": 0.35}, {"geometry.stowed_height_m": 0.45}, {})


def on_platform(fit):
    """The tables of forces on the platform, the likeliest first."""
    return [one for one in unnamed_forces(weighed(fit)) if one.in_legs is None]


def along_time(fit):
    """The force along time, by full simulation."""
    table = next(one for one in on_platform(fit) if isinstance(one.table, ForceAlongTime))
    found = simulated(table, fit).on_platform({"height": 1.0, "speed": 0.5})
    assert found is not None
    return found


@pytest.mark.slow
def test_a_force_that_comes_at_its_time_is_best_told_along_time(campaign, fitted):
    """Three start heights are at different heights and speeds when it comes."""
    found = on_platform(fitted(campaign(Gust(0.15), 91, deployments=HEIGHTS)))
    assert isinstance(found[0].table, ForceAlongTime)
    assert found[0].log_z > found[1].log_z + 3.0
    missing = along_time(fitted(campaign(Gust(0.15), 98, deployments=HEIGHTS)))
    assert "acts upwards on the platform" in missing.sentence
    strong = missing.force_N[:, 0] > 3.0 * missing.sigma_N[:, 0]
    assert missing.places[strong] == pytest.approx(0.20, abs=2.0 * missing.spacing)


@pytest.mark.slow
def test_one_run_cannot_tell_what_a_force_goes_with(campaign, fitted):
    """In one deployment time, height and speed run together."""
    assert "these runs cannot tell" in along_time(fitted(campaign(Gust(0.15), 95, deployments=({},)))).sentence


def test_a_force_along_time_shows_a_constant_force_for_what_it_is(campaign, fitted):
    """A steady weight shows as a steady force, within its band at nearly every instant."""
    found = along_time(fitted(campaign(GravityImbalance(0.02), 92, deployments=({}, {"geometry.stowed_height_m": 0.30}))))
    force, sigma = found.force_N[:, 0], found.sigma_N[:, 0]
    known = sigma < 0.1
    assert known.sum() > 4
    assert np.mean(np.abs(force[known] - 0.02) < 3.0 * sigma[known]) > 0.8


def test_without_rotations_no_moment_is_estimated_that_would_stand_against_the_lateral_force(campaign, fitted):
    runs = ({}, {"geometry.stowed_height_m": 0.30})
    fit = fitted(campaign(GravityImbalance(0.02), 97, deployments=runs, channels=("x_m", "z_m")))
    assert set(seen_places(fit.problem)) == set(range(2 * KNOTS))
    for one in on_platform(fit):
        assert one.places.max() < 2 * KNOTS


@pytest.mark.slow
def test_a_snag_between_two_heights_goes_with_the_height_and_acts_downwards(campaign, fitted):
    """Fast and slow passages of the same place: not the legs' elongation, not the speed, not the time."""
    found = on_platform(fitted(campaign(Snag(0.3), 99, deployments=HEIGHTS)))
    assert isinstance(found[0].table, ForceAlongHeight)
    text = found[0].on_platform({"speed": 9.0})
    assert text is not None
    assert "acts downwards on the platform between 0.4" in text.sentence


def test_a_force_within_its_band_is_not_put_into_words():
    speed = np.linspace(0.1, 1.2, 12)
    force = np.stack([-0.2 * speed**2, np.zeros(12), np.zeros(12)], axis=1)
    missing = MissingForce(ForceAlongSpeed, speed, force, np.full((12, 3), 1.0), {}, 0.1)
    assert "No missing force" in missing.sentence
