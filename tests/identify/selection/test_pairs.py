"""Two plain effects that one with many parameters could stand for: both are named; and one effect is not taken for two."""

from __future__ import annotations

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.selection.comparison import BUDGETS, next_effect
from identify.selection.explain import explain
from identify.selection.pairs import better_pair
from simulate.effects import CATALOGUE, CameraRoll, LegDisparity, TimeOffset
from simulate.files.model_file import read_model

RUNS = ({}, {"geometry.stowed_height_m": 0.30}, {"platform.mass_kg": 1.0}, {})


@pytest.mark.calibrate
def test_a_rolled_camera_and_a_late_clock_are_not_taken_for_unequal_legs(campaign):
    folder = campaign((CameraRoll(0.004), TimeOffset(0.0, 0.003)), 701, deployments=RUNS)
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    assert {finding.name for finding in found.findings} == {"camera-roll", "time-offset"}
    assert found.verdict == "several"


@pytest.mark.calibrate
def test_unequal_legs_are_not_taken_for_a_pair(campaign, fitted):
    legs = np.array([0.006, -0.004, 0.002, -0.005, 0.004, -0.003])
    folder = campaign(LegDisparity(tuple(legs)), 702, deployments=RUNS)
    before = fitted(folder)
    look, step = next_effect(before, CATALOGUE, BUDGETS["normal"], lambda text: None)
    assert step is not None
    assert step.best.name == "leg-disparity"
    assert better_pair(before, look, step, CATALOGUE, BUDGETS["normal"], lambda text: None) is None
