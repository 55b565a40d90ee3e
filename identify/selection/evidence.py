"""How well a hypothesis explains what was measured, all its parameters integrated out: its log evidence.

Around a fit everything is linear: gaps g, columns J of base and releases (with their priors), columns E of what the model file may
be wrong by (one tolerance each), columns C of the hypothesis with a normal prior of spread T. The noise of each channel is estimated under
each hypothesis anew (`identify.noise`). The integral is Laplace's (MacKay 2003, chapter 28):

    ln Z = ln L(g + J x + E e + C c) - (prior terms) - ln det(T) - ln det(A' A) / 2

A the whitened columns with the priors below them. Bounds cut the normal posterior and the normal prior of an effect's parameter alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, special

from identify.criteria import DEGREES, NOTHING, SAME, WITHIN
from identify.estimation.covariance import Factored, add_at
from identify.gap.linear_pieces import Columns, Lines, Part
from identify.noise.noise_model import ChannelNoise, Whitening, estimated, log_likelihood, weights
from identify.noise.windows import Taken
from measure.common.arrays import Array

ROUNDS = 8
_GAINS = 3.0  # further rounds together gain no more than so many times the last one
_INFORMATION = (DEGREES + 1.0) / (DEGREES + 3.0)  # of Student's t about its place, in units of 1 / scale^2
_LOG_SHARES = float(np.log(NOTHING / (NOTHING + WITHIN))), float(np.log(WITHIN / (NOTHING + WITHIN)))


@dataclass(frozen=True)
class Evidence:
    """A hypothesis weighed.

    log_z : its log evidence. log_likelihood : at its best, priors counted. noise : of each channel. step : (p,) of base and releases.
    errors : (q,) of the model file, in tolerances, and amounts : (k,) of its own columns, both whole and not from where the columns were
    taken. left : innovations over their scales, (n,) of each channel. unkept : log probability that straight lines promise here and the
    simulation was found not to keep.
    """

    lines: Lines = field(repr=False)
    columns: Columns = field(repr=False)
    log_z: float
    log_likelihood: float
    noise: tuple[ChannelNoise, ...]
    step: Array
    errors: Array
    amounts: Array
    left: tuple[Array, ...] = field(repr=False)
    unkept: float = 0.0

    @property
    def kept(self) -> float:
        """Its log evidence as far as the simulation bears it out."""
        return self.log_z - self.unkept

    @cached_property
    def information(self) -> Factored:
        """Of base and releases, errors and amounts, (p + q + k, p + q + k)."""
        return _informed(self.white(self.lines), self.lines.prior_precision(self.columns))

    @cached_property
    def covariance(self) -> Array:
        """The inverse of the information."""
        return self.information.inverse

    def white(self, lines: Lines) -> list[White]:
        """Linear pieces with its own columns, whitened by its noise, channel by channel."""
        return [White.of(part, noise) for part, noise in zip(lines.parts_beside(self.columns), self.noise, strict=True)]

    def answer_to(self, change: Array) -> Array:
        """How far base and releases, errors and amounts (p + q + k,) move where something (m,) is added to the gaps."""
        white = self.white(replace(self.lines, gaps=change))
        return Normal((), self.information).step(white, [_INFORMATION] * len(white), np.zeros(len(self.information.size)))

    @property
    def prior_p(self) -> float:
        """Probability that base, releases and errors are as far or farther from what is known of them beforehand."""
        return self.p_of(np.eye(len(self.lines.prior_gaps) + len(self.errors)))

    def p_of(self, part: Array) -> float:
        """The same of a part of them: a projection (n, n) of what is known beforehand, in its order, and errors.

        Only as many count as the measurements determine: k - tr(C P) of k, C their covariance and P the precision that is known beforehand
        (MacKay 2003, chapter 28), but at least one. The others stay at what is known.
        """
        off = part @ np.concatenate([self.lines.prior_gaps + self.lines.prior_columns @ self.step, self.errors])
        known = np.asarray(linalg.block_diag(self.lines.prior_columns, np.eye(len(self.errors))), dtype=float)
        own = slice(0, known.shape[1])
        held = float(np.vdot(part, known @ self.covariance[own, own] @ known.T))
        return float(special.chdtrc(max(np.trace(part) - held, 1.0), off @ off))


@dataclass(frozen=True)
class Both:
    """A hypothesis weighed with the model file as it is, and as far off as its tolerances allow; None where it has none that show.

    Its log evidence counts as far as it was found to be kept where the hypothesis stands.
    """

    exact: Evidence
    within: Evidence | None

    @property
    def log_z(self) -> float:
        """The log evidence over both."""
        return self.exact.kept if self.within is None else float(np.logaddexp(*self._parts))

    @property
    def along_lines(self) -> float:
        """The same as straight lines from there have it: with this are names beside it compared, which are weighed along them."""
        return self.exact.log_z if self.within is None else float(np.logaddexp(*self._shared(self.exact.log_z, self.within.log_z)))

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
        return self._shared(self.exact.kept, self.within.kept)

    @staticmethod
    def _shared(exact: float, within: float) -> tuple[float, float]:
        return exact + _LOG_SHARES[0], within + _LOG_SHARES[1]


def evidence(
    lines: Lines,
    columns: Columns | None = None,
    start: tuple[ChannelNoise, ...] = (),
    rounds: int = ROUNDS,
    floor: float = -np.inf,
    same: float = SAME,
) -> Evidence:
    """Weigh a hypothesis.

    Parameters
    ----------
    columns : what it adds to base, releases and tolerances; by default nothing.
    start : noise to begin with, for instance that of a neighbouring hypothesis.
    rounds : the most rounds in which noise and parameters are estimated in turn.
    floor : log likelihood that a hypothesis has to come near to be followed to the end.
    same : change of the log likelihood at which the rounds end.
    """
    own = Columns.none(len(lines.gaps)) if columns is None else columns
    parts, precision, pull = lines.parts_beside(own), lines.prior_precision(own), lines.prior_pull(own)
    noise = start or tuple(_first_noise(part.gaps) for part in parts)
    white = [White.of(part, n) for part, n in zip(parts, noise, strict=True)]
    counts = [weights(one.gaps) if start else np.ones(len(one.gaps)) for one in white]
    reached, found, left = -np.inf, np.zeros(len(pull)), ()
    for _ in range(rounds):
        normal = Normal.of(white, counts, precision)
        found = normal.step(white, counts, pull)
        residuals = [part.residual(found) for part in parts]
        taken = normal.taken(parts)
        noise = tuple(estimated(r, part.channel.apart, of, n) for r, part, of, n in zip(residuals, parts, taken, noise, strict=True))
        white = [White.of(part, n) for part, n in zip(parts, noise, strict=True)]
        left = tuple(one.residual(found) for one in white)
        counts = [weights(one) for one in left]
        before, reached = reached, _log_likelihood(lines, own, white, left, found)
        gain = reached - before
        if abs(gain) < same or reached + _GAINS * gain < floor:
            break
    p, q = lines.columns.shape[1], lines.errors.shape[1]
    log_z = reached - lines.log_spread - float(np.sum(np.log(own.spread))) + _volume(own, own.at + found[p + q :], white, precision)
    return Evidence(lines, own, log_z, reached, noise, found[:p], lines.errors_at + found[p : p + q], own.at + found[p + q :], left)


@dataclass(frozen=True)
class White:
    """One channel whitened: gaps (n,), columns (n, k), their places, and the logarithm of its scales."""

    gaps: Array
    values: Array
    places: NDArray[np.intp]
    log_size: float

    @classmethod
    def of(cls, part: Part, noise: ChannelNoise) -> White:
        """Under a noise."""
        whitening = Whitening.of(noise, part.channel.apart)
        return cls(whitening.whitened(part.gaps), whitening.whitened(part.values), part.places, whitening.log_size)

    def residual(self, step: Array) -> Array:
        """Innovations after a step of all columns, (n,)."""
        return self.gaps + self.values @ step[self.places]


def _first_noise(gaps: Array) -> ChannelNoise:
    return ChannelNoise(scale=max(1.0, 1.5 * float(np.median(np.abs(gaps)))))


@dataclass(frozen=True)
class Normal:
    """What measurements, each with its weight, and what is known beforehand say together, (p + q + k, p + q + k), decomposed.

    by_channel : what each channel says by itself of its own columns.
    """

    by_channel: tuple[Array, ...]
    factored: Factored

    @classmethod
    def of(cls, white: Sequence[White], counts: Sequence[Array | float], precision: Array) -> Normal:
        """Of whitened channels, with the weights of their samples."""
        whole, found = precision.copy(), []
        for one, count in zip(white, counts, strict=True):
            weighted = one.values * np.reshape(np.sqrt(count), (-1, 1))
            found.append(weighted.T @ weighted)
            add_at(one.places, whole, found[-1])
        return cls(tuple(found), Factored.of(whole))

    def step(self, white: Sequence[White], counts: Sequence[Array | float], pull: Array) -> Array:
        """The step (p + q + k,) of weighted least squares with priors."""
        right = pull.copy()
        for one, count in zip(white, counts, strict=True):
            right[one.places] += one.values.T @ (count * one.gaps)
        return -self.factored.solve(right)

    def taken(self, parts: Sequence[Part]) -> Iterator[Taken]:
        """What the parameters take from the noise of each channel; what its prior holds takes nothing (MacKay 2003, chapter 28)."""
        covariance = self.factored.inverse
        for own, part in zip(self.by_channel, parts, strict=True):
            of_part = covariance.take(part.places, 0).take(part.places, 1)
            yield Taken.by(part.values, of_part, float(np.vdot(own, of_part)))


def _informed(white: Sequence[White], precision: Array) -> Factored:
    """The information of all parameters at the largest probability, as Student's t has it on average."""
    return Normal.of(white, [_INFORMATION] * len(white), precision).factored


def _log_likelihood(lines: Lines, own: Columns, white: Sequence[White], left: Sequence[Array], found: Array) -> float:
    """Of the measurements and of what is known of the parameters, but for constants."""
    likelihood = sum(map(log_likelihood, left)) - sum(one.log_size for one in white)
    p, q = lines.columns.shape[1], lines.errors.shape[1]
    amounts, errors = own.at + found[p + q :], lines.errors_at + found[p : p + q]
    known = lines.prior_gaps + lines.prior_columns @ found[:p]
    return likelihood - 0.5 * float(known @ known + errors @ errors + np.sum((amounts / own.spread) ** 2))


def _volume(own: Columns, amounts: Array, white: Sequence[White], precision: Array) -> float:
    """What is added to the log evidence for the width of the posterior, and for the bounds that cut it."""
    factored = _informed(white, precision)
    return _inside(own, amounts, factored) - 0.5 * factored.log_det


def _inside(own: Columns, amounts: Array, factored: Factored) -> float:
    """What the bounds of a hypothesis do to its log evidence; nothing where there are none."""
    if not own.is_bounded:
        return 0.0
    first = len(factored.size) - own.count
    rows = linalg.solve_triangular(factored.root, np.eye(len(factored.size))[:, first:], lower=True)
    return own.log_inside(amounts, np.linalg.norm(rows, axis=0) / factored.size[first:])
