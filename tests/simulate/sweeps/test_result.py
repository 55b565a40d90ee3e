"""What a sweep says of its runs, on responses that are made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from simulate.model import responses
from simulate.sweeps.designs import design_of
from simulate.sweeps.result import SweepResult

LETTERS = ("A", "B", "C", "D")
FULL = design_of("full", 4, None, 0)


def answers_of(theta_deg):
    rows = np.zeros((len(theta_deg), responses.COUNT))
    rows[:, [responses.THETA_Z, responses.BEFORE_STOP]] = np.radians(theta_deg)[:, None]
    rows[:, responses.DIVERGED] = np.nan
    return rows


def theta_deg(coded):
    """A response with a product of four factors, which nobody writes down."""
    return 2.0 + 40.0 * coded[:, 0] - 3.0 * coded[:, 2] + 0.5 * np.prod(coded, axis=1)


def swept(answers=None, design=FULL, letters=LETTERS, respond=theta_deg, normal=False):
    factors = [SimpleNamespace(letter=letter, key=f"key.{letter}", low=0.0, high=1.0, normal=normal) for letter in letters]
    sweep: Any = SimpleNamespace(
        design=design, factors=factors, model=SimpleNamespace(name="rig"), responses_at=lambda coded: answers_of(respond(coded))
    )
    made = answers_of(respond(design.piece(0, design.runs))) if answers is None else answers
    return SweepResult(sweep, np.array_split(made, 3), "theta_z_deg", 30.0)


def test_runs_that_failed_and_diverged_are_counted_over_all_pieces():
    made = answers_of(np.array([10.0, -31.0, 29.0, 45.0, -5.0, 0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0]))
    made[3, responses.BEFORE_STOP] = 0.0
    made[9, : responses.DIVERGED], made[9, responses.DIVERGED] = np.nan, 0.3
    made[10, responses.THETA_Z] = np.nan
    report = swept(made).report
    assert (report["runs"], report["diverged"], report["without_response"]) == (16, 1, 1)
    without = swept(answers_of(np.full(16, 29.0))).report
    assert (without["runs"], without["diverged"], without["failed_percent"], without["without_response"]) == (16, 0, 0.0, 0)


def test_fresh_runs_are_others_and_the_regression_is_off_on_them_by_what_it_leaves():
    seen = []

    def respond(coded):
        seen.append(coded)
        return theta_deg(coded)

    result = swept(respond=respond)
    fresh = result.report["fresh"]
    coded = seen[-1]
    left = 0.5 * np.prod(coded, axis=1)
    assert len(coded) == fresh["runs"] == 256
    assert np.abs(coded).max() <= 1.0
    assert len(np.unique(coded[:, 0])) == 256
    assert fresh["rms"] == pytest.approx(np.sqrt(np.mean(left**2)))
    assert fresh["largest"] == pytest.approx(np.max(np.abs(left)))
    assert fresh["rms_of_response"] == pytest.approx(np.sqrt(np.mean(theta_deg(coded) ** 2)))
    nothing = swept(respond=lambda coded: np.full(len(coded), np.nan))
    assert nothing.fresh() == {"runs": 0, "rms": None, "largest": None, "rms_of_response": None}
    assert np.isnan(nothing.report["left_over_rms"])
    # drawn from a design of draws, they are still no repetition of its runs
    design = design_of("random", 4, 256, 5)
    swept(design=design, respond=respond).fresh()
    assert not np.isin(seen[-1], design.piece(0, 256)).any()


def test_coefficients_stand_with_the_largest_first_and_without_a_share_of_the_constant():
    columns = swept().coefficient_columns()
    assert columns["name"][:4] == ["A", "C", "1", "ABCD"]
    assert columns["coefficient_deg"][:2] == pytest.approx([40.0, -3.0])
    assert columns["variability_percent"][0] == pytest.approx(100.0 * 1600.0 / (1600.0 + 9.0 + 0.25))
    assert np.isnan(columns["variability_percent"][2])


def test_the_runs_as_columns_stand_in_their_order():
    columns = swept().run_columns()
    coded = FULL.piece(0, 16)
    assert list(columns["C"]) == coded[:, 2].tolist()
    assert list(columns["theta_z_deg"]) == pytest.approx(theta_deg(coded))
    assert np.isnan(list(columns["diverged_at_s"])).all()


def test_a_result_names_three_factors_and_says_that_there_are_more():
    assert repr(swept()).endswith("theta_z_deg over A key.A, B key.B, C key.C, ...)")
    three = swept(design=design_of("full", 3, None, 0), letters="ABC", respond=lambda coded: coded[:, 0])
    assert repr(three).endswith("over A key.A, B key.B, C key.C)")
    assert "full, 8 runs, 0 diverged, 0.0 % beyond 30 deg" in repr(three)
