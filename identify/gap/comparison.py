"""Measured against modelled, channel by channel, and what a comparison found, of a run held out as well: plain data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.campaign.prepared import Film
from identify.criteria import GAP_P, NO_WORSE, NOISE_AGAIN
from identify.estimation.fit import Block
from identify.estimation.problem import Fit
from identify.gap.gap_test import GapTest, leaves_noise
from identify.gap.size import NoiseOfChannel, gap_left, noise_over_stated
from identify.noise.noise_model import ChannelNoise
from measure.common.arrays import Array
from measure.notebook.shown import Shown


@dataclass(frozen=True)
class Curve:
    """One channel of one run: times, measured and modelled values and noise, each (n,), where there was a measurement."""

    run: str
    channel: str
    time_s: Array
    measured: Array
    modelled: Array
    sigma: Array

    @property
    def gap(self) -> Array:
        """Measured minus modelled."""
        return self.measured - self.modelled

    @property
    def numbers(self) -> dict[str, float]:
        """The figures of `compare-model`; nrmse is of the measured range, fit is 100 (1 - |y - y_m| / |y - mean y|)."""
        rmse = float(np.sqrt(np.mean(self.gap**2)))
        spread = float(np.linalg.norm(self.measured - self.measured.mean()))
        span = float(np.ptp(self.measured))
        return {
            "rmse": rmse,
            "max_abs": float(np.max(np.abs(self.gap))),
            "nrmse_percent": 100.0 * rmse / span if span > 0 else float("nan"),
            "fit_percent": 100.0 * (1.0 - float(np.linalg.norm(self.gap)) / spread) if spread > 0 else float("nan"),
            "noise_sigma": float(np.median(self.sigma)),
        }


@dataclass(frozen=True, repr=False)
class Comparison(Shown, by="identify.report.showing.ShowingComparison"):
    """The curves of all runs, the test of what is left, and how much repeated deployments differ among themselves."""

    fit: Fit
    curves: tuple[Curve, ...]
    test: GapTest
    dispersion_percent: float

    @property
    def gap_is_noise(self) -> bool:
        """Whether nothing beyond noise is left."""
        return self.test.p_value > GAP_P


def curves_of(fit: Fit) -> tuple[Curve, ...]:
    """Measured and modelled values behind the gaps of a fit."""
    films = {film.run.name: film for film in fit.problem.films}
    loops = {loop.run.name: loop for loop in fit.problem.loops}
    made = []
    for block in fit.problem.blocks:
        at = block.samples
        if block.run in films:
            time, measured, sigma = _film_values(films[block.run], block)
        else:
            data = loops[block.run].data
            time, measured, sigma = data.time_s[at], data.force_N[at], np.full(len(at), data.force_sigma_N)
        made.append(Curve(block.run, block.channel, time, measured, measured - fit.difference(block) * sigma, sigma))
    return tuple(made)


def _film_values(film: Film, block: Block) -> tuple[Array, Array, Array]:
    row, at = film.channels.index(block.channel), block.samples
    return film.time_s[at] + film.clock_s, film.values[row, at], film.sigma[row, at]


@dataclass(frozen=True)
class Held:
    """A run that took no part: its gap before and after, only its own release fitted.

    lead : log probability of the run with the names, over that without, all that the fits leave open integrated out; NaN where it was
    not asked for: the names make no gap larger, and something is surely missing. noise : of the channels of the runs that took part.
    """

    before: Fit
    after: Fit
    lead: float = float("nan")
    noise: Sequence[NoiseOfChannel] = ()

    @property
    def name(self) -> str:
        """Of the run."""
        return self.after.problem.blocks[0].run

    @property
    def left(self) -> float:
        """Its gap after, in units of the noise of the same channels in the other runs."""
        return gap_left(self.after) / noise_over_stated(self.noise, [self.after])

    @property
    def misses(self) -> bool:
        """Whether it is left with more than noise: the gap beside the noise is as large as it, and slower than noise of the other runs."""
        known = sorted(self.noise, key=lambda one: one.model.memory)
        of = {one.channel: one.model for one in known}
        most = known[-1].model if known else ChannelNoise()  # for a channel that no other run has
        own = [of.get(block.channel, most) for block in self.after.problem.blocks]
        return self.left > NOISE_AGAIN and not leaves_noise(self.after, own)

    @property
    def grows(self) -> bool:
        """Whether the names make its gap larger."""
        return gap_left(self.after) > NO_WORSE * gap_left(self.before)

    @property
    def contradicts(self) -> bool:
        """Whether the names make it larger than chance does, which happens to right names at most once in a thousand runs.

        That a model which is right makes what was measured so much less probable than another one has at most that probability.
        """
        return self.grows and self.lead < np.log(GAP_P)
