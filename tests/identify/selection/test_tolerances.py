"""A model file that is right within its tolerances is right: what its errors do behind the stops is simulated, and no effect is named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation.problem import Fit
from identify.selection import weighing
from identify.selection.evidence import Both
from identify.selection.explain import explain
from identify.selection.findings import moved_of
from identify.selection.stand import Stand
from identify.selection.weighing import weighed
from simulate.effects import (
    CATALOGUE,
    EndStopDissipation,
    GeometryError,
    PlatformInertia,
    PlatformMass,
    StopStiffness,
    StribeckFriction,
    ViscousFriction,
)
from simulate.files.model_file import add_effects, read_model

RIG = Path(__file__).resolve().parents[1].joinpath("rig.toml")
FEW = ("stop-stiffness", "hub-inertia", "viscous-friction", "platform-mass")


def as_built(seed):
    """Errors of a drawing that a workshop keeps to, drawn by seed; the stops a good tolerance off."""
    chance = np.random.default_rng(seed)
    return (
        StopStiffness(0.35 * chance.choice([-1.0, 1.0])),
        EndStopDissipation(0.3 * chance.normal()),
        GeometryError(tuple(chance.normal(0.0, 3e-4, 36).tolist())),
        PlatformMass(0.003 * chance.normal()),
        PlatformInertia(tuple((0.05 * chance.normal(size=3)).tolist())),
    )


@pytest.fixture
def built(campaign):
    return campaign(as_built(880), 880, loops=(), deployments=({}, {"geometry.stowed_height_m": 0.35}))


@pytest.mark.parametrize("fitted_too", [None, GeometryError(tuple([1e-3, -2e-3] * 18)), StopStiffness(0.4)])
def test_a_column_is_what_an_error_does_to_the_gaps_whatever_error_is_fitted_beside_it(campaign, fitted_too):
    """An error that is fitted stays as it is fitted, and is not among those of the tolerances."""
    folder = campaign(None, 882, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])).until(0.4)
    problem = problem.with_effects([] if fitted_too is None else [type(fitted_too)()])
    q = np.concatenate(
        [problem.start[: problem.first_effect], [] if fitted_too is None else fitted_too.flat() / problem.scales[problem.first_effect :]]
    )
    loose = Stand.loose(Fit(problem, q, *problem.jacobian(q), True))
    stand = loose.at(problem, q, loose.sizes)
    assert fitted_too is None or fitted_too.name not in stand.errors.names
    here = problem.gaps_beside([q])[0]
    for place in range(0, len(stand.sizes), 7):
        step = np.zeros(len(stand.sizes))
        step[place] = 1e-2
        moved = stand.with_errors(step).gaps_beside([q])[0] - here
        column = stand.errors.columns[:, place]
        assert np.linalg.norm(moved[: problem.measured] / 1e-2 - column) <= 0.05 * np.linalg.norm(column), stand.errors.keys[place]


def test_a_column_is_what_a_tolerance_more_does_where_the_stops_are_off_already(campaign):
    """A factor: from a stop that is twice as damped a tolerance more adds twice as much."""
    folder = campaign(None, 885, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    loose, q = Stand.loose(Fit(problem, problem.start, *problem.jacobian(problem.start), True)), problem.start
    place = loose.errors.names.index(EndStopDissipation.name)
    off = np.zeros(len(loose.sizes))
    off[place] = 2.3
    stand, m = loose.at(loose.with_errors(off), q, off), problem.measured

    def change(problem):
        return (problem.gaps_beside([q])[0] - stand.fit.gaps)[:m]

    column = stand.errors.columns[:, place]
    moved = change(stand.with_errors(off + 1e-2 * (np.arange(len(off)) == place))) / 1e-2
    assert np.linalg.norm(moved - column) <= 0.05 * np.linalg.norm(column)
    signature = stand.errors.signature_of(EndStopDissipation(), stand.given, stand.fit.problem.model)
    assert signature is not None
    more = float(stand.fit.problem.model.effect(EndStopDissipation).flat()[0]) + 0.01
    moved = change(problem.with_model(lambda model: add_effects(model, (EndStopDissipation(more),)))) / 0.01
    typical = float(EndStopDissipation().typical(problem.measures)[0])
    assert np.linalg.norm(moved * typical - signature[2][:, 0]) <= 0.05 * np.linalg.norm(moved * typical)


@pytest.mark.parametrize(
    ("name", "size", "amount"),
    [("stop-stiffness", 6.6, np.expm1(0.3 * 6.6)), ("stop-stiffness", -6.6, np.expm1(-0.3 * 6.6)), ("centre-of-mass-offset", 3.0, 1.5e-3)],
)
@pytest.mark.parametrize("stated", [0.0, 1.5])
def test_an_error_far_beyond_its_tolerance_that_is_let_free_begins_where_it_is(campaign, name, size, amount, stated):
    """A factor of 7.2 is 6.6 tolerances in equal ratios; along straight lines from there it is 2.9, and the fit must start from it.

    stated : an error of the stops that the model file has already; the factor is one of what that leaves.
    """
    folder = campaign(None, 886, loops=(), deployments=({},))
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    problem = problem.with_model(lambda model: add_effects(model, (StopStiffness(stated),)))
    amount *= 1.0 + stated if name == "stop-stiffness" else 1.0
    stand = Stand.off_by(problem, problem.start, {(name, 0): size})
    effect = problem.model.effect(CATALOGUE[name])
    signature = stand.errors.signature_of(effect, stand.given, stand.fit.problem.model)
    assert signature is not None
    amounts = np.zeros(len(effect.flat()))
    amounts[0] = amount / effect.typical(problem.measures)[0]
    kept, without = stand.lines(), stand.lines({name})
    assert without.errors.shape[1] == kept.errors.shape[1] - len(amounts)
    assert np.linalg.norm(kept.gaps - without.gaps) > 1.0
    np.testing.assert_allclose(without.gaps + signature[2] @ amounts, kept.gaps, atol=1e-6 * np.abs(kept.gaps).max())


def test_errors_of_the_stops_are_free_wherever_a_search_begins(campaign):
    """Films that end before the stops, or a law too weak to reach them, do not show them; the place to which they lead may."""
    folder = campaign(None, 883, loops=(), deployments=({},))
    whole = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    early = whole.until(0.2)
    loose = Stand.loose(Fit(early, early.start, *early.jacobian(early.start), True))
    stops = [place for place, name in enumerate(loose.errors.names) if name in ("stop-stiffness", "end-stop-dissipation")]
    assert len(stops) == 2
    assert np.abs(loose.errors.columns[:, stops]).max() < 1e-6
    there = replace(loose, given=whole).at(whole, whole.start, loose.sizes)
    assert (np.linalg.norm(there.errors.columns[:, stops], axis=0) > 1.0).all()


def test_a_model_file_without_tolerances_has_no_errors(campaign):
    folder = campaign(None, 884, loops=(), deployments=({},))
    model = read_model(folder / "model.toml")
    exact = dict.fromkeys(("platform_mass_percent", "inertia_percent", "centre_of_mass_m", "joints_m", "end_stop_percent"), 0.0)
    problem = problem_of(replace(model, nuisance=replace(model.nuisance, **exact)), read_campaign([folder / "campaign.toml"]))
    loose = Stand.loose(Fit(problem, problem.start, *problem.jacobian(problem.start), True))
    assert set(loose.errors.names) <= {"scale-error"}
    assert len(loose.sizes) == len(loose.errors.names) == loose.errors.columns.shape[1]


@pytest.mark.slow
def test_errors_within_the_tolerances_are_found_behind_the_stops_where_no_straight_line_leads(built, fitted):
    at = weighed(fitted(built))
    assert not at.both.is_exact
    assert at.exact.fit.rms > 1.5
    assert at.within.fit.rms < 1.2
    assert at.leaves_noise
    (stops,) = [effect for effect, _ in moved_of(at.within) if isinstance(effect, StopStiffness)]
    true, reach = as_built(880)[0].fraction, 0.3 * 3.0
    assert stops.fraction == pytest.approx(true, abs=reach)
    assert stops.fraction * true > 0.0


@pytest.mark.parametrize(
    ("misses", "lost", "gain", "uphill"),
    [
        (False, False, 100.0, True),
        (True, False, 100.0, False),
        (True, False, 1.0, True),  # its tolerances hardly bring anything
        (True, True, 100.0, True),  # loops are missed, which no tolerance helps
    ],
)
def test_a_model_file_that_misses_as_it_is_is_taken_uphill_only_where_it_may_hold_a_share(monkeypatch, misses, lost, gain, uphill):
    """Of right rigs with joints off by 0.3 mm it misses by 13 to 53 times the noise and is 2500 less likely: 1 s of 9 for nothing."""
    evidences: list[Any] = [SimpleNamespace(kept=kept, noise=()) for kept in (0.0, gain, 0.5)]
    found, of_within, taken = evidences
    exact = SimpleNamespace(fit=None, misses=misses, weighed=lambda: found)
    monkeypatch.setattr(weighing, "Stand", SimpleNamespace(exact=lambda fit: exact, loose=lambda fit: "loose"))
    monkeypatch.setattr(weighing, "loops_miss", lambda fit: lost)
    monkeypatch.setattr(weighing, "_both", lambda found, stand: Both(found, of_within))
    monkeypatch.setattr(weighing, "settled", lambda stand, noise: ("within", of_within))
    monkeypatch.setattr(weighing, "stepped", lambda stand, found: (stand, taken))
    one = weighed(None)  # type: ignore[arg-type]
    assert (one.both.exact is taken) == uphill
    assert one.within == ("loose" if lost else "within")


@pytest.mark.slow
def test_a_model_file_within_its_tolerances_is_no_gap_and_the_result_says_what_was_moved(built):
    found = explain(read_model(built / "model.toml"), read_campaign([built / "campaign.toml"]), {name: CATALOGUE[name] for name in FEW})
    assert found.verdict == "no-gap"
    assert "stop-stiffness" in [effect.name for effect, _ in found.within]
    assert max(size for _, size in found.within) < 3.0
    assert found.over_noise(found.as_given) > 3.0 * found.over_noise(found.before)


@pytest.mark.slow
def test_stops_that_are_off_by_a_factor_of_two_are_no_missing_effect(campaign):
    damping = read_model(RIG).end_stop.damping_N_s_per_m
    folder = campaign((StopStiffness(np.exp(-0.5) - 1.0), EndStopDissipation((np.exp(0.69) - 1.0) * damping)), 886, deployments=({},) * 3)
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]), {name: CATALOGUE[name] for name in FEW})
    assert found.verdict == "no-gap"
    sizes = {effect.name: size for effect, size in found.within}
    assert sizes["end-stop-dissipation"] == pytest.approx(0.69 / 0.3, abs=0.8)


@pytest.mark.slow
def test_a_friction_beside_such_errors_is_still_named(campaign):
    folder = campaign((*as_built(881), ViscousFriction(0.0728 + 0.05)), 881, deployments=({},))
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]), {name: CATALOGUE[name] for name in FEW})
    assert [one.name for one in found.findings] == ["viscous-friction"]
    assert found.findings[0].ci95[0][0] <= 0.0728 + 0.05 <= found.findings[0].ci95[0][1]


def test_an_effect_of_which_two_numbers_do_the_same_has_a_prior_for_each(fitted, built):
    """However large one is beside the other: neither is sure."""
    fit = fitted(built)
    problem = fit.problem.with_another(StribeckFriction())
    first, count = problem.first_effect, len(problem.rows_of("stribeck-friction"))
    chance, twice = np.random.default_rng(3), fit.jacobian[: fit.problem.measured, 0]
    for _ in range(20):
        jacobian = np.zeros((len(fit.gaps), first + count))
        jacobian[:, :first] = fit.jacobian[:, :first]
        jacobian[: len(twice), first:] = twice[:, None] * 10.0 ** chance.uniform(0.0, 5.0, count) * chance.normal(size=count)
        q = np.concatenate([fit.q[:first], np.ones(count)])
        assert np.all(Stand.exact(Fit(problem, q, fit.gaps, jacobian, True)).columns.spread > 0.0)
