"""The course of a design: which draws certify it, how often it is tried, and what is compared, with trials that are made by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from simulate.control import design as of_design
from simulate.control.certificate import counted, draws_for, upper_bound
from simulate.control.design import RESERVE, TIGHTER, _confidence, _corners, _draws, _found, _fresh, _judged, _rival, _seconds, _step_error
from simulate.control.gain_search import Found, Scales
from simulate.control.synchronise import Synchronise
from simulate.control.task import Requirement, Task
from simulate.control.uncertainty import STOPS, Uncertainty
from simulate.model import responses

LAW = Synchronise(stiffness_N_per_m=800.0, damping_N_s_per_m=8.0, force_limit_N=1.0)
WANTED = (Requirement(30.0, 0.9),)


def answers_of(turned_deg, energy=0.0):
    rows = np.zeros((len(turned_deg), responses.COUNT))
    rows[:, responses.THETA_Z] = np.radians(turned_deg)
    rows[:, responses.DIVERGED], rows[:, responses.CONTROL_ENERGY] = np.nan, energy
    return rows


@pytest.fixture
def task(prototype):
    return Task(prototype, "synchronise", {}, 1.5, WANTED, Uncertainty(0.1, 1e-3, 2e-3, 3e-4), seed=4)


class Searched:
    """A search that finds the same gains each time; told by what reserve and seed."""

    def __init__(self, finds=10):
        self.finds, self.reserve, self.tried, self.asked = finds, RESERVE, [1], []

    def least(self, most_N, seed):
        self.asked.append((most_N, seed, self.reserve, len(self.tried)))
        self.tried.append(2)
        return Found(LAW, 0.8, 0.1) if len(self.asked) <= self.finds else None


def course(task, monkeypatch, certified, finds=10):
    """What `_found` gives where the certificates are these, one after the other; what was searched; the streams of the draws."""
    streams, search = [], Searched(finds)

    def certificate(task, controller, stream):
        streams.append(stream)
        return [{"kept": [{"certified": True}, {"certified": certified[stream]}]}]

    monkeypatch.setattr(of_design, "_certified", certificate)
    any_search: Any = search
    found, rows, tries = _found(task, any_search, lambda _: None)
    return found, rows, tries, search.asked, streams


def test_a_certificate_that_holds_ends_the_search(task, monkeypatch):
    found, rows, tries, asked, streams = course(task, monkeypatch, [True])
    assert found is not None
    assert rows[0]["kept"][1]["certified"]
    assert (tries, asked, streams) == (1, [(1.5, 4, RESERVE, 1)], [0])


def test_where_it_does_not_hold_the_angles_are_tightened_on_new_draws_at_most_three_times(task, monkeypatch):
    found, rows, tries, asked, streams = course(task, monkeypatch, [False, False, False])
    assert found is not None
    assert not rows[0]["kept"][1]["certified"]
    assert (tries, streams) == (3, [0, 1, 2])
    assert [seed for _, seed, _, _ in asked] == [4, 5, 6]
    assert [reserve for _, _, reserve, _ in asked] == pytest.approx([RESERVE, RESERVE * TIGHTER, RESERVE * TIGHTER**2])
    assert [tried for *_, tried in asked] == [1, 0, 0], "what was tried for wider angles is no candidate"
    assert course(task, monkeypatch, [False, True])[2] == 2


def test_where_no_gains_are_good_enough_the_last_ones_that_were_stay(task, monkeypatch):
    assert course(task, monkeypatch, [], finds=0)[:3] == (None, [], 0)
    found, rows, tries, *_ = course(task, monkeypatch, [False], finds=1)
    assert found is not None
    assert (len(rows), tries) == (1, 1)


def test_three_certificates_together_have_the_doubt_that_is_allowed(task):
    assert (1.0 - _confidence(task)) * 3 == pytest.approx(1.0 - task.confidence)
    assert _draws(task) == 4096
    strict = replace(task, requirements=(Requirement(30.0, 0.9999), Requirement(10.0, 0.9)))
    least = math.log(0.05 / 3) / math.log(0.9999)
    assert _draws(strict) == draws_for(strict.requirements, _confidence(strict)) == math.ceil(1.36 * least)
    assert _draws(replace(strict, draws=77)) == 77


@pytest.mark.parametrize("probability", [0.9999, 0.99999])
def test_draws_are_a_third_more_than_certify_without_a_failure(probability):
    n = draws_for((Requirement(30.0, probability), Requirement(5.0, 0.9)), 0.99)
    assert upper_bound(0, round(n / 1.36), 0.99) == pytest.approx(1.0 - probability, rel=1e-4)


def test_the_corners_have_each_kind_of_stops_as_often_and_differ_from_release_to_release(task):
    corners = _corners(task)
    factors = np.array([rig.end_stop.stiffness_N_per_m / task.model.end_stop.stiffness_N_per_m for rig in corners])
    assert len(corners) == 64
    assert sorted(np.unique(factors, return_counts=True)[1]) == [21, 21, 22]
    assert set(factors) == set(STOPS.values())
    # the kinds go round, one farther after every three, so that none goes with one leg's sign alone
    assert factors[:9].tolist() == [0.5, 1.0, 2.0, 1.0, 2.0, 0.5, 2.0, 0.5, 1.0]
    by_release = list(task.uncertainty.corners(task.model, task.seed))
    assert [rig.release for rig in corners] == [rig.release for rig in by_release]


def test_draws_that_certify_are_others_than_those_of_every_other_stream(task):
    streams = [_fresh(task, 1.0, 3, stream).rows for stream in (0, 1, 10, 90)] + [_fresh(replace(task, seed=5), 1.0, 3, 0).rows]
    assert len({rows.tobytes() for rows in streams}) == 5
    assert np.array_equal(_fresh(task, 1.0, 3, 1).rows, streams[1])
    assert len(streams[0]) == 3
    soft = _fresh(task, 0.5, 2, 0).stiffest.end_stop
    assert soft.stiffness_N_per_m == 0.5 * task.model.end_stop.stiffness_N_per_m


def test_a_certificate_has_a_row_for_each_kind_of_stops_on_draws_of_its_own(task, monkeypatch):
    asked = []

    def fresh(task, factor, runs, stream):
        asked.append((factor, runs, stream))
        return SimpleNamespace(answers=lambda controller: answers_of(np.full(runs, 31.0 if factor == 2.0 else 1.0)))

    monkeypatch.setattr(of_design, "_fresh", fresh)
    rows = of_design._certified(replace(task, draws=300), LAW, 2)
    assert [(row["stops"], row["kept"][0]["failures"], row["kept"][0]["certified"]) for row in rows] == [
        ("halved", 0, True), ("as given", 0, True), ("doubled", 300, False),
    ]  # fmt: skip
    assert asked == [(0.5, 300, 20), (1.0, 300, 21), (2.0, 300, 22)]
    assert rows[0]["kept"][0]["upper_bound_percent"] == pytest.approx(100.0 * (1.0 - (0.05 / 3) ** (1.0 / 300.0)))


def test_failures_before_the_first_stop_are_counted_by_themselves_and_what_is_not_below_the_angle_has_failed():
    answers = answers_of([29.9, 30.1, -31.0, 5.0, 5.0])
    answers[:, responses.BEFORE_STOP] = np.radians([1.0, 1.0, -30.5, 2.0, 2.0])
    answers[4, responses.FULL_HEIGHT] = np.nan
    (row,) = counted(answers, WANTED, 0.95)
    assert (row["failures"], row["failures_before_stop"]) == (3, 1)
    assert (row["failed_percent"], row["failed_before_stop_percent"]) == (60.0, 20.0)


def test_the_time_that_is_foretold_is_that_of_one_try_times_all_runs(task, monkeypatch):
    monkeypatch.setattr(of_design, "timed", lambda work: 2.0)
    monkeypatch.setattr(of_design, "known_laws", lambda: dict.fromkeys("abc"))
    search: Any = SimpleNamespace(trials=SimpleNamespace(rows=np.zeros((64, 3))), most_tries=110)
    runs = 64 * 110 + 3 * (1000 + 512) + 20 * 128 + 2 * (64 * 24 + 512)
    assert _seconds(replace(task, draws=1000), search) == pytest.approx(2.0 / 64 * runs)


def test_the_error_of_the_step_is_what_half_of_it_changes_in_nineteen_of_twenty_draws():
    coarse, fine = np.linspace(10.0, 20.0, 101), np.linspace(10.0, 20.0, 101) + np.arange(101) / 1000.0

    def answers(controller, step_s=2e-3):
        return answers_of(coarse if step_s == 2e-3 else fine if step_s == 1e-3 else np.full(101, np.nan))

    trials: Any = SimpleNamespace(answers=answers, step_s=lambda controller: 2e-3)
    assert _step_error(LAW, trials) == pytest.approx(0.095)


class Seen:
    """Trials that remember how many draws they were."""

    def __init__(self, runs, turned=1.0):
        self.runs, self.turned, self.rows = runs, turned, np.zeros((64, 3))

    def first(self, runs):
        return Seen(runs, self.turned)

    def step_s(self, controller):
        return 1e-3

    def answers(self, controller, step_s=None):
        return answers_of(np.full(self.runs, self.turned if controller is not None else 40.0), energy=0.1)


SCALES = Scales(0.5, 3.0, 0.4, 0.8, 1.0)


def test_a_design_is_judged_beside_no_control_and_every_other_law(task, monkeypatch):
    asked, said = [], []

    def fresh(task, factor, runs, stream):
        asked.append((factor, runs, stream))
        return Seen(runs)

    monkeypatch.setattr(of_design, "_fresh", fresh)
    monkeypatch.setattr(of_design, "_rival", lambda task, name, scales, draws: {"law": name, "draws": draws.runs})
    search: Any = SimpleNamespace(tried=[1, 2], reserve=1.25, ranges={})
    report = _judged(task, Found(LAW, 0.8, 0.1), SCALES, search, said.append)
    assert asked == [(1.0, 512, 90), (0.5, 512, 91), (1.0, 512, 92), (2.0, 512, 93)]
    assert [row["stops"] for row in report["without_control"]] == list(STOPS)
    assert {row["kept"][0]["failed_percent"] for row in report["without_control"]} == {100.0}
    assert {row["draws"] for row in report["margins"]} == {128, 6 * 128}
    laws = {row["law"]: row["draws"] for row in report["other_laws"]}
    assert "synchronise" not in laws
    assert {"profile", "one-way", "eddy-damper", "mechanical-link"} <= set(laws)
    assert set(laws.values()) == {512}
    assert report["search"] == {"tried": 2, "shortfall_on_corners": 0.8, "reserve": 1.25, "ranges": {}}
    assert (report["step_error_deg"], said) == (0.0, ["margins", "without control", "other laws"])


def test_another_law_may_use_twice_the_stored_force_and_is_counted_with_the_whole_confidence(task, monkeypatch):
    monkeypatch.setattr(of_design.Trials, "of", lambda model, rigs: Seen(4, 10.0))
    given = replace(task, fixed={"sample_rate_Hz": 1000.0, "force_limit_N": 1.0})
    any_draws: Any = Seen(200, 10.0)
    rival = _rival(given, "profile", SCALES, any_draws)
    assert rival["law"] == "profile"
    assert rival["controller"]["sample_rate_Hz"] == 1000.0
    assert 0.5 <= rival["controller"]["force_limit_N"] <= 6.0
    assert rival["kept"][0]["upper_bound_percent"] == pytest.approx(100.0 * (1.0 - 0.05 ** (1.0 / 200.0)))
    passive = _rival(given, "eddy-damper", SCALES, any_draws)["controller"]
    assert "sample_rate_Hz" not in passive
