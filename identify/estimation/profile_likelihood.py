"""How far a parameter can go before the rest can no longer make up for it: its profile, followed by full simulation.

An effect's time or length bends what it does to the measurements, so a standard error from straight lines may stand on the wrong
side. At both ends of the interval that they give everything else is fitted again; where the sum of squares has not risen as
it should, the end is moved until it has.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import solve
from identify.estimation.parameters import Change
from measure.common.arrays import Array

REACH = 1.96  # standard deviations to either end of a 95 % interval
_AS_IT_SHOULD = 0.03  # relative error of the way to an end
_SETTLED = 0.05  # fall of the sum of squares that is not waited for
_MOVES, _REFITS = 8, 10
_SHORTER = 0.3  # of a step that went too far
_LEAST, _MOST = 1 / 3, 2.0  # of the way, in one move
_BENT = 0.25  # of the way to an end: what parameters with a straight line never come near, and times and speeds exceed
_WIDEST = 1.5  # a standard deviation of a logarithm that is drawn
_INSIDE = 0.1  # of a bracket: no nearer to its ends


def profile_interval(fit: Fit, index: int) -> tuple[float, float]:
    """Ends of the 95 % interval of a parameter, in scales; an end that its bound cuts off is the bound.

    The sum of squares may rise by 1.96^2 times what makes a unit of it one variance, as the fit's covariance has it.
    """
    profile = Profile(fit, index)
    return profile.end(-1.0), profile.end(1.0)


@dataclass(frozen=True)
class ProfileCurve:
    """Rise of the sum of squares along one parameter, everything else fitted anew; in units in which 3.84 bounds the 95 % interval.

    values, rise : (k,). interval : where the rise crosses 3.84, or a bound; open where that is only the end of what the data can tell.
    """

    name: str
    values: Array
    rise: Array
    interval: tuple[float, float]


def profile_curve(fit: Fit, name: str, points: int = 13, reach: float = 4.0) -> ProfileCurve:
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


@dataclass(frozen=True)
class _Place:
    """All parameters with one held, the others fitted. back : (k - 1, m), the way of the others to the least squares from there.

    along : (k - 1,), how they follow where the held one moves.
    """

    q: Array
    gaps: Array
    back: Array
    along: Array

    @property
    def cost(self) -> float:
        """Sum of squares."""
        return float(self.gaps @ self.gaps)


class Profile:
    """The sum of squares along one parameter, all others fitted on from the nearest place that is known."""

    def __init__(self, fit: Fit, index: int) -> None:
        self.fit, self.index = fit, index
        self.others = np.delete(np.arange(len(fit.q)), index)
        back, along = self._ways(fit.jacobian)
        alone = fit.jacobian[:, index] + fit.jacobian[:, self.others] @ along
        self.sigma = float(np.sqrt(max(fit.covariance[index, index], 0.0)))
        self.unit = float(alone @ alone) * self.sigma**2
        self.bounds = np.array([(parameter.low, parameter.high) for parameter in fit.problem.parameters])
        self.known = [_Place(fit.q, fit.gaps, back, along)]

    def end(self, sign: float) -> float:
        """Where the profile has risen far enough, on one side."""
        here = float(self.fit.q[self.index])
        room = float(self.bounds[self.index][int(sign > 0)] - here) * sign
        way = min(REACH * self.sigma, room)
        way = self._searched(here, sign, way, room)
        at = self._nearest(here + sign * way)
        if self.fit.problem.films and self._bend(at) > _BENT:
            self._look_again(at)
            way = self._searched(here, sign, way, room)
        return here + sign * way

    def _searched(self, here: float, sign: float, way: float, room: float) -> float:
        """How far it is to where the profile has risen far enough, as the slopes that are known have it."""
        short, far = (0.0, 0.0), (np.inf, np.inf)
        for _ in range(_MOVES if self.unit > 0.0 else 0):
            risen = float(np.sqrt(max(self.rise(here + sign * way), 0.0) / self.unit)) / REACH
            if abs(risen - 1.0) < _AS_IT_SHOULD or (way == room and risen < 1.0):
                break
            short, far = ((way, risen), far) if risen < 1.0 else (short, (way, risen))
            way = min(_between(short, far), room)
        return way

    def _bend(self, at: _Place) -> float:
        """How far the gaps at a place are from where straight lines put them, in the way they go up to the end of an interval."""
        straight = self.fit.gaps + self.fit.jacobian @ (at.q - self.fit.q)
        return float(np.linalg.norm(at.gaps - straight)) / max(REACH * float(np.sqrt(self.unit)), 1e-300)

    def _look_again(self, at: _Place) -> None:
        """Work out the slopes anew at a place and fit on from there: where a local minimum bends, those of the fit mislead."""
        jacobian = self.fit.problem.jacobian(at.q, range(len(at.q)), at.gaps)[1]
        self.known.append(self._fitted_on(at.q, *self._ways(jacobian)))

    def _ways(self, jacobian: Array) -> tuple[Array, Array]:
        """The ways of the other parameters, to the least squares and along with the held one, by these slopes."""
        slopes = jacobian[:, self.others]
        back = np.linalg.pinv(slopes.T @ slopes, rcond=1e-14, hermitian=True) @ slopes.T
        return back, -back @ jacobian[:, self.index]

    def rise(self, value: float) -> float:
        """Rise of the sum of squares with the parameter held at a place, in scales."""
        if not self.fit.problem.films:
            return self._refitted(value).cost - self.fit.cost
        start = self._nearest(value)
        q = start.q.copy()
        q[self.others] += start.along * (value - q[self.index])
        q[self.index] = value
        found = self._fitted_on(np.clip(q, *self.bounds.T), start.back, start.along)
        self.known.append(found)
        return found.cost - self.fit.cost

    def _refitted(self, place: float) -> Fit:
        """Loops alone cost little: the fit itself, with the parameter held."""
        problem, parameter = self.fit.problem, self.fit.problem.parameters[self.index]
        held = Change(parameter.name, value=parameter.value(place), held=True, low=-np.inf, high=np.inf)
        start = self._nearest(place).q.copy()
        start[self.index] = place
        return solve(replace(problem, changes=(*problem.changes, held)), start, robust=self.fit.robust)

    def _nearest(self, value: float) -> _Place:
        """The known place nearest to a value; of two that are as near, the later one, which has come further down."""
        return min(reversed(self.known), key=lambda place: abs(float(place.q[self.index]) - value))

    def _fitted_on(self, q: Array, back: Array, along: Array) -> _Place:
        """The others fitted by steps of Gauss and Newton; each step tells how the slopes have changed (Broyden 1965)."""
        here, share = _Place(q, self.fit.problem.gaps(q), back, along), 1.0
        for _ in range(_REFITS):
            moved = here.q.copy()
            moved[self.others] -= share * (here.back @ here.gaps)
            moved = np.clip(moved, *self.bounds.T)
            gaps = self.fit.problem.gaps(moved)
            fallen = here.cost - float(gaps @ gaps)
            turned = _bent(here.back, (moved - here.q)[self.others], gaps - here.gaps)
            here = _Place(moved, gaps, turned, along) if fallen > 0.0 else replace(here, back=turned)
            if abs(fallen) < _SETTLED:
                break
            share = 1.0 if fallen > 0.0 else _SHORTER * share
        return here


def _bent(back: Array, step: Array, change: Array) -> Array:
    """The way back, corrected so that it leads from a change of the gaps to the step that made it, where that is no division by nothing."""
    seen = back @ change
    size = float(step @ seen)
    return back + np.outer(step - seen, step @ back) / size if size > 0.1 * float(step @ step) > 0.0 else back


def _between(short: tuple[float, float], far: tuple[float, float]) -> float:
    """The next way to try, from one that rises too little and one that rises too much, of which one may not be known yet."""
    if short[0] == 0.0 or far[0] == np.inf:
        way, risen = far if short[0] == 0.0 else short
        return way * float(np.clip(1.0 / max(risen, 1e-3), _LEAST, _MOST))
    share = (1.0 - short[1]) / (far[1] - short[1])
    return short[0] + float(np.clip(share, _INSIDE, 1.0 - _INSIDE)) * (far[0] - short[0])
