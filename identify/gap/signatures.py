"""What a small amount of an effect does to the gaps, in every shape (a frequency, a time constant) from which a search starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identify.estimation.fit import Fitted, Posed
from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.measures import Measures

_STEP = 1e-5
_SHOWN = 1e-9

SIZES = (0.03, 0.1, 0.3, 1.0, 3.0)  # typical ones, at which an effect is tried that is not linear and names no sizes of its own

Branch = tuple[tuple[float, float], ...]  # the bounds that a search from a shape keeps to
Signature = tuple[Effect, Branch, Array]  # a shape, its bounds, and its columns


def columns_of_shapes(fit: Fitted[Posed], effect: Effect) -> list[Signature]:
    """What a small amount of an effect does to the gaps in every shape from which a search starts, (m, k) per typical size.

    Shapes within the same bounds are simulated side by side; those of which nothing shows are left out.
    """
    branches: dict[Branch, list[Effect]] = {}
    for shape in _shapes(effect, fit.problem.measures):
        branches.setdefault(tuple(shape.own_bounds(fit.problem.model, fit.problem.measures).values()), []).append(shape)
    return [(shape, branch, columns) for branch, alike in branches.items() for shape, columns in _columns(fit, alike)]


def _shapes(effect: Effect, measures: Measures) -> tuple[Effect, ...]:
    return effect.starts(measures) if effect == type(effect)() else (effect,)


def chords(fit: Fitted[Posed], effect: Effect) -> list[tuple[Effect, Array]]:
    """What an effect that is not linear does to the gaps at each size at which it is tried, (m,) each: chords in place of slopes."""
    problem, measures = fit.problem.with_another(effect), fit.problem.measures
    sizes = [one for one in effect.starts(measures) if one != effect] or _grown(effect, measures)
    points = [np.concatenate([fit.q, (one.flat() - effect.flat()) / problem.scales[len(fit.q) :]]) for one in sizes]
    here = np.concatenate([fit.q, np.zeros(len(effect.flat()))])
    return [(one, gaps - fit.gaps) for one, gaps in zip(sizes, problem.gaps_beside([here, *points], known=fit.gaps)[1:], strict=True)]


def _grown(effect: Effect, measures: Measures) -> list[Effect]:
    """The effect larger by multiples of its typical size."""
    return [effect.with_flat(effect.flat() + size * effect.typical(measures)) for size in SIZES]


def _columns(fit: Fitted[Posed], shapes: Sequence[Effect]) -> list[tuple[Effect, Array]]:
    problem, size = fit.problem.with_another(shapes[0]), len(shapes[0].flat())
    new = range(len(fit.q), len(fit.q) + size)
    first = problem.jacobian(np.concatenate([fit.q, np.zeros(size)]), new, fit.gaps, longer=True)[1]
    shown = np.flatnonzero(np.linalg.norm(first, axis=0) > _SHOWN).tolist()
    return list(zip(shapes, [first, *_other_shapes(fit, problem, shapes, shown)], strict=True)) if shown else []


def _other_shapes(fit: Fitted[Posed], problem: Posed, shapes: Sequence[Effect], shown: Sequence[int]) -> list[Array]:
    """Columns of an effect for each further shape, simulated side by side; its shape shows nothing while its size is zero."""
    size, scales = len(shapes[0].flat()), problem.scales[len(fit.q) :]
    points = []
    for shape in shapes[1:]:
        for parameter in shown:
            moved = (shape.flat() - shapes[0].flat()) / scales
            moved[parameter] += _STEP
            points.append(np.concatenate([fit.q, moved]))
    columns = []
    here = np.concatenate([fit.q, np.zeros(size)])
    first, *others = problem.gaps_beside([here, *points], known=fit.gaps, longer=True) if points else [fit.gaps]
    for i, gaps in enumerate(others):
        if i % len(shown) == 0:
            columns.append(np.zeros((len(fit.gaps), size)))
        columns[-1][:, shown[i % len(shown)]] = (gaps - first) / _STEP
    return columns
