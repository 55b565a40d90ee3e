"""Every hypothesis with one name more than a fit, weighed along straight lines: what it promises, and from where to fit it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.criteria import EFFECT_SPREAD, FORCES_DIFFER
from identify.estimation.parameters import STORED_FORCE
from identify.selection.evidence import Columns, Evidence
from identify.selection.signatures import Signature, chords
from identify.selection.weighing import Both, Weighed
from measure.common.arrays import Array
from simulate.model.effect import Effect

FORCES = "stored-force-per-run"
_SHOWN = 1e-6  # of the noise, by a typical size
_CHORDS = 3.0  # of a size at which an effect is tried: one standard deviation of its prior
_LOSES = 3.0  # log evidence that a name costs, in one round, from which on further rounds bring nothing
_FEW = 3  # shapes of an effect that are weighed to the end


@dataclass(frozen=True)
class Promise:
    """A name more, instead of one that was there if any: its log evidence along straight lines.

    shape : the effect in the shape that promises most, None for an error of the model file that has no parameters of its own.
    base : (k,) parameters of base and releases to fit it from. sizes : (n,) of the effect's own. errors : of the model file, by name and
    place, in tolerances; None where it is likelier as it is. looks : every shape weighed, and which of its parameters show.
    """

    name: str
    instead: str
    log_z: float
    shape: Effect | None
    base: Array
    sizes: Array
    errors: Mapping[tuple[str, int], float] | None
    looks: tuple[tuple[Evidence, NDArray[np.bool_]], ...] = ()


def promises(at: Weighed, catalogue: Mapping[str, type[Effect]], instead: str = "") -> Iterator[Promise]:
    """What each effect of a catalogue and each error of the model file would say beside a fit.

    Parameters
    ----------
    instead : an effect of the fit that is taken out meanwhile; by default none.
    """
    taken = {*at.names, instead}
    if FORCES not in taken and len(at.fit.problem.films) > 1:
        yield _of_forces(at, instead)
    for name, kind in catalogue.items():
        effect = at.exact.given.model.effect(kind)
        if name not in taken and name != FORCES:
            yield from _of_effect(at, effect, instead) if effect.is_linear() else _of_sizes(at, effect, instead)


def _of_forces(at: Weighed, instead: str) -> Promise:
    """Stored forces that differ from run to run by more than their tolerance, which is a prior of the fit already."""
    own = [i for i, one in enumerate(at.fit.problem.parameters) if one.key == STORED_FORCE]
    m = at.fit.problem.measured
    more = Columns.free(at.fit.jacobian[:m, own], float(np.sqrt(FORCES_DIFFER**2 - 1.0)))
    both = at.beside(more, instead=instead)
    base, errors = _base(at, both), _errors(at, both, instead)
    base[own] += both.likelier.amounts[-len(own) :]
    return Promise(FORCES, instead, both.log_z, None, base, np.empty(0), errors)


def _of_effect(at: Weighed, effect: Effect, instead: str) -> Iterator[Promise]:
    """An effect in all its shapes, which share its prior, as one promise that starts from the best; none where it does not show.

    One round with the noise as it is tells which shapes matter; these are weighed to the end, unless even the best loses by its price.
    """
    own = {effect.name}
    shapes = [look for signature in at.signatures_of(effect) if (look := _look(at, signature)) is not None]
    if not shapes:
        return
    first = [at.beside(look.columns, own, rounds=1, instead=instead) for look in shapes]
    order = sorted(range(len(shapes)), key=lambda i: -first[i].log_z)
    worth = instead or first[order[0]].log_z > at.log_z - _LOSES
    found = [at.beside(shapes[i].columns, own, instead=instead) if worth else first[i] for i in order[:_FEW]]
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(shapes)))
    best = int(np.argmax([one.log_z for one in found]))
    look, both = shapes[order[best]], found[best]
    sizes = np.zeros(len(look.shown))
    sizes[look.shown] = np.clip(both.likelier.amounts[-look.columns.count :], look.columns.low, look.columns.high)
    looks = tuple((one.likelier, look.shown) for one, look in zip(first, shapes, strict=True))
    yield Promise(effect.name, instead, log_z, look.shape, _base(at, both), sizes, _errors(at, both, instead, own), looks)


def _of_sizes(at: Weighed, effect: Effect, instead: str) -> Iterator[Promise]:
    """An effect that is not linear, tried at several sizes that share its prior; a fit starts from the likeliest."""
    own, rows = {effect.name}, at.fit.problem.measured
    tried = [(one, change[:rows, None]) for one, change in chords(at.fit, effect) if np.linalg.norm(change[:rows]) > _SHOWN]
    if not tried:
        return
    chord = (np.array([_CHORDS]), np.zeros(1), np.zeros(1), np.array([np.inf]))
    first = [at.beside(Columns(column, *chord), own, rounds=1, instead=instead) for _, column in tried]
    worth = instead or max(one.log_z for one in first) > at.log_z - _LOSES
    found = [at.beside(Columns(column, *chord), own, instead=instead) for _, column in tried] if worth else first
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(found)))
    best = int(np.argmax([one.log_z for one in found]))
    shape, both = tried[best][0], found[best]
    yield Promise(effect.name, instead, log_z, shape, _base(at, both), np.zeros(len(shape.flat())), _errors(at, both, instead, own))


@dataclass(frozen=True)
class _Look:
    """A shape of an effect as columns. shown : which of its parameters do anything."""

    shape: Effect
    columns: Columns
    shown: NDArray[np.bool_]


def _look(at: Weighed, signature: Signature) -> _Look | None:
    shape, branch, values = signature
    problem, rows = at.fit.problem, at.fit.problem.measured
    shown = np.linalg.norm(values[:rows], axis=0) > _SHOWN
    if not shown.any():
        return None
    low, high = ((np.array(branch) - shape.flat()[:, None]) / shape.typical(problem.measures)[:, None])[shown].T
    count = int(shown.sum())
    spread = min(EFFECT_SPREAD, shape.prior_spread(problem.model, problem.measures))
    return _Look(shape, Columns(values[:rows, shown], np.full(count, spread), np.zeros(count), low, high), shown)


def _base(at: Weighed, both: Both) -> Array:
    """Base and releases where an evidence has them, within their bounds."""
    stand = at.exact if both.is_exact else at.within
    first = stand.fit.problem.first_effect
    return np.clip(stand.fit.q[:first] + both.likelier.step, *stand.bounds[:, :first])


def _errors(at: Weighed, both: Both, instead: str, without: Collection[str] = ()) -> dict[tuple[str, int], float] | None:
    """Errors of the model file where an evidence has them; None where that takes it as it is."""
    if both.is_exact:
        return None
    stand = at.within.doing_without(instead) if instead else at.within
    keys = [key for key, free in zip(stand.keys, stand.free(without), strict=True) if free]
    return dict(zip(keys, both.likelier.errors.tolist(), strict=True))
