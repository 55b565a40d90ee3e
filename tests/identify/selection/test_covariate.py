"""A further column of the loops, to which their force is proportional, beside deployments that have no such column."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.selection.explain import explain
from identify.selection.hypotheses import BUDGETS
from measure.tables.loop import Loop
from simulate.effects import CATALOGUE
from simulate.files.model_file import read_model

SHARE = 0.4  # N per bar


@pytest.fixture
def with_pressure(campaign):
    """A deployment and three loops at other pressures, as they are pushed by them."""
    folder = campaign(None, 95, loops=((1.0, 0.03), (2.0, 0.03), (3.0, 0.03)), deployments=({},), hold_out=False, loop_steps=4000)
    runs, pressure = [], iter((1.0, 1.2, 1.5))
    for run in read_campaign([folder / "campaign.toml"]):
        if isinstance(run.table, Loop):
            bar = np.full(len(run.table.time_s), next(pressure))
            run = replace(run, table=replace(run.table, force_N=run.table.force_N + SHARE * (bar - 1.23), other={"pressure_bar": bar}))
        runs.append(run)
    return read_model(folder / "model.toml"), runs


@pytest.mark.slow
def test_a_covariate_of_loops_is_fitted_beside_deployments(with_pressure):
    model, runs = with_pressure
    few = {name: CATALOGUE[name] for name in ("viscous-friction",)}
    found = explain(model, runs, few, covariate="pressure_bar", budget=BUDGETS["quick"])
    assert found.verdict == "no-gap", found.weights
    place = found.after.problem.index_of("covariate.pressure_bar")
    error = float(np.sqrt(found.after.covariance[place, place])) * found.after.problem.scales[place]
    assert found.after.q[place] * found.after.problem.scales[place] == pytest.approx(SHARE, abs=4.0 * error)
