"""The force law's parameters from loops: one least-squares fit of all samples of all loops, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from measure.errors import InputError
from measure.tables import Array
from simulate.effect import Effect

from .loops import LoopData, effective_number, gap, gap_and_level
from .parameters import Abscissa, Layout, layout
from .recipe import Recipe, paper_recipe
from .uncertainty import Estimate, covariance_of, estimates_of, jacobians
from .verdicts import Verdict, verdict_of

Tare = Literal["common", "each", "auto"]


@dataclass(frozen=True)
class ActuatorFit:
    """What loops say about an actuator.

    lines : (5,) a_l, b_l, a_u, b_u, beta, in the middle of the abscissa where they depend on one.
    estimates : by the names of a model file. covariance : of `names`, in this order.
    theta : the vector of the fit, see `Layout`. residuals : measured minus modelled of each loop's samples that count, N.
    effective_samples : independent samples that each loop's residual is worth. tares_N : what was taken off the force of
    each loop because its level differed, zeros where nothing was.
    """

    layout: Layout
    theta: Array
    estimates: dict[str, Estimate]
    names: list[str]
    covariance: Array
    residuals: tuple[Array, ...]
    effective_samples: tuple[float, ...]
    tares_N: tuple[float, ...]
    recipe: Recipe | None
    verdict: Verdict

    @property
    def lines(self) -> Array:
        """a_l, b_l, a_u, b_u, beta; in the middle of the abscissa where they depend on one."""
        return self.layout.middle_lines(self.theta)

    @property
    def half_height_N(self) -> float:
        """Half of upper minus lower asymptote, in the middle of the elongations and of the abscissa."""
        a_l, b_l, a_u, b_u, _ = self.lines
        return float(((a_u - a_l) * self.layout.centre_m + b_u - b_l) / 2.0)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their fitted parameters."""
        return self.layout.effects(self.theta)

    def lines_of(self, loop: int) -> Array:
        """a_l, b_l, a_u, b_u, beta of one of the fitted loops."""
        return self.layout.lines(self.theta, loop)


def fit_actuator(
    loops: Sequence[LoopData],
    kinds: tuple[type[Effect], ...] = (),
    abscissa: Abscissa = "none",
    order: int = 0,
    tare: Tare = "common",
) -> ActuatorFit:
    """Fit the law, and effects jointly with it, to every sample of every loop.

    Each loop's start force is a nuisance and is taken out exactly. The covariance takes the residual's own spectrum for the
    noise's, so that a slow residual counts as few samples for what it can be mistaken for.

    Parameters
    ----------
    loops : at least one, see `loops.prepare`.
    kinds : effects of the catalogue, or like them, that act on a leg or on the load cell.
    abscissa, order : what the asymptotes follow, and by polynomials of which order.
    tare : "common", one force level for all loops; "each", a level of its own for each loop (their mean is kept);
        "auto", each if the levels differ by more than their noise and nothing else may explain it.

    Raises
    ------
    InputError
        No loop turns; an effect that loops cannot show; too few frequencies for the polynomials.
    """
    _require_turns(loops)
    if tare == "auto":
        each = fit_actuator(loops, kinds, abscissa, order, "each") if abscissa == "none" and len(loops) > 1 else None
        return each if each and levels_differ(each) else fit_actuator(loops, kinds, abscissa, order, "common")
    problem = _Problem(layout(loops, kinds, abscissa, order), tuple(loops), tare == "each", beta_bounds(loops))
    theta, converged = _minimise(problem)
    return _judged(problem, theta, converged)


def levels_differ(fit: ActuatorFit) -> bool:
    """Whether the tares of the loops scatter by more than three standard errors (root mean square).

    To be asked of a fit with a level for each loop: with a common one, other parameters have already bent to the levels.
    """
    errors = np.array([r.std() / np.sqrt(n) for r, n in zip(fit.residuals, fit.effective_samples, strict=True)])
    return bool(np.mean((np.array(fit.tares_N) / errors) ** 2) > 9.0)


@dataclass(frozen=True)
class _Problem:
    """One least-squares problem: what is free, the loops, whether levels are, and the bounds of beta."""

    shape: Layout
    loops: tuple[LoopData, ...]
    own_levels: bool
    beta: tuple[float, float]

    def residuals(self, theta: Array) -> tuple[Array, ...]:
        """Measured minus modelled of each loop, the nuisances taken out; of the levels only their mean stays in."""
        effects = self.shape.effects(theta)
        if not self.own_levels:
            return tuple(gap(self.shape.lines(theta, k), data, effects) for k, data in enumerate(self.loops))
        found = [gap_and_level(self.shape.lines(theta, k), data, effects) for k, data in enumerate(self.loops)]
        mean = float(np.mean([level for _, level in found]))
        return tuple(r + mean for r, _ in found)

    def tares(self, theta: Array) -> tuple[float, ...]:
        """What is taken off the force of each loop."""
        if not self.own_levels:
            return (0.0,) * len(self.loops)
        effects = self.shape.effects(theta)
        levels = np.array([gap_and_level(self.shape.lines(theta, k), data, effects)[1] for k, data in enumerate(self.loops)])
        return tuple(float(x) for x in levels - levels.mean())

    def bounds(self) -> tuple[Array, Array]:
        """Lines are free; log beta and the effects keep to theirs."""
        limits = [limit for kind in self.shape.kinds for limit in kind.bounds().values()]
        n = self.shape.line_values
        low = np.concatenate([np.full(n, -np.inf), [np.log(self.beta[0])], [a for a, _ in limits]])
        return low, np.concatenate([np.full(n, np.inf), [np.log(self.beta[1])], [b for _, b in limits]])

    def free(self, theta: Array) -> NDArray[np.bool_]:
        """Which entries stand clear of their bounds."""
        low, high = self.bounds()
        width = np.where(np.isfinite(high - low), high - low, 0.0)
        return (theta - low > 1e-6 * width) & (high - theta > 1e-6 * width)


def _judged(problem: _Problem, theta: Array, converged: bool) -> ActuatorFit:
    shape, loops = problem.shape, problem.loops
    residuals, free = problem.residuals(theta), problem.free(theta)
    tables = jacobians(problem.residuals, theta, *problem.bounds())
    effective = tuple(effective_number(r) for r in residuals)
    of_theta = covariance_of(tables, residuals, free)
    slopes = shape.slopes(theta)
    estimates = estimates_of(shape, theta, of_theta, free, tables, sum(effective) - len(theta))
    return ActuatorFit(
        layout=shape,
        theta=theta,
        estimates=estimates,
        names=shape.names(),
        covariance=slopes @ of_theta @ slopes.T,
        residuals=residuals,
        effective_samples=effective,
        tares_N=problem.tares(theta),
        recipe=paper_recipe(loops, problem.beta),
        verdict=verdict_of(shape, theta, estimates, loops, residuals, converged),
    )


def _require_turns(loops: Sequence[LoopData]) -> None:
    if not loops:
        raise InputError("no loop to fit; name at least one file.")
    for data in loops:
        if not data.cycles.reversals:
            raise InputError(
                f"{data.name}: the elongation never turns, so there is no loop, only one branch. "
                "Check which column was taken for the elongation, or record at least one full cycle."
            )


def beta_bounds(loops: Sequence[LoopData]) -> tuple[float, float]:
    """Between which betas these loops can tell anything, 1/m.

    Below, the force would not come near an asymptote within the longest stroke; above, it would be there before the
    elongation's noise, or a fiftieth of a sample's way, has passed.
    """
    stroke = max(float(np.ptp(d.elongation_m[d.used])) for d in loops)
    finest = min(max(d.elongation_sigma_m, float(np.median(np.abs(np.diff(d.elongation_m[d.used])))) / 50.0) for d in loops)
    return 0.3 / stroke, max(3.0 / max(finest, 1e-9 * stroke), 100.0 / stroke)


def _start(shape: Layout, loops: Sequence[LoopData], beta: tuple[float, float]) -> Array:
    """Where the fit begins: for each of a dozen betas the lines are a linear problem; the best one is taken."""
    best, least = None, np.inf
    for log_beta in np.linspace(np.log(beta[0]), np.log(beta[1]), 14)[1:-1]:
        lines, squares = _linear_lines(loops, shape.centre_m, float(np.exp(log_beta)))
        if squares < least:
            best, least = np.append(lines, log_beta), squares
    assert best is not None
    theta = np.zeros(shape.line_values + 1)
    theta[: shape.line_values : shape.order + 1] = best[:4]
    theta[-1] = best[4]
    return np.concatenate([theta, *(kind.typical() for kind in shape.kinds)])


def _linear_lines(loops: Sequence[LoopData], centre_m: float, beta: float) -> tuple[Array, float]:
    """Least-squares a_l, level_l, a_u, level_u for a given beta, and the sum of squares; the law is linear in them."""

    def residual(values: Array) -> Array:
        a_l, level_l, a_u, level_u = values
        lines = np.array([a_l, level_l - a_l * centre_m, a_u, level_u - a_u * centre_m, beta])
        return np.concatenate([gap(lines, data) for data in loops])

    at_zero = residual(np.zeros(4))
    columns = np.stack([at_zero - residual(unit) for unit in np.eye(4)], axis=1)
    length = np.sqrt(np.sum(columns**2, axis=0)) + 1e-300
    scaled = columns / length
    values = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ at_zero, rcond=1e-12)[0] / length
    left = at_zero - columns @ values
    return values, float(left @ left)


def _minimise(problem: _Problem) -> tuple[Array, bool]:
    """Least squares by lmfit, from the best of a dozen betas; whether it has converged."""
    import lmfit

    low, high = problem.bounds()
    start = np.clip(_start(problem.shape, problem.loops, problem.beta), low, high)
    names = [f"p{k}" for k in range(len(start))]
    parameters = lmfit.Parameters()
    for name, value, least, most in zip(names, start, low, high, strict=True):
        parameters.add(name, value=float(value), min=float(least), max=float(most))

    def residual(trial: Any) -> Array:
        return np.concatenate(problem.residuals(np.array([trial[name].value for name in names])))

    options = {"x_scale": "jac", "xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 200}
    result: Any = lmfit.minimize(residual, parameters, method="least_squares", **options)
    theta = np.array([result.params[name].value for name in names])
    return theta, bool(result.success) and bool(np.all(np.isfinite(theta)))
