"""Where a hypothesis stands: a fit, and what the model file is taken to be wrong by there, as linear pieces; and how it is weighed there.

The errors of the model file within their tolerances are parameters with a prior, as base and releases are; behind the stops they act by no
straight line, so they are simulated where they are likeliest.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from identify.criteria import ANYWHERE, CLOSE, SAME, TWO_SIDED_95, UNUSUAL_P
from identify.estimation.covariance import Factored
from identify.estimation.least_squares import updated_slopes
from identify.estimation.problem import Fit, Problem
from identify.gap.gap_test import leaves_noise
from identify.gap.linear_pieces import Channel, Columns, Lines
from identify.gap.signatures import Signature, columns_of_shapes
from identify.noise.noise_model import ChannelNoise, log_probability, spacing
from identify.selection.evidence import ROUNDS, Both, Evidence, evidence
from identify.selection.first_look import FirstLook
from identify.selection.model_errors import ModelErrors, effect_spreads, model_errors
from measure.common.arrays import Array
from simulate.effects import StoredForcePerRun
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect
from simulate.model.rig import geometry_of

_PRICE = 3.0  # of an error that is let free, at most, in log evidence: it is known twenty times better than its tolerance


@dataclass(frozen=True)
class Stand:
    """A fit of a model file that is off by `sizes` (q,) of its errors, in tolerances.

    given : the model file itself, without these errors. left_out : an effect that is taken out along straight lines. is_fresh : whether the
    linear pieces were worked out right here. widely : whether its effects have the priors with which their numbers are stated.
    """

    given: Problem
    fit: Fit
    errors: ModelErrors
    sizes: Array
    left_out: str = ""
    is_fresh: bool = False
    widely: bool = False

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
        """With errors of the model file by their names and places."""
        errors = ModelErrors.possible(given)
        sizes = np.array([known.get(key, 0.0) for key in errors.keys])
        problem = _off_by(given, errors, sizes)
        fit = Fit(problem, q, *problem.jacobian(q, longer=True), True)
        return cls(given, fit, errors.at(fit), sizes, is_fresh=True)

    @classmethod
    def placed(cls, given: Problem, q: Array, known: Mapping[tuple[str, int], float]) -> Stand:
        """With these errors of the model file, or with the model file as it is where there are none."""
        return cls.off_by(given, q, known) if known else cls.exact(Fit(given, q, *given.jacobian(q, longer=True), True))

    @property
    def errors_by_key(self) -> dict[tuple[str, int], float]:
        """Size of each error by name and place, in tolerances."""
        return dict(zip(self.errors.keys, self.sizes.tolist(), strict=True))

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
        free = self.free(without)
        return self._lines.get(free.tobytes()) or self._lines.setdefault(free.tobytes(), self._lines_with(free))

    @cached_property
    def _lines(self) -> dict[bytes, Lines]:
        """As linear pieces so far, by which errors are free."""
        return {}

    def _lines_with(self, kept: NDArray[np.bool_]) -> Lines:
        fit, m, first = self.fit, self.fit.problem.measured, self.fit.problem.first_effect
        channels = tuple(Channel(block.rows, spacing(block.samples)) for block in fit.problem.blocks)
        off = self.errors.sizes_along_lines(self.given.model, fit.problem.model)
        gaps = fit.gaps[:m] - fit.jacobian[:m, self._out] @ fit.q[self._out] - self.errors.columns[:, ~kept] @ off[~kept]
        spreads = np.array([one.spread for one in fit.problem.parameters[:first]])
        log_spread = float(np.sum(np.log(spreads[np.isfinite(spreads)])))
        known, errors, at = self.known, self.errors.columns[:, kept], self.sizes[kept]
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

    def across_p(self, found: Evidence) -> float:
        """How probable it is that what changes its sign in a mirror is as far off as an evidence has it; of two mirrors the less.

        In these mirrors the films look nearly the same: of all that is improbable here only this may be probable there.
        """
        return min((found.p_of(self._across(axis, turned)) for axis, turned in self.given.mirrors()), default=1.0)

    def _across(self, axis: int, turned: Sequence[int]) -> Array:
        """What changes its sign in a mirror across an axis, as a projection of what is known beforehand and the errors that are free."""
        rows, free = np.isin(np.argmax(self.fit.jacobian[self.known] != 0.0, axis=1), turned), self.free()
        odd = self.errors.odd_part(axis, geometry_of(self.given.model))[np.ix_(free, free)]
        return np.asarray(linalg.block_diag(np.diag(rows), odd), dtype=float)

    @cached_property
    def columns(self) -> Columns:
        """What the hypothesis adds: its effects where they stand. Surely they are as large as there, less two standard errors."""
        fit, m, first = self.fit, self.fit.problem.measured, self.fit.problem.first_effect
        kept = np.setdiff1d(np.arange(first, len(fit.q)), self._out)
        information = fit.jacobian.T @ fit.jacobian + ANYWHERE**-2.0 * np.eye(len(fit.q))
        deviation = np.sqrt(np.diag(Factored.of(information).inverse)[kept])
        sure = np.abs(fit.q[kept]) - TWO_SIDED_95 * deviation
        spread = effect_spreads(fit.problem, kept, sure, widely=self.widely)
        return Columns(fit.jacobian[:m, kept], spread, fit.q[kept], *self.bounds[:, kept])

    @property
    def _out(self) -> NDArray[np.intp]:
        """Places of the parameters of the effect that is left out."""
        return self.fit.problem.rows_of(self.left_out) if self.left_out else np.empty(0, dtype=np.intp)

    @property
    def bounds(self) -> Array:
        """Of all parameters, (2, k)."""
        return np.array([(one.low, one.high) for one in self.fit.problem.parameters]).reshape(-1, 2).T

    def weighed(self, noise: tuple[ChannelNoise, ...] = (), same: float = SAME) -> Evidence:
        """Its log evidence along straight lines from here, see `evidence`."""
        return evidence(self.lines(), self.columns, noise, same=same)

    def step(self, found: Evidence) -> Array:
        """How far each parameter of the fit is from where an evidence has it, (k,)."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        return np.concatenate([found.step, found.amounts[: last - first] - self.fit.q[first:]])

    def with_errors(self, sizes: Array) -> Problem:
        """The problem with the model file off by other sizes of its errors."""
        return _off_by(self.given, self.errors, sizes)

    def at(self, problem: Problem, q: Array, sizes: Array) -> Stand:
        """Simulated anew elsewhere, with new linear pieces."""
        gaps, jacobian = problem.jacobian(q, longer=True)
        fit = Fit(problem, q, gaps, jacobian, self.fit.converged)
        return replace(self, fit=fit, errors=self.errors.at(fit), sizes=sizes, is_fresh=True)

    @cached_property
    def anew(self) -> Stand:
        """The same with linear pieces that are worked out right here."""
        return self.at(self.fit.problem, self.fit.q, self.sizes)

    def moved_to(self, problem: Problem, q: Array, sizes: Array, gaps: Array) -> Stand:
        """Moved elsewhere, where the gaps are known; linear pieces are updated by what the way has shown where they predicted it."""
        k, m = len(q), problem.measured
        slopes = np.zeros((len(gaps), k + len(sizes)))
        slopes[:, :k], slopes[:m, k:] = self.fit.jacobian, self.errors.columns
        updated = updated_slopes(slopes, np.concatenate([q - self.fit.q, sizes - self.sizes]), gaps - self.fit.gaps)
        if updated is None:
            return self.at(problem, q, sizes)
        fit = Fit(problem, q, gaps, updated[:, :k], self.fit.converged)
        return replace(self, fit=fit, errors=replace(self.errors, columns=updated[:m, k:]), sizes=sizes, is_fresh=False)

    @cached_property
    def misses(self) -> bool:
        """Whether the measurements are far off: by more than their noise, which may be larger than it is said to be."""
        return self.fit.rms >= CLOSE and not leaves_noise(self.fit, self.weighed().noise)

    def borne_out(self, found: Evidence) -> Evidence:
        """An evidence along straight lines from here, with what these promise beyond the simulation at this very place.

        A stand that no step improves may still promise much: behind the stops straight lines lead nowhere.
        """
        return replace(found, unkept=max(found.log_likelihood - self.log_probability(found.noise), 0.0))

    def log_probability(self, noise: tuple[ChannelNoise, ...]) -> float:
        """Of measurements and parameters as simulated here."""
        return self.log_probability_at(self.fit.gaps, self.fit.q, self.sizes, noise)

    def log_probability_at(self, gaps: Array, q: Array, sizes: Array, noise: tuple[ChannelNoise, ...]) -> float:
        """Of gaps as simulated elsewhere, and of the parameters there."""
        blocks, first, known = self.fit.problem.blocks, self.fit.problem.first_effect, gaps[self.known]
        likelihood = sum(log_probability(of, gaps[b.rows], spacing(b.samples)) for of, b in zip(noise, blocks, strict=True))
        beyond = q[first:] / self.columns.spread
        return likelihood - 0.5 * float(known @ known + sizes @ sizes + beyond @ beyond)


def _off_by(given: Problem, errors: ModelErrors, sizes: Array) -> Problem:
    """A problem with its model file off by sizes (q,) of some errors."""
    effects = errors.effects(given, sizes)
    return given.with_model(lambda model: add_effects(model, effects)) if effects else given


@dataclass(frozen=True)
class Weighed:
    """Where a hypothesis stands with the model file as it is, and with its errors where they are likeliest.

    signatures : what each effect does to the gaps here, once it was simulated, by its name.
    """

    exact: Stand
    within: Stand
    both: Both
    signatures: dict[str, list[Signature]] = field(default_factory=dict, repr=False)

    @property
    def stand(self) -> Stand:
        """The likelier of both."""
        return self.exact if self.both.is_exact else self.within

    @property
    def fit(self) -> Fit:
        """The fit there; the model of its problem has the errors of the model file."""
        return self.stand.fit

    @property
    def evidence(self) -> Evidence:
        """The evidence there."""
        return self.both.likelier

    @property
    def log_z(self) -> float:
        """Its log evidence, over both."""
        return self.both.log_z

    @property
    def names(self) -> set[str]:
        """What the hypothesis adds to the model."""
        return self.exact.names

    @property
    def along_lines(self) -> float:
        """Its log evidence as straight lines have it, see `Both`."""
        return self.both.along_lines

    def gain_of(self, name: str) -> float:
        """What a first look says that one of its effects brings, once it is left out."""
        stand, own = self.stand, self.stand.columns
        rows = stand.fit.problem.rows_of(name) - stand.fit.problem.first_effect
        alone = Columns(own.values[:, rows], own.spread[rows], np.zeros(len(rows)), own.low[rows], own.high[rows])
        return self.doing_without(name).first_look.gain(alone).log_z

    def beside(
        self,
        columns: Columns,
        without: Collection[str] = (),
        noise: tuple[ChannelNoise, ...] = (),
        rounds: int = ROUNDS,
        shift: Array | float = 0.0,
    ) -> Both:
        """Columns weighed beside what is there.

        Parameters
        ----------
        without : kinds of errors of the model file that are not let free beside them.
        shift : (m,) what their effect does to the gaps at the amounts at which they were taken, where these are not nought.
        """
        exact, within = self.exact, self.within
        noise, lines, as_it_is = noise or self.evidence.noise, within.lines(without).shifted(shift), exact.lines().shifted(shift)

        def of(stand: Stand, own: Lines, floor: float = -np.inf) -> Evidence:
            return evidence(own, stand.columns.beside(columns), noise, rounds, floor)

        if not lines.errors.shape[1]:
            return Both(of(exact, as_it_is), None)
        if self.both.is_exact:
            first = of(exact, as_it_is)
            return Both(first, of(within, lines, first.log_likelihood))
        second = of(within, lines)
        return Both(of(exact, as_it_is, second.log_likelihood - _PRICE * lines.errors.shape[1]), second)

    @cached_property
    def first_look(self) -> FirstLook:
        """The likelier stand, ready for a first look at further columns."""
        return FirstLook(self.evidence)

    def doing_without(self, name: str) -> Weighed:
        """The same without one of its effects, along straight lines: nothing is simulated anew."""
        exact, within, noise = self.exact.doing_without(name), self.within.doing_without(name), self.evidence.noise
        loose = within.weighed(noise) if within.lines().errors.shape[1] else None
        return replace(self, exact=exact, within=within, both=Both(exact.weighed(noise), loose))

    def signatures_of(self, effect: Effect) -> list[Signature]:
        """What an effect does to the gaps in each of its shapes."""
        if effect.name not in self.signatures:
            known = self.within.errors.signature_of(effect, self.within.given, self.within.fit.problem.model)
            self.signatures[effect.name] = columns_of_shapes(self.fit, effect) if known is None else [known]
        return self.signatures[effect.name]

    def better_of(self, other: Weighed) -> Weighed:
        """Of two of the same hypothesis the likelier stand of each kind."""
        exact = max((self, other), key=lambda one: one.both.exact.kept)
        within = max((self, other), key=lambda one: -np.inf if one.both.within is None else one.both.within.kept)
        return Weighed(exact.exact, within.within, Both(exact.both.exact, within.both.within))

    @cached_property
    def leaves_noise(self) -> bool:
        """Whether what it leaves, as simulated, is noise."""
        return leaves_noise(self.fit, self.evidence.noise)

    @property
    def is_unusual(self) -> bool:
        """Whether it leaves more than noise, or stands where base, releases or errors of the model file are improbable."""
        return not self.leaves_noise or self.evidence.prior_p < UNUSUAL_P

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters of the fit, (k, k), in scales, the errors of the model file integrated out."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        errors = self.evidence.lines.errors.shape[1]
        own = np.r_[0:first, first + errors : last + errors]
        return self.evidence.covariance[np.ix_(own, own)]
