"""What may be said of the effects that joined: no-gap, named, class, several, or unknown."""

from __future__ import annotations

from collections.abc import Sequence

from identify.estimation.fit import Fit
from identify.estimation.least_squares import bic
from identify.gap.leg_force import chance_of_leg_force, closed_by_leg_force
from identify.gap.platform_force import MissingForce, chance_of_force
from identify.selection.comparison import Step
from identify.selection.forward_selection import share_closed
from identify.selection.gap_test import GAP_P, gap_test

_CLOSED_SHARE, _CLOSED_BY_FORCE = 2 / 3, 0.9
_FEW = 3  # numbers of an effect


def more_than_noise(fit: Fit) -> bool:
    """Whether anything is left that is not noise: a force, or releases that are farther from the plan than they can be."""
    return gap_test(fit).p_value < GAP_P or _lacks_a_force(fit)


def _lacks_a_force(fit: Fit) -> bool:
    """Whether a force is left that nobody has named: slow against fast, on the platform or in the legs."""
    return gap_test(fit).slow_p < GAP_P or chance_of_force(fit) < GAP_P or chance_of_leg_force(fit) < GAP_P


def verdict_of(before: Fit, after: Fit, steps: Sequence[Step], missing: MissingForce | None, *, left: bool) -> str:
    """What may be said.

    Several effects that leave a gap are not taken, for together they can imitate much. A single one that leaves a gap must close
    most of it, and do as well as a force without any physics; with many numbers, of which no loop says anything, it must leave no
    force, for six legs can push the platform any way there is.
    """
    if not steps:
        return "unknown" if left else "no-gap"
    if left and (_may_imitate(steps[0], after) or not _closes_most(before, after, missing)):
        return "unknown"
    if len(steps) > 1:
        return "several"
    return "class" if steps[0].equivalents else "named"


def _may_imitate(step: Step, after: Fit) -> bool:
    """Whether an effect has the numbers to bend itself around something else, which shows in a force that it leaves."""
    effect = step.best.effect
    return len(effect.flat()) > _FEW and not effect.acts_on_shaker() and _lacks_a_force(after)


def _closes_most(before: Fit, after: Fit, missing: MissingForce | None) -> bool:
    """Whether a fit closes most of the gap, and nearly all of what a force without any physics closes, in the legs or on the platform."""
    closed = before.cost - after.cost
    if share_closed(before, after) < _CLOSED_SHARE or closed < _CLOSED_BY_FORCE * closed_by_leg_force(before):
        return False
    if missing is None:
        return True
    by_force = before.cost - min(missing.fit.cost, after.cost)
    return closed > _CLOSED_BY_FORCE * by_force and bic(after) < bic(missing.fit)
