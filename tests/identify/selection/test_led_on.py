"""Behind the stops a small error grows: longer films are met by way of shorter ones, and a name is fitted from where the rig stands."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.selection import courses, weighing
from identify.selection.model_errors import FORCES
from identify.selection.promises import begun, posed, promises
from identify.selection.weighing import weighed_within
from simulate.effects import CATALOGUE

NAMES = ("hub-inertia", "platform-mass", "geometry-error", FORCES)


def legs_that_miss(monkeypatch, missing, far_off=()):
    """Let legs end at the place and time that they are asked for, those from a place in `missing` without meeting their films.

    far_off : place and time of legs that end far off their films.
    """
    asked = []

    def leg(stand, q, sizes, end):
        asked.append((q, end))
        fit = SimpleNamespace(q=end, met=q not in missing, rms=4.0 if (q, end) in far_off else 2.5)
        return SimpleNamespace(fit=fit, sizes=sizes), SimpleNamespace(noise=(), log_z=-len(missing) * (q in missing))

    monkeypatch.setattr(courses, "_leg", leg)
    monkeypatch.setattr(courses, "leaves_noise", lambda fit, noise: fit.met)
    return asked


@pytest.mark.parametrize(
    ("met", "missing", "far_off", "ways", "meets"),
    [
        (2.0, (), [], [(0.3, 0.6)], True),
        (None, (0.3,), [], [(0.3, 0.6)], False),
        (2.0, (0.3,), [(0.3, 0.6)], [(0.3, 0.6), (0.3, 0.45), (0.45, 0.6)], True),
        (2.0, (0.3,), [(0.3, 0.6), (0.3, 0.45)], [(0.3, 0.6), (0.3, 0.45)], False),
        (2.0, (0.3, 0.45), [], [(0.3, 0.6), (0.3, 0.45), (0.45, 0.6)], False),
    ],
)
def test_longer_films_that_are_missed_are_met_by_way_of_the_middle(monkeypatch, met, missing, far_off, ways, meets):
    """Only where the shorter ones were met, by no other course better, and the middle is not far off: else it is not the length."""
    asked = legs_that_miss(monkeypatch, missing, far_off)
    given: Any = (None, 0.3, np.zeros(0), met, 0.6, 0.45)
    there: Any = courses._led_on(*given)[0]
    assert asked == ways
    assert there.fit.met == meets


@pytest.mark.parametrize(
    ("left", "misses", "in_any_case", "ends"),
    [
        ({0.5: 1.0, 0.7: 1.4}, True, False, [0.5, 0.7, 0.9]),
        ({0.5: 1.0, 0.7: 1.6}, True, False, [0.5, 0.7]),
        ({0.5: 1.0, 0.7: 1.6}, False, False, [0.5, 0.7, 0.9]),
        ({0.5: 1.0, 0.7: 1.6}, True, True, [0.5, 0.7, 0.9]),
        ({0.5: 2.5, 0.7: 3.5}, True, False, [0.5, 0.7, 0.9]),  # the noise is larger than it is said to be
    ],
)
def test_a_course_far_off_films_that_are_not_whole_is_led_no_further_unless_there_is_no_other(monkeypatch, left, misses, in_any_case, ends):
    """A longer film cannot show it to be right: bases that a scale error kept from their films were led on from six sides."""
    asked = []

    def led_on(stand, q, sizes, met, end, middle) -> Any:
        asked.append(end)
        return SimpleNamespace(fit=SimpleNamespace(q=end), sizes=sizes), end

    def leg(end) -> Any:
        return SimpleNamespace(misses=misses, log_z=0.0, rms=left.get(end), information=None, only_follows=lambda other, information: False)

    monkeypatch.setattr(courses, "_led_on", led_on)
    monkeypatch.setattr(courses, "stretches", lambda given: [(0.5, 0.4), (0.7, 0.6), (0.9, 0.8)])
    monkeypatch.setattr(courses, "Leg", SimpleNamespace(of=lambda stand, found: leg(found)))
    monkeypatch.setattr(courses, "stepped", lambda stand, found, most: ("whole", found))
    start: Any = SimpleNamespace(given=None)
    others: Any = [[leg(0.5)]]
    led: Any = courses.led_beside(start, np.zeros(1), np.zeros(0), others, in_any_case=in_any_case)
    assert asked == ends
    assert led == ("whole" if ends[-1] == 0.9 else None)


@pytest.mark.parametrize(
    ("course", "others", "is_ahead"),
    [
        ([], [], False),
        ([(-5.0, False)], [], True),
        ([(-5.0, True), (-9.0, False)], [], True),
        ([(-5.0, False), (-9.0, True)], [], False),
        ([(-5.0, False)], [[(-4.0, False)]], False),
        ([(-5.0, False)], [[(-6.0, False), (-8.0, False)], []], True),
        ([(-5.0, False), (-9.0, False)], [[(-4.0, False)], [(-6.0, False), (-8.0, False)]], False),
    ],
)
def test_only_the_foremost_course_is_led_on_by_way_of_the_middle(course, others, is_ahead):
    """Behind another one it would not be taken, and where a gap is left each way takes as long."""
    legs: Any = [[SimpleNamespace(log_z=log_z, misses=misses, rms=1.3) for log_z, misses in one] for one in (course, *others)]
    assert courses._met(legs[0], legs[1:]) == (1.3 if is_ahead else None)


@pytest.fixture
def right(campaign, fitted):
    """A right model with two short films, its file off by some errors."""
    fit = fitted(campaign(None, 95, loops=(), deployments=({}, {"geometry.stowed_height_m": 0.30}), hold_out=False))
    problem = fit.problem.until(0.35)
    return weighed_within(problem, fit.q, {("platform-mass", 0): 1.5, ("geometry-error", 4): -2.0})


@pytest.mark.parametrize("name", NAMES)
def test_a_name_begins_where_the_rig_stands_without_it(right, name):
    (promise,) = (one for one in promises(right, {name: CATALOGUE[name]}) if one.name == name)
    problem, end = posed(right, promise)
    stand, m = begun(right, problem, promise, end), right.fit.problem.measured
    assert stand.fit.gaps[:m] == pytest.approx(right.within.fit.gaps[:m], abs=1e-6)
    assert name not in stand.errors.names
    assert bool(np.any(stand.fit.q[problem.rows_of(name)])) == (name in right.within.errors.names)


@pytest.mark.parametrize(("best", "shown", "taken"), [(1.0, True, 1.0), (0.2, True, 0.2), (0.0, True, 0.0), (0.2, False, 1.0)])
def test_a_hypothesis_is_taken_towards_its_promise_as_far_as_that_is_likelier(right, monkeypatch, best, shown, taken):
    """All the way where a parameter does not show yet: of a wave without height no step tells its period."""
    (promise,) = (one for one in promises(right, {"hub-inertia": CATALOGUE["hub-inertia"]}) if one.name == "hub-inertia")
    problem, end = posed(right, promise)
    stand = begun(right, problem, promise, end)
    end[-1] += 1.0
    stand.__dict__["columns"] = replace(stand.columns, values=stand.columns.values * shown)
    way, errors = end - stand.fit.q, {("platform-mass", 0): 3.0}

    def moved_to(self, _, q, sizes, gaps):
        return SimpleNamespace(q=q, sizes=sizes)

    def tried(stand, part, noise):
        step, change = courses._parted(stand, part)
        share = float(step @ way / (way @ way))
        return (
            stand.log_probability(noise) + (1.0 if share == pytest.approx(best) else -share),
            None,
            stand.fit.q + step,
            stand.sizes + change,
            stand.fit.gaps,
        )

    monkeypatch.setattr(type(stand), "moved_to", moved_to)
    monkeypatch.setattr(weighing, "tried", tried)
    monkeypatch.setattr(weighing, "_weighed_from", lambda there: there)
    found: Any = weighing.weighed_towards(stand, end, errors, right.evidence.noise)
    if not taken:
        assert found is stand
        return
    assert found.q == pytest.approx(stand.fit.q + taken * way)
    mass = stand.errors.keys.index(("platform-mass", 0))
    joint = stand.errors.keys.index(("geometry-error", 4))
    assert found.sizes[mass] == pytest.approx((1.0 - taken) * stand.sizes[mass] + taken * 3.0)
    assert found.sizes[joint] == pytest.approx((1.0 - taken) * stand.sizes[joint])
