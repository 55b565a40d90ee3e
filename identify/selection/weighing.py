"""A fit weighed: its linear pieces, the tolerances of the model file, the noise of each channel, and its log evidence."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.criteria import EFFECT_SPREAD, NOTHING, SURE_MISFIT, WITHIN
from identify.estimation.fit import Fit
from identify.estimation.noise_model import ChannelNoise, spacing
from identify.gap.gap_test import is_noise
from identify.gap.misfit import misfit_of
from identify.selection.evidence import ROUNDS, Channel, Columns, Evidence, Lines, evidence
from identify.selection.model_errors import ModelErrors, model_errors
from identify.selection.signatures import Signature, columns_of_shapes
from measure.common.arrays import Array
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect

_LOG_SHARES = float(np.log(NOTHING / (NOTHING + WITHIN))), float(np.log(WITHIN / (NOTHING + WITHIN)))
_ROUNDS, _MOVED = 3, 0.1  # a step within so many standard deviations changes nothing


@dataclass(frozen=True)
class Weighed:
    """A fit and what the model file may be wrong by there.

    left_out : an effect that is taken out again.
    signatures : what each effect does to the gaps here, once it was simulated, by its name.
    """

    fit: Fit
    errors: ModelErrors
    noise: tuple[ChannelNoise, ...] = ()
    left_out: str = ""
    signatures: dict[str, list[Signature]] = field(default_factory=dict, repr=False)

    @property
    def names(self) -> set[str]:
        """What the hypothesis adds to the model."""
        forces = {"stored-force-per-run"} if self.fit.problem.forces_differ else set()
        return {*forces, *(effect.name for effect in self.fit.problem.effects)}

    def signatures_of(self, effect: Effect) -> list[Signature]:
        """What an effect does to the gaps in each of its shapes."""
        if effect.name not in self.signatures:
            self.signatures[effect.name] = columns_of_shapes(self.fit, effect)
        return self.signatures[effect.name]

    def doing_without(self, name: str) -> Weighed:
        """The same fit without one of its effects, along straight lines: nothing is simulated anew."""
        return replace(self, left_out=name)

    @property
    def tolerances(self) -> ModelErrors:
        """What the model file may be wrong by besides what the hypothesis itself adds."""
        return self.errors.without(self.names - {self.left_out})

    @cached_property
    def lines(self) -> Lines:
        """The fit as linear pieces; an effect of the model file that is fitted itself has no tolerance beside it."""
        fit, m, first = self.fit, self.fit.problem.measured, self.fit.problem.first_effect
        channels = tuple(Channel(block.rows, spacing(block.samples)) for block in fit.problem.blocks)
        errors = self.tolerances.columns
        gaps = fit.gaps[:m] - fit.jacobian[:m, self._out] @ fit.q[self._out]
        spreads = np.array([one.spread for one in fit.problem.parameters[:first]])
        log_spread = float(np.sum(np.log(spreads[np.isfinite(spreads)])))
        known = m + np.flatnonzero(np.any(fit.jacobian[m:, :first] != 0.0, axis=1))
        return Lines(gaps, fit.jacobian[:m, :first], errors, fit.gaps[known], fit.jacobian[known, :first], channels, log_spread)

    @cached_property
    def columns(self) -> Columns:
        """What the hypothesis adds: its effects where they stand, and what goes beyond a tolerance."""
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

    @cached_property
    def both(self) -> Both:
        """It weighed with the model file as it is, and as far off as its tolerances allow."""
        return weighed_both_ways(self.lines, self.columns, self.noise)

    @property
    def log_z(self) -> float:
        """Its log evidence, over both."""
        return self.both.log_z

    @property
    def evidence(self) -> Evidence:
        """The likelier of both."""
        return self.both.likelier

    @property
    def leaves_noise(self) -> bool:
        """Whether what it leaves is noise: noise forgets within a few samples, and does not come again in every cycle.

        What the tolerances of the model file are to explain is simulated, for straight lines may promise more than they keep.
        """
        left = self._left_with_errors if self.evidence.lines.errors.shape[1] else self.evidence.left
        return is_noise(left) and not self._comes_again

    @property
    def _left_with_errors(self) -> list[Array]:
        """Innovations that a simulation with the errors of the model file leaves, as this hypothesis has them, channel by channel."""
        found, problem = self.evidence, self.fit.problem
        effects = self.tolerances.effects(problem.model, found.errors)
        q = np.clip(self.fit.q + self.step, *self.bounds)
        gaps = problem.with_model(lambda model: add_effects(model, effects)).gaps(q)
        return [noise.whitened(gaps[one.rows], one.apart) for noise, one in zip(found.noise, found.lines.channels, strict=True)]

    @property
    def _comes_again(self) -> bool:
        """Whether loops have a gap as large as their noise that comes again in every cycle."""
        loops = [loop.data for loop in self.fit.problem.loops]
        if not loops:
            return False
        left = misfit_of(loops, self.fit.residuals_N)
        over = left.repeated_N / np.array([data.force_sigma_N for data in loops])
        return bool(left.significance > SURE_MISFIT and np.max(over) > 1.0)

    @property
    def step(self) -> Array:
        """How far each parameter of the fit is from where the evidence has it, (k,)."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        return np.concatenate([self.evidence.step, self.evidence.amounts[: last - first] - self.fit.q[first:]])

    @property
    def deviations(self) -> Array:
        """One standard deviation of each parameter of the fit, (k,), in scales."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def shares_of_errors(self) -> dict[str, float]:
        """How much each kind of error of the model file moves the measurements under this hypothesis; the shares add up to one."""
        found = self.both.within
        if found is None:
            return {}
        names = self.tolerances.names
        moved = {
            name: self.tolerances.of(name) @ found.errors[[i for i, other in enumerate(names) if other == name]]
            for name in dict.fromkeys(names)
        }
        sizes = {name: float(gap @ gap) for name, gap in moved.items()}
        whole = sum(sizes.values())
        return {name: size / whole for name, size in sizes.items()} if whole > 0.0 else {}

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters of the fit, (k, k), in scales, the errors of the model file integrated out."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        errors = self.evidence.lines.errors.shape[1]
        own = np.r_[0:first, first + errors : last + errors]
        return self.evidence.covariance[np.ix_(own, own)]


@dataclass(frozen=True)
class Both:
    """A hypothesis weighed with the model file as it is, and as far off as its tolerances allow; None where it has none that show."""

    exact: Evidence
    within: Evidence | None

    @property
    def log_z(self) -> float:
        """The log evidence over both."""
        return self.exact.log_z if self.within is None else float(np.logaddexp(*self._parts))

    @property
    def likelier(self) -> Evidence:
        """The one with more weight."""
        return self.exact if self.within is None or self._parts[0] >= self._parts[1] else self.within

    @property
    def share_of_exact(self) -> float:
        """Probability of the model file as it is, under this hypothesis."""
        return 1.0 if self.within is None else float(np.exp(self._parts[0] - self.log_z))

    @property
    def _parts(self) -> tuple[float, float]:
        assert self.within is not None
        return self.exact.log_z + _LOG_SHARES[0], self.within.log_z + _LOG_SHARES[1]


def weighed_both_ways(lines: Lines, columns: Columns, noise: tuple[ChannelNoise, ...], rounds: int = ROUNDS) -> Both:
    """Weigh columns beside a fit, the model file exact and within its tolerances."""
    exact = evidence(lines.exact, columns, noise, rounds)
    return Both(exact, evidence(lines, columns, exact.noise, rounds) if lines.errors.shape[1] else None)


def weighed(fit: Fit) -> Weighed:
    """Take a fit to the largest probability under coloured noise and tolerances, and weigh it there.

    Least squares have taken the noise for white and the model file for exact, so the fit is close but not there. Steps of Gauss and
    Newton follow as long as they raise the evidence.
    """
    found = Weighed(fit, model_errors(fit))
    for _ in range(_ROUNDS):
        if np.max(np.abs(found.step) / np.maximum(found.deviations, 1e-300), initial=0.0) < _MOVED:
            break
        q = np.clip(found.fit.q + found.step, *found.bounds)
        gaps, jacobian = fit.problem.jacobian(q)
        after = replace(found, fit=Fit(fit.problem, q, gaps, jacobian, fit.converged), noise=found.evidence.noise, signatures={})
        if after.log_z < found.log_z:
            break
        found = after
    return found
