"""Deployments side by side are those of each rig by itself, also where the moving strips have an inertia across the leg."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simulate.deployment.deploy import deploy_many, deploy_with_division, poses_beside
from simulate.effects import GravityImbalance, HubInertia, LegMass, ViscousFriction
from simulate.kernel.layout import MANY, POSE_SIZE
from simulate.kernel.model_rows import row_of, rows_of
from simulate.model.rig import EndStop


def tilted(model, **simulation):
    brief = replace(model, simulation=replace(model.simulation, **simulation))
    return replace(brief, release=replace(brief.release, theta_rad=(0.05, -0.03, 0.02), position_m=(0.002, 0.001, -0.004)))


def heavier(model, part):
    return replace(model, platform=replace(model.platform, mass_kg=model.platform.mass_kg * (1.0 + part)))


def test_rigs_with_moving_strips_of_different_mass_do_not_feel_each_other(prototype):
    rigs = [tilted(prototype, duration_s=0.2, step_s=5e-4).with_effect(LegMass(mass)) for mass in (0.02, 0.05, 0.11)]
    together = deploy_many(rigs)
    for rig, beside in zip(rigs, together, strict=True):
        (alone,) = deploy_many([rig])
        np.testing.assert_array_equal(beside.samples, alone.samples)


@pytest.mark.parametrize("effects", [(), (ViscousFriction(0.8), LegMass(0.03)), (HubInertia(2e-6), GravityImbalance(0.01))])
def test_poses_alone_are_those_with_account_of_work_but_for_rounding(prototype, effects):
    """Divided at the stops, too."""
    rig = replace(tilted(prototype, duration_s=0.7, step_s=1e-3, sample_rate_Hz=500.0), effects=effects)
    _, division = deploy_with_division(rig, 2.5e-4)
    assert division.max() > 1
    rigs = [heavier(rig, part) for part in np.linspace(0.0, 0.05, 2 * MANY + 3)]
    found = poses_beside(rigs, division)
    whole = np.stack([run.samples[:, :POSE_SIZE] for run in deploy_many(rigs, division)])
    assert np.max(np.abs(found - whole)) < 1e-10
    assert np.max(np.abs(found[0] - found[-1])) > 1e-3


def test_poses_of_equal_rigs_are_equal_whatever_stands_beside_them(prototype):
    """Slopes are differences of runs that are a hundred thousandth of a scale apart."""
    rig = tilted(prototype, duration_s=0.7, step_s=1e-3)
    _, division = deploy_with_division(rig, 2.5e-4)
    others = [heavier(rig, part) for part in np.linspace(0.01, 0.05, MANY + 1)]
    found = poses_beside([rig, *others, rig, rig], division)
    assert np.array_equal(found[-1], found[0])
    assert np.array_equal(found[-2], found[0])
    assert np.array_equal(poses_beside([others[3], rig], division), found[[4, 0]])


def test_of_a_run_that_diverges_no_poses_are_seen_from_there_on(prototype):
    rig = tilted(prototype, duration_s=0.7, step_s=1e-3)
    wild = replace(rig, end_stop=EndStop(1e9, 0.0))
    sound, lost = poses_beside([rig, wild], np.ones(0, dtype=np.int64))
    assert np.isfinite(sound).all()
    good = np.isfinite(lost).all(axis=1)
    assert 0 < good.sum() < len(good)
    assert np.isnan(lost[int(np.argmin(good)) :]).all()


def test_the_row_of_a_model_has_the_same_digits_whatever_models_stand_before_it(prototype):
    rig = tilted(prototype)
    models = [replace(heavier(rig, 0.01 * k), release=replace(rig.release, theta_rad=(0.01 * k, 0.02, -0.3))) for k in range(MANY + 5)]
    rows = rows_of(models)
    for model, row in zip(models, rows, strict=True):
        assert np.array_equal(row_of(model), row)
