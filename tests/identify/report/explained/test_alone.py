"""What a candidate would leave alone, whatever is known of it beforehand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from identify.report.explained.alone import left_alone
from simulate.effects import CATALOGUE


@pytest.mark.parametrize("name", ["geometry-error", "platform-mass", "hub-inertia", "backlash"])
def test_a_candidate_leaves_no_more_than_there_was(campaign, fitted, name):
    fit = fitted(campaign(None, 81, loops=(), deployments=({},), hold_out=False))
    found: Any = SimpleNamespace(before=fit, over_noise=lambda one: one.rms)
    left = left_alone(found, fit.problem.model.effect(CATALOGUE[name]))
    assert 0.3 * fit.rms < left <= 1.0001 * fit.rms
