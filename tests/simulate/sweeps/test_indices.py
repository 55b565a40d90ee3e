"""Sensitivity indices against functions whose indices are known."""

import sys

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.sweeps.designs import design_of
from simulate.sweeps.indices import indices_of, levels_of, runs_of

pytest.importorskip("SALib")


def ishigami(x):
    """Of levels from -1 to 1, which stand for -pi to pi."""
    a, b, c = (np.pi * x).T
    return np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)


def test_sobol_indices_of_ishigamis_function_hold_its_closed_form_in_their_intervals():
    # Ishigami and Homma 1990, a = 7, b = 0.1
    exact = {"first_order": (0.31391, 0.44241, 0.0), "total": (0.55759, 0.44241, 0.24368)}
    levels = levels_of("saltelli", 5 * 2048, 3, 3)
    found = indices_of("saltelli", "ABC", levels, ishigami(levels))
    for name, values in exact.items():
        for letter, value in zip("ABC", values, strict=True):
            row = found["indices"][name][letter]
            assert row["value"] == pytest.approx(value, abs=0.05)
            low, high = row["interval"]
            assert low - 0.01 < value < high + 0.01


def test_intervals_narrow_as_the_runs_grow_and_the_last_step_is_the_result():
    levels = levels_of("saltelli", 5 * 1024, 3, 0)
    found = indices_of("saltelli", "ABC", levels, ishigami(levels))
    widths = [np.ptp(step["indices"]["total"]["A"]["interval"]) for step in found["convergence"]]
    assert widths[0] > 2 * widths[-1]
    assert found["convergence"][-1] == {"runs": 5 * 1024, "indices": found["indices"]}


def test_of_a_product_of_signs_the_indices_are_the_shares_of_its_walsh_coefficients():
    coefficients = {(0,): 3.0, (1,): -2.0, (0, 2): 1.0, (0, 1, 3): 0.5}
    levels = levels_of("saltelli", 6 * 4096, 4, 1)
    signs = np.sign(levels)
    values = np.sum([size * np.prod(signs[:, list(places)], axis=1) for places, size in coefficients.items()], axis=0)
    found = indices_of("saltelli", "ABCD", levels, values)["indices"]
    whole = sum(size**2 for size in coefficients.values())
    for i, letter in enumerate("ABCD"):
        total = sum(size**2 for places, size in coefficients.items() if i in places) / whole
        alone = coefficients.get((i,), 0.0) ** 2 / whole
        assert found["total"][letter]["value"] == pytest.approx(total, abs=0.03)
        assert found["first_order"][letter]["value"] == pytest.approx(alone, abs=0.05)


def test_morris_finds_the_slopes_of_a_plane_exactly_and_no_spread():
    levels = levels_of("morris", 4 * 16, 3, 0)
    found = indices_of("morris", "ABC", levels, levels @ (2.0, -1.0, 0.0))["indices"]
    # per range of a factor, which is from -1 to 1
    assert [found["mean"][letter]["value"] for letter in "ABC"] == pytest.approx([4.0, -2.0, 0.0], abs=1e-9)
    assert [found["mean_size"][letter]["value"] for letter in "ABC"] == pytest.approx([4.0, 2.0, 0.0], abs=1e-9)
    assert max(found["spread"][letter]["value"] for letter in "ABC") < 1e-9


@pytest.mark.parametrize("kind", ["saltelli", "morris"])
def test_a_run_without_a_response_takes_its_block_with_it_and_no_more(kind):
    runs = runs_of(kind, 3, 200)
    levels = levels_of(kind, runs, 3, 0)
    values = ishigami(levels)
    values[7] = np.nan
    found = indices_of(kind, "ABC", levels, values)
    assert found["left_out"] == 1
    assert found["blocks"] == runs // (5 if kind == "saltelli" else 4) - 1
    assert np.isfinite(found["indices"]["total" if kind == "saltelli" else "mean_size"]["A"]["value"])


def test_a_response_that_does_not_vary_has_no_indices():
    levels = levels_of("saltelli", 5 * 16, 3, 0)
    assert indices_of("saltelli", "ABC", levels, np.ones(len(levels)))["indices"] is None


@pytest.mark.parametrize(("kind", "asked", "given"), [("saltelli", 1000, 5 * 128), ("saltelli", None, 5 * 512), ("morris", 99, 96)])
def test_runs_come_in_whole_blocks(kind, asked, given):
    assert runs_of(kind, 3, asked) == given
    design = design_of(kind, 3, asked, 0)
    assert design.runs == given
    np.testing.assert_array_equal(np.vstack([design.piece(0, 10), design.piece(10, given)]), levels_of(kind, given, 3, 0))


def test_walks_go_to_the_ends_of_a_range_and_of_a_normal_spread_to_where_95_percent_lie():
    levels = design_of("morris", 2, 300, 0, normal=(1,)).piece(0, 300)
    assert np.abs(levels).max(axis=0) == pytest.approx([1.0, 1.959964], abs=1e-6)


def test_too_few_runs_and_a_library_that_is_not_there_are_said(monkeypatch):
    with pytest.raises(InputError, match="at least 40 in all"):
        runs_of("saltelli", 3, 20)
    monkeypatch.setitem(sys.modules, "SALib", None)
    monkeypatch.setattr("simulate.sweeps.indices.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"unspool\[indices\]"):
        runs_of("saltelli", 3, None)
