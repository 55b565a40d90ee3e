"""The page of an explanation says what the result says, in words that cannot be misread."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.campaign.noiseless import AddedNoise
from identify.gap.comparison import Held
from identify.gap.platform_force import ForceAlongTime, MissingForce
from identify.report import gap_figures
from identify.report.explained.alone import candidates
from identify.report.explained.page import report_html
from identify.report.explained.story import checks
from identify.report.explained.variants import variants_of
from identify.report.gap_figures import DRAFT, EFFECT, GIVEN, REFITTED, curve_rows, figure_of, largest
from identify.report.gap_plots import missing_force_figure
from identify.report.phrases import PHRASES, phrase_of
from identify.report.result import missing_table, result_of
from identify.selection.verdict import Finding
from simulate.effects import CATALOGUE
from simulate.model.effect import LegEffect, parameter


def test_the_page_gives_every_test_its_runs(shaken):
    first, *others = shaken.next_tests
    thrice = replace(shaken, next_tests=(replace(first, runs=3), *others))
    rows = re.findall(r'<th scope="row">(a (?:deployment|loop)[^<]*)</th><td class="n">(\d+)', report_html(thrice, "loops", {}))
    assert rows == [(test.condition.words, str(test.runs)) for test in thrice.next_tests]


def test_a_force_at_one_place_is_drawn_alone_up_to_where_it_has_no_part(shaken):
    """Where only the vertical force was estimated there is one panel, from the place before to the place behind."""
    nothing, force = np.full((1, 3), np.nan), np.array([[0.18, 0.0, 0.0]])
    sigma = np.where(force > 0.0, 0.005, nothing)
    (axes,) = missing_force_figure(MissingForce(ForceAlongTime, np.array([0.2]), force, sigma, {}, 0.05)).axes
    assert axes.get_ylabel() == "missing force, N"
    assert axes.get_xlim() == pytest.approx((0.15, 0.25))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["vertical, up"]


def test_the_curve_of_a_draft_stands_in_every_figure(shaken):
    """Of runs held out, too. Here the draft is given other fits, whose curves are known."""
    held = replace(shaken, held=(Held(shaken.before, shaken.after),))
    drafted = SimpleNamespace(fit=shaken.as_given, held_with=(shaken.before,))
    rows = curve_rows(replace(held, drafted=drafted))
    assert [row.held_out for row in rows].count(True) == len(rows) // 2
    for before, row in zip(curve_rows(held), rows, strict=True):
        own = {stage.name: stage.curve for stage in row.stages}
        assert list(own) == [*(stage.name for stage in before.stages), DRAFT]
        assert np.array_equal(own[DRAFT].modelled, own[REFITTED if row.held_out else GIVEN].modelled)
        lines = [line.name for panel in figure_of(row, name="one").panels for line in panel.lines]
        assert lines.count(DRAFT) == 2


def test_the_page_says_which_tables_were_given_noise(shaken):
    assert "values without noise" not in report_html(shaken, "loops", {})
    given = replace(shaken, noise_added=(AddedNoise("run-1.csv", "z_m", 1e-5), AddedNoise("run-1.csv", "theta_y_rad", 1e-4)))
    assert "run-1.csv: values without noise, as a simulation writes them" in report_html(given, "loops", {})
    assert "(z_m 1e-05, theta_y_rad 0.0001)" in report_html(given, "loops", {})


@pytest.mark.parametrize(
    ("verdict", "headline"), [("partly", "the runs that took part are explained"), ("unknown", "a run held out has a gap")]
)
def test_a_run_held_out_that_is_left_with_more_than_noise_stands_in_headline_and_next_step(shaken, verdict, headline):
    findings = shaken.findings if verdict == "partly" else ()
    held = (Held(shaken.before, shaken.before),)
    missed = replace(shaken, verdict=verdict, missed=True, findings=findings, held=held, next_tests=(), rivals={})
    page, result = report_html(missed, "loops", {}), result_of(missed)
    assert f"{verdict}: {headline}" in page
    assert "which was held out, is left with" in page
    assert f"Compare how {missed.held[0].name} was made" in page
    assert result["gap"]["held_out"]["missed"]
    assert (result["missing_force"], missing_table(missed)) == (None, None)
    assert result_of(replace(shaken, held=missed.held))["gap"]["held_out"]["missed"] is False


@pytest.mark.parametrize(
    ("equivalents", "headline"), [((), "by far the likeliest, but films alone"), (("release-pose",), "one of a few answers")]
)
def test_the_page_says_why_an_effect_of_many_numbers_is_not_named_alone(shaken, equivalents, headline):
    (first, *_) = shaken.findings
    legs = replace(first, effect=CATALOGUE["leg-disparity"](), equivalents=equivalents, stderr=np.ones(6), ci95=np.ones((6, 2)))
    page = report_html(replace(shaken, verdict="class", findings=(legs,), next_tests=(), rivals={}), "loops", {})
    assert f"class: one effect is {headline}" in page or f"class: {headline}" in page
    assert "Films alone do not tell an effect of so many numbers from all others" in page
    assert "films alone do not tell an effect of so many" not in report_html(shaken, "loops", {}).lower()


def test_the_first_sentence_names_the_effect_its_size_in_units_of_people_and_what_it_is_worth(shaken):
    said = re.search(r'<p class="sentence">([^<]*)</p>', report_html(shaken, "loops", {}))
    assert said
    numbers = re.search(r"([\d.]+) g \(([\d.]+) to ([\d.]+) g\)", said[1])
    assert numbers
    size, low, high = map(float, numbers.groups())
    assert low < size < high
    assert size == pytest.approx(10.0, rel=0.02)
    assert "or hub-inertia" in said[1] or "or leg-mass" in said[1]
    assert "of the noise, without it to" in said[1]


def test_a_class_that_cannot_exclude_nothing_says_so_on_the_page(shaken):
    """In the sentence to be quoted as well as in the answer; a sure one says nothing of it."""
    assert shaken.verdict == "class"
    assert "nothing" not in re.findall(r'<p class="sentence">([^<]*)</p>', report_html(shaken, "loops", {}))[0]
    unsure = replace(shaken, weights={**shaken.weights, "no-gap": 0.3})
    assert "or nothing is missing at all (0.30)" in re.findall(r'<p class="sentence">([^<]*)</p>', report_html(unsure, "loops", {}))[0]


def test_the_gap_is_drawn_where_the_eye_sees_it(shaken):
    rows = curve_rows(shaken)
    first = largest(rows)
    assert first.over_noise > 0.5 * max(row.over_noise for row in rows)
    assert first.visible > 0.2, "a fifth of the measured range"
    figure = figure_of(first, name="gap")
    above, below = figure.drawn
    assert [one.name for one in above.drawn] == ["measured", GIVEN, REFITTED, EFFECT]
    assert [one.name for one in below.drawn][1:] == [GIVEN, REFITTED, EFFECT], "all on one scale"


def test_a_loop_is_drawn_from_its_own_samples(monkeypatch):
    loops = [
        SimpleNamespace(run=SimpleNamespace(name=name), data=SimpleNamespace(elongation_m=along, cycles=SimpleNamespace(reversals=())))
        for name, along in (("a", np.arange(20.0)), ("b", -np.arange(20.0)))
    ]
    blocks = [SimpleNamespace(run="a", samples=np.arange(0, 10)), SimpleNamespace(run="b", samples=np.arange(5, 12))]
    found: Any = SimpleNamespace(before=SimpleNamespace(problem=SimpleNamespace(loops=loops, blocks=blocks)))
    monkeypatch.setattr(gap_figures, "loop_curves", lambda row, elongation_mm, kept, name: elongation_mm)
    for name, expected in (("a", 1e3 * np.arange(0, 10)), ("b", -1e3 * np.arange(5, 12))):
        row: Any = SimpleNamespace(run=name, held_out=False)
        np.testing.assert_array_equal(gap_figures.any_figure(found, row, "loop"), expected)  # type: ignore[arg-type]


def test_what_a_candidate_leaves_is_exact_where_it_was_fitted_and_never_less_than_noise_where_it_does_nothing(shaken):
    found = {one.name: one for one in candidates(shaken)}
    assert len(found) == 6
    for name in ("hub-inertia", "leg-mass"):
        assert found[name].left == pytest.approx(1.0, abs=0.05)
        assert found[name].fitted
    others = [one for one in found.values() if not one.fitted]
    assert all(one.left > 3.0 for one in others), "no other candidate closes the gap of this campaign"
    assert all(one.why.startswith("excluded") for one in others)


def test_a_switched_off_effect_leaves_the_gap_that_it_closes(shaken):
    states = variants_of(shaken)
    assert list(states) == ["1", "0"]
    assert states["1"] is shaken.after
    assert shaken.over_noise(states["0"]) > 10.0


def test_the_page_says_what_was_checked(shaken):
    rows = {words: good for words, good, _ in checks(shaken)}
    assert rows["What is left is noise"]
    assert not rows["The rivals are excluded"], "a shaker cannot tell a heavy hub from heavy legs"


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE.keys())
def test_every_effect_is_told_in_a_phrase_with_its_numbers(kind):
    size = len(kind.flat_names())
    effect, sure = kind(), np.full(size, 0.1)
    finding = Finding(effect, sure, np.column_stack([effect.flat() - 0.2, effect.flat() + 0.2]), (), 0.0, 0.0, 1.0)
    assert "{" not in phrase_of(finding)
    assert kind.name in PHRASES
    assert phrase_of(finding)[0].islower()


def test_an_effect_of_ones_own_is_told_by_its_name(shaken):
    @dataclass(frozen=True)
    class Sticky(LegEffect):
        """Sticks."""

        name = "sticky"
        force_N: float = parameter(0.0, low=0.0, high=1.0, typical=0.1, doc="force")

    finding = Finding(Sticky(0.02), np.array([0.001]), np.array([[0.018, 0.022]]), (), 0.0, 0.0, 1.0)
    assert phrase_of(finding) == "the model lacks sticky: force_N = 20.0 mN (18.0 to 22.0 mN)"
