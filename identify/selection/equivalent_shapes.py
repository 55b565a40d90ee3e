"""Every shape (a frequency, a time constant, a clearance) with which an effect that was found suits the measurements as well.

A shaken base has a local minimum of the sum of squares at each of several frequencies, and some are as deep as one another. What is told
comes from the deepest of them, and an interval spans all that cannot be told from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.estimation.fit import Fit
from identify.estimation.least_squares import ROUGHLY, refitted, solve, to_the_end
from identify.estimation.problem import Problem
from identify.estimation.profile_likelihood import REACH
from identify.estimation.threads import side_by_side
from identify.selection.screening import ShapeLook, looks_at_shapes
from measure.common.arrays import Array

_FIRST_STEPS, _FOLLOWED, _STEPS = 6, 4, 25  # from every shape; the deepest ones then, and how far these are followed
_NEAR = 10.0  # units above the deepest local minimum, within which a hurried fit may turn out as deep


@dataclass(frozen=True)
class LocalMinimum:
    """The parameters of an effect (k,) in one of its local minima, with their standard errors."""

    values: Array
    stderr: Array


def deepest_shape(after: Fit, name: str) -> tuple[Fit, tuple[LocalMinimum, ...]]:
    """The same fit, or one with another shape of an effect that is deeper; and the other local minima that cannot be told from it.

    Parameters
    ----------
    name : of one of the effects that were fitted; without starts of its own nothing is tried.
    """
    fits = [after, *_with_other_shapes(after, name)]
    deepest = min(fits, key=lambda fit: fit.cost)
    if deepest.cost > after.cost - ROUGHLY:
        deepest = after
    limit = deepest.cost + REACH**2 * deepest.unit
    return deepest, tuple(_minimum(fit, name) for fit in fits if fit.cost < limit and _elsewhere(fit, deepest))


def _elsewhere(fit: Fit, deepest: Fit) -> bool:
    """Whether two fits say something different of the measurements: one local minimum can be written with several sets of numbers."""
    return float(np.sum((fit.gaps - deepest.gaps) ** 2)) > deepest.unit


def _with_other_shapes(after: Fit, name: str) -> Sequence[Fit]:
    """The measurements fitted from other shapes of an effect: a few steps each, on from the deepest, those near these to the end."""
    (found,) = (effect for effect in after.problem.effects if effect.name == name)
    plain = after.problem.model.effect(type(found))
    if plain != type(found)() or len(plain.starts()) < 2:
        return ()
    less = refitted(after, [effect for effect in after.problem.effects if effect.name != name])
    looks = _of_every_value(looks_at_shapes(less, plain))
    starts = [(less.problem.with_another(look.shape), np.concatenate([less.q, look.start])) for look in looks]
    tried = _followed(starts, _FIRST_STEPS)[:_FOLLOWED]
    fits = _followed([(fit.problem, fit.q) for fit in tried], _STEPS)
    limit = min(fit.cost for fit in (after, *fits)) + _NEAR * after.unit
    return [to_the_end(fit) for fit in fits if fit.cost < limit]


def _of_every_value(looks: Sequence[ShapeLook]) -> list[ShapeLook]:
    """The foremost shapes in which each value stands once from which a search starts: not every frequency at every phase."""
    kept: list[ShapeLook] = []
    seen: set[tuple[int, float]] = set()
    for look in looks:
        values = set(enumerate(look.shape.flat().tolist()))
        if not values <= seen:
            kept.append(look)
            seen |= values
    return kept


def _followed(starts: Sequence[tuple[Problem, Array]], steps: int) -> list[Fit]:
    """Fits from these starts, the deepest first."""
    found = side_by_side(lambda i: solve(*starts[i], most_steps=steps, enough=ROUGHLY), len(starts))
    return sorted(found, key=lambda fit: fit.cost)


def _minimum(fit: Fit, name: str) -> LocalMinimum:
    (effect,) = (effect for effect in fit.problem.effects_at(fit.q) if effect.name == name)
    rows = fit.problem.rows_of(name)
    return LocalMinimum(effect.flat(), np.sqrt(np.maximum(np.diag(fit.covariance)[rows], 0.0)) * fit.problem.scales[rows])
