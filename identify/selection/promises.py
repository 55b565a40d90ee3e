"""Every hypothesis with one name more than a fit, weighed along straight lines: what it promises, and from where to fit it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from identify.criteria import FORCES_DIFFER, LOSES
from identify.estimation.parameters import STORED_FORCE
from identify.estimation.problem import Problem
from identify.estimation.tolerances import TOLERANCE_OF
from identify.gap.linear_pieces import Columns, Gain, Shown
from identify.gap.signatures import chords
from identify.selection.evidence import Both
from identify.selection.first_look import Promise
from identify.selection.model_errors import FORCES, as_wide, effect_spreads
from identify.selection.stand import Stand, Weighed
from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.measures import Measures
from simulate.model.wave import Wave

_SHOWN = 1e-6  # of the noise, by a typical size
_CHORDS = 3.0  # of a size at which an effect is tried: one standard deviation of its prior
_HALF = 0.5  # of what a name brings at a first look; one that brings less is not looked at in its place
_FEW = 3  # shapes of an effect that are weighed to the end


def promises(at: Weighed, catalogue: Mapping[str, type[Effect]], instead: str = "") -> Iterator[Promise]:
    """What each effect of a catalogue and each error of the model file would say beside a fit.

    A first look tells which shapes of which effects matter. These are weighed to the end; of what brings too little the first look stands.

    Parameters
    ----------
    instead : an effect of the fit that is taken out meanwhile; by default none.
    """
    taken = {*at.names, instead}
    stand, least = (at.doing_without(instead), _HALF * max(at.gain_of(instead), 0.0)) if instead else (at, -LOSES)
    if FORCES not in taken and len(at.fit.problem.films) > 1:
        yield _of_forces(stand, instead)
    effects = [at.exact.given.model.effect(kind) for name, kind in catalogue.items() if name not in taken and name != FORCES]
    looked = [one for effect in effects if (one := _Looked.at(stand, effect)) is not None]
    least = max([least, *(one.first - LOSES for one in looked)])
    yield from (one.promise(stand, instead, least) for one in looked)


def posed(before: Weighed, promise: Promise) -> tuple[Problem, Array]:
    """The problem of a hypothesis with one name more than another, with the model file as it is, and where a fit of it starts."""
    there, given = before.fit, before.exact.given
    problem = given.with_effects([effect for effect in given.effects if effect.name != promise.instead])
    own = np.concatenate([there.q[there.problem.rows_of(effect.name)] for effect in problem.effects] or [np.empty(0)])
    if promise.shape is not None:
        problem = problem.with_another(promise.shape)
    elif promise.name == FORCES:
        problem = replace(problem, forces_differ=True)
    return problem, np.concatenate([promise.base, own, promise.sizes])


def begun(before: Weighed, problem: Problem, promise: Promise, end: Array) -> Stand:
    """The same hypothesis where the one before it stands: nothing of it acts yet, or as much of an error of the model file as does there.

    end : (k,) where it is promised to be.
    """
    stand, new, q = before.within, problem.rows_of(promise.name), end.copy()
    q[: problem.first_effect] = stand.fit.q[: problem.first_effect]
    q[new] = 0.0
    if promise.name in stand.errors.names and promise.shape is not None:
        sizes = np.array([stand.errors_by_key[promise.name, place] for place in range(len(new))])
        values = TOLERANCE_OF[promise.name].values(stand.given.model, sizes)
        q[new] = (values - promise.shape.flat()) / problem.scales[new]
    return Stand.off_by(problem, q, stand.errors_by_key)


def _of_forces(at: Weighed, instead: str) -> Promise:
    """Stored forces that differ from run to run by more than their tolerance, which is a prior of the fit already."""
    own = [i for i, one in enumerate(at.fit.problem.parameters) if one.key == STORED_FORCE]
    m = at.fit.problem.measured
    both = at.beside(Columns.free(at.fit.jacobian[:m, own], float(np.sqrt(FORCES_DIFFER**2 - 1.0))))
    base, errors = _base(at, both), _errors(at, both)
    base[own] += both.likelier.amounts[-len(own) :]
    return Promise(FORCES, instead, both.log_z, None, base, np.empty(0), errors)


@dataclass(frozen=True)
class _Shape:
    """An effect in one shape as columns. shown : which of its parameters these are; None for a chord, which is of all of them together.

    known : one standard deviation of what the effect knows of itself, in typical sizes, else infinite.
    """

    effect: Effect
    columns: Columns
    shown: NDArray[np.bool_] | None
    known: float

    def looked_at(self, seen: Shown) -> tuple[_Shape, Gain]:
        """With a prior as wide as its amounts are large, and what it brings at a first look, by what is seen of its columns."""
        gain = seen.gain(self.columns)
        spread = as_wide(np.full(self.columns.count, self.known), np.abs(gain.amounts))
        if np.array_equal(spread, self.columns.spread):
            return self, gain
        wider = replace(self.columns, spread=spread)
        return replace(self, columns=wider), seen.gain(wider)

    def sizes(self, amounts: Array) -> Array:
        """Where a fit of the effect starts, (n,) in typical sizes from its shape: by a chord at the size at which it was tried."""
        found = np.zeros(len(self.effect.flat()))
        if self.shown is not None:
            found[self.shown] = np.clip(amounts[-self.columns.count :], self.columns.low, self.columns.high)
        return found


@dataclass(frozen=True)
class _Waves(_Shape):
    """Waves of one frequency together, a column of each.

    parts : (k, n) parameters of each. typical : (n,) sizes of them.
    """

    parts: Array
    typical: Array

    @classmethod
    def of(cls, alike: Sequence[_Shape], measures: Measures) -> _Waves:
        """Of shapes that differ in nothing but what adds up."""
        columns, first = reduce(Columns.beside, (one.columns for one in alike)), alike[0]
        free = replace(Columns.free(columns.values, 1.0), spread=columns.spread)
        parts = np.array([one.effect.flat() for one in alike])
        return cls(first.effect, free, first.shown, first.known, parts, first.effect.typical(measures))

    def sizes(self, amounts: Array) -> Array:
        """Where a fit of the effect starts: from the one wave that they make."""
        assert isinstance(self.effect, Wave)
        whole = self.effect.sum_of(self.parts, amounts[-self.columns.count :] * self.typical[0])
        return (whole.flat() - self.effect.flat()) / self.typical


@dataclass(frozen=True)
class _Looked:
    """An effect in all its shapes, which share its prior, and what each brings at a first look.

    ways, gains : the shapes from which a fit may start, of waves those of one frequency together, and what each brings. Of both the one
    that may bring most stands first.
    """

    shapes: tuple[_Shape, ...]
    looks: tuple[Gain, ...]
    ways: tuple[_Shape, ...]
    gains: tuple[Gain, ...]

    @classmethod
    def at(cls, at: Weighed, effect: Effect) -> _Looked | None:
        """Beside a fit; None where nothing of the effect shows."""
        shapes = _slopes(at, effect) if effect.is_linear() else _chords(at, effect)
        if not shapes:
            return None
        if not isinstance(effect, Wave) or len(shapes) == 1:
            looked = _ranked((shape, at.first_look.shown(shape.columns.values)) for shape in shapes)
            return cls(*looked, *looked)
        waves = [(alike, _Waves.of(alike, at.fit.problem.measures)) for alike in _alike(shapes, effect.summed)]
        seen = [(alike, one, at.first_look.shown(one.columns.values)) for alike, one in waves]
        each = ((shape, whole.of(k, shape.columns.count)) for alike, _, whole in seen for k, shape in enumerate(alike))
        return cls(*_ranked(each), *_ranked((one, whole) for _, one, whole in seen))

    @property
    def first(self) -> float:
        """The most that a shape brings at a first look."""
        return max(gain.log_z for gain in self.gains)

    def promise(self, at: Weighed, instead: str, least: float) -> Promise:
        """The effect as one promise that starts from its best shape, weighed to the end if some shape may gain `least`."""
        pairs = zip(self.looks, self.shapes, strict=True)
        looks = tuple((gain, shape.shown) for gain, shape in pairs if shape.shown is not None)
        shape, few = self.ways[0].effect, self.ways[:_FEW]
        if self.gains[0].most < least and shape.name not in at.within.errors.names:
            log_z, sizes = at.along_lines + self._shared([gain.log_z for gain in self.gains[:_FEW]]), np.zeros(len(shape.flat()))
            return Promise(shape.name, instead, log_z, shape, _base(at, at.both), sizes, _errors(at, at.both), looks, self.first)
        along = sorted(((at.beside(one.columns, {shape.name}), one) for one in few), key=lambda pair: -pair[0].log_z)
        found = []
        for of_way, way in along if isinstance(few[0], _Waves) else along[:1]:
            log_z, both, sizes = self._led(at, way, of_way)
            errors = _errors(at, both, {shape.name})
            found.append(Promise(shape.name, instead, log_z, way.effect, _base(at, both), sizes, errors, looks, self.first))
        best, *others = sorted(found, key=lambda one: -one.log_z)
        return replace(best, log_z=max(best.log_z, self._shared([one.log_z for one, _ in along])), others=tuple(others))

    def _led(self, at: Weighed, way: _Shape, both: Both) -> tuple[float, Both, Array]:
        """Where one of the ways leads: its log evidence, the evidence there, and sizes (n,) of the effect's parameters."""
        log_z, sizes = self._shared([both.log_z]), way.sizes(both.likelier.amounts)
        if way.shown is None or way.shown.all() or not sizes.any():  # else some of its parameters show once there is some of the effect
            return log_z, both, sizes
        return max((log_z, both, sizes), _with_shape_free(at, way.effect, sizes), key=lambda one: one[0])

    def _shared(self, logs: Sequence[float]) -> float:
        """Log evidence over all ways, of which the few that bring most count."""
        return float(np.logaddexp.reduce(logs) - np.log(len(self.ways)))


def _ranked(shapes: Iterable[tuple[_Shape, Shown]]) -> tuple[tuple[_Shape, ...], tuple[Gain, ...]]:
    """Shapes, one or more, with what they bring at a first look; first what may bring most once the noise is estimated anew."""
    found = sorted((one.looked_at(seen) for one, seen in shapes), key=lambda pair: -pair[1].most)
    return tuple(shape for shape, _ in found), tuple(gain for _, gain in found)


def _alike(shapes: Sequence[_Shape], summed: Collection[str]) -> list[list[_Shape]]:
    """Shapes that differ only in what adds up, together."""
    found: dict[tuple[object, ...], list[_Shape]] = {}
    for one in shapes:
        rest = tuple(getattr(one.effect, item.name) for item in fields(one.effect) if item.name not in summed)
        found.setdefault(rest, []).append(one)
    return list(found.values())


def _slopes(at: Weighed, effect: Effect) -> list[_Shape]:
    made = []
    problem, rows = at.fit.problem, at.fit.problem.measured
    for shape, branch, values in at.signatures_of(effect):
        shown = np.linalg.norm(values[:rows], axis=0) > _SHOWN
        if shown.any():
            low, high = ((np.array(branch) - shape.flat()[:, None]) / shape.typical(problem.measures)[:, None])[shown].T
            count = int(shown.sum())
            known, zero = shape.prior_spread(problem.model, problem.measures), np.zeros(count)
            columns = Columns(values[:rows, shown], as_wide(np.full(count, known), zero), zero, low, high)
            made.append(_Shape(shape, columns, shown, known))
    return made


def _with_shape_free(at: Weighed, effect: Effect, sizes: Array) -> tuple[float, Both, Array]:
    """An effect weighed where a first line has led, for there its shape shows, too: log evidence, evidence, and sizes (n,) a step on."""
    problem, m = at.fit.problem.with_another(effect), at.fit.problem.measured
    new = problem.rows_of(effect.name)
    gaps, slopes = problem.jacobian(np.concatenate([at.fit.q, sizes]), new.tolist(), longer=True)
    low, high = np.array([(problem.parameters[k].low, problem.parameters[k].high) for k in new]).T
    columns = Columns(slopes[:m], effect_spreads(problem, new, np.abs(sizes)), sizes, low, high)
    both = at.beside(columns, {effect.name}, shift=(gaps - at.fit.gaps)[:m])
    return both.log_z, both, np.clip(both.likelier.amounts[-len(sizes) :], low, high)


def _chords(at: Weighed, effect: Effect) -> list[_Shape]:
    """An effect that is not linear, tried at several sizes: each has a column of its own."""
    rows = at.fit.problem.measured
    tried = [(shape, change[:rows, None]) for shape, change in chords(at.fit, effect) if np.linalg.norm(change[:rows]) > _SHOWN]
    spread, zero, most = np.array([_CHORDS]), np.zeros(1), np.array([np.inf])
    return [_Shape(shape, Columns(column, spread, zero, zero, most), None, _CHORDS) for shape, column in tried]


def _base(at: Weighed, both: Both) -> Array:
    """Base and releases where an evidence has them, within their bounds."""
    stand = at.exact if both.is_exact else at.within
    first = stand.fit.problem.first_effect
    return np.clip(stand.fit.q[:first] + both.likelier.step, *stand.bounds[:, :first])


def _errors(at: Weighed, both: Both, without: Collection[str] = ()) -> dict[tuple[str, int], float] | None:
    """Errors of the model file where an evidence has them; None where that takes it as it is."""
    if both.is_exact:
        return None
    keys = [key for key, free in zip(at.within.errors.keys, at.within.free(without), strict=True) if free]
    return dict(zip(keys, both.likelier.errors.tolist(), strict=True))
