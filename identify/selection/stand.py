"""Where a hypothesis stands: a fit, and what the model file is taken to be wrong by there, as linear pieces and with a way to better ones.

The errors of the model file within their tolerances are parameters with a prior, as base and releases are; behind the stops they act by no
straight line, so they are simulated where they are likeliest.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.criteria import CLOSE, EFFECT_SPREAD
from identify.estimation.horizons import horizons
from identify.estimation.least_squares import updated_slopes
from identify.estimation.noise_model import ChannelNoise, log_likelihood, spacing
from identify.estimation.problem import Fit, Problem
from identify.selection.evidence import Channel, Columns, Evidence, Lines, evidence
from identify.selection.model_errors import ModelErrors, model_errors, tolerance_of
from identify.selection.signatures import Signature
from measure.common.arrays import Array
from simulate.effects import StoredForcePerRun
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect
from simulate.model.model import Model

_MOST_STEPS, _NEAR = 10, 0.1  # a step within so many standard deviations changes nothing
_HARDLY = 0.5  # of a log probability, that a step promises
_SHARES = (1.0, 0.5, 0.2)  # of a step that are tried


@dataclass(frozen=True)
class Stand:
    """A fit of a model file that is off by `sizes` (q,) of its errors, in tolerances.

    given : the model file itself, without these errors. left_out : an effect that is taken out along straight lines. is_fresh : whether the
    linear pieces were worked out right here.
    """

    given: Problem
    fit: Fit
    errors: ModelErrors
    sizes: Array
    left_out: str = ""
    is_fresh: bool = False

    @classmethod
    def exact(cls, fit: Fit) -> Stand:
        """With the model file as it is."""
        none = ModelErrors.none(fit.problem.measured)
        return cls(fit.problem, fit, none, np.empty(0))

    @classmethod
    def loose(cls, fit: Fit) -> Stand:
        """With errors of the model file that are nought so far."""
        errors = model_errors(fit)
        return cls(fit.problem, fit, errors, np.zeros(len(errors.names)))

    @classmethod
    def off_by(cls, given: Problem, q: Array, known: Mapping[tuple[str, int], float]) -> Stand:
        """With errors of the model file by their names and places, as far as they show."""
        zero = cls.loose(Fit(given, q, *given.jacobian(q), True))
        sizes = np.array([known.get(key, 0.0) for key in zero.keys])
        return zero.at(zero.with_errors(sizes), q, sizes)

    @property
    def keys(self) -> tuple[tuple[str, int], ...]:
        """Name and place of each error."""
        return tuple(zip(self.errors.names, self.errors.places, strict=True))

    @property
    def errors_by_key(self) -> dict[tuple[str, int], float]:
        """Size of each error by name and place, in tolerances."""
        return dict(zip(self.keys, self.sizes.tolist(), strict=True))

    def free(self, without: Collection[str] = ()) -> NDArray[np.bool_]:
        """Which errors are free (q,): not those of an effect that is fitted, nor some further kinds."""
        out = {*(self.names - {self.left_out}), *without}
        return np.array([name not in out for name in self.errors.names], dtype=bool)

    @property
    def names(self) -> set[str]:
        """What the hypothesis adds to the model."""
        forces = {StoredForcePerRun.name} if self.fit.problem.forces_differ else set()
        return {*forces, *(effect.name for effect in self.fit.problem.effects)}

    def doing_without(self, name: str) -> Stand:
        """The same without one of the effects, along straight lines: nothing is simulated anew."""
        return replace(self, left_out=name)

    def lines(self, without: Collection[str] = ()) -> Lines:
        """The fit as linear pieces, some kinds of errors taken out. What is fitted itself has no tolerance beside it."""
        fit, m, first = self.fit, self.fit.problem.measured, self.fit.problem.first_effect
        channels = tuple(Channel(block.rows, spacing(block.samples)) for block in fit.problem.blocks)
        kept = self.free(without)
        gaps = fit.gaps[:m] - fit.jacobian[:m, self._out] @ fit.q[self._out] - self.errors.columns[:, ~kept] @ self.sizes[~kept]
        spreads = np.array([one.spread for one in fit.problem.parameters[:first]])
        log_spread = float(np.sum(np.log(spreads[np.isfinite(spreads)])))
        known = self.known
        errors, at = self.errors.columns[:, kept], self.sizes[kept]
        return Lines(gaps, fit.jacobian[:m, :first], errors, at, fit.gaps[known], fit.jacobian[known, :first], channels, log_spread)

    @property
    def origin(self) -> Array:
        """Base and releases as the model file has them, the effects as they are, (k,)."""
        first = self.fit.problem.first_effect
        return np.concatenate([self.given.start[:first], self.fit.q[first:]])

    @property
    def known(self) -> NDArray[np.intp]:
        """Rows of what is known of base and releases beforehand."""
        m, first = self.fit.problem.measured, self.fit.problem.first_effect
        return m + np.flatnonzero(np.any(self.fit.jacobian[m:, :first] != 0.0, axis=1))

    def signature_of(self, effect: Effect) -> Signature | None:
        """What an effect does to the gaps that is an error of the model file, per typical size; None of any other."""
        mine = [i for i, name in enumerate(self.errors.names) if name == effect.name]
        if not mine:
            return None
        places, measures = [self.errors.places[i] for i in mine], self.given.measures
        columns = np.zeros((self.given.measured, len(effect.flat())))
        columns[:, places] = self.errors.columns[:, mine] * (effect.typical(measures) / tolerance_of(effect, self.given.model))[places]
        return effect, tuple(effect.own_bounds(self.given.model, measures).values()), columns

    @cached_property
    def columns(self) -> Columns:
        """What the hypothesis adds: its effects where they stand."""
        fit, m, first = self.fit, self.fit.problem.measured, self.fit.problem.first_effect
        kept = np.setdiff1d(np.arange(first, len(fit.q)), self._out)
        low, high = self.bounds[:, kept]
        spread = np.minimum([fit.problem.parameters[k].spread for k in kept], EFFECT_SPREAD) if len(kept) else np.empty(0)
        return Columns(fit.jacobian[:m, kept], spread, fit.q[kept], low, high)

    @property
    def _out(self) -> NDArray[np.intp]:
        """Places of the parameters of the effect that is left out."""
        return self.fit.problem.rows_of(self.left_out) if self.left_out else np.empty(0, dtype=np.intp)

    @property
    def bounds(self) -> Array:
        """Of all parameters, (2, k)."""
        return np.array([(one.low, one.high) for one in self.fit.problem.parameters]).reshape(-1, 2).T

    def weighed(self, noise: tuple[ChannelNoise, ...] = ()) -> Evidence:
        """Its log evidence along straight lines from here."""
        return evidence(self.lines(), self.columns, noise)

    def step(self, found: Evidence) -> Array:
        """How far each parameter of the fit is from where an evidence has it, (k,)."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        return np.concatenate([found.step, found.amounts[: last - first] - self.fit.q[first:]])

    @property
    def moved(self) -> tuple[tuple[Effect, float], ...]:
        """What of the model file was moved, and by how many tolerances (root mean square of its parameters), the farthest first."""
        free = self.free()
        made = [one for one in self.errors.effects(self.given, np.where(free, self.sizes, 0.0)) if one.name not in self.names]
        of = {one.name: [size for name, size in zip(self.errors.names, self.sizes, strict=True) if name == one.name] for one in made}
        rows = [(one, float(np.sqrt(np.mean(np.square(of[one.name]))))) for one in made]
        return tuple(sorted((row for row in rows if row[1] > 0.0), key=lambda row: -row[1]))

    def with_errors(self, sizes: Array) -> Problem:
        """The problem with the model file off by other sizes of its errors."""
        effects = self.errors.effects(self.given, sizes)

        def off(model: Model) -> Model:
            return add_effects(model, effects)

        return self.given.with_model(off) if effects else self.given

    def at(self, problem: Problem, q: Array, sizes: Array) -> Stand:
        """Simulated anew elsewhere, with new linear pieces."""
        gaps, jacobian = problem.jacobian(q)
        fit = Fit(problem, q, gaps, jacobian, self.fit.converged)
        return replace(self, fit=fit, errors=self.errors.at(fit), sizes=sizes, is_fresh=True)

    @cached_property
    def anew(self) -> Stand:
        """The same with linear pieces that are worked out right here."""
        return self.at(self.fit.problem, self.fit.q, self.sizes)

    def moved_to(self, problem: Problem, q: Array, sizes: Array) -> Stand:
        """Simulated anew elsewhere; the linear pieces are updated by what the way has shown where they foresaw it."""
        gaps, k, m = problem.gaps(q), len(q), problem.measured
        slopes = np.zeros((len(gaps), k + len(sizes)))
        slopes[:, :k], slopes[:m, k:] = self.fit.jacobian, self.errors.columns
        updated = updated_slopes(slopes, np.concatenate([q - self.fit.q, sizes - self.sizes]), gaps - self.fit.gaps)
        if updated is None:
            return self.at(problem, q, sizes)
        fit = Fit(problem, q, gaps, updated[:, :k], self.fit.converged)
        return replace(self, fit=fit, errors=replace(self.errors, columns=updated[:m, k:]), sizes=sizes, is_fresh=False)

    def log_probability(self, problem: Problem, q: Array, sizes: Array, noise: tuple[ChannelNoise, ...], rows: NDArray[np.intp]) -> float:
        """Of measurements and parameters at a place, as simulated there, but for a constant."""
        gaps, first = problem.gaps(q), problem.first_effect
        lines = zip(noise, problem.blocks, strict=True)
        likelihood = sum(log_likelihood(of.whitened(gaps[b.rows], spacing(b.samples))) for of, b in lines)
        beyond = q[first:] / self.columns.spread
        return likelihood - 0.5 * float(gaps[rows] @ gaps[rows] + sizes @ sizes + beyond @ beyond)


def settled(stand: Stand, noise: tuple[ChannelNoise, ...] = ()) -> tuple[Stand, Evidence]:
    """A stand taken to the largest probability under coloured noise, and its evidence there.

    Steps of Gauss and Newton, shortened where the simulation does not keep what the straight lines promise, as long as they raise the
    probability of measurements and parameters. Where nothing is added to the model and films are far off, they are met up to the first stop
    first, and then ever further.
    """
    if len(stand.sizes) and not stand.names and stand.fit.rms > CLOSE:
        stand = _from_afar(stand)
    return _stepped(stand, stand.weighed(noise))


def _from_afar(stand: Stand) -> Stand:
    """A stand led by ever longer films, from where it is; where that leaves a gap also from the model file as it is."""
    led = _led(stand, stand.fit.q, stand.sizes)
    if led.fit.rms < CLOSE:
        return led
    return max(led, _led(stand, stand.origin, np.zeros(len(stand.sizes))), key=lambda one: one.weighed().log_z)


def _led(stand: Stand, q: Array, sizes: Array) -> Stand:
    for horizon in horizons(stand.given):
        cut = replace(stand, given=stand.given.until(horizon))
        early = cut.at(cut.with_errors(sizes), q, sizes)
        early, _ = _stepped(early, early.weighed())
        q, sizes = early.fit.q, early.sizes
    there = stand.at(stand.with_errors(sizes), q, sizes)
    return _stepped(there, there.weighed())[0]


def _stepped(stand: Stand, found: Evidence) -> tuple[Stand, Evidence]:
    for _ in range(_MOST_STEPS):
        after = _a_step_on(stand, found) or (None if stand.is_fresh else stand.anew)
        if after is None:
            return stand, found
        stand, found = after, after.weighed(found.noise)
    return (stand, found) if stand.is_fresh else (stand.anew, stand.anew.weighed(found.noise))


def _a_step_on(stand: Stand, found: Evidence) -> Stand | None:
    """The stand a step farther; None where no step is worth it or none of them raises the probability."""
    kept = stand.free()
    step, change = stand.step(found), np.zeros(len(stand.sizes))
    change[kept] = found.errors - stand.sizes[kept]
    deviations = np.sqrt(np.maximum(np.diag(found.covariance), 1e-300))
    way = np.max(np.abs(np.concatenate([step[: len(found.step)], change[kept], step[len(found.step) :]])) / deviations, initial=0.0)
    if way < _NEAR:
        return None
    rows, (low, high) = stand.known, stand.bounds
    here = stand.log_probability(stand.fit.problem, stand.fit.q, stand.sizes, found.noise, rows)
    for share in _SHARES:
        q, sizes = np.clip(stand.fit.q + share * step, low, high), stand.sizes + share * change
        problem = stand.with_errors(sizes)
        if stand.log_probability(problem, q, sizes, found.noise, rows) > here + _HARDLY:
            return stand.moved_to(problem, q, sizes)
    return None
