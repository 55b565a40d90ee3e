"""An effect drafted where nothing that is known fits, fitted by full simulation and tried on runs that took no part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from identify.draft.choice import Chosen, chosen_forms
from identify.draft.drafted import Drafted
from identify.draft.effect_file import Origin, Variable, effect_from, formula_text, source_of
from identify.estimation.least_squares import solve
from identify.estimation.problem import Fit, Problem
from identify.gap.leg_force import LegTable
from identify.gap.platform_force import ForceTable
from identify.gap.size import gap_left, noise_of_channels
from identify.gap.unnamed import Unnamed
from identify.selection.stand import Weighed
from identify.selection.weighing import led_anew, weighed, weighed_within

HeldOut: TypeAlias = Callable[[Fit], Sequence[Fit]]
MOST_TRIED = 2  # variables whose form is fitted by full simulation
_LEAST_SCORE = 0.0
_LESS_WELL = 10.0  # of the sum of squares: a variable so much worse is not tried beside the best


def draft(beside: Weighed, left: Fit, tables: Sequence[Unnamed], held_out: HeldOut, origin: Origin) -> Drafted | None:
    """Draft the force that is missing beside a hypothesis. Base, releases and the errors of the model file are free beside it.

    Parameters
    ----------
    left : the fit that leaves what is missing. tables : the forces without a name that were weighed beside it.
    held_out : makes of a fit those of the runs that took no part, with its base and effects.
    origin : what it is made from, for the file.

    Returns
    -------
    Drafted or None
        The one that runs held out prefer, or the best fit where there are none; None where no formula says anything.
    """
    found = [one for one in chosen_forms(tables, left.effective_samples, _LESS_WELL) if one.score > _LEAST_SCORE]
    near = [one for one in found[:MOST_TRIED] if one.rank > found[0].rank - _LESS_WELL]
    before = held_out(left) if near else ()
    tried = [_tried(beside, one, before, held_out, origin) for one in near]
    return min(tried, key=lambda one: gap_left(*one.held_with) if one.held_with else one.fit.cost, default=None)


def _tried(beside: Weighed, chosen: Chosen, before: Sequence[Fit], held_out: HeldOut, origin: Origin) -> Drafted:
    table = chosen.table.table
    assert isinstance(table, LegTable | ForceTable)
    arm = [] if chosen.arm_m is None else [chosen.arm_m]
    variable, span = Variable.of(table, chosen.axis, has_arm=bool(arm)), (float(table.places[0]), float(table.places[-1]))
    values = np.array([*chosen.values, *arm])
    source = source_of(chosen.form, values, variable, span, origin)
    effect = effect_from(source)()
    problem = beside.exact.given.with_another(effect)
    found = _from_sizes(problem, beside, (values - effect.flat()) / effect.typical(problem.measures))
    anew = led_anew(found)
    best = found if anew is None else found.better_of(anew)
    fit, of = best.fit, best.evidence
    drafted = fit.problem.effects_at(fit.q)[-1]
    return Drafted(
        variable,
        formula_text(chosen.form, drafted.flat(), variable),
        source_of(chosen.form, drafted.flat(), variable, span, origin),
        fit,
        tuple(before),
        tuple(held_out(fit)),
        noise_of_channels(fit.problem.blocks, fit.problem.stated_noise, of.noise, of.left) if best.leaves_noise else (),
    )


def _from_sizes(problem: Problem, before: Weighed, sizes: np.ndarray) -> Weighed:
    """A hypothesis with one effect more from where the one before it stands, and from some sizes (n,) of the effect, in scales."""
    start = np.concatenate([before.fit.q, sizes])
    if before.both.is_exact:
        return weighed(solve(problem, start, loosely=True))
    return weighed_within(problem, start, before.within.errors_by_key)
