"""The fitted model with its effects switched on and off, one by one, everything else as it was fitted."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from identify.estimation.problem import Fit
from identify.selection.explanation import Explanation

MOST_SWITCHED = 3  # effects; each one more doubles the curves


def switched(found: Explanation) -> list[str]:
    """Names of the effects that can be switched: those that were found and have parameters of their own."""
    known = {effect.name for effect in found.after.problem.effects}
    return [finding.name for finding in found.findings if finding.name in known][:MOST_SWITCHED]


def variants_of(found: Explanation) -> dict[str, Fit]:
    """The fit in every state of the switches, "1" where an effect is on, in their order; all on first. Nothing is fitted again."""
    names = switched(found)
    states = ["".join(state) for state in product("10", repeat=len(names))] if names else []
    return {state: _switched(found.after, dict(zip(names, state, strict=True))) for state in states}


def _switched(fit: Fit, states: dict[str, str]) -> Fit:
    q = fit.q.copy()
    for effect in fit.problem.effects:
        if states.get(effect.name) == "0":
            rows = fit.problem.rows_of(effect.name)
            q[rows] = (type(effect)().flat() - effect.flat()) / fit.problem.scales[rows]
    return fit if "0" not in states.values() else replace(fit, q=q, gaps=fit.problem.gaps(q))
