"""Effects that join while they help, and leave again when others do without them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import before_the_stops, bic, refitted, solve
from identify.estimation.multistart import searched_everywhere
from identify.gap.sparse_force import SHORTEST, Push, is_bent, push
from identify.selection.comparison import RIVAL_P, Budget, Say, Step, next_effect
from identify.selection.gap_test import GAP_P, gain, gap_test
from identify.selection.null_hypothesis import Family
from identify.selection.pairs import better_pair
from simulate.model.effect import Effect

FAIR_SHARE = 0.05
_FAR_ABOVE = 2.0  # times the sum of squares: more than a push at a few places could say


@dataclass(frozen=True)
class Joined:
    """Effects that joined. before : the base. first : the step of the foremost alone, if any.

    tests : how many independent tests a look at the catalogue is. pushed : what a push at a few places says instead.
    """

    before: Fit
    steps: list[Step]
    first: list[Step]
    tests: Family
    pushed: Push | None = None

    @property
    def fit(self) -> Fit:
        """With all of them."""
        return self.steps[-1].best.fit if self.steps else self.before


def joined(before: Fit, catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say) -> Joined:
    """Effects added one by one while they help; or two at once, where the foremost only stands for them."""
    look, found = next_effect(before, catalogue, budget, say)
    if found is None:
        return Joined(look.current, [], [], look.tests)
    before, first = found.before, [found]
    pair = better_pair(before, look, found, catalogue, budget, say) if budget.effects > 1 else None
    steps = list(pair or first)
    current = steps[-1].best.fit
    pushed = _push_of_few(before, current, say)
    rivals = found.rivals_of(current) if pair is None else [current]
    if pushed is not None and is_bent(before, rivals, pushed) and gap_test(pushed.force.fit).p_value > GAP_P:
        return Joined(before, steps, first, look.tests, pushed)
    while len(steps) < budget.effects:
        look, found = next_effect(steps[-1].best.fit, catalogue, budget, say, last=len(steps) + 1 == budget.effects)
        steps[-1] = _with_fit(steps[-1], look.current)
        if found is None or not _matters(before, look.current, found.best.fit):
            break
        steps.append(found)
    return Joined(before, steps, first if pair else steps[:1], look.tests, pushed)


def _with_fit(step: Step, fit: Fit) -> Step:
    """The step with its best effect in the local minimum of the releases that a look at a further one has found."""
    return step if fit is step.best.fit else replace(step, best=replace(step.best, fit=fit))


def _push_of_few(before: Fit, current: Fit, say: Say) -> Push | None:
    """What a push at a few places says; None of a large gap, or where effects close it in no more words than a push needs."""
    short = len(current.q) - len(before.q) <= SHORTEST and gap_test(current).p_value > GAP_P
    if short or not before.problem.films or before.cost > _FAR_ABOVE * current.cost:
        return None
    say("doing without physics")
    return push(before, bic(current))


def _matters(before: Fit, current: Fit, found: Fit) -> bool:
    """Whether a further effect is worth a name: it leaves only noise, or it closes a fair part of the gap that was there at first.

    Measurements of a real machine never quite agree with a model; many small effects could each mend a little of that.
    """
    return gap_test(found).p_value > GAP_P or share_closed(before, found) - share_closed(before, current) > FAIR_SHARE


def without_superfluous(current: Fit, steps: list[Step], say: Say) -> tuple[Fit, list[Step]]:
    """Take out each effect in turn and see whether the others do without it."""
    if len(steps) < 2:
        return current, steps
    for step in reversed(steps):
        others = tuple(e for e in current.problem.effects if e.name != step.best.name)
        say(f"doing without {step.best.name}")
        less = refitted(current, others)
        if _is_needed(less, current) and not _is_needed(_early(less), _early(current)):  # a wrong local minimum lies behind the stops
            less = searched_everywhere(less)
        if not _is_needed(less, current):
            return without_superfluous(less, [s for s in steps if s is not step], say)
    return current, steps


def _early(fit: Fit) -> Fit:
    return solve(before_the_stops(fit.problem), fit.q)


def _is_needed(less: Fit, more: Fit) -> bool:
    """Whether a fit without an effect is worse than chance makes it."""
    return gain(less, more).p_value <= RIVAL_P


def share_closed(before: Fit, after: Fit) -> float:
    """Part of the excess over noise that goes: (S_before - S_after) / (S_before - number of samples)."""
    excess = before.cost - before.problem.measured * min(1.0, after.rms**2)
    return float(np.clip((before.cost - after.cost) / excess, 0.0, 1.0)) if excess > 0 else 0.0
