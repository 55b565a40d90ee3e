"""What a candidate would leave alone, whatever is known of it beforehand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.estimation.least_squares import solve
from identify.report.explained.alone import left_alone
from simulate.effects import CATALOGUE, ViscousFriction


@pytest.mark.parametrize("name", ["geometry-error", "platform-mass", "hub-inertia", "backlash"])
def test_a_candidate_leaves_no_more_than_there_was(campaign, fitted, name):
    fit = fitted(campaign(None, 81, loops=(), deployments=({},), hold_out=False))
    found: Any = SimpleNamespace(before=fit, over_noise=lambda one: one.rms)
    left = left_alone(found, fit.problem.model.effect(CATALOGUE[name]))
    assert 0.3 * fit.rms < left <= 1.0001 * fit.rms


def test_what_acts_leaves_alone_what_its_whole_fit_leaves_and_at_a_bound_as_much_more_as_it_falls_short(campaign, fitted):
    """A friction of 0.2 for 0.0728. With all gaps the other way round it would have to be negative, and ends at zero."""
    fit, known, acts = fitted(campaign(ViscousFriction(0.2), 109, deployments=())), 0.0728, 0.2
    effect = fit.problem.model.effect(ViscousFriction)
    assert effect.flat()[0] == known
    whole = solve(fit.problem.with_effects([effect]))
    found: Any = SimpleNamespace(before=fit, over_noise=lambda one: one.rms)
    assert whole.rms < 0.5 * fit.rms
    assert left_alone(found, effect) == pytest.approx(whole.rms, rel=0.01)
    turned: Any = SimpleNamespace(before=replace(fit, gaps=-fit.gaps), over_noise=lambda one: one.rms)
    short = 1.0 - known / (acts - known)
    assert left_alone(turned, effect) == pytest.approx(np.sqrt(whole.rms**2 + short**2 * (fit.rms**2 - whole.rms**2)), rel=0.02)
