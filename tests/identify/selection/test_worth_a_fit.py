"""Which hypotheses that were only weighed are worth a fit, and from where names are weighed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.selection import search as search_module
from identify.selection.hypotheses import BUDGETS, Ahead
from identify.selection.search import _BEYOND, Search

BOTH = ("end-stop-dissipation", "stored-force-per-run")


def hypothesis(names, log_weight, rms=1.0, as_it_is=1.0, leaves_noise=True) -> Any:
    return SimpleNamespace(
        names=names,
        log_weight=log_weight,
        is_believable=True,
        fit=SimpleNamespace(rms=rms),
        largest_rms=as_it_is,
        weighed=SimpleNamespace(leaves_noise=leaves_noise, log_z=log_weight),
    )


def promised(names, log_weight, promise: Any = True, beside: Any = None) -> Any:
    return Ahead(names, beside, promise, log_weight)


@pytest.mark.parametrize(
    ("foremost", "less", "is_worth"), [((), 0.9 * _BEYOND, True), ((), 1.1 * _BEYOND, False), (("hub-inertia",), 0.5, False)]
)
def test_a_name_promised_a_little_less_than_nothing_is_fitted_and_one_more_beside_a_name_is_not(foremost, less, is_worth):
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    search.fitted = {(): hypothesis((), -100.0), foremost: hypothesis(foremost, -50.0)}
    one = promised(tuple(sorted((*foremost, "platform-mass"))), -50.0 - less)
    assert search._is_worth_a_fit(one) == is_worth


@pytest.mark.parametrize(
    ("before", "log_weight", "is_worth"),
    [(None, -400.0, True), (-350.0, -300.0, True), (-350.0, -340.0, False), (-300.0, -300.0, False), (-290.0, -220.0, True)],
)
def test_what_would_stay_behind_the_force_without_a_name_is_not_fitted(before, log_weight, is_worth):
    """One was promised `before` and came to -300; the force without a name has -250."""
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    search.fitted = {(): hypothesis((), -500.0, 4.0, 4.0, leaves_noise=False)}
    search.ahead = {("missing-force-along-time",): promised(("missing-force-along-time",), -250.0, None)}
    if before is not None:
        search.fitted[("ripple",)] = hypothesis(("ripple",), -300.0, 3.0, 3.0, leaves_noise=False)
        search.led = {("ripple",): promised(("ripple",), before)}
    one = promised(("ripple", "viscous-friction"), log_weight)
    assert search._may_reach_the_unnamed(one) == is_worth


@pytest.mark.parametrize(("rms", "as_it_is", "is_meant"), [(1.144, 9.3, True), (1.144, 1.131, False), (16.4, 1.9, False)])
def test_a_name_is_not_thrown_out_for_a_gap_that_only_a_model_moved_beyond_its_tolerances_closes(rms, as_it_is, is_meant):
    search, names = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("centre-of-mass-offset",)
    search.fitted = {(): hypothesis((), -300.0, 1.131, as_it_is), names: hypothesis(names, -100.0, rms)}
    assert (search.foremost.names == names) == is_meant


@pytest.mark.parametrize(
    ("logs", "leaves_noise", "sure"),
    [((-0.1, 0.0), True, ("stored-force-per-run",)), ((-9.0, 0.0), True, BOTH), ((-0.1, 0.0), False, BOTH)],
)
def test_a_second_name_that_may_be_nothing_is_not_said(logs, leaves_noise, sure):
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    one, both = (hypothesis(names, log, 1.0) for names, log in zip((BOTH[1:], BOTH), logs, strict=True))
    one.weighed.leaves_noise = leaves_noise
    search.fitted = {(): hypothesis((), -70.0, 2.0, 2.0), BOTH[1:]: one, BOTH: both}
    search.promised = {(): []}
    assert search._sure_of(BOTH) == sure


@pytest.mark.parametrize(
    ("base", "fitted", "foremost", "least", "is_behind"),
    [
        (-108.0, -123.0, None, -200.0, True),
        (-108.0, -123.0, None, -90.0, False),  # something else promises more
        (-108.0, -140.0, None, -200.0, False),
        (-133.6, -132.0, None, -200.0, False),
        (-133.4, -132.0, None, -200.0, True),
        (-134.0, -132.0, None, -200.0, False),
        (-114.0, -60.0, -50.0, -200.0, True),
        (-128.0, -56.0, -50.0, -200.0, False),  # the base gained 6 and lacks 78
    ],
)
def test_a_name_that_was_fitted_from_a_worse_base_is_behind_where_it_may_compete_once_it_is_as_much_likelier(
    base, fitted, foremost, least, is_behind
):
    """An inertia came to -123 from a base of -134, whose releases leant the wrong way; from a base of -108 it came to -99."""
    search, names = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("platform-inertia",)
    search.fitted = {(): hypothesis((), base), names: hypothesis(names, fitted)}
    search.fitted |= {} if foremost is None else {("ripple",): hypothesis(("ripple",), foremost)}
    search.led = {names: promised(names, -124.0, beside=hypothesis((), -134.0))}
    assert (search._left_behind(least) is not None) == is_behind


def fitting_again(monkeypatch, promises, ahead=None) -> Any:
    """A search with a name left behind by a base that was found since, what each of two stands promises, and what it fits."""
    kinds: Any = {"hub-inertia": "Hub", "ripple": "Ripple"}
    search, names = Search(kinds, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("ripple",)
    base, search.ahead = hypothesis((), -108.0), ahead or {}
    search.fitted = {(): base, names: hypothesis(names, -123.0)}
    search.led = {names: promised(names, -124.0, SimpleNamespace(name="ripple", instead=""), beside=hypothesis((), -134.0))}

    def promises_of(at, catalogue, instead):
        assert catalogue == {"ripple": "Ripple"}
        return [SimpleNamespace(name=name, instead=instead, log_z=log_z) for name, log_z in promises[at]]

    monkeypatch.setattr(search_module, "stands_of", lambda one: [("whole", 0.0), ("early", -7.0)] if one is base.weighed else [])
    monkeypatch.setattr(search_module, "promises", promises_of)
    done = []
    monkeypatch.setattr(search, "_fit", done.append)
    search._fit_again(search.led[names])
    return search, done


def test_a_name_left_behind_is_fitted_from_the_stand_that_promises_most_and_not_another_that_is_promised_with_it(monkeypatch):
    """Beside several films forces that differ are always promised; only what was left behind is fitted."""
    told = {"whole": [("stored-force-per-run", 50.0), ("ripple", 4.0)], "early": [("stored-force-per-run", 50.0), ("ripple", -2.0)]}
    search, done = fitting_again(monkeypatch, told)
    assert [(one.names, one.log_weight, one.beside.log_weight) for one in done] == [(("ripple",), -103.0, -108.0)]
    assert search._left_behind(-np.inf) is None


def test_what_was_promised_from_where_the_base_is_no_more_is_not_fitted_again(monkeypatch):
    """From there it had been promised 23 more than its fit brought: both promises were fitted in turn until the budget was spent."""
    monkeypatch.setattr(Search, "_may_reach_the_unnamed", lambda search, one: True)
    before = promised(("ripple",), -100.0, SimpleNamespace(name="ripple", instead=""), beside=hypothesis((), -134.0))
    search, done = fitting_again(monkeypatch, {"whole": [("ripple", 4.0)], "early": []}, {("ripple",): before})
    search.led[("ripple",)] = done[0]
    assert not [one for one in search.ahead.values() if search._is_worth_a_fit(one)]


def test_a_name_left_behind_that_shows_no_more_is_not_asked_for_again(monkeypatch):
    search, done = fitting_again(monkeypatch, {"whole": [], "early": []})
    assert not done
    assert search._left_behind(-np.inf) is None


@pytest.mark.parametrize(("spent", "again"), [(0, [("ripple",)]), (99, [])])
def test_a_search_fits_what_was_left_behind_again_while_its_budget_lasts(monkeypatch, spent, again):
    search, names, done = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("ripple",), []
    search.fitted = {(): hypothesis((), -108.0), names: hypothesis(names, -123.0)}
    search.led = {names: promised(names, -124.0, beside=hypothesis((), -134.0))}
    search.seen_from, search.turned, search.spent, search.promised = {(), names}, {(), names}, spent, {(): []}

    def fit_again(led) -> None:
        done.append(led.names)
        search.led[led.names] = promised(led.names, -99.0, beside=search.fitted[()])

    for name, stub in {"_fit_again": fit_again, "_keep": lambda names, found: None}.items():
        monkeypatch.setattr(search, name, stub)
    monkeypatch.setattr(search_module, "weighed", lambda base: None)
    search.run(None)  # type: ignore[arg-type]
    assert done == again


@pytest.mark.parametrize(
    ("names", "gain", "base", "is_taken"),
    [
        (("ripple",), 0.4, -50.0, False),
        (("ripple",), 7.0, -55.0, True),
        (("ripple",), 7.0, -61.0, False),
        (("ripple",), 11.0, -90.0, True),
        ((), 11.0, -50.0, False),
    ],
)
def test_the_base_is_taken_along_to_where_names_were_found_likelier_if_it_may_compete_there(monkeypatch, names, gain, base, is_taken):
    """On the wrong side a mass was as likely as nothing; there it came 7 higher, and nothing would have stayed behind."""
    search, taken = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), []
    search.fitted = {(): hypothesis((), base), ("ripple",): hypothesis(("ripple",), -50.0)}
    monkeypatch.setattr(search, "_base_again", lambda led, is_elsewhere: taken.append((led, is_elsewhere)))
    search._take_the_base_along(search.fitted[names], gain)
    assert taken == ([(search.fitted[names].weighed, True)] if is_taken else [])


@pytest.mark.parametrize(
    ("leaves_noise", "named", "unnamed", "turned"),
    [
        (True, -101.0, -103.0, []),  # what leaves noise and is likeliest stays so on whatever side
        (True, -99.0, -103.0, [(), ("ripple",)]),
        (True, -101.0, -99.0, [()]),
        (False, -101.0, -103.0, [()]),
    ],
)
def test_nothing_is_looked_for_on_the_other_side_only_where_something_is_likelier_or_it_leaves_a_gap(
    monkeypatch, leaves_noise, named, unnamed, turned
):
    """A name is promised as much as nothing, and comes to `named`; before it is said it is looked for on the other side, too."""
    search, sides, nothing = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), [], hypothesis((), -100.0)
    nothing.weighed.leaves_noise = leaves_noise

    def fit(ahead) -> None:
        search.fitted[ahead.names] = hypothesis(ahead.names, named)
        search.seen_from.add(ahead.names)

    def look(one) -> None:
        search.seen_from.add(one.names)
        search.promised[one.names] = []
        search.ahead = {one.names: one for one in (promised(("ripple",), -100.0), promised(("missing-force",), unnamed, None))}

    def keep(names, found) -> None:
        search.fitted[names] = nothing

    def turn(names) -> None:
        sides.append(names)
        search.turned.add(names)

    for name, stub in {"_fit": fit, "_look_from": look, "_keep": keep, "_turn": turn, "_brought_back": lambda one: one}.items():
        monkeypatch.setattr(search, name, stub)
    monkeypatch.setattr(search_module, "weighed", lambda base: None)
    search.run(None)  # type: ignore[arg-type]
    assert sides == turned
    assert ("ripple",) in search.fitted


@pytest.mark.parametrize(
    ("seen", "is_left", "looked"),
    [(False, True, [(), ("backlash",)]), (False, False, [(), ("backlash",)]), (True, True, [])],
)
def test_all_is_weighed_anew_from_a_base_that_was_found_elsewhere_since(monkeypatch, seen, is_left, looked):
    """Legs that differ came to -11235 from a base of -11650; from the base of -11206 that was found since they come to -10949.

    Where the base was turned nothing is left of what was weighed before: beside the foremost name there would be no other hypothesis.
    """
    search, names, turned = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("backlash",), []
    search.fitted = {(): hypothesis((), -200.0), names: hypothesis(names, -195.0)}
    search.seen_from, search.turned, done = {names} | ({()} if seen else set()), {(), names}, []
    search.promised = {names: []} if is_left else {}

    def look(one) -> None:
        done.append(one.names)
        assert len(done) <= len(looked)
        search.seen_from.add(one.names)
        if not one.names:  # the other name may be found anew, then the foremost one is looked from again
            search.seen_from.discard(names)

    for name, stub in {"_look_from": look, "_keep": lambda names, found: None, "_brought_back": lambda one: one}.items():
        monkeypatch.setattr(search, name, stub)
    monkeypatch.setattr(search, "_turn", turned.append)
    monkeypatch.setattr(search_module, "weighed", lambda base: None)
    search.run(None)  # type: ignore[arg-type]
    assert done == looked
    assert not turned


@pytest.mark.parametrize(("names", "turns"), [(("leg-disparity",), True), ((), False)])
@pytest.mark.parametrize(("gain", "again"), [(20.0, True), (5.0, False), (-5.0, False)])
def test_what_is_found_in_a_far_likelier_place_is_looked_from_and_brought_back_again_and_names_are_turned(gain, again, names, turns):
    """The base, which has no names, is turned once only: its search is thorough, and takes long."""
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    fit: Any = SimpleNamespace(rms=1.0, q=np.zeros(0), problem=SimpleNamespace(first_effect=0, parameters=()))
    places: Any = [SimpleNamespace(log_z=log_z, fit=fit, exact=SimpleNamespace(fit=fit)) for log_z in (-100.0, -100.0 + gain)]
    before, after = places
    before.better_of = lambda other: other
    search.fitted = {(): hypothesis((), -120.0)} if names else {}
    search._keep(names, before)
    done = search.seen_from, search.brought_back, search.turned
    for one in done:
        one.add(names)
    search._keep(names, after)
    assert [names in one for one in done] == [not again, not again, not (again and turns)]


@pytest.mark.parametrize(
    ("names", "leaves_noise", "misses", "thoroughly"),
    [((), True, False, True), ((), False, True, True), ((), False, False, False), (("ripple",), True, False, False)],
)
def test_only_a_base_that_leaves_noise_or_is_far_off_is_searched_thoroughly(monkeypatch, names, leaves_noise, misses, thoroughly):
    """Close to films that show a gap a name may close it."""
    search, asked = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), []
    one = hypothesis(names, -100.0, leaves_noise=leaves_noise)
    one.weighed.stand, one.weighed.better_of = SimpleNamespace(misses=misses), lambda other: other
    search.fitted = {(): hypothesis((), -120.0), names: one}

    def side(one, *, thoroughly):
        asked.append(thoroughly)
        return one

    monkeypatch.setattr(search_module, "on_the_likelier_side", side)
    search._turn(names)
    assert asked == [thoroughly]
    assert search.turned == {names}


@pytest.mark.parametrize(("rival", "fits"), [(-3.3, [("sensor-filter",)]), (-6.0, [])])
def test_what_was_promised_a_few_hundredths_beside_a_name_alone_is_fitted_before_that_is_said(monkeypatch, rival, fits):
    """A filter was promised 0.034 beside a delay's 0.96, and was the likelier one once it was fitted."""
    search, names = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("sensor-lag",)
    search.fitted = {(): hypothesis((), -100.0, 1.3, 1.3), names: hypothesis(names, 0.0)}
    for one, log_weight, promise in ((("sensor-filter",), rival, True), (("missing-force",), -9.0, None)):
        search.ahead[one] = promised(one, log_weight, promise, beside=search.fitted[()])
    search.promised, search.tables, done = {(): []}, {(): []}, []

    def fit(ahead) -> None:
        done.append(ahead.names)
        search.fitted[ahead.names] = hypothesis(ahead.names, 1.2)

    monkeypatch.setattr(search, "_fit", fit)
    monkeypatch.setattr(search, "_brought_back", lambda one: one)
    found = search.settled()
    assert done == fits
    assert found.names == (fits[0] if fits else names)


@pytest.mark.parametrize(
    ("unnamed", "named", "prior_p", "looked"),
    [
        (-130.0, -140.0, 0.02, ["whole"]),
        (-130.0, -140.0, 5e-4, ["whole", "early"]),
        (-130.0, -80.0, 5e-4, ["whole"]),
        (-90.0, -140.0, 0.4, ["whole", "turned", "early"]),
        (-90.0, -95.0, 0.4, ["whole", "turned", "early"]),
        (-90.0, -80.0, 0.4, ["whole", "turned"]),
    ],
)
def test_where_no_name_explains_a_likelier_force_or_an_improbable_base_names_are_weighed_up_to_the_first_stop_as_well(
    monkeypatch, unnamed, named, prior_p, looked
):
    """Releases had bent to a contact with handrails: whole films promised it 1 and an air drag 10, up to the first stop 37 and -2.

    Joints bent by up to two tolerances followed a cable: of it straight lines promised -2 there, and 31 up to the first stop.
    """
    search, seen = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), []
    base = hypothesis((), -108.0)
    stands: Any = [(SimpleNamespace(name="whole", along_lines=0.0), 0.0), (SimpleNamespace(name="early", along_lines=1.0), 1.0)]
    base.fit.problem, base.weighed.evidence = SimpleNamespace(effects=()), SimpleNamespace(prior_p=prior_p)
    search.fitted, search.promised, search.spent = {(): base}, {(): []}, search.budget.fits
    monkeypatch.setattr(search_module, "stands_of", lambda one, closely=False: stands if closely else stands[:1])
    monkeypatch.setattr(search_module, "promises", lambda at, catalogue: seen.append(at.name) or [])

    def weigh_tables(one, at, found) -> None:
        search.ahead[("missing-force-along-height",)] = promised(("missing-force-along-height",), unnamed, promise=None, beside=base)
        search.ahead[("air-drag",)] = promised(("air-drag",), named)

    monkeypatch.setattr(search, "_weigh_tables", weigh_tables)
    monkeypatch.setattr(search, "_turn", lambda names: search.turned.add(names) or seen.append("turned"))
    monkeypatch.setattr(search, "_brought_back", lambda one: one)
    monkeypatch.setattr(search_module, "weighed", lambda fit: base.weighed)
    monkeypatch.setattr(search, "_keep", lambda names, found: None)
    search.run(base.fit)
    assert seen == looked


@pytest.mark.parametrize(("log_weight", "foremost"), [(-100.2, ("scale-error",)), (-100.05, ()), (-99.0, ())])
def test_of_two_that_are_equally_likely_the_one_with_fewer_names_is_foremost(log_weight, foremost):
    """A scale error came to 0.49 beside nothing with 0.46, so that the base was looked for on the other side: 9 s of 20."""
    search, names = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("scale-error",)
    search.fitted = {(): hypothesis((), log_weight), names: hypothesis(names, -100.0)}
    search.promised = {(): []}
    assert search.foremost.names == foremost
    assert search._doubts_the_base == bool(foremost)
    assert search._is_explained == bool(foremost)


@pytest.mark.parametrize(("log_weight", "is_worth"), [(-100.0, True), (-113.0, False)])
def test_a_name_that_is_promised_far_more_from_another_name_than_its_fit_brought_is_fitted_again_once(log_weight, is_worth):
    """A pulley's friction was fitted from nothing to -1631; in the place of an imbalance, which had -1613, it was promised -1612."""
    search, names = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None), ("pulley-friction",)
    search.fitted = {(): hypothesis((), -400.0, leaves_noise=False), names: hypothesis(names, -118.0, leaves_noise=False)}
    elsewhere = promised(names, log_weight, beside=hypothesis(("gravity-imbalance",), -99.0))
    search.led = {names: promised(names, -130.0, beside=search.fitted[()])}
    assert search._is_worth_a_fit(elsewhere) == is_worth
    search.led[names] = elsewhere
    assert not search._is_worth_a_fit(elsewhere)


@pytest.mark.parametrize(
    ("base", "leaves_noise", "spent", "misses", "leads_on"),
    [
        (-52.9, True, 0, False, False),  # nothing may be missing: it holds more than a twentieth
        (-53.1, True, 0, False, True),
        (-52.9, False, 0, False, True),
        (-99.0, False, 99, True, False),
        (-99.0, False, 99, False, True),
    ],
)
def test_no_further_name_is_looked_for_where_nothing_may_be_missing_or_a_spent_search_is_far_off(
    base, leaves_noise, spent, misses, leads_on
):
    """Joints within their tolerance were as likely as nothing, and all was weighed beside them, too: 16 s for a right model."""
    one = hypothesis(("geometry-error",), -50.0)
    one.weighed.stand = SimpleNamespace(misses=misses)
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    search.fitted, search.spent = {(): hypothesis((), base, leaves_noise=leaves_noise), one.names: one}, spent
    assert search._leads_on(one) == leads_on
    assert search._leads_on(search.fitted[()])
