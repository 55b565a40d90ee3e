"""Least squares over a problem's parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from identify.criteria import CLOSE, ENOUGH
from identify.estimation.covariance import shift_of
from identify.estimation.fit import Fitted, P, Posed
from measure.common.arrays import Array

_PREDICTED = 0.5  # part of a change of the gaps that a Jacobian may miss and still be updated instead of being worked out again
_AT_BOUND, _OFF_BOUND = 1e-6, 1e-3  # in scales: nearer than this a parameter is at its bound, and starts so far off it
_LAST_LEG = 60
_OFF, _STILL = 0.5, 0.1  # of a spread
_OF_LOOPS, _POLISHING, _SHORTER, _POLISHED = 200, 60, 0.9, 1e-11  # evaluations; further steps, by how much each is shorter, the last one
_OUTLIER = 2.0  # robust standard deviations from which on a gap counts less, where asked for


def solve(
    problem: P,
    start: Array | None = None,
    *,
    free: Sequence[int] | None = None,
    most_steps: int = 25,
    enough: float = ENOUGH,
    robust: bool = False,
    loosely: bool = False,
) -> Fitted[P]:
    """Find the parameters with the least sum of squares, within their bounds (trust region reflective, scipy).

    A parameter that a user holds stays where the problem has it. Loops alone cost little and are fitted to the last digits.

    Parameters
    ----------
    start : parameters to start from; by default the problem's own start.
    free : indices of the parameters that may move; by default all.
    most_steps : bound on the number of evaluations.
    enough : a fall of the sum of squares below which it stops.
    robust : gaps far off count less (soft l1 loss), against spikes.
    loosely : loops too stop where the sum of squares hardly falls any more, for fits that are only compared.
    """
    chosen = None if free is None else tuple(int(i) for i in free)
    moving = np.array([i for i in (range(len(problem.parameters)) if free is None else free) if not problem.held[i]], dtype=int)
    q = np.where(problem.held, problem.start, problem.start if start is None else start)
    low, high = (bound[moving] for bound in problem.bounds)
    if not len(moving):
        gaps = problem.gaps(q)
        return Fitted(problem, q, gaps, np.zeros((len(gaps), len(q) if chosen is None else len(chosen))), True, chosen, robust)
    course = _Course(problem, q, moving)
    found = least_squares(
        course.gaps,
        _off_bounds(q[moving], low, high),
        jac=course.jacobian,  # type: ignore[arg-type]
        bounds=(low, high),
        **_options(problem, course, most_steps, enough, robust, loosely),
    )
    fit = Fitted(problem, course.whole(found.x), found.fun, np.empty(0), found.status > 0, chosen, robust, int(found.nfev))
    jacobian = np.zeros((len(found.fun), len(fit.columns)))
    jacobian[:, np.isin(fit.columns, moving)] = found.jac if loosely and problem.films else course.fresh(found.x)
    fit = replace(fit, jacobian=jacobian)
    return fit if loosely else polished(fit)


def off_the_mirror(fit: Fitted[P]) -> Fitted[P]:
    """The same fit, or a better one of the same free parameters that begins off the place where mirror images meet.

    What films do not show of their releases acts on what they show by its square. At nought nothing pulls at it: a fit from there stays.
    """
    still = [i for i in fit.columns if fit.problem.unseen[i] and abs(fit.q[i]) < _STILL]
    if not still:
        return fit
    q = fit.q.copy()
    q[still] += _OFF
    return min(fit, solve(fit.problem, q, free=fit.moved), key=lambda one: one.cost)


def _options(problem: Posed, course: _Course, most_steps: int, enough: float, robust: bool, loosely: bool) -> dict[str, Any]:
    """Settings of the solver: as rough as asked for with films, to the last digits without."""
    if problem.films:
        made: dict[str, Any] = {
            "x_scale": 1.0,
            "ftol": enough / max(problem.measured, 1),
            "xtol": 1e-7,
            "gtol": 1e-9,
            "max_nfev": most_steps,
        }
    elif loosely:
        made = {"x_scale": "jac", "ftol": 1e-6, "xtol": 1e-8, "gtol": 1e-10, "max_nfev": most_steps}
    else:
        made = {"x_scale": "jac", "ftol": 1e-12, "xtol": 1e-10, "gtol": 1e-12, "max_nfev": max(most_steps, _OF_LOOPS)}
    if robust:
        gaps = course.gaps(course.start)
        made |= {"loss": "soft_l1", "f_scale": _OUTLIER * 1.4826 * max(float(np.median(np.abs(gaps))), 1e-12)}
    return made


def _off_bounds(begun: Array, low: Array, high: Array) -> Array:
    """A start a little off the bounds that it is at, or beyond."""
    inside = np.minimum(_OFF_BOUND, 0.25 * (high - low))
    return np.where(begun < low + _AT_BOUND, low + inside, np.where(begun > high - _AT_BOUND, high - inside, begun))


def polished(fit: Fitted[P]) -> Fitted[P]:
    """The same fit of loops, at the root of J'g = 0 to the last digits: steps of Gauss and Newton, as long as they shorten."""
    if fit.problem.films or fit.robust or not fit.converged:
        return fit
    low, high = fit.problem.bounds
    last = np.inf
    for _ in range(_POLISHING):
        kept = fit.columns[fit.clear_of_bounds]
        step = shift_of(fit.jacobian, fit.gaps, fit.clear_of_bounds)[fit.clear_of_bounds]
        size = float(np.linalg.norm(fit.jacobian[:, fit.clear_of_bounds] @ step))
        q = fit.q.copy()
        q[kept] += step
        if not size < _SHORTER * last or np.any((q <= low) & (fit.q > low)) or np.any((q >= high) & (fit.q < high)):
            return fit
        gaps, jacobian = fit.problem.jacobian(q, fit.columns.tolist())
        fit, last = replace(fit, q=q, gaps=gaps, jacobian=jacobian), size
        if size < _POLISHED:
            return fit
    return fit


class _Course:
    """The way of a fit: gaps as they are asked for, and a Jacobian that is worked out again where it no longer predicts the gaps.

    Elsewhere it is updated by what a step has shown (Broyden 1965), which costs no simulation.
    """

    def __init__(self, problem: Posed, q: Array, moving: NDArray[np.intp]) -> None:
        self.problem, self.q, self.moving, self.start = problem, q, moving, q[moving]
        self.seen: tuple[Array, Array] | None = None
        self.slopes: tuple[Array, Array, Array] | None = None

    def whole(self, part: Array) -> Array:
        filled = self.q.copy()
        filled[self.moving] = part
        return filled

    def fresh(self, part: Array) -> Array:
        return self.problem.jacobian(self.whole(part), self.moving.tolist(), self.gaps(part))[1]

    def gaps(self, part: Array) -> Array:
        if self.seen is None or not np.array_equal(self.seen[0], part):
            self.seen = part.copy(), self.problem.gaps(self.whole(part))
        return self.seen[1]

    def jacobian(self, part: Array) -> Array:
        here = self.gaps(part)
        updated = None
        if self.slopes is not None and self.problem.films:
            at, before, slopes = self.slopes
            updated = updated_slopes(slopes, part - at, here - before)
        self.slopes = part.copy(), here, self.fresh(part) if updated is None else updated
        return self.slopes[2]


def updated_slopes(slopes: Array, step: Array, change: Array) -> Array | None:
    """A Jacobian (m, k) after a step (k,) that changed the gaps by (m,), by Broyden's update; None where it did not predict the change."""
    missed = change - slopes @ step
    length = float(step @ step)
    if length == 0.0:
        return slopes
    if float(missed @ missed) > _PREDICTED**2 * float(change @ change):
        return None
    return slopes + np.outer(missed, step / length)


def to_the_end(fit: Fitted[P], free: Sequence[int] | None = None) -> Fitted[P]:
    """A fit that is close but was cut off, carried on until nothing improves any more."""
    if fit.converged or fit.rms >= CLOSE:
        return fit
    return solve(fit.problem, fit.q, free=free, most_steps=_LAST_LEG)


def laid_out(fit: Fitted[Posed], other: Posed) -> Array:
    """The parameters of a fit, by their names, for another problem of the same model; unknown ones (releases of other runs) are zero."""
    known = {parameter.name: parameter.shift(float(q)) for parameter, q in zip(fit.problem.parameters, fit.q, strict=True)}
    return np.array([parameter.place_of_shift(known.get(parameter.name, 0.0)) for parameter in other.parameters])
