"""Formulas of every kind side by side: a block that calls them run by run, and a sweep whose formulas have a branch, against the others."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from simulate import effects as known
from simulate.deployment.deploy import deploy, deploy_many
from simulate.dispatch.lane_forms import form_for_all
from simulate.model.model import Simulation
from simulate.sweeps.sweep import responses_of

SIZES: tuple[Any, ...] = (
    known.Backlash(2e-3),
    known.CurvedAsymptotes(2.0, -3.0),
    known.LegMass(0.2),
    known.JointFriction(1e-3, 2e-4),
    known.CounterweightInertia(0.7),
    known.BaseExcitation(0.5, 8.0, 0.3, (0.6, 0.48, 0.64)),
    known.SeriesPlay(1e-3),
    known.FlexibleBase(8.0, 12.0, 0.05),
)


def rigs_of(model, effects, runs):
    """Rigs that differ in everything: forces, release, mass and the size of each effect."""
    rng, rigs = np.random.default_rng(5), []
    for _ in range(runs):
        law = model.actuator.shifted(tuple(rng.uniform(-0.1, 0.1, 6)))
        release = replace(
            model.release, theta_rad=tuple(rng.normal(0.0, 0.05, 3)), angular_velocity_rad_per_s=tuple(rng.normal(0.0, 0.3, 3))
        )
        share = rng.uniform(0.5, 1.0)
        sized = tuple(kind.with_flat(type(kind)().flat() + share * (kind.flat() - type(kind)().flat())) for kind in effects)
        platform = replace(model.platform, mass_kg=rng.uniform(0.7, 0.9))
        rigs.append(replace(model, actuator=law, release=release, platform=platform, effects=sized))
    return rigs


def test_a_few_rigs_with_formulas_of_every_kind_are_each_what_it_is_alone(lopsided):
    model = replace(lopsided, simulation=Simulation(0.1, 200.0, 1e-3))
    rigs = rigs_of(model, SIZES, 3)
    for rig, beside in zip(rigs, deploy_many(rigs), strict=True):
        np.testing.assert_array_equal(beside.samples, deploy(rig).samples)


@dataclass(frozen=True)
class BranchedZone(known.TransitionZone):
    name = "branched-zone"

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        if u < 0.0:
            return -p[0]
        return -p[0] * math.exp(-u / p[1])


@dataclass(frozen=True)
class BranchedMass(known.LegMass):
    name = "branched-mass"

    @staticmethod
    def leg_mass(u, p):
        return p[0] if p[0] > 0.0 else 0.0


def test_formulas_with_a_branch_are_called_run_by_run_in_a_sweep_and_find_what_those_without_find(lopsided):
    """Each with the parameters of its own run, of which the first has two."""
    assert form_for_all(BranchedZone.leg_force, "leg_force") is None
    model = replace(lopsided, simulation=Simulation(0.06, 200.0, 1e-3))
    found, expected = (
        responses_of(rigs_of(model, effects, 3))
        for effects in ((BranchedZone(0.4, 0.08), BranchedMass(0.2)), (known.TransitionZone(0.4, 0.08), known.LegMass(0.2)))
    )
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
    assert np.ptp(found[:, 0]) > 1e-3, "the rigs differ"
