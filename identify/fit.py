"""Least squares over a problem's knobs, and what a fit is worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from measure.tables import Array

from .loops import effective_number
from .problem import Block, Problem

_TOLERANCE = 1e-5
_CLOSE = 3.0


@dataclass(frozen=True)
class Fit:
    """A problem with its knobs at the least squares: gaps (m,) in units of the noise, their Jacobian (m, k).

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

    @property
    def measured_gaps(self) -> Array:
        """The gaps of measured values, priors left out."""
        return self.gaps[: self.problem.measured]

    @property
    def rms(self) -> float:
        """Root mean square of the gap over the noise."""
        return float(np.sqrt(np.mean(self.measured_gaps**2)))

    @cached_property
    def dilution(self) -> float:
        """Samples per independent sample, one where neighbours are independent; never below one."""
        parts = [self.gaps[block.rows] for block in self.problem.blocks]
        independent = sum(effective_number(part) for part in parts if len(part))
        return max(1.0, self.problem.measured / max(independent, 1.0))

    @property
    def effective_samples(self) -> float:
        """Number of independent samples."""
        return self.problem.measured / self.dilution

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the knobs, (k, k), in scales: widened where the gap is larger than the noise or its samples hang together."""
        inverse = np.linalg.pinv(self.jacobian.T @ self.jacobian, rcond=1e-14, hermitian=True)
        return inverse * max(1.0, self.rms**2) * self.dilution

    def part(self, block: Block) -> Array:
        """The gap of one run and channel."""
        return self.gaps[block.rows]


def solve(problem: Problem, start: Array | None = None, *, free: Sequence[int] | None = None, most_steps: int = 25) -> Fit:
    """Find the knobs with the least sum of squares, within their bounds (trust region reflective, scipy).

    Parameters
    ----------
    start : knobs to start from; by default the model file's values.
    free : indices of the knobs that may move; by default all.
    most_steps : bound on the number of evaluations.
    """
    knobs = problem.knobs
    moving = np.arange(len(knobs)) if free is None else np.asarray(free, dtype=int)
    low, high = (np.array([getattr(knobs[i], side) for i in moving]) for side in ("low", "high"))
    q = np.zeros(len(knobs)) if start is None else np.array(start, dtype=float)
    if not len(moving):
        return Fit(problem, q, problem.gaps(q), np.empty((len(problem.gaps(q)), 0)), True)
    inside = np.minimum(1e-3, 0.25 * (high - low))

    def whole(part: Array) -> Array:
        filled = q.copy()
        filled[moving] = part
        return filled

    found = least_squares(
        lambda part: problem.gaps(whole(part)),
        np.clip(q[moving], low + inside, high - inside),
        jac=lambda part: problem.jacobian(whole(part), moving)[1],  # type: ignore[arg-type]
        bounds=(low, high),
        x_scale=1.0,
        ftol=_TOLERANCE,
        xtol=1e-7,
        gtol=1e-9,
        max_nfev=most_steps,
    )
    return Fit(problem, whole(found.x), found.fun, np.asarray(found.jac), found.status > 0)


def solve_from_afar(problem: Problem, start: Array | None = None) -> Fit:
    """Fit whole films at once, and, where that does not end well, up to the stops first and whole from there.

    Behind the stops errors grow, so a start that is far off can lead astray. The better of both answers is returned.
    """
    whole = solve(problem, start)
    horizon = first_stop_s(problem)
    if not problem.films or (whole.converged and whole.rms < _CLOSE) or horizon >= min(problem.until_s, _last_frame_s(problem)):
        return whole
    early = solve(problem.until(horizon), start, most_steps=12)
    return min(whole, solve(problem, early.q), key=lambda fit: fit.cost)


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
