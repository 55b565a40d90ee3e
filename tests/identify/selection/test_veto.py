"""What a run that took no part says against a name: integrated over all that the fits leave open, so that chance is no veto."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.criteria import GAP_P
from identify.selection.explain import _before_any_name, explain
from identify.selection.hypotheses import BUDGETS
from simulate.effects import CATALOGUE, ViscousFriction
from simulate.files.model_file import read_model

FEW = {name: CATALOGUE[name] for name in ("viscous-friction", "scale-error")}
LOOPS = (1.0, 0.03), (3.0, 0.03)


@pytest.fixture
def explained(campaign):
    """What acts in the runs that take part, and what in the one held out, explained."""

    def ask(acts, acts_in_held_out):
        folders = [campaign(hidden, seed, loops=LOOPS, loop_steps=4000) for seed, hidden in ((61, acts), (62, acts_in_held_out))]
        runs, others = (read_campaign([folder / "campaign.toml"]) for folder in folders)
        strange = next(run for run in others if run.hold_out)
        runs = [replace(run, table=strange.table) if run.hold_out else run for run in runs]
        return explain(read_model(folders[0] / "model.toml"), runs, FEW, budget=BUDGETS["quick"])

    return ask


@pytest.mark.slow
def test_a_friction_that_was_gone_in_the_run_held_out_is_not_named(explained):
    found = explained(ViscousFriction(0.5), None)
    assert found.verdict == "unknown"
    assert found.vetoed == ("viscous-friction",)
    assert found.held[0].lead < np.log(GAP_P)


@pytest.mark.slow
def test_a_run_with_the_same_friction_speaks_for_it_but_were_its_gap_to_grow_it_would_not_be_named_alone(explained, monkeypatch):
    monkeypatch.setattr("identify.gap.comparison.Held.grows", True)
    found = explained(ViscousFriction(0.5), ViscousFriction(0.5))
    assert [finding.name for finding in found.findings] == ["viscous-friction"]
    assert found.verdict == "class"
    assert found.held[0].lead > -np.log(GAP_P)


@pytest.mark.slow
def test_a_friction_that_only_the_run_held_out_has_is_no_absence_of_a_gap(explained):
    found = explained(None, ViscousFriction(0.5))
    assert (found.verdict, found.missed, found.findings, found.drafted) == ("unknown", True, (), None)
    assert found.held[0].left > 2.0


@pytest.mark.slow
def test_a_friction_that_is_stronger_in_the_run_held_out_is_a_part_only(explained):
    found = explained(ViscousFriction(0.5), ViscousFriction(0.8))
    assert (found.verdict, found.missed, found.drafted) == ("partly", True, None)
    assert [finding.name for finding in found.findings] == ["viscous-friction"]


@pytest.mark.slow
def test_a_run_held_out_that_what_is_open_can_meet_is_no_gap(explained, monkeypatch):
    """Were it left with more: law, release and tolerances are known from the other runs, but not exactly."""
    monkeypatch.setattr("identify.gap.comparison.Held.misses", True)
    found = explained(None, None)
    assert (found.verdict, found.missed) == ("no-gap", False)


@pytest.mark.slow
@pytest.mark.parametrize(("lead", "verdict", "vetoed"), [(-0.1, "no-gap", ("viscous-friction",)), (0.1, "class", ())])
def test_beside_a_name_that_may_be_nothing_a_run_held_out_decides(explained, monkeypatch, lead, verdict, vetoed):
    """Were the weight of nothing more than 0.05, and the run held out a little less or more probable with the name."""
    monkeypatch.setattr("identify.selection.verdict.may_be_nothing", lambda listed: True)
    monkeypatch.setattr("identify.selection.explain._lead", lambda *of: lead)
    monkeypatch.setattr("identify.gap.comparison.Held.misses", False)
    found = explained(ViscousFriction(0.5), ViscousFriction(0.5))
    assert (found.verdict, found.vetoed) == (verdict, vetoed)
    assert found.held[0].lead == lead


@pytest.mark.parametrize(("leaves_noise", "squares", "says_squares"), [(True, 0.976, False), (False, 0.976, True), (False, 0.984, False)])
def test_where_tolerances_leave_noise_an_exact_model_file_that_drags_the_release_is_not_what_is_said(leaves_noise, squares, says_squares):
    """After a veto the answer began with a release moved by 19 spreads: least squares left 0.976, the fit within tolerances 0.98."""
    exact: Any = SimpleNamespace(rms=squares)
    nothing: Any = SimpleNamespace(fit=SimpleNamespace(rms=0.98), leaves_noise=leaves_noise)
    assert _before_any_name(nothing, exact) is (exact if says_squares else nothing.fit)
