"""What columns would bring beside a hypothesis with the noise as it is there: cheap, and enough to leave out what brings nothing.

With noise and weights of the samples fixed, base, releases, errors and effects of the hypothesis are eliminated once and for all. Further
columns C with a normal prior of spread T then cost a small system:

    S = C' W C + T^-2 - C' W A H^-1 A' W C        gain = g' S^-1 g / 2 - ln det(S) / 2 - ln det(T),   g = C' W r

A the columns of the hypothesis, H their information, r what it leaves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.gap.linear_pieces import Columns
from identify.noise.noise_model import weights
from identify.selection.evidence import Evidence, Normal
from measure.common.arrays import Array
from simulate.model.effect import Effect

_JITTER = 1e-10
_FADED = 3.0  # times that noise which remembers, for it has taken up what is missing, makes a slow effect look too weak


@dataclass(frozen=True)
class Gain:
    """Log evidence that columns bring, and the most that they may bring once the noise is estimated anew.

    amounts : (k,) and covariance : (k, k) of the columns themselves.
    """

    log_z: float
    most: float
    amounts: Array
    covariance: Array
    columns: Columns


class FirstLook:
    """A hypothesis with its noise, ready for further columns."""

    def __init__(self, of: Evidence) -> None:
        self._apart = [part.channel for part in of.lines.parts]
        self._noise = of.noise
        self._counts = [weights(left) for left in of.left]
        self._white = of.white(of.lines)
        precision = of.lines.prior_precision(of.columns)
        normal = Normal.of(self._white, self._counts, precision)
        step = normal.step(self._white, self._counts, of.lines.prior_pull(of.columns))
        self._left = [one.residual(step) for one in self._white]
        self._known = normal.factored

    def gain(self, columns: Columns) -> Gain:
        """What further columns bring, from nought."""
        own, across, drive = np.diag(columns.spread**-2.0), np.zeros((len(self._known.size), columns.count)), np.zeros(columns.count)
        for channel, noise, left, count, one in zip(self._apart, self._noise, self._left, self._counts, self._white, strict=True):
            values = noise.whitened(columns.values[channel.rows], channel.apart)
            weighted = values * count[:, None]
            own += weighted.T @ values
            across[one.places] += one.values.T @ weighted
            drive += weighted.T @ left
        rest = own - across.T @ self._known.solve(across)
        size = np.sqrt(np.maximum(np.diag(rest), 1e-300))
        unit = rest / np.outer(size, size) + _JITTER * np.eye(len(size))
        covariance = np.linalg.pinv(unit, hermitian=True) / np.outer(size, size)
        amounts = -covariance @ drive
        log_det = float(np.linalg.slogdet(unit)[1] + 2.0 * np.sum(np.log(size)))
        met = 0.5 * float(drive @ covariance @ drive)
        price = 0.5 * log_det + float(np.sum(np.log(columns.spread)))
        cut = columns.log_inside(amounts, np.sqrt(np.diag(covariance))) if columns.is_bounded else 0.0
        return Gain(met - price + cut, _FADED * met - price + max(cut, 0.0), amounts, covariance, columns)


@dataclass(frozen=True)
class Promise:
    """A name more, instead of one that was there if any: its log evidence along straight lines.

    shape : the effect in the shape that promises most, None for an error of the model file that has no parameters of its own.
    base : (k,) parameters of base and releases to fit it from. sizes : (n,) of the effect's own. errors : of the model file, by name and
    place, in tolerances; None where it is likelier as it is. looks : a first look at every shape, and which of its parameters show; none of
    an effect that is not linear. first : the most log evidence of a first look. others : from where a fit may start as well, of a wave,
    which has a local minimum near every frequency.
    """

    name: str
    instead: str
    log_z: float
    shape: Effect | None
    base: Array
    sizes: Array
    errors: Mapping[tuple[str, int], float] | None
    looks: tuple[tuple[Gain, NDArray[np.bool_]], ...] = ()
    first: float = -np.inf
    others: tuple[Promise, ...] = ()
