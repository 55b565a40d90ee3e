"""Least squares over a problem's parameters, and what a fit is worth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

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
_CLOSE = 1.5  # times the noise: worth being taken to the very end


@dataclass(frozen=True)
class Fit:
    """A problem with its parameters at the least squares: gaps (m,) in units of the noise, their Jacobian (m, k).

    converged : whether the solver stopped because nothing improved any more.
    """

    problem: Problem
    q: Array
    gaps: Array
    jacobian: Array
    converged: bool

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
        """Covariance of the parameters, (k, k), in scales.

            H^-1 (sum over runs and channels of d J'J) H^-1,   H the whole J'J

        Each run and channel speaks with its own noise: d is its samples per independent sample times its mean square, where
        that is above one, so that a film with slow tracking errors does not lend its sureness to an effect.
        """
        inverse = np.linalg.pinv(self.jacobian.T @ self.jacobian, rcond=1e-14, hermitian=True)
        rows = np.ones(len(self.gaps))
        for block in self.problem.blocks:
            part = self.part(block)
            if len(part):
                own = len(part) / effective_number(part)
                rows[block.rows] = max(1.0, own) * max(1.0, float(np.mean(part**2)))
        weighted = self.jacobian.T @ (self.jacobian * rows[:, None])
        return inverse @ weighted @ inverse

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
    problem: Problem, start: Array | None = None, *, free: Sequence[int] | None = None, most_steps: int = 25, enough: float = ENOUGH
) -> Fit:
    """Find the parameters with the least sum of squares, within their bounds (trust region reflective, scipy).

    Parameters
    ----------
    start : parameters to start from; by default the model file's values.
    free : indices of the parameters that may move; by default all.
    most_steps : bound on the number of evaluations.
    enough : a fall of the sum of squares below which it stops.
    """
    parameters = problem.parameters
    moving = np.arange(len(parameters)) if free is None else np.asarray(free, dtype=int)
    low, high = (np.array([getattr(parameters[i], side) for i in moving]) for side in ("low", "high"))
    q = np.zeros(len(parameters)) if start is None else np.array(start, dtype=float)
    if not len(moving):
        return Fit(problem, q, problem.gaps(q), np.empty((len(problem.gaps(q)), 0)), True)
    inside = np.minimum(_OFF_BOUND, 0.25 * (high - low))
    begun = q[moving]
    begun = np.where(begun < low + _AT_BOUND, low + inside, np.where(begun > high - _AT_BOUND, high - inside, begun))

    def whole(part: Array) -> Array:
        filled = q.copy()
        filled[moving] = part
        return filled

    course = _Course(problem, whole, moving)
    found = least_squares(
        course.gaps,
        begun,
        jac=course.jacobian,  # type: ignore[arg-type]
        bounds=(low, high),
        x_scale=1.0,
        ftol=enough / max(problem.measured, 1),
        xtol=1e-7,
        gtol=1e-9,
        max_nfev=most_steps,
    )
    return Fit(problem, whole(found.x), found.fun, np.asarray(found.jac), found.status > 0)


class _Course:
    """The way of a fit: gaps as they are asked for, and a Jacobian that is worked out again only where it may have changed."""

    def __init__(self, problem: Problem, whole: Callable[[Array], Array], moving: NDArray[np.intp]) -> None:
        self.problem, self.whole, self.moving = problem, whole, moving
        self.seen: tuple[Array, Array] | None = None
        self.slopes: tuple[Array, float, Array] | None = None

    def gaps(self, part: Array) -> Array:
        if self.seen is None or not np.array_equal(self.seen[0], part):
            self.seen = part.copy(), self.problem.gaps(self.whole(part))
        return self.seen[1]

    def jacobian(self, part: Array) -> Array:
        here = self.gaps(part)
        cost = float(here @ here)
        if self.slopes is None or not self._near(part, cost):
            self.slopes = part.copy(), cost, self.problem.jacobian(self.whole(part), self.moving.tolist(), here)[1]
        return self.slopes[2]

    def _near(self, part: Array, cost: float) -> bool:
        assert self.slopes is not None
        at, before, _ = self.slopes
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
    known = {parameter.name: value * parameter.scale for parameter, value in zip(fit.problem.parameters, fit.q, strict=True)}
    return np.array([known.get(parameter.name, 0.0) / parameter.scale for parameter in other.parameters])


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
