"""The force that no effect explains: where it acts, what it goes with, and in what words."""

from __future__ import annotations

import numpy as np
import pytest
from board.outside import Gust, Snag

from identify.gap.force_tables import seen_places
from identify.gap.platform_force import ALONGS, KNOTS, ForceAlongHeight, ForceAlongSpeed, ForceAlongTime, MissingForce
from identify.gap.unnamed import simulated
from identify.selection.unknown_force import unnamed_forces
from identify.selection.weighing import weighed
from measure.common.file_kinds import TABLE, kind_of
from measure.tables.csv_cells import write_columns
from simulate.effects import GravityImbalance

HEIGHTS = ({}, {"geometry.stowed_height_m": 0.35}, {"geometry.stowed_height_m": 0.45})
LOOPS = ((1.0, 0.04), (3.0, 0.04))


@pytest.fixture
def fit_of(campaign, fitted):
    """The fit of deployments in which something acts, none held out, and of two loops for the force law."""
    return lambda hidden, seed, deployments, **more: fitted(
        campaign(hidden, seed, loops=LOOPS, deployments=deployments, hold_out=False, **more)
    )


def on_platform(fit):
    """The tables of forces on the platform, the likeliest first."""
    return [one for one in unnamed_forces(weighed(fit)) if one.in_legs is None]


def along_time(fit, tables):
    """The force along time, by full simulation."""
    table = next(one for one in tables if isinstance(one.table, ForceAlongTime))
    found = simulated(table, fit).on_platform({"height": 1.0, "speed": 0.5})
    assert found is not None
    return found


@pytest.mark.slow
def test_a_force_that_comes_at_its_time_is_best_told_along_time(fit_of):
    """Three start heights are at different heights and speeds when it comes."""
    fit = fit_of(Gust(0.15), 91, HEIGHTS)
    found = on_platform(fit)
    assert isinstance(found[0].table, ForceAlongTime)
    assert found[0].log_z > found[1].log_z + 3.0
    missing = along_time(fit, found)
    assert "acts upwards on the platform" in missing.sentence
    strong = missing.force_N[:, 0] > 3.0 * missing.sigma_N[:, 0]
    assert missing.places[strong] == pytest.approx(0.20, abs=2.0 * missing.spacing)


@pytest.mark.slow
def test_one_run_cannot_tell_what_a_force_goes_with(fit_of):
    """In one deployment time, height and speed run together."""
    fit = fit_of(Gust(0.15), 95, ({},))
    assert "these runs cannot tell" in along_time(fit, on_platform(fit)).sentence


def test_a_force_along_time_shows_a_constant_force_for_what_it_is(fit_of):
    """A steady weight shows as a steady force, within its band at nearly every instant."""
    fit = fit_of(GravityImbalance(0.02), 92, ({},))
    found = along_time(fit, on_platform(fit))
    force, sigma = found.force_N[:, 0], found.sigma_N[:, 0]
    known = sigma < 0.1
    assert known.sum() > 4
    assert np.mean(np.abs(force[known] - 0.02) < 3.0 * sigma[known]) > 0.8


def test_without_rotations_no_moment_is_estimated_that_would_stand_against_the_lateral_force(fit_of):
    fit = fit_of(GravityImbalance(0.02), 97, ({},), channels=("x_m", "z_m"))
    assert set(seen_places(fit.problem)) == set(range(2 * KNOTS))
    for one in on_platform(fit):
        assert one.places.max() < 2 * KNOTS


@pytest.mark.slow
def test_a_snag_between_two_heights_goes_with_the_height_and_acts_downwards(fit_of):
    """Fast and slow passages of the same place: not the legs' elongation, not the speed, not the time."""
    found = on_platform(fit_of(Snag(0.3), 99, HEIGHTS))
    assert isinstance(found[0].table, ForceAlongHeight)
    text = found[0].on_platform({"speed": 9.0})
    assert text is not None
    assert "acts downwards on the platform between 0.4" in text.sentence


def test_a_force_within_its_band_is_not_put_into_words():
    speed = np.linspace(0.1, 1.2, 12)
    force = np.stack([-0.2 * speed**2, np.zeros(12), np.zeros(12)], axis=1)
    missing = MissingForce(ForceAlongSpeed, speed, force, np.full((12, 3), 1.0), {}, 0.1)
    assert "No missing force" in missing.sentence


@pytest.mark.parametrize("along", ALONGS, ids=lambda one: one.words)
def test_its_table_is_a_result_that_a_second_run_may_replace(tmp_path, along):
    places, force = np.linspace(0.2, 0.7, 9), np.full((9, 3), 0.1)
    write_columns(MissingForce(along, places, force, 0.1 * force, {}, 0.0625).columns, tmp_path / "missing_force.csv")
    assert kind_of(tmp_path / "missing_force.csv") == TABLE
