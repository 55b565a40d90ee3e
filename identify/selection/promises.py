"""Every hypothesis with one name more than a fit, weighed along straight lines: what it promises, and from where to fit it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.criteria import EFFECT_SPREAD, FORCES_DIFFER
from identify.estimation.parameters import STORED_FORCE
from identify.selection.evidence import Columns
from identify.selection.first_look import Gain
from identify.selection.signatures import Signature, chords
from identify.selection.weighing import Both, Weighed
from measure.common.arrays import Array
from simulate.model.effect import Effect

FORCES = "stored-force-per-run"
_SHOWN = 1e-6  # of the noise, by a typical size
_CHORDS = 3.0  # of a size at which an effect is tried: one standard deviation of its prior
_LOSES = 3.0  # log evidence that a name costs at a first look, from which on a closer one brings nothing
_HALF = 0.5  # of what a name brings at a first look; one that brings less is not looked at in its place
_FEW = 3  # shapes of an effect that are weighed to the end


@dataclass(frozen=True)
class Promise:
    """A name more, instead of one that was there if any: its log evidence along straight lines.

    shape : the effect in the shape that promises most, None for an error of the model file that has no parameters of its own.
    base : (k,) parameters of base and releases to fit it from. sizes : (n,) of the effect's own. errors : of the model file, by name and
    place, in tolerances; None where it is likelier as it is. looks : a first look at every shape, and which of its parameters show.
    """

    name: str
    instead: str
    log_z: float
    shape: Effect | None
    base: Array
    sizes: Array
    errors: Mapping[tuple[str, int], float] | None
    looks: tuple[tuple[Gain, NDArray[np.bool_]], ...] = ()


def promises(at: Weighed, catalogue: Mapping[str, type[Effect]], instead: str = "") -> Iterator[Promise]:
    """What each effect of a catalogue and each error of the model file would say beside a fit.

    Parameters
    ----------
    instead : an effect of the fit that is taken out meanwhile; by default none.
    """
    taken = {*at.names, instead}
    stand, least = (at.doing_without(instead), _HALF * max(at.gain_of(instead), 0.0)) if instead else (at, -_LOSES)
    if FORCES not in taken and len(at.fit.problem.films) > 1:
        yield _of_forces(stand, instead)
    for name, kind in catalogue.items():
        effect = at.exact.given.model.effect(kind)
        if name not in taken and name != FORCES:
            yield from (_of_effect if effect.is_linear() else _of_sizes)(stand, effect, instead, least)


def _of_forces(at: Weighed, instead: str) -> Promise:
    """Stored forces that differ from run to run by more than their tolerance, which is a prior of the fit already."""
    own = [i for i, one in enumerate(at.fit.problem.parameters) if one.key == STORED_FORCE]
    m = at.fit.problem.measured
    both = at.beside(Columns.free(at.fit.jacobian[:m, own], float(np.sqrt(FORCES_DIFFER**2 - 1.0))))
    base, errors = _base(at, both), _errors(at, both)
    base[own] += both.likelier.amounts[-len(own) :]
    return Promise(FORCES, instead, both.log_z, None, base, np.empty(0), errors)


def _of_effect(at: Weighed, effect: Effect, instead: str, least: float) -> Iterator[Promise]:
    """An effect in all its shapes, which share its prior, as one promise that starts from the best; none where it does not show.

    A first look tells which shapes matter; these are weighed to the end, unless even the best gains less than `least`.
    """
    looks = [look for signature in at.signatures_of(effect) if (look := _look(at, signature)) is not None]
    if not looks:
        return
    gains = [at.first_look.gain(look.columns) for look in looks]
    shown = tuple((gain, look.shown) for gain, look in zip(gains, looks, strict=True))
    order = sorted(range(len(looks)), key=lambda i: -gains[i].log_z)
    own, few = {effect.name}, order[:_FEW]
    if max(gain.most for gain in gains) < least and effect.name not in at.within.errors.names:
        log_z = at.log_z + float(np.logaddexp.reduce([gains[i].log_z for i in few]) - np.log(len(looks)))
        yield _hopeless(at, looks[order[0]].shape, instead, log_z, shown)
        return
    found = [at.beside(looks[i].columns, own) for i in few]
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(looks)))
    best = int(np.argmax([one.log_z for one in found]))
    look, both = looks[order[best]], found[best]
    sizes = np.zeros(len(look.shown))
    sizes[look.shown] = np.clip(both.likelier.amounts[-look.columns.count :], look.columns.low, look.columns.high)
    yield Promise(effect.name, instead, log_z, look.shape, _base(at, both), sizes, _errors(at, both, own), shown)


def _of_sizes(at: Weighed, effect: Effect, instead: str, least: float) -> Iterator[Promise]:
    """An effect that is not linear, tried at several sizes that share its prior; a fit starts from the likeliest."""
    own, rows = {effect.name}, at.fit.problem.measured
    tried = [(one, change[:rows, None]) for one, change in chords(at.fit, effect) if np.linalg.norm(change[:rows]) > _SHOWN]
    if not tried:
        return
    columns = [Columns(column, np.array([_CHORDS]), np.zeros(1), np.zeros(1), np.array([np.inf])) for _, column in tried]
    gains = [at.first_look.gain(one) for one in columns]
    if max(gain.most for gain in gains) < least:
        log_z = at.log_z + float(np.logaddexp.reduce([gain.log_z for gain in gains]) - np.log(len(gains)))
        yield _hopeless(at, tried[0][0], instead, log_z)
        return
    found = [at.beside(one, own) for one in columns]
    log_z = float(np.logaddexp.reduce([one.log_z for one in found]) - np.log(len(found)))
    best = int(np.argmax([one.log_z for one in found]))
    shape, both = tried[best][0], found[best]
    yield Promise(effect.name, instead, log_z, shape, _base(at, both), np.zeros(len(shape.flat())), _errors(at, both, own))


def _hopeless(at: Weighed, shape: Effect, instead: str, log_z: float, looks: tuple[tuple[Gain, NDArray[np.bool_]], ...] = ()) -> Promise:
    """An effect that loses by its price: no fit will start from it."""
    return Promise(shape.name, instead, log_z, shape, _base(at, at.both), np.zeros(len(shape.flat())), _errors(at, at.both), looks)


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


def _errors(at: Weighed, both: Both, without: Collection[str] = ()) -> dict[tuple[str, int], float] | None:
    """Errors of the model file where an evidence has them; None where that takes it as it is."""
    if both.is_exact:
        return None
    keys = [key for key, free in zip(at.within.keys, at.within.free(without), strict=True) if free]
    return dict(zip(keys, both.likelier.errors.tolist(), strict=True))
