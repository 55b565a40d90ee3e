"""The force law's parameters from loops: one least-squares fit of all samples of all loops, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit, Disagreement, Trial
from identify.actuator.homogeneity import disagreements
from identify.actuator.levels import Levels, drift_significance, levels_of
from identify.actuator.loops_alone import problem_of_loops, solve_loops
from identify.actuator.rounding import covariance_of_rounding
from identify.actuator.suggestions import CHANNEL_EFFECTS, faults_of_drifts, faults_of_trials, moved_beyond, sentence_of
from identify.actuator.trials import OutOfStep, tried
from identify.actuator.verdict import Evidence, verdict_of
from identify.campaign.prepared import beta_bounds
from identify.criteria import STRUCTURED_SHARE, ZEROS_DIFFER
from identify.estimation.estimates import estimates_of
from identify.estimation.parameters import Change
from identify.estimation.problem import Fit, Problem
from identify.estimation.rate import Abscissa
from identify.gap.misfit import misfit_of
from identify.loops.covariates import shares
from identify.loops.loop_data import LoopData
from identify.loops.paper_recipe import Recipe, paper_recipe
from identify.loops.residual_dependence import depends_on
from identify.loops.sign import swapped_channels, units_apart
from identify.noise.effective_number import effective_number
from measure.common.arrays import Array
from simulate.effects import SensorLag
from simulate.model.effect import Effect

Tare = Literal["common", "each", "auto"]


def fit_actuator(
    loops: Sequence[LoopData],
    kinds: tuple[type[Effect], ...] = (),
    abscissa: Abscissa = "none",
    order: int = 0,
    tare: Tare = "common",
    covariate: str = "",
    robust: bool = False,
    changes: Sequence[Change] = (),
    suggest: bool = True,
) -> ActuatorFit:
    """Fit the law, and effects jointly with it, to every sample of every loop.

    Each loop's start force is a nuisance and is taken out exactly; so is what the errors of its motion can do. The covariance takes the
    residual's own spectrum for the noise's, so that a slow residual counts as few samples for what it can be mistaken for.

    Parameters
    ----------
    loops : at least one, see `prepare`.
    kinds : effects of the catalogue, or like them, that act on a leg or on the load cell.
    abscissa, order : what the asymptotes follow, and by polynomials of which order.
    tare : "common", one zero of the load cell for all loops; "each", one of its own for each loop, from where it may drift;
        "auto", one of its own where nothing else may explain it, and a drift where it is surely there.
    covariate : name of a column of all loops to which a part of the force is proportional, fitted jointly.
    robust : samples far off the model count less (soft l1 loss), against spikes.
    changes : parameters that are held, bounded, or begin elsewhere.
    suggest : try every effect of the catalogue on what is left, not only those of the channels.

    Returns
    -------
    ActuatorFit
        Estimates with standard errors by name, the verdict, what is left, and the `lmfit` result.

    Raises
    ------
    InputError
        No loop turns; an effect that loops cannot show; too few frequencies for the polynomials.
    """
    levels = levels_of(loops, kinds, own=own_zeros(loops, tare, follows=abscissa != "none" or bool(covariate)))
    fit = _solved(loops, kinds, levels, tare, changes, Options(abscissa, order, covariate, robust))
    return judged(fit, tuple(loops), suggest=suggest)


@dataclass(frozen=True)
class Options:
    """What the asymptotes follow, and how residuals count."""

    abscissa: Abscissa = "none"
    order: int = 0
    covariate: str = ""
    robust: bool = False


def own_zeros(loops: Sequence[LoopData], tare: Tare, *, follows: bool) -> bool:
    """Whether each loop has a zero of its own; where something else may explain its level, only if that is asked for."""
    return len(loops) > 1 and (tare == "each" or (tare == "auto" and not follows))


def _solved(
    loops: Sequence[LoopData], kinds: tuple[type[Effect], ...], levels: Levels, tare: Tare, changes: Sequence[Change], options: Options
) -> Fit:
    """The least squares about a force of zero, drifts free where they are asked for or surely there; levels put back."""
    counted, centred = levels.changes_without(changes), levels.without(loops)

    def problem(*, drifting: bool) -> Problem:
        return problem_of_loops(
            centred,
            kinds,
            options.abscissa,
            options.order,
            options.covariate,
            own_zeros=levels.own,
            drifting=drifting,
            changes=counted,
        )

    fit = solve_loops(problem(drifting=tare == "each"), robust=options.robust)
    if levels.own and tare == "auto":
        drifted = solve_loops(problem(drifting=True), fit.q, robust=options.robust)
        fit = drifted if drift_significance(drifted) > ZEROS_DIFFER else fit
    return levels.put_back(fit, levels.changes_without(fit.problem.changes, 1.0))


def judged(fit: Fit, loops: tuple[LoopData, ...], *, suggest: bool = True) -> ActuatorFit:
    """A fit with everything that is said of it: what is left, which effects would explain it, and how far its numbers can be trusted."""
    of_channels = [*(fault for data in loops for fault in data.faults), *units_apart(loops), *swapped_channels(loops)]
    refused = any(fault.consequence == "refused" for fault in of_channels)
    trials = () if refused else tried(fit, None if suggest else CHANNEL_EFFECTS)
    better = trials[0] if trials else None
    disagree = _disagreements(fit, better)
    better = None if disagree else better
    moves = better is not None and moved_beyond(fit, better)
    fit = replace(fit, widened=_widened(fit, better, moves=moves))
    sigmas = [loop.data.force_sigma_N for loop in fit.problem.loops]
    residuals = fit.residuals_N
    whitened = [fit.part(block) * sigma for block, sigma in zip(fit.problem.blocks, sigmas, strict=True)]
    tables = [fit.jacobian[block.rows] * sigma for block, sigma in zip(fit.problem.blocks, sigmas, strict=True)]
    left, estimates, misfit = depends_on(loops, residuals), estimates_of(fit), misfit_of(loops, whitened)
    said = [*faults_of_trials(loops, () if disagree else trials), *faults_of_drifts(fit, loops)]
    faults = (*of_channels, *said)
    seen = Evidence(
        lines=[fit.problem.lines_at(fit.q, fit.problem.rate.z_of(data)) for data in loops],
        estimates=estimates,
        loops=loops,
        residuals=residuals,
        left=left,
        misfit=misfit,
        faults=faults,
        converged=fit.converged,
        at_bounds=fit.at_bounds(),
        disagree=disagree,
        better="" if disagree else sentence_of(fit, trials, loops),
        moves=moves,
        robust=fit.robust,
    )
    return ActuatorFit(
        fit=fit,
        loops=loops,
        estimates=estimates,
        residuals=residuals,
        effective_samples=tuple(effective_number(r) for r in residuals),
        covariate_shares=shares(loops, residuals, tables),
        left=left,
        recipe=_recipe(fit, loops),
        verdict=verdict_of(seen),
        misfit=misfit,
        faults=faults,
        trials=trials,
        disagree=disagree,
    )


def _widened(fit: Fit, better: Trial | None, *, moves: bool) -> Array:
    """Further covariance, (k, k): of rounding; of an effect that is there and not in the fit, or else of channels out of step unseen."""
    whole = covariance_of_rounding(fit)
    if better is not None:
        moved = np.where(fit.problem.held, 0.0, better.moved)
        return whole + np.outer(moved, moved) if moves else whole
    lag_known = any(effect.name == SensorLag.name for effect in fit.problem.effects)
    return whole if lag_known else whole + OutOfStep(fit, SensorLag).widened


def _disagreements(fit: Fit, better: Trial | None) -> tuple[Disagreement, ...]:
    """Quantities in which the loops differ with and without the effect that explains most, where they are most of what is left.

    None where the effect explains more than they do, or where something else is left in the main.
    """
    found, excess = disagreements(fit), fit.cost - fit.problem.measured
    found = found if found and max(one.fall for one in found) > STRUCTURED_SHARE * excess else ()
    if not found or better is None:
        return found
    if max(one.fall for one in found) < better.fall * fit.cost:
        return ()
    still = {one.what for one in disagreements(better.fit)}
    return tuple(one for one in found if one.what in still)


def _recipe(fit: Fit, loops: Sequence[LoopData]) -> Recipe | None:
    """The paper's recipe on loops of one level; put back to where the fit has it."""
    own = [replace(data, force_N=run.data.force_N - zero) for data, run, zero in zip(loops, fit.problem.loops, _zeros(fit), strict=True)]
    return paper_recipe(own, beta_bounds(loops))


def _zeros(fit: Fit) -> Array:
    return fit.problem.zeros_at(fit.q)[0]
