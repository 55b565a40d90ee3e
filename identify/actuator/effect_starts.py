"""Where a fit of loops with effects begins: at the solution without them, and from there at several sizes and shapes of each.

A model with an effect more can say all that the model without it says, so its fit is never worse than that.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from identify.estimation.parameters import amplitudes_of
from identify.estimation.problem import Problem
from measure.common.arrays import Array
from simulate.model.effect import Effect

_SHARES = (0.03, 0.3, 1.0)  # of the loops' own force, that an effect makes up where its fit begins
_PATHS = (0.003, 0.02, 0.1)  # of the stroke, for a play


def starts_with_effects(problem: Problem, base: Array) -> Iterator[Array]:
    """Parameters (k,) to begin from: the base solution with all effects off, and with one of them on at a size and a shape.

    Parameters
    ----------
    base : (k',) parameters of the same problem without the last effects, at its solution.
    """
    off = np.concatenate([base, np.zeros(len(problem.parameters) - len(base))])
    yield off
    exact, place = problem.with_exact_motion(), problem.first_effect
    gaps = exact.gaps(off)
    for effect in problem.effects:
        if place >= len(base):
            yield from _starts_of(exact, effect, off, place, gaps)
        place += len(effect.flat())


def _starts_of(exact: Problem, effect: Effect, off: Array, place: int, gaps: Array) -> Iterator[Array]:
    """One effect on, with each of its shapes, each size and both signs; a size is what it does to the force."""
    low, high = exact.bounds
    scales, rows = exact.scales[place : place + len(effect.flat())], slice(place, place + len(effect.flat()))
    for shape in effect.starts():
        for size in _amplitudes(shape, exact):
            q = off.copy()
            q[rows] = (size - effect.flat()) / scales
            q = np.where(exact.held, off, np.clip(q, low, high))
            if not np.array_equal(q, off):
                for share in _SHARES if shape.is_linear() else (None,):
                    yield from _at_share(exact, off, q, rows, shape, share, gaps)


def _at_share(exact: Problem, off: Array, q: Array, rows: slice, shape: Effect, share: float | None, gaps: Array) -> Iterator[Array]:
    """The start itself, or with its amplitude such that it makes up a share of the force of the loops."""
    if share is None:
        yield q
        return
    change = float(np.linalg.norm((exact.gaps(q) - gaps)[: exact.measured]))
    if change == 0.0:
        return
    whole = np.concatenate([_about_mean(loop.data.force_N[loop.data.used]) / loop.data.force_sigma_N for loop in exact.loops])
    grown = q.copy()
    grown[rows] = np.where(amplitudes_of(type(shape))[0], q[rows] * share * float(np.linalg.norm(whole)) / change, q[rows])
    yield np.clip(grown, *exact.bounds)


def _about_mean(values: Array) -> Array:
    return values - values.mean()


def _amplitudes(shape: Effect, problem: Problem) -> Iterator[Array]:
    """Values of the parameters of an effect that is on: its typical ones up and down, or a play of several parts of the stroke."""
    free, linear = map(np.array, amplitudes_of(type(shape)))
    if shape.is_linear():
        for sign in (1.0, -1.0):
            yield np.where(free, sign * shape.typical(), shape.flat())
        return
    if not any(free):
        yield shape.flat()
        return
    stroke = max(float(np.ptp(loop.data.elongation_m[loop.data.used])) for loop in problem.loops)
    for part in _PATHS:
        yield np.where(free & ~linear, part * stroke, shape.flat())
