"""A force in every leg that has no name: seen where it is, and not where it is not."""

from __future__ import annotations

import numpy as np
import pytest
from board.outside import CoilRipple

from identify.gap.leg_force import ForceAlongElongation
from identify.selection.unknown_force import unnamed_forces
from identify.selection.weighing import weighed


@pytest.mark.slow
def test_a_ripple_too_quick_for_slow_against_fast_is_seen(campaign, fitted):
    """By loops and by a film, each alone."""
    by_film = {"loops": (), "deployments": ({},), "hold_out": False}
    for size, seed, runs in ((0.004, 631, {"deployments": ()}), (0.02, 632, by_film)):
        at = weighed(fitted(campaign(CoilRipple(size), seed, **runs)))
        best = unnamed_forces(at)[0]
        assert isinstance(best.table, ForceAlongElongation)
        assert best.log_z > at.evidence.log_z + 10.0


@pytest.mark.parametrize("seed", [633, 634])
def test_noise_is_no_force_in_the_legs(campaign, fitted, seed):
    at = weighed(fitted(campaign(None, seed, loops=((1.0, 0.04), (3.0, 0.04)), deployments=())))
    assert all(one.log_z < at.evidence.log_z for one in unnamed_forces(at))


def test_the_ripple_is_drawn_as_it_was(campaign, fitted):
    """Up to what the force law can say itself, a level and a slope."""
    found = next(one.in_legs for one in unnamed_forces(weighed(fitted(campaign(CoilRipple(0.01), 639, deployments=())))) if one.in_legs)
    u = found.table.places
    known = found.sigma_N < 3.0 * np.median(found.sigma_N)
    ripple = 0.01 * np.sin(2.0 * np.pi * u / 0.06)
    level = np.linalg.lstsq(np.stack([np.ones(known.sum()), u[known]], axis=1), (found.force_N - ripple)[known], rcond=None)[0]
    off = (found.force_N - ripple)[known] - level[0] - level[1] * u[known]
    assert np.sqrt(np.mean(off**2)) < 0.002
    assert np.sqrt(np.mean(ripple[known] ** 2)) > 0.005
    assert "in every leg that goes with its elongation" in found.sentence
