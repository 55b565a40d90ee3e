"""A draft of a force that no catalogue holds, from files to a formula that a run held out bears out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from board.outside import SideWind

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.draft.draft import draft
from identify.draft.drafted import Drafted
from identify.draft.effect_file import Origin, Variable
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import laid_out, solve
from identify.gap.size import NoiseOfChannel
from identify.noise.noise_model import ChannelNoise
from identify.selection.unknown_force import unnamed_forces
from identify.selection.weighing import weighed
from simulate.files.model_file import read_model


@pytest.mark.slow
def test_a_draught_from_the_side_is_drafted_with_the_arm_at_which_it_acts(campaign):
    folder = campaign(SideWind(-0.12), 811, loops=())
    model, runs = read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])
    problem = problem_of(model, [run for run in runs if not run.hold_out], "")
    apart = problem_of(model, [run for run in runs if run.hold_out], "")

    def held_out(fit):
        alone = apart.with_effects(fit.problem.effects)
        return [solve(alone, laid_out(fit, alone), free=range(alone.first_nuisance, alone.first_effect))]

    base = weighed(solve_from_afar(problem))
    found = draft(base, base.fit, unnamed_forces(base), held_out, Origin("drafted", "Made for a test.", problem.measures))
    assert found is not None
    assert found.before is not None
    assert found.after is not None
    assert (found.variable.kind, found.variable.name) == ("lateral force at an arm", "time")
    assert found.effect.flat()[-1] == pytest.approx(0.05, abs=0.01)
    assert found.before - found.after > 0.7 * (found.before - 1.0) > 0.3
    assert [one.over for one in found.noise] == pytest.approx([1.0] * len(problem.blocks), abs=0.25)


def run_with(size: float) -> Any:
    """A run held out that leaves noise of a size, in units of what its channel was taken to have."""
    gaps = size * np.random.default_rng(7).normal(size=4000)
    return SimpleNamespace(problem=SimpleNamespace(blocks=[SimpleNamespace(channel="z_m")]), part=lambda block: gaps)


def drafted_with(noise: tuple[NoiseOfChannel, ...]) -> Drafted:
    return Drafted(Variable("height", False), "F", "", run_with(1.0), (run_with(3.0),), (run_with(1.5),), noise)


def test_the_gap_of_a_run_held_out_is_measured_by_the_noise_that_the_draft_leaves():
    """Noise with a memory is half as large again as neighbouring samples show: a draft that leaves just that leaves nothing."""
    loud = NoiseOfChannel("run", "z_m", 1e-3, 0.0, slice(0, 1), 1.5, ChannelNoise(0.6))
    found = drafted_with((loud,))
    assert (found.before, found.after) == pytest.approx((2.0, 1.0), rel=0.05)
    as_measured = drafted_with(())
    assert (as_measured.before, as_measured.after) == pytest.approx((3.0, 1.5), rel=0.05)


def test_without_a_run_held_out_a_draft_has_no_gap_there():
    found = Drafted(Variable("height", False), "F", "", run_with(1.0))
    assert (found.before, found.after) == (None, None)
    assert found.carries_over
