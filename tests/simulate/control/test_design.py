"""The design of a controller: exact bounds, what is drawn, ranges that follow the rig, and a design that keeps what it promises."""

from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.control.certificate import counted, draws_for, upper_bound
from simulate.control.design import design_control
from simulate.control.eddy_damper import EddyDamper
from simulate.control.gain_search import Search, ranges_of, scales_of, shortfall
from simulate.control.synchronise import Synchronise
from simulate.control.task import Requirement, Task
from simulate.control.trials import Trials
from simulate.control.uncertainty import STOPS, Uncertainty, with_stops
from simulate.model import responses
from simulate.model.rig import Simulation, geometry_of, per_leg

SPREAD = Uncertainty(0.1, 1e-3, 2e-3, 3e-4)
GAINS: dict[str, Any] = {"stiffness_N_per_m": 1000.0, "damping_N_s_per_m": 20.0, "force_limit_N": 1.0}
SENSED: dict[str, Any] = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4}


def answers_of(turned_deg):
    rows = np.zeros((len(turned_deg), responses.COUNT))
    rows[:, responses.THETA_Z] = np.radians(turned_deg)
    rows[:, responses.DIVERGED] = np.nan
    return rows


@pytest.mark.parametrize("n", [100, 2995, 4096])
def test_no_failure_bounds_the_probability_by_the_root_of_the_doubt(n):
    # P(no failure) = (1 - p)^n = 1 - confidence at the bound
    assert upper_bound(0, n, 0.95) == pytest.approx(1.0 - 0.05 ** (1.0 / n), rel=1e-9)
    assert upper_bound(n, n, 0.95) == 1.0


def test_the_bound_covers_as_often_as_it_says():
    # at a true probability p the bound lies below p in at most 5 % of all samples: summed over the binomial distribution, exactly
    from scipy.stats import binom

    for n, p in ((50, 0.1), (200, 0.01), (1000, 0.004)):
        k = np.arange(n + 1)
        missed = [upper_bound(int(i), n, 0.95) < p for i in k]
        assert np.sum(binom.pmf(k, n, p)[missed]) <= 0.05


def test_zero_failures_in_4096_certify_a_thousandth_and_nothing_finer():
    wanted = [Requirement(30.0, 0.999), Requirement(30.0, 0.9999)]
    none = counted(answers_of(np.zeros(4096)), wanted, 0.95)
    assert [row["certified"] for row in none] == [True, False]
    one = np.zeros(4096)
    one[7] = 31.0
    assert not counted(answers_of(one), wanted[:1], 0.95)[0]["certified"]
    assert draws_for(wanted, 0.95) > 29956


def test_a_run_that_diverged_has_failed():
    answers = answers_of(np.zeros(10))
    answers[3, : responses.DIVERGED] = np.nan
    assert counted(answers, [Requirement(30.0, 0.9)], 0.95)[0]["failures"] == 1
    assert shortfall(answers, [Requirement(30.0, 0.999)]) > 1.0


def test_a_platform_that_is_held_back_for_good_has_failed():
    answers = answers_of(np.zeros(10))
    answers[0, responses.FULL_HEIGHT] = np.nan
    assert counted(answers, [Requirement(30.0, 0.9)], 0.95)[0]["failures"] == 1
    assert shortfall(answers, [Requirement(30.0, 0.999)]) > 1.0


def test_a_rig_that_does_not_deploy_by_itself_is_refused(prototype):
    brief = replace(prototype, simulation=Simulation(duration_s=0.3))
    with pytest.raises(InputError, match="full height"):
        design_control(Task(brief, "synchronise", SENSED, 1.5, (Requirement(30.0, 0.999),), SPREAD))


def test_what_is_drawn_has_the_stated_spread(prototype):
    rigs = list(SPREAD.drawn(prototype, 400, 1))
    forces = np.array([per_leg(rig.actuator.b_l_N) for rig in rigs]) / 2.79 - 1.0
    assert np.max(np.abs(forces)) <= 0.1
    assert np.std(forces) == pytest.approx(0.1 / np.sqrt(3.0), rel=0.05)
    assert np.std([rig.release.theta_rad for rig in rigs]) == pytest.approx(2e-3, rel=0.1)
    joints = np.array([geometry_of(rig).base_joints_m for rig in rigs]) - np.array(geometry_of(prototype).base_joints_m)
    assert np.std(joints) == pytest.approx(3e-4, rel=0.05)
    assert next(SPREAD.drawn(prototype, 1, 1)) == rigs[0]
    assert next(SPREAD.drawn(prototype, 1, 2)) != rigs[0]


def test_the_corners_are_all_combinations_of_the_forces(prototype):
    rigs = list(SPREAD.corners(prototype, 0))
    signs = {tuple(np.sign(per_leg(rig.actuator.b_l_N) - 2.79)) for rig in rigs}
    assert len(rigs) == len(signs) == 64


def test_stops_are_made_softer_and_harder_together(prototype):
    soft, hard = (with_stops(prototype, STOPS[name]).end_stop for name in ("halved", "doubled"))
    assert hard.stiffness_N_per_m == 4 * soft.stiffness_N_per_m
    assert hard.damping_N_s_per_m == 4 * soft.damping_N_s_per_m


def test_ranges_of_gains_follow_the_rig_and_not_one_rig(prototype):
    here = ranges_of(Synchronise, scales_of(prototype, 0.1, 0.5), SENSED)
    law = prototype.actuator
    ten = replace(prototype, actuator=replace(law, b_l_N=27.9, b_u_N=28.9, initial_force_N=29.87))
    there = ranges_of(Synchronise, scales_of(ten, 0.1, 0.5), SENSED)
    assert there["stiffness_N_per_m"] == pytest.approx([10.0 * end for end in here["stiffness_N_per_m"]])
    assert "stiffness_N_per_m" not in ranges_of(Synchronise, scales_of(ten, 0.1, 0.5), {"stiffness_N_per_m": 1.0})
    assert list(ranges_of(EddyDamper, scales_of(ten, 0.1, 0.5), {})) == ["damping_N_s_per_m"]


def test_trials_answer_like_a_sweep_whatever_the_controller(prototype):
    rigs = list(islice(SPREAD.corners(prototype, 0), 3))
    trials = Trials.of(prototype, rigs)
    controller = Synchronise(**GAINS, **SENSED, observer_Hz=40.0)
    alone = [Trials.of(prototype, [rig]).answers(controller.reseeded(k))[0] for k, rig in enumerate(rigs)]
    assert np.array_equal(trials.answers(controller), np.array(alone), equal_nan=True)
    assert not np.array_equal(trials.answers(None), trials.answers(controller), equal_nan=True)


def test_the_search_finds_less_force_than_it_may_use(prototype):
    rigs = list(SPREAD.corners(prototype, 0))[21:43:3]  # among them the legs that alternate, which turn the platform farthest
    wanted = [Requirement(30.0, 0.999)]
    ranges = ranges_of(Synchronise, scales_of(prototype, 0.1, 0.5), {})
    search = Search(Synchronise, {}, ranges, Trials.of(prototype, rigs), wanted)
    search.best(3.0, 0, points=8, fine=4)
    assert search.nearest().shortfall <= 1.0
    least = search._least_force(3.0)
    assert 0.2 < least < 1.2  # the legs are up to 0.56 N apart, and let go askew


def test_an_unknown_law_and_too_many_draws_are_refused(prototype):
    task = Task(prototype, "no-law", {}, 1.5, (Requirement(30.0, 0.999),), SPREAD)
    with pytest.raises(InputError, match="no law is named"):
        design_control(task)
    with pytest.raises(InputError, match="at most 200000"):
        design_control(replace(task, law="synchronise", requirements=(Requirement(30.0, 0.99999),)))


@pytest.mark.calibrate
def test_with_noise_delay_and_lag_brakes_of_one_and_a_half_newton_are_found_and_certified(prototype):
    wanted = (Requirement(30.0, 0.999), Requirement(10.0, 0.95))
    design = design_control(Task(prototype, "synchronise", SENSED, 1.5, wanted, SPREAD))
    assert design.certified
    assert design.nearest.flat()[15] <= 1.5
    assert {row["stops"] for row in design.report["certificate"]} == set(STOPS)
    assert min(row["draws"] for row in design.report["certificate"]) >= 4096
    before = design.report["without_control"][1]["kept"][0]
    assert before["failed_percent"] > 20.0
    dampers = next(row for row in design.report["other_laws"] if row["law"] == "eddy-damper")
    assert dampers["kept"][0]["failed_percent"] > 1.0
