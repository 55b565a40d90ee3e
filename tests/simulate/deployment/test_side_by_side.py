"""Deployments side by side are those of each rig by itself, also where the moving strips have an inertia across the leg."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simulate.deployment.deploy import deploy_many
from simulate.effects import LegMass


def test_rigs_with_moving_strips_of_different_mass_do_not_feel_each_other(prototype):
    brief = replace(prototype, simulation=replace(prototype.simulation, duration_s=0.2, step_s=5e-4))
    tilted = replace(brief, release=replace(brief.release, theta_rad=(0.05, -0.03, 0.02)))
    rigs = [tilted.with_effect(LegMass(mass)) for mass in (0.02, 0.05, 0.11)]
    together = deploy_many(rigs)
    for rig, beside in zip(rigs, together, strict=True):
        (alone,) = deploy_many([rig])
        np.testing.assert_array_equal(beside.samples, alone.samples)
