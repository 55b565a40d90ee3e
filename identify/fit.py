"""Least squares over a problem's knobs, and what a fit is worth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from measure.tables import Array

from .loops import effective_number
from .problem import Block, Problem

_TOLERANCE = 1e-5


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


def solve(problem: Problem, start: Array | None = None, *, most_steps: int = 25) -> Fit:
    """Find the knobs with the least sum of squares, within their bounds (trust region reflective, scipy).

    Parameters
    ----------
    start : knobs to start from; by default the model file's values.
    most_steps : bound on the number of evaluations.
    """
    knobs = problem.knobs
    low, high = (np.array([getattr(k, side) for k in knobs]) for side in ("low", "high"))
    q0 = np.zeros(len(knobs)) if start is None else np.asarray(start, dtype=float)
    inside = np.minimum(1e-3, 0.25 * (high - low))
    q0 = np.clip(q0, low + inside, high - inside)
    found = least_squares(
        problem.gaps,
        q0,
        jac=lambda q: problem.jacobian(q)[1],  # type: ignore[arg-type]
        bounds=(low, high),
        x_scale=1.0,
        ftol=_TOLERANCE,
        xtol=1e-7,
        gtol=1e-9,
        max_nfev=most_steps,
    )
    return Fit(problem, found.x, found.fun, np.asarray(found.jac), found.status > 0)
