"""Every effect of a catalogue looked at by its signature: what it would add to the gaps, freed of base and releases."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import lsq_linear

from identify.estimation.fit import Fit
from identify.estimation.problem import Problem
from identify.selection.gap_test import Signature, signature, similarity
from measure.common.arrays import Array
from simulate.model.effect import Effect

_WORTH_FITTING = 6.0
_STEP = 1e-5
_SIZES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # typical ones
_NEARLY, _UNLIKE, _SHAPES = 0.5, 0.8, 3  # of the best gain; cosine; shapes that are fitted from

Branch = tuple[tuple[float, float], ...]  # the bounds that a search from a shape keeps to


@dataclass(frozen=True)
class Screened:
    """An effect and what its signature promises.

    effect : with its shape (a frequency, a time constant) where it promises most. promise : sum of squares gained, within
    bounds, on independent samples. start : sizes of its parameters that would gain it, as parameters. others : effect and start for shapes
    that promise nearly as much and cannot be come to from there. looked_at : the signatures of all shapes that were tried.
    """

    effect: Effect
    signature: Signature
    promise: float
    start: Array
    looked_at: tuple[Signature, ...]
    others: tuple[tuple[Effect, Array], ...] = ()

    @property
    def worth_fitting(self) -> bool:
        """Whether it promises anything."""
        return self.promise > _WORTH_FITTING


def kinds_to_try(catalogue: Mapping[str, type[Effect]], fit: Fit) -> list[Effect]:
    """One effect of each kind that is not among the unknown yet: as the model has it, or switched off."""
    taken = {effect.name for effect in fit.problem.effects}
    return [fit.problem.model.effect(kind) for name, kind in catalogue.items() if name not in taken]


def screen(fit: Fit, effects: Iterable[Effect]) -> list[Screened]:
    """All effects that show at all, those that promise most first."""
    found = [_screened(fit, effect) for effect in effects]
    return sorted((s for s in found if s is not None), key=lambda s: -s.promise)


def _screened(fit: Fit, effect: Effect) -> Screened | None:
    if not effect.is_linear():
        shape = _shapes(effect)[0]
        return _tried_at_sizes(fit, fit.problem.with_another(shape), shape)
    looks = looks_at_shapes(fit, effect)
    if not looks:
        return None
    foremost, *others = _far_apart(looks)
    further = tuple((look.shape, look.start) for look in others)
    looked_at = tuple(look.signature for look in looks)
    return Screened(foremost.shape, foremost.signature, foremost.gained / fit.variance_inflation, foremost.start, looked_at, further)


def looks_at_shapes(fit: Fit, effect: Effect) -> list[ShapeLook]:
    """Every shape of an effect from which a search starts and that shows at all, those that gain most first."""
    return sorted((_look(fit, *one) for one in columns_of_shapes(fit, effect)), key=lambda look: -look.gained)


@dataclass(frozen=True)
class ShapeLook:
    """A shape of an effect, the bounds that a search from it keeps to, its signature, and what it gains along straight lines by which
    sizes, as parameters."""

    shape: Effect
    branch: Branch
    signature: Signature
    start: Array
    gained: float


def columns_of_shapes(fit: Fit, effect: Effect) -> list[tuple[Effect, Branch, Array]]:
    """What a small amount of an effect does to the gaps in every shape from which a search starts, (m, k) per typical size.

    Shapes within the same bounds are simulated side by side; those of which nothing shows are left out.
    """
    branches: dict[Branch, list[Effect]] = {}
    for shape in _shapes(effect):
        branches.setdefault(tuple(shape.own_bounds(fit.problem.model).values()), []).append(shape)
    return [(shape, branch, columns) for branch, alike in branches.items() for shape, columns in _columns(fit, alike)]


def _shapes(effect: Effect) -> tuple[Effect, ...]:
    return effect.starts() if effect == type(effect)() else (effect,)


def _columns(fit: Fit, shapes: Sequence[Effect]) -> list[tuple[Effect, Array]]:
    problem, size = fit.problem.with_another(shapes[0]), len(shapes[0].flat())
    new = range(len(fit.q), len(fit.q) + size)
    first = problem.jacobian(np.concatenate([fit.q, np.zeros(size)]), new, fit.gaps)[1]
    shown = signature(fit, first).shown
    return list(zip(shapes, [first, *_other_shapes(fit, problem, shapes, shown)], strict=True)) if len(shown) else []


def _look(fit: Fit, shape: Effect, branch: Branch, columns: Array) -> ShapeLook:
    problem = fit.problem.with_another(shape)
    return ShapeLook(shape, branch, signature(fit, columns), *_bounded(fit, problem, columns, range(len(fit.q), len(problem.parameters))))


def _far_apart(looks: Sequence[ShapeLook]) -> list[ShapeLook]:
    """The shape that gains most, and those behind it that gain nearly as much in a local minimum, or within bounds, of their own."""
    best, *rest = looks
    found = [best]
    for look in rest:
        near = look.gained > _NEARLY * best.gained and len(found) < _SHAPES
        if near and all(look.branch != one.branch or similarity(look.signature, one.signature) < _UNLIKE for one in found):
            found.append(look)
    return found


def _other_shapes(fit: Fit, problem: Problem, shapes: Sequence[Effect], shown: Iterable[int]) -> list[Array]:
    """Columns of an effect for each further shape, simulated side by side; its shape shows nothing while its size is zero."""
    size, scales, shown = len(shapes[0].flat()), problem.scales[len(fit.q) :], list(shown)
    points = []
    for shape in shapes[1:]:
        for parameter in shown:
            moved = (shape.flat() - shapes[0].flat()) / scales
            moved[parameter] += _STEP
            points.append(np.concatenate([fit.q, moved]))
    columns = []
    here = np.concatenate([fit.q, np.zeros(size)])
    for i, gaps in enumerate(problem.gaps_beside([here, *points], known=fit.gaps)[1:] if points else []):
        if i % len(shown) == 0:
            columns.append(np.zeros((len(fit.gaps), size)))
        columns[-1][:, shown[i % len(shown)]] = (gaps - fit.gaps) / _STEP
    return columns


def _bounded(fit: Fit, problem: Problem, columns: Array, new: Sequence[int]) -> tuple[Array, float]:
    """Sizes within their bounds that linearly close most of the gap together with the other parameters, and the gain."""
    free = fit.free_of_parameters(columns)
    norms = np.linalg.norm(free, axis=0)
    used = np.flatnonzero(norms > 1e-9)
    if not used.size:
        return np.zeros(len(new)), 0.0
    low, high = (np.array([getattr(problem.parameters[i], side) for i in new])[used] * norms[used] for side in ("low", "high"))
    low, high = np.minimum(low, -0.0), np.maximum(high, 0.0)
    r, triangle = np.linalg.qr(free[:, used] / norms[used])
    found = lsq_linear(triangle, -(r.T @ fit.gaps), bounds=(low, np.maximum(high, low + 1e-9)))
    start = np.zeros(len(new))
    start[used] = found.x / norms[used]
    left = fit.gaps + free @ start
    return start, max(0.0, fit.cost - float(left @ left))


def _tried_at_sizes(fit: Fit, problem: Problem, effect: Effect) -> Screened | None:
    """An effect that does not begin as a straight line (a gap that opens) is looked at in several sizes."""
    sizes = [size * np.ones(len(effect.flat())) for size in _SIZES]
    changes = [gaps - fit.gaps for gaps in problem.gaps_many([np.concatenate([fit.q, size]) for size in sizes])]
    found = [signature(fit, change[:, None]) for change in changes]
    best = int(np.argmax([s.chi2 for s in found]))
    if not found[best].parameters:
        return None
    return Screened(effect, found[best], found[best].chi2 / fit.variance_inflation, sizes[best], tuple(found))
