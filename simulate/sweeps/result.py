"""What comes out of a sweep: responses run by run, the regression, failures and tolerances."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from measure.common.arrays import Array
from measure.notebook.shown import Shown
from measure.tables.frames import frame_of
from simulate.model import responses
from simulate.model.responses import RESPONSES
from simulate.sweeps.indices import KINDS, indices_of, levels_of
from simulate.sweeps.rare_events import RareFailure
from simulate.sweeps.regression import HIGHEST_ORDER, coefficients_of, formula, predicted, variability_percent
from simulate.sweeps.sweep import RunCounts, Sweep, count_runs

if TYPE_CHECKING:
    from pandas import DataFrame

_BINS = 60
GRID = 17
_FRESH = 256


@dataclass(frozen=True)
class SweepResult(Shown, by="simulate.report.showing.ShowingSweep"):
    """All responses of a sweep, and which of them is explained.

    sweep : model, factors and design, with the step that was chosen.
    pieces : responses piece by piece, in order, each (runs, responses.COUNT) in SI units; gone through several times, and never
        all in memory.
    response, failure_deg : what the regression explains, and the abs(theta_z) beyond which a run has failed.
    step : how the step was chosen and how exact it is, as the JSON of the command gives it.
    wall_s : how long the runs took. rare : probability of failure by subset simulation, where it was asked for.
    """

    sweep: Sweep
    pieces: Iterable[Array]
    response: str
    failure_deg: float
    step: Mapping[str, Any] = field(default_factory=dict)
    wall_s: float = float("nan")
    rare: RareFailure | None = None

    def __repr__(self) -> str:
        counted, letters = self.counts, ", ".join(f"{f.letter} {f.key}" for f in self.sweep.factors[:3])
        more = ", ..." if len(self.sweep.factors) > 3 else ""
        return (
            f"SweepResult({self.sweep.model.name!r:.60}, {self.sweep.design.kind}, {counted.runs} runs, {counted.diverged} diverged, "
            f"{counted.failed_percent:.1f} % beyond {self.failure_deg:g} deg, {self.response} over {letters}{more})"
        )

    def to_frame(self, table: Literal["runs", "coefficients"] = "runs") -> DataFrame:
        """The runs or the regression as a pandas frame; units in `frame.attrs["units"]`.

        Parameters
        ----------
        table : "runs", one row a run with the coded levels by letter, every response, and when the run diverged; or "coefficients",
            one row a term of the regression, the largest first, with its share of the variability.
        """
        if table == "coefficients":
            return frame_of(self.coefficient_columns(), name=self.response)
        return frame_of(self.run_columns(), dict.fromkeys(self.letters, ""), name=self.sweep.model.name)

    @property
    def unit(self) -> str:
        """Unit of the response."""
        return RESPONSES[self.response].unit

    @property
    def limit(self) -> float | None:
        """The failure angle, where the response is one that fails."""
        return self.failure_deg if self.response in ("theta_z_deg", "theta_z_before_stop_deg") else None

    @property
    def letters(self) -> list[str]:
        """Letters of the factors."""
        return [factor.letter for factor in self.sweep.factors]

    def values(self) -> Iterator[Array]:
        """The response in its unit, NaN where there is none, piece by piece."""
        return (_column(answers, self.response) for answers in self.pieces)

    def _coded(self) -> Iterator[tuple[Array, Array]]:
        """Coded levels and response, piece by piece."""
        first = 0
        for values in self.values():
            yield self.sweep.design.piece(first, first + len(values)), values
            first += len(values)

    @cached_property
    def counts(self) -> RunCounts:
        """Runs, diverged and failed."""
        return sum((count_runs(answers, self.failure_deg) for answers in self.pieces), RunCounts(0, 0, 0, 0))

    @cached_property
    def coefficients(self) -> dict[str, float]:
        """Of the regression in coded factors."""
        return coefficients_of(self.sweep.design, self.letters, self.values)

    @cached_property
    def report(self) -> dict[str, Any]:
        """The result as the command's JSON gives it, but for tolerance, step, time and provenance."""
        counted = self.counts
        return {
            "runs": counted.runs,
            "diverged": counted.diverged,
            "failed_percent": counted.failed_percent,
            "failed_before_stop_percent": counted.failed_before_stop_percent,
            "failed_interval_percent": None if self._is_chosen else counted.interval_percent(),
            "without_response": sum(int(np.isnan(values).sum()) for values in self.values()) - counted.diverged,
            "design": self.sweep.design.kind,
            "response": self.response,
            "factors": [{"letter": f.letter, "key": f.key, "low": f.low, "high": f.high, **_spread(f.normal)} for f in self.sweep.factors],
            "coefficients": self.coefficients,
            "variability_percent": variability_percent(self.coefficients),
            "formula": formula(self.coefficients, self.response.removesuffix(f"_{self.unit}")),
            "left_over_rms": self._left_over(),
            "fresh": self.fresh(),
            "indices": self.indices,
            "subset_simulation": None if self.rare is None else self.rare.report,
        }

    @property
    def _is_chosen(self) -> bool:
        """Whether the runs were chosen, so that they are no independent draws."""
        return bool(self.sweep.design.basic) or self.sweep.design.kind in KINDS.values()

    @cached_property
    def indices(self) -> dict[str, Any] | None:
        """Sensitivity indices of the response, see `indices_of`; None where the runs were not chosen for them."""
        design = self.sweep.design
        if design.kind not in KINDS.values():
            return None
        levels = levels_of(design.kind, design.runs, design.factors, design.seed)
        return indices_of(design.kind, self.letters, levels, np.concatenate(list(self.values())), design.seed)

    def fresh(self) -> dict[str, Any]:
        """Error of the regression on runs that it has not seen, drawn from the whole of the factors' ranges."""
        seed = self.sweep.design.seed + 1
        normal = tuple(i for i, factor in enumerate(self.sweep.factors) if factor.normal)
        kind = replace(self.sweep.design, kind="random", runs=_FRESH, seed=seed, normal=normal, basic=0, columns=())
        coded = kind.piece(0, _FRESH)
        values = _column(self.sweep.responses_at(coded), self.response)
        good = np.isfinite(values)
        if not self._short or not np.any(good):
            return {"runs": int(good.sum()), "rms": None, "largest": None, "rms_of_response": None}
        error = values[good] - predicted(self._short, self.letters, coded[good])
        size = float(np.sqrt(np.mean(values[good] ** 2)))
        rms, largest = float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))
        return {"runs": int(good.sum()), "rms": rms, "largest": largest, "rms_of_response": size}

    def run_columns(self) -> dict[str, Iterable[float]]:
        """One row a run, read piece by piece: coded levels by letter, every response, and when it diverged."""
        levels = {letter: self._levels(i) for i, letter in enumerate(self.letters)}
        answers = {name: self._answers(name) for name in RESPONSES}
        return {**levels, **answers, "diverged_at_s": (v for answers in self.pieces for v in answers[:, responses.DIVERGED])}

    def _levels(self, place: int) -> Iterator[float]:
        return (v for coded, _ in self._coded() for v in coded[:, place])

    def _answers(self, name: str) -> Iterator[float]:
        return (v for answers in self.pieces for v in _column(answers, name))

    def histogram(self) -> tuple[Array, Array]:
        """(bins,) runs and (bins + 1,) edges of the responses."""
        low, high = np.inf, -np.inf
        for values in self.values():
            finite = values[np.isfinite(values)]
            low, high = min(low, np.min(finite, initial=np.inf)), max(high, np.max(finite, initial=-np.inf))
        edges = np.linspace(low, high if high > low else low + 1.0, _BINS + 1) if np.isfinite(low) else np.linspace(0.0, 1.0, _BINS + 1)
        return sum((np.histogram(v[np.isfinite(v)], edges)[0] for v in self.values()), np.zeros(_BINS, dtype=int)), edges

    def map(self, first: int, second: int) -> Array:
        """(GRID, GRID) the response over the coded levels of two factors, the first along the rows, all others in their middle."""
        levels = np.linspace(-1.0, 1.0, GRID)
        coded = np.zeros((GRID * GRID, len(self.sweep.factors)))
        coded[:, first], coded[:, second] = np.repeat(levels, GRID), np.tile(levels, GRID)
        return _column(self.sweep.responses_at(coded), self.response).reshape(GRID, GRID)

    @property
    def largest_pair(self) -> tuple[int, int] | None:
        """Places of the two factors with the largest main effects, None where there are not two."""
        sizes = np.array([abs(self.coefficients.get(letter, 0.0)) for letter in self.letters])
        if len(sizes) < 2:
            return None
        one, other = np.sort(np.argsort(-sizes, kind="stable")[:2])
        return int(one), int(other)

    def coefficient_columns(self) -> dict[str, Any]:
        """One row a coefficient, the largest first."""
        share = variability_percent(self.coefficients)
        names = sorted(self.coefficients, key=lambda name: -abs(self.coefficients[name]))
        return {
            "name": names,
            f"coefficient_{self.unit}": [self.coefficients[name] for name in names],
            "variability_percent": [share.get(name, float("nan")) for name in names],
        }

    @cached_property
    def _short(self) -> dict[str, float]:
        """The regression of up to three factors in a product, which is what anybody writes down."""
        return {name: value for name, value in self.coefficients.items() if len(name) <= HIGHEST_ORDER}

    def _left_over(self) -> float:
        """RMS of what the regression of up to three factors leaves of the response, in its unit, on the runs themselves."""
        total, count = 0.0, 0
        for coded, values in self._coded() if self._short else ():
            good = np.isfinite(values)
            total += float(np.sum((values[good] - predicted(self._short, self.letters, coded[good])) ** 2))
            count += int(good.sum())
        return float(np.sqrt(total / count)) if count else float("nan")


def _column(answers: Array, name: str) -> Array:
    response = RESPONSES[name]
    return answers[:, response.place] * response.scale


def _spread(normal: bool) -> dict[str, str]:
    return {"spread": "normal, one standard deviation either way"} if normal else {}
