"""Least squares over a problem's parameters, and what a fit is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from identify.estimation.covariance import clipped, sandwich, shift_of
from identify.estimation.problem import Block, Problem
from identify.loops.loop_data import effective_number
from measure.common.arrays import Array
from simulate.model.effect import Effect

ENOUGH, ROUGHLY = 0.05, 1.0  # fall of the sum of squares at which a fit stops, in units of the noise squared
NEAR = 50.0  # in units of the noise squared: two fits so close that either may turn out the deeper one
_SAME_COURSE, _SAME_PLACE = 1e-3, 0.2  # relative change of the sum of squares, and way in scales, within which a Jacobian is still good
_AT_BOUND, _OFF_BOUND = 1e-6, 1e-3  # in scales: nearer than this a parameter is at its bound, and starts so far off it
_EARLY_SPREAD = 30.0  # typical sizes
_FIRST_LEG, _NEXT_LEG, _LAST_LEG = 12, 6, 60
_NOTHING, _UNDONE = 1e-3, 1e-6  # of the noise, by a typical size of a parameter; of what the parameter does
AT_BOUND, WIDE = 1e-6, 100.0  # of the width between bounds, in scales where one is farther off than the second
_OF_LOOPS, _POLISHING, _POLISHED = 200, 12, 1e-11  # evaluations; further steps, and how long the last is, in units of the noise
_OUTLIER = 2.0  # robust standard deviations from which on a gap counts less, where asked for
_CLOSE = 1.5  # times the noise: worth being taken to the very end


@dataclass(frozen=True)
class Fit:
    """A problem with its parameters at the least squares: gaps (m,) in units of the noise, their Jacobian (m, k).

    converged : whether the solver stopped because nothing improved any more. moved : the parameters of the Jacobian's columns where
    these are not all. robust : whether gaps far off counted less. widened : further covariance (k, k), of errors that no gap shows.
    """

    problem: Problem
    q: Array
    gaps: Array
    jacobian: Array
    converged: bool
    moved: tuple[int, ...] | None = None
    robust: bool = False
    evaluations: int = 0
    widened: Array | None = None

    @property
    def cost(self) -> float:
        """Sum of squares of gaps and priors."""
        return float(self.gaps @ self.gaps)

    @cached_property
    def basis(self) -> Array:
        """Orthonormal columns (m, k) of what the parameters can do to the gaps, each parameter by its own measure."""
        norms = np.linalg.norm(self.jacobian, axis=0)
        return np.linalg.qr(self.jacobian[:, norms > 0] / norms[norms > 0])[0]

    def free_of_parameters(self, columns: Array) -> Array:
        """Columns (m, n) freed of what the parameters can do themselves: projected on what is perpendicular to that."""
        return columns - self.basis @ (self.basis.T @ columns)

    def beyond(self, first: int) -> Array:
        """What the parameters from `first` on do to the gaps, (m, k), freed of what those before them can do themselves."""
        return replace(self, jacobian=self.jacobian[:, :first]).free_of_parameters(self.jacobian[:, first:])

    def moves(self, parameter: int) -> bool:
        """Whether moving a parameter does anything to the gaps."""
        return float(np.linalg.norm(self.jacobian[:, parameter])) > _NOTHING

    def shows(self, parameter: int) -> bool:
        """Whether moving a parameter does anything to the gaps that all others together cannot undo."""
        column = self.jacobian[:, parameter]
        free = replace(self, jacobian=np.delete(self.jacobian, parameter, axis=1)).free_of_parameters(column)
        return self.moves(parameter) and float(np.linalg.norm(free)) > _UNDONE * float(np.linalg.norm(column))

    @property
    def measured_gaps(self) -> Array:
        """The gaps of measured values, priors left out."""
        return self.gaps[: self.problem.measured]

    @property
    def rms(self) -> float:
        """Root mean square of the gap over the noise."""
        return float(np.sqrt(np.mean(self.measured_gaps**2)))

    @cached_property
    def variance_inflation(self) -> float:
        """Samples per independent sample, one where neighbours are independent; never below one."""
        parts = [self.gaps[block.rows] for block in self.problem.blocks]
        independent = sum(effective_number(part) for part in parts if len(part))
        return max(1.0, self.problem.measured / max(independent, 1.0))

    @property
    def unit(self) -> float:
        """Of a sum of squares, one independent sample's worth of the noise that is left."""
        return self.variance_inflation * max(1.0, self.rms**2)

    @property
    def effective_samples(self) -> float:
        """Number of independent samples."""
        return self.problem.measured / self.variance_inflation

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters, (k, k), in scales: the sandwich, and what an error of the turning points adds."""
        gaps = clipped(self.gaps, self._rows) if self.robust else self.gaps
        known = sandwich(self.jacobian, gaps, self._rows, self.clear_of_bounds) + np.outer(self.of_turns, self.of_turns)
        moving = ~self.problem.held[self.columns]
        return (known if self.widened is None else known + self.widened) * np.outer(moving, moving)

    @cached_property
    def of_turns(self) -> Array:
        """What the parameters bend by, (k,), where all turning points of all loops are one standard deviation further out.

        A fit bends to such an error, so no gap shows it.
        """
        return shift_of(self.jacobian, self.problem.turned(self.q, self.gaps), self.clear_of_bounds)

    @cached_property
    def clear_of_bounds(self) -> NDArray[np.bool_]:
        """Which of the columns' parameters stand clear of their bounds, and are not held."""
        low, high = (bound[self.columns] for bound in self.problem.bounds)
        width = np.minimum(np.where(np.isfinite(high - low), high - low, 1.0), WIDE)
        q = self.q[self.columns]
        return (q - low > AT_BOUND * width) & (high - q > AT_BOUND * width) & ~self.problem.held[self.columns]

    def at_bounds(self) -> dict[str, str]:
        """Which parameters ran to a bound, and to which, in words: {"hub-inertia.mass_kg": "lower bound 0"}."""
        found = {}
        for k, clear in zip(self.columns, self.clear_of_bounds, strict=True):
            parameter, q = self.problem.parameters[k], float(self.q[k])
            if not clear and parameter.vary:
                side, bound = min((("lower", parameter.low), ("upper", parameter.high)), key=lambda end: abs(end[1] - q))
                found[parameter.name] = f"{side} bound {parameter.value(bound):.4g}"
        return found

    @property
    def columns(self) -> NDArray[np.intp]:
        """The parameters of the Jacobian's columns: all, or those that were left free."""
        return np.arange(len(self.q)) if self.moved is None else np.array(self.moved, dtype=np.intp)

    @property
    def _rows(self) -> list[slice]:
        return [block.rows for block in self.problem.blocks]

    def stderr(self, name: str) -> float:
        """One standard deviation of a parameter, in its own unit."""
        return float(np.sqrt(self.covariance_of([name])[0, 0]))

    def value(self, name: str) -> float:
        """A parameter in its own unit."""
        index = self.problem.index_of(name)
        return self.problem.parameters[index].value(float(self.q[index]))

    def covariance_of(self, names: Sequence[str]) -> Array:
        """Covariance of these parameters, in their own units."""
        places = [self.problem.index_of(name) for name in names]
        slopes = self.problem.slopes_at(self.q)[places]
        rows = np.searchsorted(self.columns, places)
        return self.covariance[np.ix_(rows, rows)] * np.outer(slopes, slopes)

    @cached_property
    def effective_parameters(self) -> float:
        """Number of parameters that the effects speak with, never more than they have.

        A direction of the parameters, in typical sizes, counts as far as it moves the measurements beyond what base and releases
        can do, s^2 / (1 + s^2): one that shows nothing (an axis across the camera, an angle that another makes up for) says nothing.
        """
        sizes = np.linalg.svd(self.beyond(self.problem.first_effect), compute_uv=False) ** 2
        return float(np.sum(sizes / (1.0 + sizes)))

    def part(self, block: Block) -> Array:
        """The gap of one run and channel."""
        return self.gaps[block.rows]

    def difference(self, block: Block) -> Array:
        """Measured minus modelled of one run and channel over its noise, the motion of a loop taken as exact."""
        return self._differences[block.rows]

    @cached_property
    def _differences(self) -> Array:
        return self.problem.with_exact_motion().gaps(self.q) if self.problem.loops else self.gaps


def solve(
    problem: Problem,
    start: Array | None = None,
    *,
    free: Sequence[int] | None = None,
    most_steps: int = 25,
    enough: float = ENOUGH,
    robust: bool = False,
) -> Fit:
    """Find the parameters with the least sum of squares, within their bounds (trust region reflective, scipy).

    A parameter that a user holds stays where the problem has it. Loops alone cost little and are fitted to the last digits.

    Parameters
    ----------
    start : parameters to start from; by default the problem's own start.
    free : indices of the parameters that may move; by default all.
    most_steps : bound on the number of evaluations.
    enough : a fall of the sum of squares below which it stops.
    robust : gaps far off count less (soft l1 loss), against spikes.
    """
    chosen = None if free is None else tuple(int(i) for i in free)
    moving = np.array([i for i in (range(len(problem.parameters)) if free is None else free) if not problem.held[i]], dtype=int)
    q = np.where(problem.held, problem.start, problem.start if start is None else start)
    low, high = (bound[moving] for bound in problem.bounds)
    if not len(moving):
        gaps = problem.gaps(q)
        return Fit(problem, q, gaps, np.zeros((len(gaps), len(q) if chosen is None else len(chosen))), True, chosen, robust)
    course = _Course(problem, q, moving)
    found = least_squares(
        course.gaps,
        _off_bounds(q[moving], low, high),
        jac=course.jacobian,  # type: ignore[arg-type]
        bounds=(low, high),
        **_options(problem, course, most_steps, enough, robust),
    )
    fit = Fit(problem, course.whole(found.x), found.fun, np.empty(0), found.status > 0, chosen, robust, int(found.nfev))
    jacobian = np.zeros((len(found.fun), len(fit.columns)))
    jacobian[:, np.isin(fit.columns, moving)] = found.jac if problem.films else course.fresh(found.x)
    return polished(replace(fit, jacobian=jacobian))


def _options(problem: Problem, course: _Course, most_steps: int, enough: float, robust: bool) -> dict[str, Any]:
    """Settings of the solver: as rough as asked for with films, to the last digits without."""
    if problem.films:
        made: dict[str, Any] = {
            "x_scale": 1.0,
            "ftol": enough / max(problem.measured, 1),
            "xtol": 1e-7,
            "gtol": 1e-9,
            "max_nfev": most_steps,
        }
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


def polished(fit: Fit) -> Fit:
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
        if not size < 0.5 * last or np.any((q <= low) & (fit.q > low)) or np.any((q >= high) & (fit.q < high)):
            return fit
        gaps, jacobian = fit.problem.jacobian(q, fit.columns.tolist())
        fit, last = replace(fit, q=q, gaps=gaps, jacobian=jacobian), size
        if size < _POLISHED:
            return fit
    return fit


class _Course:
    """The way of a fit: gaps as they are asked for, and a Jacobian that is worked out again only where it may have changed."""

    def __init__(self, problem: Problem, q: Array, moving: NDArray[np.intp]) -> None:
        self.problem, self.q, self.moving, self.start = problem, q, moving, q[moving]
        self.seen: tuple[Array, Array] | None = None
        self.slopes: tuple[Array, float, Array] | None = None

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
        cost = float(here @ here)
        if self.slopes is None or not self._near(part, cost):
            self.slopes = part.copy(), cost, self.fresh(part)
        return self.slopes[2]

    def _near(self, part: Array, cost: float) -> bool:
        assert self.slopes is not None
        at, before, _ = self.slopes
        if not self.problem.films:
            return bool(np.array_equal(part, at))
        return abs(cost - before) < _SAME_COURSE * before and bool(np.max(np.abs(part - at)) < _SAME_PLACE)


def solve_from_afar(problem: Problem, start: Array | None = None, *, free: Sequence[int] | None = None, most_steps: int = 20) -> Fit:
    """Fit the films up to the stops first, then ever further, and whole at last.

    Behind the stops errors grow, so a start that is far off can lead into a wrong local minimum. What does not show yet is held
    near its start meanwhile.
    """
    q = start
    for i, horizon in enumerate(horizons(problem)):
        shorter = replace(problem.until(horizon), effect_spread=_EARLY_SPREAD)
        q = solve(shorter, q, free=free, most_steps=_FIRST_LEG if i == 0 else _NEXT_LEG, enough=ROUGHLY).q
    return to_the_end(solve(problem, q, free=free, most_steps=most_steps), free)


def to_the_end(fit: Fit, free: Sequence[int] | None = None) -> Fit:
    """A fit that is close but was cut off, carried on until nothing improves any more."""
    if fit.converged or fit.rms >= _CLOSE:
        return fit
    return solve(fit.problem, fit.q, free=free, most_steps=_LAST_LEG)


def refitted(fit: Fit, effects: Sequence[Effect]) -> Fit:
    """The same measurements with some of the effects that a fit has, fitted from where it stands."""
    problem = fit.problem.with_effects(effects)
    return solve(problem, laid_out(fit, problem))


def laid_out(fit: Fit, other: Problem) -> Array:
    """The parameters of a fit, by their names, for another problem of the same model; unknown ones (releases of other runs) are zero."""
    known = {parameter.name: parameter.shift(float(q)) for parameter, q in zip(fit.problem.parameters, fit.q, strict=True)}
    return np.array([parameter.place_of_shift(known.get(parameter.name, 0.0)) for parameter in other.parameters])


def bic_penalty(problem: Problem) -> float:
    """What a parameter costs by the BIC, samples taken as independent: for fits that leave little but noise."""
    return float(np.log(problem.measured))


def bic(fit: Fit) -> float:
    """Sum of squares and the price of the parameters: of base and releases all, of effects those that speak."""
    return fit.cost + (fit.problem.first_effect + fit.effective_parameters) * bic_penalty(fit.problem)


def horizons(problem: Problem) -> list[float]:
    """Times up to which the films are fitted one after the other: the first stop, and on in thirds of what is behind it, s."""
    stop = first_stop_s(problem)
    if not problem.films or stop >= min(problem.until_s, _last_frame_s(problem)):
        return []
    return [stop + part * (_last_frame_s(problem) - stop) for part in (0.0, 1 / 3, 2 / 3)]


def before_the_stops(problem: Problem) -> Problem:
    """The films cut where the first of them reaches the stops; the same problem where none does."""
    found = horizons(problem)
    return problem.until(found[0]) if found else problem


def _last_frame_s(problem: Problem) -> float:
    return max(float(film.time_s[-1]) for film in problem.films)


def first_stop_s(problem: Problem) -> float:
    """When the first film reaches 98 % of the deployed height, s; infinite where no elevation was seen or it never did."""
    times = [np.inf]
    for film in problem.films:
        if "z_m" not in film.channels or film.model.geometry is None:
            continue
        geometry = film.model.geometry
        height = geometry.stowed_height_m + 0.98 * (geometry.deployed_height_m - geometry.stowed_height_m)
        up = np.flatnonzero(film.values[film.channels.index("z_m")] >= height)
        times += [float(film.time_s[up[0]])] if len(up) else []
    return min(times)
