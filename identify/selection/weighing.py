"""A hypothesis weighed: with the model file as it is, and as far off as its tolerances allow."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from identify.criteria import CLOSE, CREDIBLE, NOTHING, ROUGHLY, SURE_MISFIT, WITHIN
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.noise_model import ChannelNoise, spacing
from identify.estimation.problem import Fit, Problem
from identify.gap.gap_test import is_noise
from identify.gap.misfit import misfit_of
from identify.selection.evidence import ROUNDS, Columns, Evidence, evidence
from identify.selection.first_look import FirstLook
from identify.selection.signatures import Signature, columns_of_shapes
from identify.selection.stand import Stand, settled
from measure.common.arrays import Array
from simulate.model.effect import Effect

_FEW_STEPS = 8
_PRICE = 3.0  # of an error that is let free, at most, in log evidence: it is known twenty times better than its tolerance
_LOG_SHARES = float(np.log(NOTHING / (NOTHING + WITHIN))), float(np.log(WITHIN / (NOTHING + WITHIN)))


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
    def is_exact(self) -> bool:
        """Whether the model file as it is has more weight."""
        return self.within is None or self._parts[0] >= self._parts[1]

    @property
    def likelier(self) -> Evidence:
        """The one with more weight."""
        return self.exact if self.within is None or self.is_exact else self.within

    @property
    def share_of_exact(self) -> float:
        """Probability of the model file as it is, under this hypothesis."""
        return 1.0 if self.within is None else float(np.exp(self._parts[0] - self.log_z))

    @property
    def _parts(self) -> tuple[float, float]:
        assert self.within is not None
        return self.exact.log_z + _LOG_SHARES[0], self.within.log_z + _LOG_SHARES[1]


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

    def gain_of(self, name: str) -> float:
        """What a first look says that one of its effects brings, once it is left out."""
        stand = self.stand
        rows = stand.fit.problem.rows_of(name) - stand.fit.problem.first_effect
        own = stand.columns
        alone = Columns(own.values[:, rows], own.spread[rows], np.zeros(len(rows)), own.low[rows], own.high[rows])
        return self.doing_without(name).first_look.gain(alone).log_z

    def beside(self, columns: Columns, without: Collection[str] = (), noise: tuple[ChannelNoise, ...] = (), rounds: int = ROUNDS) -> Both:
        """Columns weighed beside what is there.

        Parameters
        ----------
        without : kinds of errors of the model file that are not let free beside them.
        """
        exact, within = self.exact, self.within
        noise, lines = noise or self.evidence.noise, within.lines(without)

        def of_exact(floor: float = -np.inf) -> Evidence:
            return evidence(exact.lines(), exact.columns.beside(columns), noise, rounds, floor)

        def of_within(floor: float = -np.inf) -> Evidence:
            return evidence(lines, within.columns.beside(columns), noise, rounds, floor)

        if not lines.errors.shape[1]:
            return Both(of_exact(), None)
        if self.both.is_exact:
            first = of_exact()
            return Both(first, of_within(first.log_likelihood))
        second = of_within()
        return Both(of_exact(second.log_likelihood - _PRICE * lines.errors.shape[1]), second)

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
            known = self.within.signature_of(effect)
            self.signatures[effect.name] = columns_of_shapes(self.fit, effect) if known is None else [known]
        return self.signatures[effect.name]

    def better_of(self, other: Weighed) -> Weighed:
        """Of two of the same hypothesis the likelier stand of each kind."""
        exact = max((self, other), key=lambda one: one.both.exact.log_z)
        loose = [one for one in (self, other) if one.both.within is not None]
        within = max(loose, key=lambda one: one.both.within.log_z if one.both.within is not None else -np.inf, default=exact)
        return Weighed(exact.exact, within.within, Both(exact.both.exact, within.both.within))

    def from_another(self, fit: Fit) -> Weighed:
        """The same hypothesis from another fit of the likelier stand."""
        if self.both.is_exact:
            return weighed(fit)
        within, found = settled(replace(self.within, fit=fit, errors=self.within.errors.at(fit)), self.evidence.noise)
        return Weighed(self.exact, within, Both(self.both.exact, found))

    @cached_property
    def leaves_noise(self) -> bool:
        """Whether what it leaves, as simulated, is noise: noise forgets within a few samples, and does not come again in every cycle."""
        gaps, blocks = self.fit.gaps, self.fit.problem.blocks
        left = [of.whitened(gaps[b.rows], spacing(b.samples)) for of, b in zip(self.evidence.noise, blocks, strict=True)]
        return is_noise(left) and not self._comes_again

    @property
    def _comes_again(self) -> bool:
        """Whether loops have a gap as large as their noise that comes again in every cycle."""
        loops = [loop.data for loop in self.fit.problem.loops]
        if not loops:
            return False
        left = misfit_of(loops, self.fit.residuals_N)
        over = left.repeated_N / np.array([data.force_sigma_N for data in loops])
        return bool(left.significance > SURE_MISFIT and np.max(over) > 1.0)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters of the fit, (k, k), in scales, the errors of the model file integrated out."""
        first, last = self.fit.problem.first_effect, len(self.fit.q)
        errors = self.evidence.lines.errors.shape[1]
        own = np.r_[0:first, first + errors : last + errors]
        return self.evidence.covariance[np.ix_(own, own)]


def weighed(fit: Fit) -> Weighed:
    """Take a fit to the largest probability under coloured noise and tolerances, and weigh it there.

    Least squares have taken the noise for white and the model file for exact. Where its tolerances may matter they are simulated, too.
    """
    exact, found = settled(Stand.exact(fit))
    loose = Stand.loose(exact.fit)
    if loops_miss(exact.fit):
        return Weighed(exact, loose, Both(found, None))
    both = _both(found, loose)
    if both.share_of_exact > CREDIBLE:
        return Weighed(exact, loose, both)
    within, of_within = settled(loose, found.noise)
    return Weighed(exact, within, Both(found, of_within))


def loops_miss(fit: Fit) -> bool:
    """Whether the loops by themselves are missed: then no tolerance helps, for a shaker knows nothing of the rig."""
    if not fit.problem.films or not fit.problem.loops:
        return False
    alone = replace(fit.problem, films=())
    return solve(alone, laid_out(fit, alone), enough=ROUGHLY, loosely=True).rms > CLOSE


def weighed_within(given: Problem, q: Array, errors: Mapping[tuple[str, int], float]) -> Weighed:
    """Weigh a hypothesis from where the model file is off by some errors; as it is, it is fitted from there in a few steps.

    Parameters
    ----------
    given : the problem, with the model file as it is. q : (k,) its parameters.
    errors : of the model file, by name and place, in tolerances.
    """
    within, found = settled(Stand.off_by(given, q, errors))
    short = solve(given, within.fit.q, most_steps=_FEW_STEPS, enough=ROUGHLY, loosely=True)
    exact = Stand.exact(short)
    exact, of_exact = settled(exact, found.noise) if short.rms < CLOSE else (exact, exact.weighed(found.noise))
    return Weighed(exact, within, Both(of_exact, found if within.lines().errors.shape[1] else None))


def from_rest(problem: Problem, before: Weighed) -> Weighed:
    """Weigh a hypothesis with one name more from where the one before it stands, that name at nought: it is hardly less likely then."""
    start = np.concatenate([before.fit.q, np.zeros(len(problem.parameters) - len(before.fit.q))])
    if before.both.is_exact:
        return weighed(solve(problem, start, loosely=True))
    return weighed_within(problem, start, before.within.errors_by_key)


def along_lines(fit: Fit) -> Weighed:
    """Weigh a fit where it is, without any step from there."""
    exact, loose = Stand.exact(fit), Stand.loose(fit)
    return Weighed(exact, loose, _both(exact.weighed(), loose))


def _both(exact: Evidence, within: Stand) -> Both:
    return Both(exact, within.weighed(exact.noise) if within.lines().errors.shape[1] else None)
