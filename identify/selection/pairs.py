"""Two effects at once, where one alone would only stand for them.

Effects join one by one, so an effect with many parameters can stand for two with few of them before these are looked at
together, and one that is neither of two can close the most of what both do. Signatures tell which pair could say more; that pair is
fitted, each of the two looked for once more beside the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import bic, refitted
from identify.selection.candidate_fits import carried_to_the_end, fit_screened
from identify.selection.comparison import (
    STRONG_BIC,
    Budget,
    Look,
    Say,
    Step,
    next_effect,
)
from identify.selection.gap_test import GAP_P, gap_test
from identify.selection.null_hypothesis import gained_by
from identify.selection.screening import Screened
from simulate.model.effect import Effect

CLEAR_BIC = 2.0 * STRONG_BIC  # of a pair over one effect: there are fourteen times as many pairs, and two are rarer than one
_FITTED = 4  # effects that are fitted for each of the two
_PLAIN = 2  # parameters: an effect with no more of them cannot stand for two


def better_pair(
    before: Fit, look: Look, step: Step, catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say
) -> tuple[Step, Step] | None:
    """A pair that explains clearly more than the effect of a step; None where there is none.

    Beside an effect that closes the gap only a pair with fewer parameters is looked at, beside one that does not any pair.

    Returns
    -------
    A step for each of the two on top of the other; the last one holds the fit with both.
    """
    closed = gap_test(step.best.fit).p_value > GAP_P
    if closed and step.best.gain.parameters <= _PLAIN:
        return None
    first = _promising_pair(look, step.best.name, plainer=closed)
    if first is None:
        return None
    say(f"trying {first.effect.name} with another beside it")
    budget = replace(budget, fitted=min(budget.fitted, _FITTED), whole=1, rivals=min(budget.rivals, _FITTED))
    (alone,) = carried_to_the_end(before, [fit_screened(look.hint, first)])
    second = next_effect(alone.fit, catalogue, budget, say)[1]
    if second is None:
        return None
    both = second.best.fit
    kept = [effect for effect in both.problem.effects if effect.name == second.best.name]
    other = next_effect(refitted(both, kept), catalogue, budget, say)[1]
    if other is None or bic(other.best.fit) > bic(step.best.fit) - CLEAR_BIC:
        return None
    return second, other


def _promising_pair(look: Look, name: str, *, plainer: bool) -> Screened | None:
    """The stronger one of the pair whose signatures promise clearly more than those of one effect; plainer : in fewer words."""
    shown = {one.effect.name: one for one in look.screened if one.signature.parameters}
    if name not in shown:
        return None
    frame = np.linalg.qr(np.column_stack([look.hint.gaps, *(one.signature.columns for one in shown.values())]))[0]
    gaps = frame.T @ look.hint.gaps[:, None]
    columns = {key: frame.T @ one.signature.columns for key, one in shown.items()}
    words = {key: one.signature.parameters * float(np.log(look.hint.effective_samples)) for key, one in shown.items()}

    def gained(*names: str) -> float:
        return float(gained_by(np.column_stack([columns[one] for one in names]), gaps)[0])

    pairs = [pair for pair in combinations(shown, 2) if not plainer or words[pair[0]] + words[pair[1]] < words[name]]
    worth = [gained(*pair) - words[pair[0]] - words[pair[1]] for pair in pairs]
    if not pairs or max(worth) < gained(name) - words[name] + CLEAR_BIC:
        return None
    return shown[max(pairs[int(np.argmax(worth))], key=gained)]
