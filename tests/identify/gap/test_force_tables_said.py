"""Tables of a force without a name: what they do to platform and legs, and what is said of them."""

from __future__ import annotations

import re

import numpy as np
import pytest

from identify.gap.comparison import Curve
from identify.gap.leg_force import PLACES, ForceAlongElongation, ForceAlongLegSpeed, LegForce
from identify.gap.platform_force import ALONGS, KNOTS, ForceAlongHeight, ForceAlongSpeed, ForceAlongTime, MissingForce
from identify.gap.unnamed import Unnamed

POSE, TWIST = np.array([0.0, 0.0, 0.4, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 0.7, 0.0, 0.0, 0.0])
WHERE = {ForceAlongTime: 0.1, ForceAlongHeight: 0.4, ForceAlongSpeed: 0.7}


def wrench_of(table):
    """F_x, F_z and M_y at a time of 0.1 s, a height of 0.4 m, a speed of 0.7 m/s."""
    p = np.concatenate([table.flat(), table.constants_of(None)])
    wrench = np.ones(6)
    table.platform_wrench(0.1, POSE, TWIST, p, wrench)
    return wrench - 1.0


@pytest.mark.parametrize("along", ALONGS)
def test_a_table_is_read_at_its_own_abscissa_on_straight_lines_and_is_steady_beyond_its_ends(along):
    z, x, m = np.arange(KNOTS) ** 2.0, -(np.arange(KNOTS) ** 2.0) - 1.0, 3.0 * np.arange(KNOTS)
    at = WHERE[along]
    for place, expected in ((2.25, 5.25), (7.5, 56.5), (-3.0, 0.0), (40.0, 529.0)):
        table = along(tuple(z), tuple(x), tuple(m), first=at - 0.02 * place, spacing=0.02)
        fx, fy, fz, mx, my, mz = wrench_of(table)
        assert fz == pytest.approx(expected, abs=1e-4)
        assert fx == pytest.approx(-expected - 1.0, abs=1e-4)
        assert my == pytest.approx(3.0 * min(max(place, 0.0), 23.0), abs=1e-4)
        assert fy == mx == mz == 0.0


@pytest.mark.parametrize("along", [ForceAlongElongation, ForceAlongLegSpeed])
def test_a_table_of_a_leg_is_read_at_its_elongation_or_its_speed(along):
    at = {ForceAlongElongation: 0.2, ForceAlongLegSpeed: -0.6}[along]
    for place, expected in ((2.25, 5.25), (-3.0, 0.0), (40.0, 529.0)):
        table = along(tuple(np.arange(PLACES) ** 2.0), first=at - 0.02 * place, spacing=0.02)
        p = np.concatenate([table.flat(), table.constants_of(None)])
        assert table.leg_force(0.2, -0.6, 0.0, 0.0, 0.0, p) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("along", [*ALONGS, ForceAlongElongation, ForceAlongLegSpeed])
def test_a_table_reaches_from_one_end_to_the_other(along):
    places = along.over(0.2, 0.9).places
    assert places[[0, -1]] == pytest.approx([0.2, 0.9])
    assert np.diff(places) == pytest.approx(0.7 / 23.0)


def missing(force, sigma=0.01, along=ForceAlongHeight, leads=None):
    n = len(force)
    columns = np.zeros((n, 3))
    columns[:, 0] = force
    return MissingForce(along, 0.1 * np.arange(n), columns, np.full((n, 3), sigma), {} if leads is None else leads, 0.1)


def test_a_force_acts_where_it_stands_out_of_its_band_beside_its_largest_value():
    said = missing([0.0, 0.04, 0.09, 0.05, 0.0, 0.06, 0.0]).sentence
    assert "acts upwards on the platform between 0.10 and 0.30 m of height, 0.09 +- 0.01 N at its largest (0.20)" in said


def test_a_stretch_of_force_reaches_to_both_ends_of_its_table_and_ends_where_its_sign_turns():
    assert "between 0.00 and 0.20 m" in missing([0.05, 0.09, 0.05]).sentence
    assert "acts downwards on the platform between 0.10 and 0.20 m" in missing([0.05, -0.09, -0.05, 0.05]).sentence


def test_three_standard_deviations_are_the_band():
    assert "No missing force" in missing([0.0, 0.0299, 0.0]).sentence
    assert "acts upwards" in missing([0.0, 0.0301, 0.0]).sentence


def test_the_largest_value_is_one_that_stands_out_and_not_one_that_is_hardly_known():
    one = missing([0.5, 0.0, 0.09, 0.0])
    one.sigma_N[0] = 1.0
    assert "0.09 +- 0.01 N at its largest (0.20)" in one.sentence


def test_each_direction_is_told_in_its_own_words():
    one = missing([0.0, 0.0])
    one.force_N[1] = [0.0, -0.3, 0.2]
    assert re.search(r"to the left on the platform .* and turns the platform about \+y .*N m", one.sentence)
    one.force_N[1] = [0.0, 0.3, -0.2]
    assert re.search(r"to the right on the platform .* and turns the platform about -y .*N m", one.sentence)


def test_a_lead_of_three_says_what_a_force_goes_with_and_a_smaller_one_does_not():
    assert missing([1.0], leads={"time": 3.1, "speed": 9.0}).goes_with == "it goes with the height, whatever the time and the speed"
    assert missing([1.0], leads={"time": 2.9, "speed": 9.0}).goes_with == "whether it goes with height, time these runs cannot tell"
    assert missing([1.0]).goes_with == "estimated along height only"


def test_a_table_shows_from_its_first_to_its_last_estimated_place_only():
    places = np.array([3, 4, 6, KNOTS + 5])
    found = Unnamed(ForceAlongTime.over(0.0, 2.3), 0.0, places, np.arange(1.0, 5.0), 0.1 * np.arange(1.0, 5.0), 1.0, np.eye(4), np.zeros(4))
    shown = found.on_platform({})
    assert shown is not None
    assert shown.places == pytest.approx([0.3, 0.4, 0.5, 0.6])
    assert shown.force_N[:, 0] == pytest.approx([1.0, 2.0, 0.0, 3.0])
    assert shown.force_N[2, 1] == 4.0
    assert np.isnan(shown.sigma_N[2, 0])
    assert found.in_legs is None


def test_a_force_in_the_legs_is_said_at_its_extremes_among_the_places_that_are_known():
    force, sigma = np.zeros(PLACES), np.full(PLACES, 0.01)
    force[[2, 5, 9]], sigma[9] = (0.3, -0.4, 5.0), 0.5
    said = LegForce(ForceAlongElongation.over(0.0, 0.23), force, sigma).sentence
    assert "+0.3 N (sigma 0.01) at 20 mm and -0.4 N (sigma 0.01) at 50 mm" in said


def test_what_was_not_estimated_in_a_leg_is_not_known():
    table = ForceAlongElongation.over(0.0, 0.23)
    legs = Unnamed(table, 0.0, np.array([1, 2]), np.array([0.1, 0.2]), np.array([0.3, 0.4]), 1.0, np.eye(2), np.zeros(2)).in_legs
    assert legs is not None
    assert legs.sigma_N[:3] == pytest.approx([np.inf, 0.3, 0.4])
    assert legs.force_N[:3] == pytest.approx([0.0, 0.1, 0.2])


def test_numbers_of_a_comparison_are_those_that_can_be_worked_out_by_hand():
    measured = np.array([0.0, 1.0, 2.0, 3.0])
    curve = Curve("run", "z_m", np.arange(4.0), measured, measured - [0.3, 0.0, -0.4, 0.0], np.array([1.0, 2.0, 2.0, 9.0]))
    assert curve.gap == pytest.approx([0.3, 0.0, -0.4, 0.0])
    assert curve.numbers == pytest.approx(
        {
            "rmse": 0.25,
            "max_abs": 0.4,
            "nrmse_percent": 100.0 * 0.25 / 3.0,
            "fit_percent": 100.0 * (1.0 - 0.5 / np.sqrt(5.0)),
            "noise_sigma": 2.0,
        }
    )
