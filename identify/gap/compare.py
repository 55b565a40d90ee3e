"""A model against measurements, in numbers: run by run and channel by channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from identify.campaign.noiseless import with_noise_where_none
from identify.campaign.posing import problem_of
from identify.campaign.prepared import Film
from identify.campaign.run import Run
from identify.criteria import GAP_P
from identify.estimation.fit import Block
from identify.estimation.least_squares import solve
from identify.estimation.parameters import Change
from identify.estimation.problem import Fit
from identify.gap.gap_test import GapTest, gap_test
from measure.common.arrays import Array
from measure.notebook.shown import Shown
from simulate.model.model import Model


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


def compare(model: Model, runs: Sequence[Run], *, fit_release: bool = True, changes: Sequence[Change] = ()) -> Comparison:
    """Compare a model with what was measured.

    Parameters
    ----------
    fit_release : whether each run's own release (pose and instant, within the spreads of the model file) is fitted first;
        it differs from run to run without meaning anything. Otherwise the model is taken to the letter.
    changes : parameters that are held, bounded, or begin elsewhere.

    Raises
    ------
    InputError
        A run cannot be used with this model.
    """
    fit = _fitted(model, runs, fit_release, changes)
    noisy, added = with_noise_where_none(runs)
    test = gap_test(_fitted(model, noisy, fit_release, changes) if added else fit)
    return Comparison(fit, curves_of(fit), test, dispersion_percent(fit.problem.films))


def _fitted(model: Model, runs: Sequence[Run], fit_release: bool, changes: Sequence[Change]) -> Fit:
    problem = problem_of(model, runs, changes=changes)
    return solve(problem, free=range(problem.first_nuisance, problem.first_effect) if fit_release else ())


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


def dispersion_percent(films: Sequence[Film]) -> float:
    """How much repeated deployments differ in elevation: rms over the measured range, the largest of all pairs, NaN without a pair."""
    found = [
        _difference_percent(a, b)
        for a, b in combinations(films, 2)
        if a.run.changes == b.run.changes and "z_m" in a.channels and "z_m" in b.channels
    ]
    return max(found, default=float("nan"))


def _difference_percent(a: Film, b: Film) -> float:
    curves = []
    for film in (a, b):
        values = film.values[film.channels.index("z_m")]
        good = np.isfinite(values)
        curves.append((film.time_s[good], values[good]))
    (ta, za), (tb, zb) = curves
    common = ta[(ta >= tb[0]) & (ta <= tb[-1])]
    if not len(common):
        return float("nan")
    difference = np.interp(common, ta, za) - np.interp(common, tb, zb)
    return 100.0 * float(np.sqrt(np.mean(difference**2))) / float(np.ptp(za))
