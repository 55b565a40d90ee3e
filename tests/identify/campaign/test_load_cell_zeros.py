"""Loops whose load cell was set to zero for each anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.load_cell_zeros import drifts_of, zeros_of
from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.criteria import GAP_P
from identify.estimation.horizons import solve_from_afar
from identify.gap.gap_test import gap_test
from identify.selection.explain import explain
from identify.selection.hypotheses import BUDGETS
from measure.tables.loop import Loop
from simulate.effects import CATALOGUE, HubInertia, ViscousFriction
from simulate.files.model_file import read_model

FEW = {
    name: CATALOGUE[name] for name in ("hub-inertia", "leg-mass", "viscous-friction", "power-law-friction", "platform-mass", "force-offset")
}


def zeroed_anew(folder, sigma_N=0.01, drift_N_per_s=0.0):
    """The model and the runs of a campaign, each loop off by a force of its own that drifts; and these forces at mid-record."""
    chance, zeros, runs = np.random.default_rng(8), {}, []
    for run in read_campaign([folder / "campaign.toml"]):
        if isinstance(run.table, Loop):
            zeros[run.name] = float(chance.normal(0.0, sigma_N))
            zero = zeros[run.name] + drift_N_per_s * (run.table.time_s - run.table.time_s.mean())
            run = replace(run, table=replace(run.table, force_N=run.table.force_N + zero))
        runs.append(run)
    return read_model(folder / "model.toml"), runs, zeros


@pytest.mark.slow
def test_loops_alone_with_zeros_of_their_own_still_name_a_friction(campaign):
    model, runs, zeros = zeroed_anew(campaign(ViscousFriction(0.0728 + 0.02), 820, deployments=()))
    assert explain(model, runs, FEW, tare="common").verdict in ("unknown", "partly")
    found = explain(model, runs, FEW)
    assert found.verdict in ("named", "class")
    assert "viscous-friction" in (found.findings[0].name, *found.findings[0].equivalents)
    given = zeros_of(found.after)
    errors = np.array([given[name] - zeros[name] for name in zeros])
    assert np.abs(errors - errors.mean()).max() < 1e-3


def test_a_zero_and_its_drift_are_not_read_as_the_force_with_which_a_loop_starts(campaign):
    model, runs, zeros = zeroed_anew(campaign(None, 823, deployments=()), sigma_N=0.05, drift_N_per_s=2e-3)
    fit = solve_from_afar(problem_of(model, runs, own_zeros=True))
    assert gap_test(fit).p_value > GAP_P
    assert fit.rms == pytest.approx(1.0, abs=0.05)
    given = zeros_of(fit)
    errors = np.array([given[name] - zeros[name] for name in zeros])
    assert np.abs(errors - errors.mean()).max() < 1e-3
    slow = min(fit.problem.loops, key=lambda loop: loop.data.frequency_Hz).run.name
    assert drifts_of(fit)[slow] == pytest.approx(2e-3, rel=0.1)


@pytest.mark.slow
def test_common_zeros_stay_common(campaign):
    folder = campaign(ViscousFriction(0.0728 + 0.02), 821, deployments=())
    found = explain(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]), FEW)
    assert found.verdict in ("named", "class")
    assert zeros_of(found.after) == {}


@pytest.mark.slow
def test_with_a_deployment_too_an_inertia_is_named(campaign):
    model, runs, zeros = zeroed_anew(campaign(HubInertia(0.746 + 0.01), 822, deployments=({},)), drift_N_per_s=1e-3)
    found = explain(model, runs, FEW, budget=BUDGETS["quick"])
    assert found.verdict in ("named", "class")
    assert "hub-inertia" in (found.findings[0].name, *found.findings[0].equivalents)
    given = zeros_of(found.after)
    errors = np.array([given[name] - zeros[name] for name in zeros])
    assert np.abs(errors - errors.mean()).max() < 1e-3
    assert np.abs(errors).max() < 5e-3
