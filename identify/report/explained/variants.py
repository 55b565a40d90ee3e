"""The fitted model with its effects switched on and off, one by one, everything else as it was fitted."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from identify.estimation.fit import Fit
from identify.selection.explain import Explanation

MOST_SWITCHED = 3  # effects; each one more doubles the curves


@dataclass(frozen=True)
class Variant:
    """A state of the switches, "1" where an effect is on, in the order of the findings; the model's gaps in it."""

    state: str
    fit: Fit


def switched(found: Explanation) -> list[str]:
    """Names of the effects that can be switched: those that were found and have parameters of their own."""
    known = {effect.name for effect in found.after.problem.effects}
    return [finding.name for finding in found.findings if finding.name in known][:MOST_SWITCHED]


def variants_of(found: Explanation) -> list[Variant]:
    """The fit in every state of the switches, all on first; nothing is fitted again."""
    names = switched(found)
    return [_variant(found.after, dict(zip(names, state, strict=True))) for state in product("10", repeat=len(names))] if names else []


def _variant(fit: Fit, states: dict[str, str]) -> Variant:
    state = "".join(states.values())
    if "0" not in state:
        return Variant(state, fit)
    q = fit.q.copy()
    for name, on in states.items():
        if on == "0":
            rows = fit.problem.rows_of(name)
            off = type(next(effect for effect in fit.problem.effects if effect.name == name))()
            start = next(effect for effect in fit.problem.effects if effect.name == name)
            q[rows] = (off.flat() - start.flat()) / fit.problem.scales[rows]
    return Variant(state, Fit(fit.problem, q, fit.problem.gaps(q), fit.jacobian, fit.converged))
