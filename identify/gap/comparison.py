"""Measured against modelled, channel by channel, and what a comparison found: plain data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from identify.campaign.prepared import Film
from identify.criteria import GAP_P
from identify.estimation.fit import Block
from identify.estimation.problem import Fit
from identify.gap.gap_test import GapTest
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
