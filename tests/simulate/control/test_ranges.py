"""What is tried on a controller, by which scales, and the forces of laws at places that are known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from simulate.control.certificate import described, margins
from simulate.control.eddy_damper import EddyDamper
from simulate.control.gain_search import Scales, Search, ranges_of, scales_of, shortfall
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.control.task import LIMIT, Requirement
from simulate.control.uncertainty import Uncertainty, with_stops
from simulate.model import responses
from simulate.model.rig import per_leg


def answers_of(turned_deg, energy: Any = 0.0):
    rows = np.zeros((len(turned_deg), responses.COUNT))
    rows[:, responses.THETA_Z] = np.radians(turned_deg)
    rows[:, responses.DIVERGED] = np.nan
    rows[:, responses.CONTROL_ENERGY] = energy
    return rows


def forces(law, t, u, v, constants=()):
    out = np.zeros(6)
    law.command(t, u, v, None, None, np.concatenate([[getattr(law, name) for name in law.gains()], constants]), out)
    return out


def test_a_leg_on_its_way_is_not_pushed_and_one_ahead_is_held_back():
    profile = Profile(duration_s=2.0, stiffness_N_per_m=10.0, damping_N_s_per_m=3.0, force_limit_N=9.0)
    strokes = np.linspace(0.3, 0.4, 6)
    x = 0.3
    share, rate = 10 * x**3 - 15 * x**4 + 6 * x**5, (30 * x**2 - 60 * x**3 + 30 * x**4) / 2.0
    u, v = strokes * share, strokes * rate
    assert forces(profile, 0.6, u, v, strokes) == pytest.approx(np.zeros(6), abs=1e-12)
    assert forces(profile, 0.6, u + 0.1, v, strokes) == pytest.approx(np.full(6, -1.0))
    assert forces(profile, 0.6, u, v + 0.1, strokes) == pytest.approx(np.full(6, -0.3))
    assert forces(profile, 5.0, strokes, np.zeros(6), strokes) == pytest.approx(np.zeros(6), abs=1e-12)


def test_a_clutch_holds_against_coiling_only_and_an_eddy_damper_is_strongest_at_its_critical_speed():
    v = np.array([-1.0, -0.01, 0.0, 0.01, 1.0, 2.0])
    clutch = forces(OneWay(clutch_force_N=2.0, clutch_speed_m_per_s=0.01), 0.0, v, v)
    assert clutch == pytest.approx([2.0, 2.0 * np.tanh(1.0), 0.0, 0.0, 0.0, 0.0])
    damper = forces(EddyDamper(damping_N_s_per_m=3.0, critical_speed_m_per_s=1.0), 0.0, v, v)
    assert damper == pytest.approx([1.5, 0.03 / 1.0001, 0.0, -0.03 / 1.0001, -1.5, -6.0 / 5.0])


def test_ranges_of_gains_follow_gap_force_stroke_and_time_of_the_rig():
    found = ranges_of(Synchronise, Scales(0.5, 3.0, 0.4, 0.8, 1.0), {"sample_rate_Hz": 1000.0})
    assert found["stiffness_N_per_m"] == pytest.approx((25.0, 6250.0))
    assert found["damping_N_s_per_m"] == pytest.approx((0.1, 60.0))
    assert found["observer_Hz"] == pytest.approx((2.5, 200.0))
    assert "observer_Hz" not in ranges_of(Synchronise, Scales(0.5, 3.0, 0.4, 0.8, 1.0), {})
    duration = ranges_of(Profile, Scales(0.5, 3.0, 0.4, 0.8, 1.0), {})["duration_s"]
    assert duration == pytest.approx((0.8, 1.0))
    assert ranges_of(Profile, Scales(0.5, 3.0, 0.4, 0.8, 0.5), {})["duration_s"] == pytest.approx((0.8, 0.88))


def test_two_legs_may_differ_by_twice_the_disparity(prototype):
    scales = scales_of(prototype, 0.1, 0.3)
    assert scales.gap_N == pytest.approx(0.2 * 2.79)
    assert (scales.force_N, scales.rise_s, scales.duration_s) == (pytest.approx(2.79), 0.3, prototype.simulation.duration_s)


def test_a_requirement_falls_short_by_its_quantile_over_its_angle_and_the_worst_counts():
    answers = answers_of(np.arange(1.0, 101.0))
    assert shortfall(answers, [Requirement(30.0, 0.9)]) == pytest.approx(91.0 / 30.0)
    assert shortfall(answers, [Requirement(200.0, 0.9), Requirement(50.0, 0.5)]) == pytest.approx(51.0 / 50.0)


class Bowl:
    """Rigs that turn by how far the logarithms of two gains are from a place, and more where the force limit is too small."""

    def answers(self, controller):
        off = np.log(controller.stiffness_N_per_m / 800.0) ** 2 + np.log(controller.damping_N_s_per_m / 8.0) ** 2
        weak = 0.0 if controller.force_limit_N >= 0.7 else 100.0
        return answers_of(np.full(4, 10.0 + 20.0 * off + weak), energy=controller.force_limit_N + off)


BOWL: Any = Bowl()


def test_a_search_finds_gains_that_keep_the_angle_at_the_least_force_that_does():
    ranges = {"stiffness_N_per_m": (50.0, 5000.0), "damping_N_s_per_m": (1.0, 100.0)}
    search = Search(Synchronise, {}, ranges, BOWL, [Requirement(20.0, 0.9)])
    found = search.least(4.0, 0)
    assert found is not None
    assert found.shortfall <= 1.0
    assert 0.7 <= getattr(found.controller, LIMIT) < 0.85
    assert len(search.tried) <= search.most_tries + 12
    assert search.nearest().shortfall == min(one.shortfall for one in search.tried)


def test_a_search_says_so_where_no_gains_are_good_enough_and_a_try_that_is_not_kept_leaves_no_trace():
    ranges = {"stiffness_N_per_m": (50.0, 5000.0), "damping_N_s_per_m": (1.0, 100.0)}
    search = Search(Synchronise, {}, ranges, BOWL, [Requirement(9.0, 0.9)])
    search.untold(1.0)
    assert search.tried == []
    assert search.least(4.0, 0) is None
    reserved = Search(Synchronise, {}, ranges, BOWL, [Requirement(20.0, 0.9)], reserve=2.5)
    assert reserved.least(4.0, 0) is None


class Outside(Bowl):
    """Best where both gains are beyond their ranges, one above and one below."""

    def answers(self, controller):
        return answers_of(np.full(4, 1e4 * controller.damping_N_s_per_m / controller.stiffness_N_per_m), energy=1.0)


def test_a_search_stays_within_its_ranges_and_reaches_their_ends():
    ranges = {"stiffness_N_per_m": (50.0, 5000.0), "damping_N_s_per_m": (1.0, 100.0)}
    outside: Any = Outside()
    search = Search(Synchronise, {}, ranges, outside, [Requirement(20.0, 0.9)])
    best = search.best(2.0, 0, fine=60)
    for name, (low, high) in ranges.items():
        tried = [getattr(one.controller, name) for one in search.tried]
        assert low <= min(tried) <= max(tried) <= high
    assert (best.controller.stiffness_N_per_m, best.controller.damping_N_s_per_m) == (5000.0, 1.0)  # type: ignore[attr-defined]


def test_margins_are_looked_at_for_what_a_controller_has():
    sampled = Synchronise(
        stiffness_N_per_m=800.0, damping_N_s_per_m=8.0, force_limit_N=1.0, sample_rate_Hz=1000.0, delay_s=0.002, sensor_noise_m=1e-4
    )
    seen: list[Any] = []

    def answers(controller):
        seen.append(controller)
        return answers_of([0.0, 31.0])

    trials: Any = SimpleNamespace(answers=answers)
    rows = margins(sampled, trials, [Requirement(30.0, 0.9)])
    changes = [row["change"] for row in rows]
    assert changes[:4] == ["gains times 0.5", "gains times 2", "gains times 4", "force_limit_N times 0.8"]
    assert [name for name in changes if "delay" in name] == ["delay_s times 2", "delay_s times 4", "delay_s times 8"]
    assert not any("lag" in name for name in changes)
    assert changes[-3:] == ["one sensor fails", "one brake stuck", "one brake dead"]
    assert {one.failed_sensor for one in seen} == set(range(7))
    assert [one.failed_brake for one in seen[-6:]] == [1, 2, 3, 4, 5, 6]
    assert [one.stuck_force_N for one in seen[-12:]] == 6 * [1.0] + 6 * [sampled.stuck_force_N]
    assert seen[0].stiffness_N_per_m == 400.0
    assert rows[0]["failed"] == [{"angle_deg": 30.0, "failed_percent": 50.0}]
    assert rows[-1]["draws"] == 12


def test_what_happened_in_trials_is_told_by_its_extremes():
    answers = answers_of([1.0, -5.0, 3.0, 2.0], energy=[0.1, 0.4, 0.2, 0.3])
    answers[:, responses.CONTROL_FORCE] = [0.1, 0.2, 0.9, 0.4]
    answers[3, responses.FULL_HEIGHT] = np.nan
    said = described(answers)
    assert said["theta_z_deg"]["100 %"] == pytest.approx(5.0)
    assert said["theta_z_deg"]["50 %"] == pytest.approx(3.0)
    assert said["control_force_N"] == 0.9
    assert said["control_energy_J"] == [pytest.approx(0.1), pytest.approx(0.4)]
    assert (said["full_height_percent"], said["diverged"], said["draws"]) == (75.0, 0, 4)


def test_corners_are_all_signs_of_the_stored_forces_and_two_standard_deviations_of_the_release(prototype):
    rigs = list(Uncertainty(0.1, 1e-3, 2e-3, 0.0).corners(prototype, 1))
    shares = np.array([per_leg(rig.actuator.b_l_N) for rig in rigs]) / 2.79 - 1.0
    assert len({tuple(np.sign(row)) for row in shares}) == 64
    assert np.abs(shares) == pytest.approx(np.full((64, 6), 0.1))
    assert np.abs([rig.release.position_m for rig in rigs]) == pytest.approx(np.full((64, 3), 2e-3))
    assert np.abs([rig.release.theta_rad for rig in rigs]) == pytest.approx(np.full((64, 3), 4e-3))
    assert with_stops(prototype, 2.0).end_stop.stiffness_N_per_m == 2.0 * prototype.end_stop.stiffness_N_per_m
    assert with_stops(prototype, 2.0).end_stop.damping_N_s_per_m == 2.0 * prototype.end_stop.damping_N_s_per_m
