"""Intervals end where everything else, fitted again, can no longer make up for the parameter."""

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.criteria import TWO_SIDED_95
from identify.estimation.least_squares import solve
from identify.estimation.parameters import lines_of
from identify.estimation.problem import Fit
from identify.estimation.profile_likelihood import Profile
from measure import Loop
from simulate.effects import ForceRelaxation, HubInertia, StribeckFriction
from simulate.loop import loop_force

FINE = 10


def fitted(prototype, hidden) -> Fit:
    bare = replace(prototype, effects=())
    chance, runs = np.random.default_rng(7), []
    for frequency in (0.2, 1.0, 3.0):
        t, w = np.arange(600 * FINE + 1) * (3.0 / frequency / 600 / FINE), 2 * np.pi * frequency
        u, v, a = 0.1 + 0.03 * np.sin(w * t), 0.03 * w * np.cos(w * t), -0.03 * w**2 * np.sin(w * t)
        force = loop_force(lines_of(bare), t, u, v, a, 2.84, (hidden,))[::FINE] + chance.normal(0.0, 1e-3, 601)
        runs.append(Run(Loop(t[::FINE], u[::FINE] + chance.normal(0.0, 1e-6, 601), force, name=f"{frequency:g} Hz")))
    problem = problem_of(bare, runs).with_effects([hidden])
    return solve(problem, enough=1e-6)


def interval(fit: Fit, index: int) -> tuple[float, float]:
    """Both ends of the 95 % interval of a parameter, in scales."""
    profile = Profile(fit, index)
    return profile.end(-1.0), profile.end(1.0)


def risen(fit: Fit, index: int, value: float) -> float:
    """Rise of the sum of squares with one parameter held, the others fitted by scipy, in variances of that parameter."""
    start = fit.q.copy()
    start[index] = value
    held = solve(fit.problem, start, free=[i for i in range(len(start)) if i != index], most_steps=60, enough=1e-6)
    others, alone = np.delete(fit.jacobian, index, axis=1), fit.jacobian[:, index]
    alone = alone - others @ np.linalg.lstsq(others, alone)[0]
    return (held.cost - fit.cost) / (float(alone @ alone) * fit.covariance[index, index])


def test_straight_parameter_has_the_interval_of_its_standard_error(prototype):
    fit = fitted(prototype, HubInertia(0.1))
    sigma = np.sqrt(fit.covariance[-1, -1])
    ends = interval(fit, len(fit.q) - 1)
    assert ends == pytest.approx((fit.q[-1] - TWO_SIDED_95 * sigma, fit.q[-1] + TWO_SIDED_95 * sigma), abs=0.05 * TWO_SIDED_95 * sigma)


BENT = [
    *((ForceRelaxation(*values), back) for values in ((4e-4, 0.15), (2.5e-4, 0.2)) for back in (1, 2)),
    (StribeckFriction(6e-4, 0.07), 1),
]


@pytest.mark.parametrize(("effect", "back"), BENT)
def test_ends_of_a_bent_parameter_are_where_a_full_fit_has_risen_as_far(prototype, effect, back):
    fit = fitted(prototype, effect)
    index = len(fit.q) - back
    low, high = interval(fit, index)
    assert [risen(fit, index, end) for end in (low, high)] == pytest.approx([TWO_SIDED_95**2] * 2, rel=0.07)
    assert abs((high - fit.q[index]) / (fit.q[index] - low) - 1.0) > 0.05  # which straight lines could not say


def test_interval_ends_at_a_bound(prototype):
    fit = fitted(prototype, HubInertia(1e-6))
    low, high = interval(fit, len(fit.q) - 1)
    assert low == pytest.approx(fit.problem.parameters[-1].low)
    assert high > fit.q[-1]
