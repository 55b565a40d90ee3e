"""What loops say about an actuator, as plain data: the fit, its estimates, and all that is said of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from identify.actuator.rates_and_strokes import covered
from identify.actuator.transition_zone import Level, level_against_length
from identify.criteria import ZEROS_DIFFER
from identify.estimation.parameters import BETA_NAME, LINE_NAMES, Estimate, Word
from identify.estimation.problem import Fit
from identify.estimation.profile_likelihood import ProfileCurve, profile_curve
from identify.gap.misfit import Misfit
from identify.loops.loop_data import Fault, LoopData, centre_of
from identify.loops.paper_recipe import Recipe
from identify.loops.residual_dependence import Dependence
from measure.common.arrays import Array
from measure.notebook.shown import Shown
from simulate.model.effect import Effect

if TYPE_CHECKING:
    from lmfit.minimizer import Minimizer, MinimizerResult
    from pandas import DataFrame

_AS_GOOD = 10.0  # of BIC: strong evidence (Kass and Raftery 1995)


@dataclass(frozen=True)
class Disagreement:
    """One quantity in which loops differ.

    what : "beta", 1/m; "height", N, in the middle of the elongations; "slope", the mean of both, N/m. values, stderr : (loops,), as each
    loop wants it, NaN where it does not tell. p_value : how often loops that agree differ so much by noise. fall : of the sum of squares,
    if each loop had its own.
    """

    what: str
    values: Array
    stderr: Array
    p_value: float
    fall: float

    def sentence(self, names: Sequence[str]) -> str:
        """The values with the files that have them, smallest and largest first where there are many."""
        unit = {"beta": "1/m", "height": "N", "slope": "N/m"}[self.what]
        known = [k for k in np.argsort(self.values) if np.isfinite(self.values[k])]
        shown = known if len(known) <= 4 else [known[0], known[-1]]
        listed = ", ".join(f"{self.values[k]:.4g} +- {self.stderr[k]:.2g} in {Path(names[int(k)]).name}" for k in shown)
        return f"{self.what} {listed} ({unit})"


@dataclass(frozen=True)
class Trial:
    """An effect fitted jointly with the law. before : the fit without it to the same samples.

    p_value : how often noise gains so much, all that were tried counted. delta_bic : fall of BIC by the effect. alike : effects whose
    signatures cannot be told from its own.
    """

    name: str
    fit: Fit
    before: Fit
    p_value: float
    delta_bic: float
    alike: tuple[str, ...] = ()

    @property
    def effect(self) -> Effect:
        """The effect with its fitted parameters."""
        return self.fit.problem.effects_at(self.fit.q)[-1]

    @property
    def moved(self) -> Array:
        """By how much the parameters of the fit before, (k,), are others with the effect, in scales."""
        return self.fit.q[: len(self.before.q)] - self.before.q

    @property
    def fall(self) -> float:
        """Fall of the sum of squares, in parts of that before."""
        return 1.0 - self.fit.cost / self.before.cost


def as_good(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """Those that cannot be told from the first."""
    return tuple(trial for trial in trials if trials[0].delta_bic - trial.delta_bic < _AS_GOOD)


@dataclass(frozen=True)
class Verdict:
    """The word on a fit and the sentence that gives the reason."""

    word: Word
    reason: str


def zeros_apart(fit: Fit, taken_N: Array) -> bool:
    """Whether the zeros of the loops differ by more than their noise: root mean square above three standard errors.

    Parameters
    ----------
    taken_N : (loops,) what was taken off each loop's force before the fit.
    """
    zeros = [f"{run.run.label}.zero_N" for run in fit.problem.loops]
    places = [fit.problem.index_of(name) for name in zeros]
    centring = (np.eye(len(places)) - 1.0 / len(places)) * fit.problem.scales[places]
    variances = np.diag(centring @ fit.covariance[np.ix_(places, places)] @ centring.T)
    apart = centring @ fit.q[places] + taken_N - taken_N.mean()
    return bool(np.sqrt(np.mean(apart**2 / np.maximum(variances, 1e-300))) > ZEROS_DIFFER)


@dataclass(frozen=True, repr=False)
class ActuatorFit(Shown, by="identify.report.showing.ShowingFit"):
    """What loops say about an actuator.

    fit : the least squares. loops : as they were given.
    estimates : by name, the lines in the middle of the rates where they follow one.
    residuals : measured minus modelled of each loop's samples that count, N.
    effective_samples : independent samples that each loop's residual is worth. covariate_shares : of the residual, that each further
    column would explain. left : what the residual still follows. misfit : what comes again in every cycle. faults : of the channels.
    trials : effects that are surely there and not in the fit. disagree : quantities in which the loops differ.
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
    misfit: Misfit
    faults: tuple[Fault, ...] = ()
    trials: tuple[Trial, ...] = ()
    disagree: tuple[Disagreement, ...] = ()

    def __repr__(self) -> str:
        known = ", ".join(f"{name} {self.estimates[name].value:.4g} +- {self.estimates[name].stderr:.2g}" for name in ("b_l_N", BETA_NAME))
        return f"ActuatorFit({self.verdict.word}: {len(self.loops)} loops, {known})"

    @property
    def names(self) -> list[str]:
        """Names of the parameters in `estimates` and `covariance`."""
        return self.fit.problem.reported

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
        measured = [data.force_N.mean() - run.data.force_N.mean() for data, run in zip(self.loops, self.fit.problem.loops, strict=True)]
        if not self.fit.problem.own_zeros or not self._zeros_differ:
            return (0.0,) * len(self.loops)
        zeros = self.fit.problem.zeros_at(self.fit.q)[0] + np.array(measured)
        return tuple(float(x) for x in zeros - zeros.mean())

    @cached_property
    def _zeros_differ(self) -> bool:
        taken = [data.force_N.mean() - run.data.force_N.mean() for data, run in zip(self.loops, self.fit.problem.loops, strict=True)]
        return zeros_apart(self.fit, np.array(taken))

    def polynomials(self) -> dict[str, tuple[float, ...]]:
        """Coefficients of a_l, b_l, a_u, b_u in the rate itself, lowest power first; with frequency, stroke and speed of each loop."""
        return {**self.fit.problem.polynomials_at(self.fit.q), **covered(self.loops)}

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


def transition_of(fit: ActuatorFit, loops: Sequence[LoopData]) -> Level:
    """Force level against elongation of the fitted loops, tares and inertia taken out."""
    known = fit.estimates[BETA_NAME].verdict == "ok" and fit.verdict.word != "model-does-not-apply"
    return level_against_length(loops, float(fit.lines[4]) if known else float("nan"), fit.effects, fit.tares_N)


def corrected_force(fit: ActuatorFit, loop: int) -> Array:
    """Force of a loop as the law sees it, N, (n,): without the tare that it was given and without the covariate's part.

    The covariate's part is that of its difference from the mean over all loops, so that the corrected loops are those at the mean.
    """
    force = fit.loops[loop].force_N - fit.tares_N[loop]
    problem = fit.fit.problem
    return force - problem.covariate_force(fit.fit.q, loop) if problem.covariate else force


def coefficients_of(fit: ActuatorFit, line: int) -> list[str]:
    """Names of the coefficients of one of the four lines over the scaled rate, lowest power first."""
    return [LINE_NAMES[line], *(f"rate.{LINE_NAMES[line]}[{j}]" for j in range(1, fit.fit.problem.rate.order + 1))]


def line_at(fit: ActuatorFit, line: int, x: Array, elongation_m: float | None = None) -> tuple[Array, Array]:
    """One of a_l, b_l, a_u, b_u over the rate, and its standard error, (n,) each.

    Parameters
    ----------
    line : 0 to 3. x : the rate, (n,). elongation_m : where the level of b_l or b_u is taken, a u + b; without it at zero.
    """
    rate = fit.fit.problem.rate
    powers = ((x - rate.middle) / rate.half)[:, None] ** np.arange(rate.order + 1)
    names = coefficients_of(fit, line)
    if elongation_m is not None:
        names, powers = names + coefficients_of(fit, line - 1), np.hstack([powers, elongation_m * powers])
    value = powers @ np.array([fit.fit.value(name) for name in names])
    return value, np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", powers, fit.fit.covariance_of(names), powers), 0.0))


def polynomial_errors_of(fit: ActuatorFit) -> dict[str, list[float]]:
    """Standard errors of the coefficients of a_l, b_l, a_u, b_u in the rate itself, lowest power first."""
    rate = fit.fit.problem.rate
    turn = np.array([np.pad(c := rate.unscaled(row), (0, rate.order + 1 - len(c))) for row in np.eye(rate.order + 1)])
    covariances = [fit.fit.covariance_of(coefficients_of(fit, line)) for line in range(4)]
    return {
        name: np.sqrt(np.maximum(np.diag(turn.T @ covariance @ turn), 0.0)).tolist()
        for name, covariance in zip(("a_l", "b_l", "a_u", "b_u"), covariances, strict=True)
    }
