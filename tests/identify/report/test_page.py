"""The page of an explanation says what the result says, in words that cannot be misread."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.noiseless import AddedNoise
from identify.gap.platform_force import ForceAlongTime, MissingForce
from identify.report.gap_plots import missing_force_figure
from identify.report.page import report_html


def test_the_page_gives_every_test_its_runs(shaken):
    first, *others = shaken.next_tests
    thrice = replace(shaken, next_tests=(replace(first, runs=3), *others))
    rows = re.findall(r'<td>(a (?:deployment|loop)[^<]*)<td class="n">(\d+)', report_html(thrice, "loops", {}))
    assert rows == [(test.condition.words, str(test.runs)) for test in thrice.next_tests]


def test_a_force_at_one_place_is_drawn_alone_up_to_where_it_has_no_part(shaken):
    """Where only the vertical force was estimated there is one panel, from the place before to the place behind."""
    nothing, force = np.full((1, 3), np.nan), np.array([[0.18, 0.0, 0.0]])
    sigma = np.where(force > 0.0, 0.005, nothing)
    (axes,) = missing_force_figure(MissingForce(ForceAlongTime, np.array([0.2]), force, sigma, {}, 0.05)).axes
    assert axes.get_ylabel() == "missing force, N"
    assert axes.get_xlim() == pytest.approx((0.15, 0.25))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["vertical, up"]


def test_the_page_says_which_tables_were_given_noise(shaken):
    assert "values without noise" not in report_html(shaken, "loops", {})
    given = replace(shaken, noise_added=(AddedNoise("run-1.csv", "z_m", 1e-5), AddedNoise("run-1.csv", "theta_y_rad", 1e-4)))
    assert "run-1.csv: values without noise, as a simulation writes them" in report_html(given, "loops", {})
    assert "(z_m 1e-05, theta_y_rad 0.0001)" in report_html(given, "loops", {})
