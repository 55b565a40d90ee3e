"""What columns would bring beside a hypothesis with the noise as it is there: cheap, and enough to leave out what brings nothing.

With noise and weights of the samples fixed, base, releases, errors and effects of the hypothesis are eliminated once and for all. What
measurements then say of further columns C is

    information = C' W C - C' W A H^-1 A' W C        slope = -C' W r

A the columns of the hypothesis, H their information, r what it leaves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.gap.linear_pieces import Columns, Gain, Shown
from identify.noise.noise_model import Whitening, weights
from identify.selection.evidence import Evidence, Normal
from measure.common.arrays import Array
from simulate.model.effect import Effect


class FirstLook:
    """A hypothesis with its noise, ready for further columns."""

    def __init__(self, of: Evidence) -> None:
        channels = [part.channel for part in of.lines.parts]
        self._rows = [channel.rows for channel in channels]
        self._whitening = [Whitening.of(noise, channel.apart) for noise, channel in zip(of.noise, channels, strict=True)]
        self._counts = [weights(left) for left in of.left]
        self._white = of.white(of.lines)
        precision = of.lines.prior_precision(of.columns)
        normal = Normal.of(self._white, self._counts, precision)
        step = normal.step(self._white, self._counts, of.lines.prior_pull(of.columns))
        self._left = [one.residual(step) for one in self._white]
        self._known = normal.factored

    def gain(self, columns: Columns) -> Gain:
        """What further columns bring, from nought."""
        return self.shown(columns.values).gain(columns)

    def shown(self, values: Array) -> Shown:
        """What the measurements say of further columns (m, k)."""
        count = values.shape[1]
        own, across, slope = np.zeros((count, count)), np.zeros((len(self._known.size), count)), np.zeros(count)
        for rows, whitening, left, of_sample, one in zip(self._rows, self._whitening, self._left, self._counts, self._white, strict=True):
            if not values[rows].any():
                continue
            white = whitening.whitened(values[rows])
            weighted = white * of_sample[:, None]
            own += weighted.T @ white
            across[one.places] += one.values.T @ weighted
            slope -= weighted.T @ left
        return Shown(own - across.T @ self._known.solve(across), slope)


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
