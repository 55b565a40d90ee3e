"""What a result says in words."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.gap.size import NoiseOfChannel
from identify.noise.noise_model import ChannelNoise
from identify.report.sentences import (
    _by_chance,
    _by_films,
    _colour,
    _likelier,
    _opening,
    _or_nothing,
    left_sentence,
    moved_far,
    next_experiment,
    sentence,
    within_tolerances,
)
from identify.selection.explanation import Explanation
from identify.selection.verdict import Finding
from simulate.effects import (
    EndStopDissipation,
    GeometryError,
    GravityImbalance,
    PlatformMass,
    RateDependentAsymptotes,
    ReleasePose,
    StopStiffness,
)


def class_of(verdict, nothing, rivals=()) -> Any:
    """An explanation with one name, as far as its sentences ask for it."""
    found = object.__new__(Explanation)
    finding = SimpleNamespace(name="platform-mass", equivalents=rivals)
    weights = {"platform-mass": 1.0 - nothing, "no-gap": nothing}
    found.__dict__.update(verdict=verdict, weights=weights, findings=(finding,), rivals={}, next_tests=())
    return found


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ({"no-gap": 0.9, "platform-mass": 0.1}, ""),
        ({"platform-mass": 0.62, "no-gap": 0.33}, "; platform-mass would explain it too and is likelier (0.62 to 0.33), but not sure"),
        ({"unknown": 0.6, "no-gap": 0.3}, "; a force without a name would explain it too and is likelier (0.60 to 0.30), but not sure"),
        ({"geometry-error": 0.9, "no-gap": 0.02}, ""),
        ({"geometry-error": 0.98, "geometry-error + stop-stiffness": 0.01, "no-gap": 0.001}, ""),
        (
            {"platform-mass": 0.5, "no-gap": 0.2, "geometry-error": 0.2},
            "; platform-mass would explain it too and is likelier (0.50 to 0.40), but not sure",
        ),
        ({}, ""),
    ],
)
def test_where_nothing_is_not_excluded_but_less_likely_the_likelier_name_is_said(weights, said):
    """Joints that were fitted and came out within their tolerances are said with these."""
    problem = SimpleNamespace(effects=(SimpleNamespace(name="geometry-error"),))
    found: Any = SimpleNamespace(weights=weights, after=SimpleNamespace(problem=problem), vetoed=())
    assert _likelier(found) == said
    found.vetoed = ("platform-mass",)
    assert _likelier(found) == said + (", and a run held out speaks against it" if said.startswith("; platform-mass") else "")


@pytest.mark.parametrize(
    ("verdict", "nothing", "said"),
    [("class", 0.068, ", or nothing at all (0.07)"), ("class", 0.04, ""), ("named", 0.02, ""), ("partly", 0.3, "")],
)
def test_a_class_that_cannot_exclude_nothing_says_so(verdict, nothing, said):
    found = class_of(verdict, nothing)
    assert _or_nothing(found) == said
    assert (found.weight_of_nothing is None) == (not said)


@pytest.mark.parametrize(
    ("verdict", "rivals", "said"),
    [
        ("class", ("geometry-error",), "missing effect, one of a class: "),
        ("class", (), "missing effect: "),
        ("named", (), "missing effect: "),
        ("partly", (), "mainly "),
    ],
)
def test_a_class_of_one_name_is_not_said_to_be_one_of_several(verdict, rivals, said):
    assert _opening(class_of(verdict, 0.3, rivals)) == said


@pytest.mark.parametrize(
    ("rivals", "says"),
    [
        (("geometry-error",), "Measure the coordinates of the joints; that needs no further deployment."),
        (
            ("pulley-inertia", "stored-force-per-run", "geometry-error"),
            "Measure the coordinates of the joints and the stored force before each run; that needs no further deployment.",
        ),
    ],
)
def test_what_can_be_measured_without_a_deployment_is(rivals, says):
    assert next_experiment(class_of("class", 0.0, rivals)) == says


@pytest.mark.parametrize(
    ("rivals", "says"),
    [
        ((), "Add further runs like these, or others that show more of it: whether platform-mass is there at all is not sure."),
        (
            ("pulley-inertia",),
            "What may stand in the place of platform-mass (pulley-inertia) was weighed and not fitted: try a larger --budget.",
        ),
    ],
)
def test_where_only_nothing_may_stand_in_the_place_of_a_name_further_runs_are_asked_for(rivals, says):
    assert next_experiment(class_of("class", 0.3, rivals)) == says


@pytest.mark.parametrize(
    ("lags", "said"),
    [
        ([(0.1, 300), (0.4, 100)], ", correlated by 0.2 from sample to sample"),
        ([(0.1, 300), (0.2, 100)], ""),
        ([(0.5, 200), (0.62, 200)], ", correlated by 0.6 from sample to sample"),
        ([], ""),
    ],
)
def test_the_memory_of_the_noise_is_said_on_an_average_over_all_samples(lags, said):
    noise = [NoiseOfChannel("run", "z_m", 1e-4, 0.0, slice(0, count), 1.0, ChannelNoise(lag)) for lag, count in lags]
    found: Any = SimpleNamespace(noise=noise)
    assert _colour(found) == said


def unknown() -> Any:
    """An explanation with no names."""
    fit = SimpleNamespace(problem=SimpleNamespace(effects=()))
    return SimpleNamespace(
        verdict="unknown", weights={}, drafted=None, after=fit, within=(), vetoed=(), missed=False, is_open=True, noise=()
    )


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ((), ""),
        ((0.3,), ""),
        ((1.9, 0.7), "the model file is off within its tolerances: end-stop-dissipation by 1.9, stop-stiffness by 0.7 of them"),
        ((3.2,), "the model file is off beyond its tolerances: end-stop-dissipation by 3.2 of them"),
        (
            (3.2, 2.4, 0.8),
            "the model file is off beyond its tolerances: end-stop-dissipation by 3.2, stop-stiffness by 2.4 of them, "
            "and within them: platform-mass by 0.8",
        ),
    ],
)
def test_what_the_model_file_is_off_by_is_said_to_be_within_its_tolerances_or_beyond(sizes, expected):
    made = unknown()
    made.within = tuple(zip((EndStopDissipation(), StopStiffness(), PlatformMass()), sizes, strict=False))
    assert within_tolerances(made) == expected


@pytest.mark.parametrize(
    ("vetoed", "why"),
    [
        ((), "nothing in the catalogue explains it"),
        (
            ("geometry-error",),
            "what explains it best (geometry-error) makes the gap of a run held out larger than chance does, so it is not named",
        ),
    ],
)
def test_an_unknown_gap_says_why_the_likeliest_names_are_not_said(monkeypatch, vetoed, why):
    monkeypatch.setattr("identify.report.sentences.moved_far", lambda of: ())
    made = unknown()
    made.vetoed = vetoed
    assert sentence(made) == f"there is a gap, and {why}"


def test_a_run_held_out_that_is_left_with_more_than_noise_is_named_with_what_it_is_left_with(monkeypatch):
    monkeypatch.setattr("identify.report.sentences.moved_far", lambda of: ())
    made = unknown()
    made.missed, made.held = True, [SimpleNamespace(name=f"run-{k}.csv", left=left) for k, left in ((4, 1.1), (5, 2.71))]
    said = "run-5.csv, which was held out, is left with 2.7 times its noise; the other runs are left with noise only"
    assert sentence(made) == f"there is a gap: {said}"
    made.next_tests = ()
    assert "Compare how run-5.csv was made" in str(next_experiment(made))
    made.verdict = "partly"
    assert left_sentence(made) == said


def film(height_m, mass_kg):
    """A deployment in some condition."""
    geometry, platform = SimpleNamespace(stowed_height_m=height_m), SimpleNamespace(mass_kg=mass_kg)
    return SimpleNamespace(model=SimpleNamespace(geometry=geometry, platform=platform))


@pytest.mark.parametrize(
    ("verdict", "effect", "said", "further"),
    [
        ("class", ReleasePose(), True, "Hold out a deployment with ballast on the platform: release-pose has to predict it."),
        ("class", RateDependentAsymptotes(), True, "Add loops of one actuator on a shaker at two frequencies: they show rate-dependent"),
        ("named", ReleasePose(), False, "None"),
        ("class", GravityImbalance(), False, "None"),
        ("class", GeometryError(), False, "Measure the coordinates of the joints"),
    ],
)
def test_an_effect_of_many_numbers_from_films_alone_says_why_it_is_not_named_alone_and_what_would_show_it(verdict, effect, said, further):
    found = class_of(verdict, 0.0)
    finding = Finding(effect, np.empty(0), np.empty(0), (), 0.0, 0.0, 1.0)
    problem = SimpleNamespace(only_films_show=lambda effect: True, films=(film(0.25, 0.8), film(0.3, 0.8)), loops=())
    found.__dict__.update(
        findings=(finding,), after=SimpleNamespace(problem=problem), before=SimpleNamespace(problem=problem), missed=False
    )
    assert _by_films(found).endswith("it is not named alone") is said
    assert str(next_experiment(found)).startswith(further)


@pytest.mark.parametrize(("is_open", "of"), [(True, "as_given"), (False, "after")])
def test_what_was_moved_far_is_that_of_the_model_as_given_where_a_force_is_left(monkeypatch, is_open, of):
    monkeypatch.setattr("identify.report.sentences.dragged", lambda fit: (fit,))
    made = unknown()
    made.is_open, made.as_given, made.after = is_open, "as_given", "after"
    assert moved_far(made) == (of,)


@pytest.mark.parametrize(("grows", "said"), [((True,), True), ((False, True), True), ((False,), False), ((), False)])
def test_a_held_out_gap_that_grows_by_chance_is_said(grows, said):
    made = unknown()
    made.findings, made.held = ("viscous-friction",), tuple(SimpleNamespace(grows=one) for one in grows)
    assert ("no more than the fits leave open" in _by_chance(made)) is said
    made.findings = ()
    assert _by_chance(made) == ""
