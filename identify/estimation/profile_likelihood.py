"""How far a parameter of loops can go before the rest can no longer make up for it: its profile.

An effect's time or length bends what it does to the measurements, so a standard error from straight lines may stand on the wrong
side. At both ends of the interval that they give everything else is fitted again; where the sum of squares has not risen as
it should, the end is moved until it has.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from identify.criteria import TWO_SIDED_95
from identify.estimation.fit import Fitted, Posed
from identify.estimation.least_squares import solve
from identify.estimation.parameters import Change
from measure.common.arrays import Array

_AS_IT_SHOULD = 0.03  # relative error of the way to an end
_MOVES = 8
_LEAST, _MOST = 1 / 3, 2.0  # of the way, in one move
_WIDEST = 1.5  # a standard deviation of a logarithm that is drawn
_INSIDE = 0.1  # of a bracket: no nearer to its ends


@dataclass(frozen=True)
class ProfileCurve:
    """Rise of the sum of squares along one parameter, everything else fitted anew; in units in which 3.84 bounds the 95 % interval.

    values, rise : (k,). interval : where the rise crosses 3.84, or a bound; open where that is only the end of what the data can tell.
    """

    name: str
    values: Array
    rise: Array
    interval: tuple[float, float]


def profile_curve(fit: Fitted[Posed], name: str, points: int = 13, reach: float = 4.0) -> ProfileCurve:
    """The profile of a parameter, at points up to `reach` standard deviations to either side of it.

    A unit of the sum of squares is what the fit's covariance makes one variance, so that the profile knows of coloured noise too, and
    shows what a covariance cannot: an interval that is not symmetric.
    """
    index = fit.problem.index_of(name)
    profile, parameter = Profile(fit, index), fit.problem.parameters[index]
    width = min(profile.sigma, _WIDEST * (parameter.start / parameter.scale if parameter.log else np.inf))
    places = float(fit.q[index]) + width * np.linspace(-reach, reach, points)
    rise = np.array([max(profile.rise(float(place)), 0.0) for place in places]) / max(profile.unit, 1e-300)
    low, high = profile.end(-1.0), profile.end(1.0)
    if parameter.log:  # its bounds are where the data end, not where the parameter does
        low, high = (-np.inf if low <= parameter.low else low), (np.inf if high >= parameter.high else high)
    ends = (parameter.value(low), parameter.value(high))
    return ProfileCurve(name, np.array([parameter.value(float(place)) for place in places]), rise, ends)


class Profile:
    """The sum of squares of loops along one parameter, everything else fitted anew at each place."""

    def __init__(self, fit: Fitted[Posed], index: int) -> None:
        self.fit, self.index = fit, index
        others = np.delete(fit.jacobian, index, axis=1)
        along = np.linalg.pinv(others.T @ others, rcond=1e-14, hermitian=True) @ (others.T @ fit.jacobian[:, index])
        alone = fit.jacobian[:, index] - others @ along
        self.sigma = float(np.sqrt(max(fit.covariance[index, index], 0.0)))
        self.unit = float(alone @ alone) * self.sigma**2

    def end(self, sign: float) -> float:
        """Where the profile has risen far enough, on one side; an end that a bound cuts off is the bound.

        The sum of squares may rise by 1.96^2 times what makes a unit of it one variance, as the fit's covariance has it.
        """
        parameter, here = self.fit.problem.parameters[self.index], float(self.fit.q[self.index])
        room = ((parameter.high if sign > 0 else parameter.low) - here) * sign
        way = min(TWO_SIDED_95 * self.sigma, room)
        short, far = (0.0, 0.0), (np.inf, np.inf)
        for _ in range(_MOVES if self.unit > 0.0 else 0):
            risen = float(np.sqrt(max(self.rise(here + sign * way), 0.0) / self.unit)) / TWO_SIDED_95
            if abs(risen - 1.0) < _AS_IT_SHOULD or (way == room and risen < 1.0):
                break
            short, far = ((way, risen), far) if risen < 1.0 else (short, (way, risen))
            way = min(_between(short, far), room)
        return here + sign * way

    def rise(self, place: float) -> float:
        """Rise of the sum of squares with the parameter held at a place, in scales."""
        problem, parameter = self.fit.problem, self.fit.problem.parameters[self.index]
        held = Change(parameter.name, value=parameter.value(place), held=True, low=-np.inf, high=np.inf)
        start = self.fit.q.copy()
        start[self.index] = place
        return solve(problem.with_changes((*problem.changes, held)), start, robust=self.fit.robust).cost - self.fit.cost


def _between(short: tuple[float, float], far: tuple[float, float]) -> float:
    """The next way to try, from one that rises too little and one that rises too much, of which one may not be known yet."""
    if short[0] == 0.0 or far[0] == np.inf:
        way, risen = far if short[0] == 0.0 else short
        return way * float(np.clip(1.0 / max(risen, 1e-3), _LEAST, _MOST))
    share = (1.0 - short[1]) / (far[1] - short[1])
    return short[0] + float(np.clip(share, _INSIDE, 1.0 - _INSIDE)) * (far[0] - short[0])
