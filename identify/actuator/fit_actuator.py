"""The force law's parameters from loops: one least-squares fit of all samples of all loops, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.actuator.beta_profile import Profile, is_open, profile_of_beta
from identify.actuator.layout import BETA_NAME, Abscissa, Layout, layout
from identify.actuator.loop_problem import LoopProblem, beta_bounds, minimise, require_turns
from identify.actuator.verdict import Verdict, verdict_of
from identify.estimation.covariance import (
    BetaDoubt,
    Estimate,
    clipped,
    covariance_of,
    covariance_of_motion,
    estimates_of,
    jacobians,
)
from identify.loops.covariates import shares
from identify.loops.loop_data import LoopData, effective_number, with_turns_moved
from identify.loops.paper_recipe import Recipe, paper_recipe
from identify.loops.residual_dependence import Dependence, depends_on
from measure.common.arrays import Array
from simulate.model.effect import Effect

Tare = Literal["common", "each", "auto"]


@dataclass(frozen=True)
class ActuatorFit:
    """What loops say about an actuator.

    lines : (5,) a_l, b_l, a_u, b_u, beta, in the middle of the abscissa where they depend on one.
    estimates : by the names of a model file. covariance : of `names`, in this order.
    theta, theta_covariance : the vector of the fit, see `Layout`. residuals : measured minus modelled of each loop's samples that count, N.
    effective_samples : independent samples that each loop's residual is worth. tares_N : what was taken off the force of
    each loop because its level differed, zeros where nothing was. covariate_shares : of the residual, that each further
    column would explain. left : what the residual still follows.
    """

    problem: LoopProblem
    theta: Array
    theta_covariance: Array
    estimates: dict[str, Estimate]
    names: list[str]
    covariance: Array
    residuals: tuple[Array, ...]
    effective_samples: tuple[float, ...]
    tares_N: tuple[float, ...]
    covariate_shares: dict[str, float]
    left: Dependence
    recipe: Recipe | None
    verdict: Verdict

    @property
    def layout(self) -> Layout:
        """What the entries of `theta` are."""
        return self.problem.shape

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

    def profile(self) -> Profile:
        """The misfit along beta, everything else fitted anew."""
        return profile_of_beta(self.problem, self.theta, self.estimates[BETA_NAME].stderr / float(self.lines[4]))

    def lines_of(self, loop: int) -> Array:
        """a_l, b_l, a_u, b_u, beta of one of the fitted loops."""
        return self.layout.lines(self.theta, loop)


def fit_actuator(
    loops: Sequence[LoopData],
    kinds: tuple[type[Effect], ...] = (),
    abscissa: Abscissa = "none",
    order: int = 0,
    tare: Tare = "common",
    covariate: str = "",
    robust: bool = False,
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
    covariate : name of a column of all loops to which a part of the force is proportional, fitted jointly.
    robust : samples far off the model count less (soft l1 loss), against spikes.

    Raises
    ------
    InputError
        No loop turns; an effect that loops cannot show; too few frequencies for the polynomials.
    """
    require_turns(loops)
    if tare == "auto":
        alone = abscissa != "none" or bool(covariate) or len(loops) < 2
        each = None if alone else fit_actuator(loops, kinds, abscissa, order, "each", covariate, robust)
        return each if each and levels_differ(each) else fit_actuator(loops, kinds, abscissa, order, "common", covariate, robust)
    shape = layout(loops, kinds, abscissa, order, covariate)
    problem = LoopProblem(shape, tuple(loops), tare == "each", beta_bounds(loops), robust)
    theta, converged = minimise(problem)
    return _judged(problem, theta, converged)


def levels_differ(fit: ActuatorFit) -> bool:
    """Whether the tares of the loops scatter by more than three standard errors (root mean square).

    To be asked of a fit with a level for each loop: with a common one, other parameters have already bent to the levels.
    """
    errors = np.array([r.std() / np.sqrt(n) for r, n in zip(fit.residuals, fit.effective_samples, strict=True)])
    return bool(np.mean((np.array(fit.tares_N) / errors) ** 2) > 9.0)


def _judged(problem: LoopProblem, theta: Array, converged: bool) -> ActuatorFit:
    shape, loops = problem.shape, problem.loops
    residuals, free = problem.residuals(theta), problem.free(theta)
    tables = jacobians(problem.residuals, theta, *problem.bounds())
    effective = tuple(effective_number(r) for r in residuals)
    of_theta = covariance_of(tables, clipped(residuals) if problem.robust else residuals, free)
    of_motion = covariance_of_motion(tables, _turned(problem, theta, residuals), _swayed(problem, theta, residuals), free)
    of_theta += of_motion
    beta_error, by_turns = (float(np.sqrt(of[shape.line_values, shape.line_values])) for of in (of_theta, of_motion))
    doubt = BetaDoubt(by_turns, is_open(problem, theta, beta_error))
    slopes, left = shape.slopes(theta), depends_on(loops, residuals)
    estimates = estimates_of(shape, theta, of_theta, free, tables, sum(effective) - len(theta), loops, doubt)
    return ActuatorFit(
        problem=problem,
        theta=theta,
        theta_covariance=of_theta,
        estimates=estimates,
        names=shape.names(),
        covariance=slopes @ of_theta @ slopes.T,
        residuals=residuals,
        effective_samples=effective,
        tares_N=problem.tares(theta),
        covariate_shares=shares(loops, residuals, tables),
        left=left,
        recipe=paper_recipe(loops, problem.beta),
        verdict=verdict_of(shape, theta, estimates, loops, residuals, left, converged),
    )


def _turned(problem: LoopProblem, theta: Array, residuals: Sequence[Array]) -> list[Array]:
    """What one standard deviation of the turning points, all outward, does to the residuals."""
    return _changed(problem, [with_turns_moved(data, data.turns_sigma_m) for data in problem.loops], theta, residuals)


def _swayed(problem: LoopProblem, theta: Array, residuals: Sequence[Array]) -> list[Array]:
    """What each error that a loop's motion may have does to its residual, (n, k) for each loop."""
    most = max(len(data.paths_in_doubt) for data in problem.loops)
    with_error = [[replace(data, path=(*data.paths_in_doubt, *most * [data.path])[j]) for data in problem.loops] for j in range(most)]
    changes = [_changed(problem, loops, theta, residuals) for loops in with_error]
    return [np.array([change[k] for change in changes]).reshape(most, len(residual)).T for k, residual in enumerate(residuals)]


def _changed(problem: LoopProblem, loops: Sequence[LoopData], theta: Array, residuals: Sequence[Array]) -> list[Array]:
    moved = replace(problem, loops=tuple(loops)).residuals(theta)
    return [after - before for after, before in zip(moved, residuals, strict=True)]
