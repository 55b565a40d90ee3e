"""The force law's parameters from loops: one least-squares fit of all samples of all loops, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from identify.actuator.loops_alone import problem_of_loops, solve_loops
from identify.actuator.rate_order import polynomials_of
from identify.actuator.verdict import Verdict, verdict_of
from identify.campaign.load_cell_zeros import zeros_differ
from identify.campaign.prepared import beta_bounds
from identify.estimation.estimate import Estimate
from identify.estimation.estimates import centre_of, estimates_of, reported
from identify.estimation.least_squares import Fit
from identify.estimation.parameters import BETA_NAME, Change
from identify.estimation.profile_likelihood import ProfileCurve, profile_curve
from identify.estimation.rate import Abscissa
from identify.loops.covariates import shares
from identify.loops.loop_data import LoopData, effective_number
from identify.loops.paper_recipe import Recipe, paper_recipe
from identify.loops.residual_dependence import Dependence, depends_on
from measure.common.arrays import Array
from simulate.model.effect import Effect

if TYPE_CHECKING:
    from lmfit.minimizer import Minimizer, MinimizerResult
    from pandas import DataFrame

Tare = Literal["common", "each", "auto"]


@dataclass(frozen=True, repr=False)
class ActuatorFit:
    """What loops say about an actuator.

    fit : the least squares. loops : as they were given.
    estimates : by name, the lines in the middle of the rates where they follow one.
    residuals : measured minus modelled of each loop's samples that count, N.
    effective_samples : independent samples that each loop's residual is worth. covariate_shares : of the residual, that each further
    column would explain. left : what the residual still follows.
    """

    fit: Fit
    loops: tuple[LoopData, ...]
    estimates: dict[str, Estimate]
    residuals: tuple[Array, ...]
    effective_samples: tuple[float, ...]
    covariate_shares: dict[str, float]
    left: Dependence
    recipe: Recipe | None
    verdict: Verdict

    def __repr__(self) -> str:
        known = ", ".join(f"{name} {self.estimates[name].value:.4g} +- {self.estimates[name].stderr:.2g}" for name in ("b_l_N", BETA_NAME))
        return f"ActuatorFit({self.verdict.word}: {len(self.loops)} loops, {known})"

    @property
    def names(self) -> list[str]:
        """Names of the parameters in `estimates` and `covariance`."""
        return reported(self.fit)

    @property
    def covariance(self) -> Array:
        """Covariance of the parameters `names`, in their units."""
        return self.fit.covariance_of(self.names)

    @property
    def lines(self) -> Array:
        """a_l, b_l, a_u, b_u, beta; in the middle of the rates where they depend on one."""
        return self.fit.problem.lines_at(self.fit.q)

    def lines_of(self, loop: int) -> Array:
        """a_l, b_l, a_u, b_u, beta of one of the fitted loops."""
        return self.fit.problem.lines_at(self.fit.q, self.fit.problem.rate.z_of(self.loops[loop]))

    @cached_property
    def centre_m(self) -> float:
        """The middle of the elongations of all loops."""
        return centre_of(self.loops)

    @property
    def half_height_N(self) -> float:
        """Half of upper minus lower asymptote, in the middle of the elongations and of the rates."""
        a_l, b_l, a_u, b_u, _ = self.lines
        return float(((a_u - a_l) * self.centre_m + b_u - b_l) / 2.0)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The effects with their fitted parameters."""
        return self.fit.problem.effects_at(self.fit.q)

    @property
    def tares_N(self) -> tuple[float, ...]:
        """What was taken off the force of each loop because its level differed; zeros where nothing was."""
        zeros = self.fit.problem.zeros_at(self.fit.q)[0]
        return tuple(float(x) for x in zeros - zeros.mean())

    def polynomials(self) -> dict[str, tuple[float, ...]]:
        """Coefficients of a_l, b_l, a_u, b_u in the rate itself, lowest power first."""
        return polynomials_of(self.fit)

    def profile(self) -> ProfileCurve:
        """The sum of squares along beta, everything else fitted anew."""
        return profile_curve(self.fit, BETA_NAME)

    @cached_property
    def result(self) -> MinimizerResult:
        """The fit as lmfit's result, for `lmfit.report_fit` and the like."""
        from identify.estimation.lmfit_result import lmfit_result

        return lmfit_result(self.fit)

    @cached_property
    def minimizer(self) -> Minimizer:
        """The problem as lmfit's minimizer, for `lmfit.conf_interval(fit.minimizer, fit.result)`."""
        from identify.estimation.lmfit_result import lmfit_minimizer

        return lmfit_minimizer(self.fit)

    def to_frame(self) -> DataFrame:
        """The estimates as a pandas table, one row a parameter; the units stand in `frame.attrs["units"]`."""
        from pandas import DataFrame

        from measure.tables.frames import unit_in_name

        rows = [(e.value, e.stderr, *e.ci95, e.verdict) for e in self.estimates.values()]
        frame = DataFrame(rows, index=list(self.estimates), columns=["value", "stderr", "ci95_low", "ci95_high", "verdict"])
        frame.attrs["units"] = {name: unit_in_name(name.partition("[")[0]) for name in self.estimates}
        return frame


def fit_actuator(
    loops: Sequence[LoopData],
    kinds: tuple[type[Effect], ...] = (),
    abscissa: Abscissa = "none",
    order: int = 0,
    tare: Tare = "common",
    covariate: str = "",
    robust: bool = False,
    changes: Sequence[Change] = (),
) -> ActuatorFit:
    """Fit the law, and effects jointly with it, to every sample of every loop.

    Each loop's start force is a nuisance and is taken out exactly; so is what the errors of its motion can do. The covariance takes the
    residual's own spectrum for the noise's, so that a slow residual counts as few samples for what it can be mistaken for.

    Parameters
    ----------
    loops : at least one, see `loops.prepare`.
    kinds : effects of the catalogue, or like them, that act on a leg or on the load cell.
    abscissa, order : what the asymptotes follow, and by polynomials of which order.
    tare : "common", one zero of the load cell for all loops; "each", one of its own for each loop, from where it may drift;
        "auto", each if the zeros differ by more than their noise and nothing else may explain it.
    covariate : name of a column of all loops to which a part of the force is proportional, fitted jointly.
    robust : samples far off the model count less (soft l1 loss), against spikes.
    changes : parameters that are held, bounded, or begin elsewhere.

    Raises
    ------
    InputError
        No loop turns; an effect that loops cannot show; too few frequencies for the polynomials.
    """
    own_zeros = tare == "each" and len(loops) > 1
    problem = problem_of_loops(loops, kinds, abscissa, order, covariate, own_zeros=own_zeros, changes=changes)
    fit = solve_loops(problem, robust=robust)
    if tare == "auto" and abscissa == "none" and not covariate and zeros_differ(fit):
        fit = solve_loops(problem_of_loops(loops, kinds, own_zeros=True, changes=changes), robust=robust)
    return _judged(fit, tuple(loops))


def _judged(fit: Fit, loops: tuple[LoopData, ...]) -> ActuatorFit:
    problem, estimates = fit.problem, estimates_of(fit)
    sigmas = [loop.data.force_sigma_N for loop in problem.loops]
    residuals = tuple(fit.difference(block) * sigma for block, sigma in zip(problem.blocks, sigmas, strict=True))
    tables = [fit.jacobian[block.rows] * sigma for block, sigma in zip(problem.blocks, sigmas, strict=True)]
    left = depends_on(loops, residuals)
    lines = [problem.lines_at(fit.q, problem.rate.z_of(data)) for data in loops]
    return ActuatorFit(
        fit=fit,
        loops=loops,
        estimates=estimates,
        residuals=residuals,
        effective_samples=tuple(effective_number(r) for r in residuals),
        covariate_shares=shares(loops, residuals, tables),
        left=left,
        recipe=paper_recipe(loops, beta_bounds(loops)),
        verdict=verdict_of(lines, estimates, loops, residuals, left, fit.converged, fit.at_bounds()),
    )
