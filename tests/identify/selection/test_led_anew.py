"""A fit that stays where a base had bent to what was missing is led anew from the model file, where what it leaves is unusual for noise."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.criteria import SAME, TO_COMPARE
from identify.estimation.covariance import Factored
from identify.estimation.horizons import horizons
from identify.selection import courses, weighing
from identify.selection import stand as stand_module
from identify.selection.evidence import Both, Evidence
from identify.selection.stand import Weighed
from identify.selection.weighing import led_anew, weighed


@pytest.fixture
def right(campaign, fitted):
    """A right model with one film, weighed."""
    return weighed(fitted(campaign(None, 95, loops=(), deployments=({},), hold_out=False)))


def astray(right):
    """The same, where a law that has bent leaves the film unmet behind its stop."""
    within = right.within
    q = within.fit.q.copy()
    q[: within.fit.problem.first_nuisance] += 0.3
    there = within.at(within.fit.problem, q, within.sizes)
    return Weighed(there, there, Both(there.weighed(), there.weighed()))


@pytest.mark.slow
def test_a_bent_fit_is_led_to_the_likelier_place(right):
    lost = astray(right)
    found = led_anew(lost)
    assert found is not None
    assert found.log_z == pytest.approx(right.log_z, abs=4.0)  # its place depends on the last digits of a processor
    assert found.log_z > lost.log_z + 50.0
    assert found.fit.rms < 1.2


@pytest.mark.parametrize(("slow_p", "prior_p"), [(0.5, 0.5), (1e-6, 0.5), (0.5, 1e-6)])
def test_a_fit_is_led_nowhere_where_nothing_slow_is_left_or_nothing_is_unusual(right, monkeypatch, slow_p, prior_p):
    monkeypatch.setattr(courses, "_leg", None)
    monkeypatch.setattr(weighing, "gap_test", lambda fit: SimpleNamespace(p_value=slow_p))
    monkeypatch.setattr(Evidence, "prior_p", prior_p)
    assert led_anew(right) is None


@pytest.mark.parametrize(("leaves_noise", "prior_p", "is_unusual"), [(True, 0.5, False), (True, 0.01, True), (False, 0.5, True)])
def test_what_leaves_more_than_noise_or_stands_at_an_improbable_place_is_unusual(right, monkeypatch, leaves_noise, prior_p, is_unusual):
    monkeypatch.setattr(stand_module, "leaves_noise", lambda fit, noise: leaves_noise)
    monkeypatch.setattr(Evidence, "prior_p", prior_p)
    assert replace(right).is_unusual == is_unusual


def test_films_that_reach_no_stop_are_led_nowhere(right, monkeypatch):
    monkeypatch.setattr(weighing, "led_beside", None)
    lost = astray(right)
    early = replace(lost.within, given=lost.within.given.until(0.9 * horizons(lost.within.given)[0]))
    assert led_anew(replace(lost, exact=early, within=early)) is None


def test_films_that_are_missed_before_their_first_stop_are_led_no_farther(right, monkeypatch):
    legs = []

    def missed(stand, q, sizes, horizon):
        legs.append(horizon)
        there = stand.at(stand.fit.problem, q, sizes)
        fit = replace(there.fit, gaps=there.fit.gaps + 20.0 * np.sin(np.arange(len(there.fit.gaps)) / 20.0))
        return replace(there, fit=fit), there.weighed()

    monkeypatch.setattr(courses, "_leg", missed)
    lost = astray(right)
    assert led_anew(lost) is None
    assert legs == horizons(lost.within.given)[:1]


@pytest.mark.slow
def test_films_that_are_missed_early_but_by_less_than_now_are_led_on(right, monkeypatch):
    """Loud noise or outliers may make what is left before the first stop look like a gap; the place is better all the same."""
    monkeypatch.setattr(courses, "leaves_noise", lambda fit, noise: False)
    lost = astray(right)
    found = led_anew(lost)
    assert found is not None
    assert found.log_z > lost.log_z + 50.0


@pytest.mark.slow
def test_what_falls_far_behind_another_or_comes_to_where_it_has_been_is_led_no_farther(right):
    stand = right.within
    taken: list[courses.Course] = []
    assert courses.led_beside(stand, stand.fit.q, stand.sizes, taken) is not None
    (course,) = taken
    assert len(course) == len(horizons(stand.given)) == 3
    better = replace(course[0], log_z=1e9)
    deviation = np.sqrt(np.diag(course[-1].information.inverse))
    elsewhere = [replace(leg, place=leg.place + 4.0 * deviation) for leg in course]
    joined = [*elsewhere[:2], course[2]]
    for others, legs, follows in (
        ([[better, *course[1:]]], 1, True),
        ([course], 1, True),
        ([elsewhere], 3, False),
        ([joined], 3, True),
        ([elsewhere, joined], 3, True),
        ([], 3, False),
    ):
        found = courses.led_beside(stand, stand.fit.q, stand.sizes, others)
        assert len(others[-1]) == legs
        assert (found is None) == follows


@pytest.mark.parametrize(
    ("log_z", "misses", "follows"),
    [(-101.0, False, False), (-151.0, False, True), (-101.0, True, True), (-99.0, True, False), (-100.0, True, False)],
)
def test_where_films_are_missed_already_only_a_likelier_place_is_led_on(log_z, misses, follows):
    """Elsewhere one that is somewhat behind may turn out to be ahead in longer films."""
    known = Factored.of(np.eye(2))
    other = courses.Leg(-100.0, np.zeros(2), known, misses, 1.0)
    assert courses.Leg(log_z, np.array([11.0, 0.0]), known, misses, 1.0).only_follows(other, known) == follows


@pytest.mark.parametrize(("apart", "follows"), [((1.5, 1.5), True), ((1.5, -1.5), False), ((9.0, 9.0), True), ((12.0, 12.0), False)])
def test_places_within_every_standard_error_are_apart_where_longer_films_tell_them_apart(apart, follows):
    """Two places of a film of the elevation alone: each number was within two standard errors, both together 7000 less likely."""
    known = Factored.of(np.linalg.inv([[1.0, 0.99], [0.99, 1.0]]))
    here, other = (courses.Leg(-100.0, np.array(place), known, False, 1.0) for place in (apart, (0.0, 0.0)))
    assert here.only_follows(other, known) == follows


@pytest.mark.parametrize(("gains", "most", "taken"), [(18, None, 18), (18, 10, 10), (40, None, 25), (0, None, 0)])
def test_a_place_is_settled_while_steps_gain_and_compared_after_ten(monkeypatch, gains, most, taken):
    def place(step):
        def weighed_there(noise, same=SAME):
            return SimpleNamespace(noise=noise, step=step, same=same)

        return SimpleNamespace(step=step, is_fresh=True, weighed=weighed_there, borne_out=lambda found: found)

    def step_on(stand, found, gain, length, surely):
        assert length == (stand.step or np.inf)  # the next step begins with the length that this one leaves
        return place(stand.step + 1) if stand.step < gains else None, stand.step + 1

    monkeypatch.setattr(courses, "_a_step_on", step_on)
    begun = SimpleNamespace(noise=(), step=0)
    end: Any = courses.stepped(place(0), begun, **({} if most is None else {"most": most}))  # type: ignore[arg-type]
    stand, found = end
    assert (stand.step, found.step) == (taken, taken)
    assert found.same == SAME  # however rough an evidence may be on the way
    assert TO_COMPARE == 10


@pytest.mark.parametrize(
    ("is_fresh", "promised", "brings", "surely", "after", "to_come"),
    [
        (False, 10.0, 5.0, False, "moved", 2.0),
        (False, 10.0, 0.0, False, "anew", 1.0),  # lines from the way promised what the simulation does not keep
        (False, 0.1, 5.0, True, "anew", np.inf),
        (False, 0.1, 5.0, False, None, np.inf),  # on the way from film to film no line is worked out only to be sure
        (True, 10.0, 0.0, True, None, np.inf),
    ],
)
def test_lines_from_the_way_that_promise_nothing_are_worked_out_anew_only_to_be_sure(
    monkeypatch, is_fresh, promised, brings, surely, after, to_come
):
    """The next step begins with so many lengths of the whole one."""
    stand: Any = SimpleNamespace(is_fresh=is_fresh, anew="anew", log_probability=lambda noise: -100.0, moved_to=lambda *there: "moved")
    monkeypatch.setattr(courses, "_way_within", lambda stand, found: np.ones(2))
    monkeypatch.setattr(courses, "tried", lambda stand, way, noise: (-100.0 + brings, "problem", "q", "sizes", "gaps"))
    monkeypatch.setattr(courses, "_bent", lambda stand, found, step, there, least, promised: there)
    found: Any = SimpleNamespace(information=Factored.of(promised * np.eye(2)), noise=())
    reached = courses._a_step_on(stand, found, 3.0, np.inf, surely)
    assert reached == (after, pytest.approx(to_come * np.sqrt(2.0 * promised)))


@pytest.mark.parametrize(
    ("length", "brings", "taken", "tries", "to_come"),
    [
        (np.inf, {0: 5.0}, 0, 1, 20.0),  # the whole step
        (np.inf, {3: 5.0}, 3, 4, 2.5),
        (5.0, {3: 5.0}, 3, 3, 2.5),  # it begins as the step before left it
        (5.0, {1: 5.0}, 1, 1, 10.0),
        (5.0, {0: 5.0}, None, 6, 5.0),
        (10 / 2**9, {6: 5.0}, 6, 1, 0.3125),  # what is shorter promises less than the gain
        (np.inf, {}, None, 7, np.inf),
    ],
)
def test_a_step_that_does_not_gain_is_shortened_until_it_does_and_the_next_begins_twice_as_long(
    monkeypatch, length, brings, taken, tries, to_come
):
    """A base 50 times the noise off tried every step whole first, then seven others: 2400 simulations for 450 steps."""
    asked: list[int] = []

    def tried(stand, way, noise):
        asked.append(round(-np.log2(float(way[0]))))
        return -100.0 + brings.get(asked[-1], 0.0), asked[-1]

    stand: Any = SimpleNamespace(is_fresh=True, log_probability=lambda noise: -100.0, moved_to=lambda *there: there[0])
    monkeypatch.setattr(courses, "_way_within", lambda stand, found: np.ones(1))
    monkeypatch.setattr(courses, "tried", tried)
    monkeypatch.setattr(courses, "_bent", lambda stand, found, step, there, least, promised: there)
    found: Any = SimpleNamespace(information=Factored.of(np.array([[100.0]])), noise=())
    after, to_try = courses._a_step_on(stand, found, 1.2, length, True)
    assert (after, to_try) == (taken, pytest.approx(to_come))
    assert len(asked) == tries


def on_a_bent_line(bend, errors):
    """A stand at the origin of two parameters x and y: gaps 100 (y - bend x^2) and x - 1; y may be an error of the model file."""

    def gaps(x, y):
        return np.array([100.0 * (y - bend * x * x), x - 1.0])

    slopes, of_errors = np.array([[0.0, 100.0], [1.0, 0.0]]), np.empty((2, 0))
    if errors:
        slopes, of_errors = slopes[:, :1], slopes[:, 1:]
    fit = SimpleNamespace(gaps=gaps(0.0, 0.0), jacobian=slopes, q=np.zeros(slopes.shape[1]))
    given, none = SimpleNamespace(measured=2), np.zeros(of_errors.shape[1])
    stand: Any = SimpleNamespace(fit=fit, given=given, errors=SimpleNamespace(columns=of_errors), sizes=none)
    places = []

    def tried(stand, way, noise) -> Any:
        places.append(way)
        there = gaps(*way)
        return -0.5 * float(there @ there), None, way[: slopes.shape[1]], way[slopes.shape[1] :], there

    found: Any = SimpleNamespace(noise=(), answer_to=lambda change: np.array([-change[1], -change[0] / 100.0]))
    return stand, found, tried, places


@pytest.mark.parametrize("errors", [False, True])
def test_a_step_off_a_bent_line_is_bent_back_to_it(monkeypatch, errors):
    """Straight on, half of the step is 12.5 times the noise off the line, and any step that gains is a tenth as long."""
    stand, found, tried, places = on_a_bent_line(0.5, errors)
    monkeypatch.setattr(courses, "tried", tried)
    step = np.array([0.5, 0.002])
    there = courses._bent(stand, found, step, tried(stand, step, ()), least=-0.4, promised=-0.145)
    assert there[0] == pytest.approx(-0.145)
    assert places[-1] == pytest.approx([0.5, 0.127])  # as far off as the lines have it
    assert len(places) == 2


@pytest.mark.parametrize(
    ("brings", "kept", "tries"),
    [
        ([-0.1], 0, 0),  # enough as it is
        ([-10.0, -8.0, -0.1], 0, 1),  # hardly nearer
        ([-10.0, -6.0, -0.1], 2, 2),
        ([-10.0, -6.0, -5.0, -0.1], 1, 2),
        ([-10.0, -6.0, -3.0, -1.5, -0.1], 3, 3),
    ],
)
def test_a_step_is_bent_again_only_while_it_misses_much_less_each_time(monkeypatch, brings, kept, tries):
    stand, found, _, _ = on_a_bent_line(0.5, False)
    answers = [(of, place, np.zeros(2), np.zeros(0), np.zeros(2)) for place, of in enumerate(brings)]
    asked = iter(answers[1:])
    monkeypatch.setattr(courses, "tried", lambda stand, way, noise: next(asked))
    there: Any = courses._bent(stand, found, np.zeros(2), answers[0], least=-0.5, promised=0.0)  # type: ignore[arg-type]
    assert there[1] == kept
    assert len(list(asked)) == len(brings) - 1 - tries


@pytest.mark.parametrize(("louder", "wave", "misses"), [(1.0, 0.0, False), (3.0, 0.0, False), (1.0, 20.0, True), (3.0, 20.0, True)])
def test_films_are_missed_by_more_than_their_noise_however_large_that_is_said_to_be(right, louder, wave, misses):
    fit = right.within.fit
    gaps = louder * fit.gaps + wave * np.sin(np.arange(len(fit.gaps)) / 20.0)
    there = replace(right.within, fit=replace(fit, gaps=gaps))
    assert there.misses == misses
    assert courses.Leg.of(there, there.weighed()).misses == misses


@pytest.mark.parametrize("is_exact", [False, True])
def test_with_films_up_to_the_first_stop_errors_of_the_model_file_start_from_where_whole_films_have_them(monkeypatch, is_exact):
    """They were led there already, so nothing is led again; where the model file is likelier as it is they start from nought."""
    problem: Any = SimpleNamespace(films=["a film"], loops=["a loop"])
    exact, within = (SimpleNamespace(fit=SimpleNamespace(q=q, problem=problem)) for q in ("q as it is", "q of errors"))
    within.errors_by_key = {("platform-mass", 0): 2.0}
    stand = SimpleNamespace(misses=True, fit=(exact if is_exact else within).fit)
    one: Any = SimpleNamespace(both=SimpleNamespace(is_exact=is_exact), within=within, exact=exact, stand=stand, fit=stand.fit)
    one.names, one.along_lines = (), -7.0
    monkeypatch.setattr(weighing, "before_the_stops", lambda given: "shorter films")
    monkeypatch.setattr(weighing, "weighed_within", lambda *given: SimpleNamespace(given=given, along_lines=-3.0))
    stands: Any = weighing.stands_of(one)
    (whole, _), (near, reached) = stands
    assert whole is one
    assert near.given == (
        ("shorter films", "q as it is", {}) if is_exact else ("shorter films", "q of errors", {("platform-mass", 0): 2.0})
    )
    assert reached == -3.0


@pytest.mark.slow
def test_a_law_that_stays_bent_while_only_noise_is_left_is_begun_anew_where_no_loops_hold_it(right, monkeypatch):
    """Between both is a ridge: straight lines from the bent law lead back to it."""
    monkeypatch.setattr(weighing, "is_bent", lambda fit: True)
    monkeypatch.setattr(weighing, "gap_test", lambda fit: SimpleNamespace(p_value=0.5))
    lost = astray(right)
    found = led_anew(lost)
    assert found is not None
    assert found.log_z == pytest.approx(right.log_z, abs=4.0)
    assert led_anew(right) is None
    monkeypatch.setattr(weighing, "is_bent", lambda fit: False)
    assert led_anew(lost) is None
