"""What straight lines promise and the simulation does not keep is no evidence; intervals reach over all sides that are likely."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.selection.evidence import Both
from identify.selection.findings import _on_all_sides, _over_all, _Part
from identify.selection.hypotheses import BUDGETS, Hypothesis
from identify.selection.search import Search
from identify.selection.stand import Stand
from identify.selection.weighing import settled


@pytest.fixture
def stand(campaign, fitted):
    folder = campaign(None, 871, loops=(), deployments=({},), hold_out=False)
    return settled(Stand.exact(fitted(folder)))[0]


def test_a_place_where_no_step_leads_on_keeps_what_its_lines_promise(stand):
    assert stand.borne_out(stand.weighed()).unkept < 1.0


def test_what_lines_promise_from_a_place_where_the_simulation_stays_is_no_evidence(stand):
    """Two standard deviations of a number of the law beside the best place, all else as it is: lines still lead back and promise two."""
    off = stand.fit.q.copy()
    off[1] += 2.0 / np.sqrt(np.linalg.inv(stand.weighed().covariance)[1, 1])
    there = stand.at(stand.fit.problem, off, stand.sizes)
    found = there.borne_out(there.weighed())
    lost = stand.log_probability(found.noise) - there.log_probability(found.noise)
    assert found.kept == pytest.approx(found.log_z - lost, abs=1.0)
    assert found.unkept > 1.0
    assert Both(found, None).log_z == found.kept
    assert Both(found, None).along_lines == found.log_z


def test_an_interval_over_one_side_is_that_of_a_normal_distribution():
    assert _over_all(np.array([3.0]), np.array([0.5]), np.ones(1)) == pytest.approx((2.02, 3.98), abs=1e-3)


def test_an_interval_over_two_equal_sides_leaves_a_twentieth_of_either():
    assert _over_all(np.array([-10.0, 10.0]), np.array([1.0, 1.0]), np.full(2, 0.5)) == pytest.approx((-11.645, 11.645), abs=1e-3)


def test_a_side_that_is_hardly_likely_does_not_widen_an_interval():
    assert _over_all(np.array([0.0, 10.0]), np.array([1.0, 1.0]), np.array([0.999, 0.001])) == pytest.approx((-1.96, 1.98), abs=0.02)


def test_a_side_on_which_a_parameter_does_not_show_says_nothing_of_it():
    assert _over_all(np.array([0.0, 10.0]), np.array([1.0, np.nan]), np.full(2, 0.5)) == pytest.approx((-1.96, 1.96), abs=1e-3)


def test_a_parameter_that_shows_on_an_impossible_side_only_keeps_its_bounds():
    """A side 800 less likely has a share of nought to the last digit."""

    def side(value, stderr) -> Any:
        limits = np.array([[-1.0, -1.0], [1.0, 1.0]])
        return _Part(ScaleOf((value, 0.1)), np.array([stderr, 0.01]), limits.T.copy(), 1.0, 1, (), limits)  # type: ignore[arg-type]

    found = _on_all_sides([side(0.0, np.nan), side(0.5, 0.01)], np.array([1.0, 0.0]))
    assert found.ci95[0].tolist() == [-1.0, 1.0]
    assert found.ci95[1] == pytest.approx((0.0804, 0.1196), abs=1e-4)


class ScaleOf(tuple):  # type: ignore[type-arg]
    """In place of an effect: its parameters laid flat."""

    def flat(self) -> Any:
        return np.array(self)


def hypothesis(names, log_weight, weighed=None) -> Any:
    weighed = weighed or SimpleNamespace(leaves_noise=True, log_z=log_weight)
    fit = SimpleNamespace(rms=1.0)
    return SimpleNamespace(names=names, log_weight=log_weight, is_believable=True, fit=fit, largest_rms=1.0, weighed=weighed)


ALONE, BESIDE = {("viscous-friction",)}, {("a", "b"), ("a", "c")}


@pytest.mark.parametrize(("gain", "left"), [(20.0, ALONE), (5.0, ALONE | BESIDE), (0.0, ALONE | BESIDE)])
def test_before_a_name_is_added_the_others_are_looked_for_on_the_other_side(monkeypatch, gain, left):
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    search.fitted = {(): hypothesis((), -100.0), ("a",): hypothesis(("a",), -50.0)}
    search.ahead = {one: SimpleNamespace(names=one, log_weight=-45.0, promise=True, beside=None) for one in ALONE | BESIDE}  # type: ignore[misc]
    fits, bases = [], []
    before = search.fitted[("a",)].weighed
    after = SimpleNamespace(leaves_noise=True, log_z=before.log_z + gain) if gain else before
    monkeypatch.setattr("identify.selection.search.on_the_likelier_side", lambda one, thoroughly: after)
    monkeypatch.setattr(search, "_keep", lambda names, found: search.fitted.update({names: hypothesis(names, found.log_z, found)}))
    monkeypatch.setattr(search, "_base_again", lambda led, is_elsewhere: bases.append(led))
    monkeypatch.setattr(search, "_fit", lambda ahead: fits.append(ahead.names))
    search._fit_or_turn(search.ahead[("a", "b")])
    assert fits == []
    assert set(search.ahead) == left
    assert search.fitted[("a",)].weighed is after
    assert bases == ([after] if left == ALONE else [])
    search._fit_or_turn(SimpleNamespace(names=("a", "b")))  # type: ignore[arg-type]
    assert fits == [("a", "b")]


@pytest.mark.parametrize(("gain", "is_anew"), [(-1.0, False), (5.0, False), (20.0, True)])
def test_only_from_a_much_likelier_place_all_else_is_weighed_anew(gain, is_anew):
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    fit: Any = SimpleNamespace(rms=1.0, q=np.zeros(0), problem=SimpleNamespace(first_effect=0, parameters=()))
    exact = SimpleNamespace(fit=fit)
    found = SimpleNamespace(log_z=-50.0 + gain, fit=fit, exact=exact)
    known = SimpleNamespace(log_z=-50.0, fit=fit, exact=exact, better_of=lambda other: max(known, other, key=lambda one: one.log_z))
    search.fitted = {(): hypothesis((), -60.0), ("a",): Hypothesis(("a",), known, 0.0)}  # type: ignore[arg-type, dict-item]
    search.seen_from, search.brought_back = {("a",)}, {("a",)}
    search._keep(("a",), found)  # type: ignore[arg-type]
    assert search.fitted[("a",)].weighed is (found if gain > 0.0 else known)
    assert (("a",) not in search.seen_from) == is_anew
    assert (("a",) not in search.brought_back) == is_anew
