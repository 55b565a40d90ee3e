"""How exact a run is, from two runs that are made by hand; and how many runs stand side by side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simulate.deployment.deploy import _widths, step_error
from simulate.deployment.result import Deployment
from simulate.kernel.layout import ALONE, FEW, MANY, SAMPLE_ELONGATION, SAMPLE_ENERGY, SAMPLE_POSE, SAMPLE_SIZE
from simulate.model.rig import stroke_of

COUNT = 8
TIME = np.arange(COUNT) / 100.0


def run_of(model, heights, stops_from=None, elongation=0.5):
    samples = np.zeros((COUNT, SAMPLE_SIZE))
    samples[:, SAMPLE_POSE + 2], samples[:, SAMPLE_POSE + 3] = heights, 1.0
    samples[:, SAMPLE_ELONGATION : SAMPLE_ELONGATION + 6] = elongation * stroke_of(model)
    if stops_from is not None:
        samples[stops_from:, SAMPLE_ENERGY + 2] = -0.1
    return Deployment(model, TIME, samples, 1e-3, None)


HEIGHTS = np.linspace(0.25, 0.6, COUNT)


def test_a_run_is_off_by_twice_what_half_the_step_changes_in_all_and_before_the_first_stop(prototype):
    finer = HEIGHTS.copy()
    finer[2] += 1e-4
    finer[6] -= 3e-4
    found = step_error(run_of(prototype, HEIGHTS, stops_from=5), run_of(prototype, finer))
    assert found.whole["z_m"] == pytest.approx(6e-4)
    assert found.to_the_stops["z_m"] == pytest.approx(2e-4)
    assert found.whole["x_m"] == found.to_the_stops["theta_z_rad"] == 0.0
    never = step_error(run_of(prototype, HEIGHTS), run_of(prototype, finer))
    assert never.to_the_stops["z_m"] == pytest.approx(6e-4)


def test_a_stop_is_reached_by_its_work_or_by_a_leg_that_is_longer_than_its_stroke(prototype):
    finer = HEIGHTS + 1e-4
    longer = run_of(prototype, HEIGHTS)
    longer.samples[3, SAMPLE_ELONGATION + 4] = 1.001 * stroke_of(prototype)[4]
    finer[3:] += 1e-3
    assert step_error(longer, run_of(prototype, finer)).to_the_stops["z_m"] == pytest.approx(2e-4)
    at_once = step_error(run_of(prototype, HEIGHTS, stops_from=0), run_of(prototype, finer))
    assert at_once.to_the_stops["z_m"] == 0.0


def test_where_one_of_two_runs_has_no_number_the_error_is_infinite_and_where_both_have_none_it_is_that_of_the_rest(prototype):
    cut = HEIGHTS.copy()
    cut[6:] = np.nan
    assert step_error(run_of(prototype, HEIGHTS), run_of(prototype, cut)).whole["z_m"] == np.inf
    assert step_error(run_of(prototype, cut), run_of(prototype, cut)).whole["z_m"] == 0.0
    diverged = replace(run_of(prototype, cut), diverged_at_s=0.06)
    assert step_error(diverged, run_of(prototype, cut)).whole["z_m"] == np.inf


@pytest.mark.parametrize("runs", range(1, 2 * MANY + 2))
def test_every_run_stands_in_one_block_and_no_more_than_half_of_a_wide_one_is_empty(runs):
    blocks = _widths(runs)
    assert [k for _, block in blocks for k in range(block.start, block.stop)] == list(range(runs))
    for width, block in blocks:
        count = block.stop - block.start
        assert width in (ALONE, FEW, MANY)
        assert -(-count // width) * width - count < max(width // 2, 1) + (width == FEW)
        assert width != ALONE or count == 1


@pytest.mark.parametrize(("off", "fine"), [(4.9e-6, True), (5.1e-6, False)])
def test_a_run_is_fine_to_a_hundredth_of_a_millimetre(prototype, off, fine):
    assert step_error(run_of(prototype, HEIGHTS), run_of(prototype, HEIGHTS + off)).fine == fine


@pytest.mark.parametrize(("off_deg", "fine"), [(0.0049, True), (0.0051, False)])
def test_a_run_is_fine_to_a_hundredth_of_a_degree(prototype, off_deg, fine):
    turned = run_of(prototype, HEIGHTS)
    half = np.radians(off_deg) / 2.0
    turned.samples[:, SAMPLE_POSE + 3], turned.samples[:, SAMPLE_POSE + 6] = np.cos(half), np.sin(half)
    found = step_error(run_of(prototype, HEIGHTS), turned)
    assert found.fine == fine
    assert found.report["whole_run"]["theta_z_rad"] == pytest.approx(2.0 * np.radians(off_deg))
