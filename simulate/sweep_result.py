"""What comes out of a sweep: responses run by run, the regression, failures and tolerances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from measure.tables import Array

from . import responses
from .factorial import coefficients_of, formula, predicted, variability_percent
from .responses import RESPONSES
from .sweep import Sweep, tally
from .tolerance import tolerance_of


@dataclass(frozen=True)
class SweepResult:
    """All responses of a sweep, and which of them is explained."""

    sweep: Sweep
    answers: Array
    response: str
    failure_deg: float

    @classmethod
    def of(cls, sweep: Sweep, pieces: Sequence[Array], response: str, failure_deg: float) -> SweepResult:
        """From the pieces of a sweep, in order."""
        return cls(sweep, np.concatenate(pieces), response, failure_deg)

    @property
    def unit(self) -> str:
        """Unit of the response."""
        return RESPONSES[self.response].unit

    @property
    def limit(self) -> float | None:
        """The failure angle, where the response is one that fails."""
        return self.failure_deg if self.response == "theta_z_deg" else None

    @property
    def values(self) -> Array:
        """(runs,) the response in its unit, NaN where there is none."""
        return self._column(self.response)

    @property
    def letters(self) -> list[str]:
        """Letters of the factors."""
        return [factor.letter for factor in self.sweep.factors]

    @cached_property
    def coefficients(self) -> dict[str, float]:
        """Of the regression in coded factors."""
        return coefficients_of(self.sweep.design, self.letters, self.values)

    @cached_property
    def report(self) -> dict[str, Any]:
        """The result as the command's JSON gives it, but for time and provenance."""
        counted = tally(self.answers, self.failure_deg)
        return {
            "runs": counted.runs,
            "diverged": counted.diverged,
            "failed_percent": counted.failed_percent,
            "failed_interval_percent": None if self.sweep.design.basic else counted.interval_percent(),
            "without_response": int(np.isnan(self.values).sum()) - counted.diverged,
            "design": self.sweep.design.kind,
            "response": self.response,
            "factors": [{"letter": f.letter, "key": f.key, "low": f.low, "high": f.high} for f in self.sweep.factors],
            "coefficients": self.coefficients,
            "variability_percent": variability_percent(self.coefficients),
            "formula": formula(self.coefficients, self.response.removesuffix(f"_{self.unit}")),
            "left_over_rms": self._left_over(),
            "tolerance": tolerance_of(self.sweep.model),
        }

    def run_columns(self) -> dict[str, Array]:
        """One row a run: coded levels by letter, every response, and when it diverged."""
        coded = self.sweep.design.piece(0, self.sweep.design.runs)
        levels = {letter: coded[:, i] for i, letter in enumerate(self.letters)}
        answers = {name: self._column(name) for name in RESPONSES}
        return {**levels, **answers, "diverged_at_s": self.answers[:, responses.DIVERGED]}

    def coefficient_columns(self) -> dict[str, Any]:
        """One row a coefficient, the largest first."""
        share = variability_percent(self.coefficients)
        names = sorted(self.coefficients, key=lambda name: -abs(self.coefficients[name]))
        return {
            "name": names,
            f"coefficient_{self.unit}": [self.coefficients[name] for name in names],
            "variability_percent": [share.get(name, float("nan")) for name in names],
        }

    def _column(self, name: str) -> Array:
        response = RESPONSES[name]
        return self.answers[:, response.place] * response.scale

    def _left_over(self) -> float:
        """RMS of what the regression of up to three factors leaves of the response, in its unit, on the runs themselves."""
        short = {name: value for name, value in self.coefficients.items() if len(name) <= 3}
        good = np.isfinite(self.values)
        if not np.any(good) or not short:
            return float("nan")
        coded = self.sweep.design.piece(0, self.sweep.design.runs)[good]
        return float(np.sqrt(np.mean((self.values[good] - predicted(short, self.letters, coded)) ** 2)))
