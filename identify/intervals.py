"""How far a parameter can go before the rest can no longer make up for it: its profile, followed by full simulation.

An effect's time or length bends what it does to the measurements, so a standard error from straight lines may stand on the wrong
side. At both ends of the interval that they give everything else is fitted again; where the sum of squares has not risen as
it should, the end is moved until it has.
"""

from __future__ import annotations

import numpy as np

from .fit import Fit

REACH = 1.96  # standard deviations to either end of a 95 % interval
_AS_IT_SHOULD = 0.1  # relative error of the way to an end
_MOVES, _REFITS = 5, 6
_LEAST, _MOST = 1 / 3, 2.0  # of the way, in one move


def profile_interval(fit: Fit, index: int) -> tuple[float, float]:
    """Ends of the 95 % interval of a knob, in scales; an end that its bound cuts off is the bound.

    The sum of squares may rise by 1.96^2 times what makes a unit of it one variance, as the fit's covariance has it.
    """
    profile = _Profile(fit, index)
    return profile.end(-1.0), profile.end(1.0)


class _Profile:
    """The sum of squares along one knob, all others fitted on: by steps of Gauss and Newton with the slopes of the fit itself."""

    def __init__(self, fit: Fit, index: int) -> None:
        self.fit, self.index = fit, index
        self.others = np.delete(np.arange(len(fit.q)), index)
        slopes = fit.jacobian[:, self.others]
        self.back = np.linalg.pinv(slopes.T @ slopes, rcond=1e-14, hermitian=True) @ slopes.T
        self.along = -self.back @ fit.jacobian[:, index]
        alone = fit.jacobian[:, index] + slopes @ self.along
        self.sigma = float(np.sqrt(max(fit.covariance[index, index], 0.0)))
        self.unit = float(alone @ alone) * self.sigma**2
        self.bounds = np.array([(knob.low, knob.high) for knob in fit.problem.knobs])

    def end(self, sign: float) -> float:
        """Where the profile has risen far enough, on one side."""
        here = float(self.fit.q[self.index])
        room = float(self.bounds[self.index][int(sign > 0)] - here) * sign
        way = min(REACH * self.sigma, room)
        for _ in range(_MOVES if self.unit > 0.0 else 0):
            risen = np.sqrt(max(self._rise(here + sign * way), 0.0) / self.unit) / REACH
            further = float(np.clip(1.0 / max(risen, 1e-3), _LEAST, _MOST))
            if abs(further - 1.0) < _AS_IT_SHOULD or (way == room and further > 1.0):
                break
            way = min(way * further, room)
        return here + sign * way

    def _rise(self, value: float) -> float:
        """Rise of the sum of squares with the knob held at a value."""
        moved = value - self.fit.q[self.index]
        q = self.fit.q.copy()
        q[self.index] = value
        q[self.others] += self.along * moved
        least = np.inf
        for _ in range(_REFITS):
            q = np.clip(q, *self.bounds.T)
            gaps = self.fit.problem.gaps(q)
            cost = float(gaps @ gaps)
            if cost > least - _AS_IT_SHOULD:
                break
            least = cost
            q[self.others] -= self.back @ gaps
        return least - self.fit.cost
