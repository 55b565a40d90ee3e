"""How fits, comparisons and explanations show themselves in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit
from identify.gap.comparison import Comparison
from identify.report.explained.story import sentence
from identify.report.gap_figures import curve_rows, largest
from identify.report.gap_plots import comparison_figure, pair_figure
from identify.report.loop_plots import fit_figure
from identify.report.result import parameters_of, result_of
from identify.selection.explanation import Explanation
from measure.tables.frames import frame_of, unit_in_name

if TYPE_CHECKING:
    from pandas import DataFrame


class ShowingFit:
    """How a fit of loops shows itself."""

    def __init__(self, fit: ActuatorFit) -> None:
        self.fit = fit

    def figure(self) -> Any:
        """The slowest and the fastest loop, measured and modelled."""
        return fit_figure(self.fit, self.fit.loops)


class ShowingComparison:
    """How a comparison shows itself."""

    def __init__(self, found: Comparison) -> None:
        self.found = found

    def text(self) -> str:
        """How far the model is off, and whether that is noise."""
        word = "noise" if self.found.gap_is_noise else "more than noise"
        return f"Comparison({len({c.run for c in self.found.curves})} runs: the gap is {self.found.fit.rms:.3g} times the noise, {word})"

    def frame(self) -> DataFrame:
        """One row a channel, with its error, fit and noise."""
        rows = [{"run": curve.run, "channel": curve.channel, **curve.numbers} for curve in self.found.curves]
        columns = {key: [row[key] for row in rows] for key in rows[0]}
        return frame_of(columns, {"rmse": "of the channel", "max_abs": "of the channel", "noise_sigma": "of the channel"})

    def figure(self) -> Any:
        """Every run and channel."""
        return comparison_figure(self.found.curves)


class ShowingExplanation:
    """How an explanation shows itself."""

    def __init__(self, found: Explanation) -> None:
        self.found = found

    def text(self) -> str:
        """The verdict and the finding."""
        return f"Explanation({self.found.verdict}: {sentence(self.found, result_of(self.found))})"

    def frame(self) -> DataFrame:
        """One row a parameter of what was found, with its interval; without a finding one row a hypothesis, with its probability."""
        rows = [
            {"effect": finding.name, "parameter": name, "unit": unit_in_name(name.partition("[")[0]), **_numbers(row)}
            for finding in self.found.findings
            for name, row in parameters_of(finding).items()
        ]
        if not rows:
            return frame_of({"answer": list(self.found.weights), "probability": list(self.found.weights.values())})
        frame = frame_of({key: [row[key] for row in rows] for key in rows[0]})
        frame.attrs["units"] |= dict.fromkeys(("value", "stderr", "ci95_low", "ci95_high"), "as in the column unit")
        return frame

    def figure(self) -> Any:
        """The channel in which one sees the gap best, with what is left below."""
        one = largest(curve_rows(self.found))
        after = next((stage.curve for stage in one.stages if stage.look == "effect"), None)
        return pair_figure(one.without, after)


def _numbers(row: dict[str, Any]) -> dict[str, float]:
    low, high = row["ci95"] if row["identifiable"] else (np.nan, np.nan)
    return {"value": row["value"], "stderr": row["stderr"], "ci95_low": low, "ci95_high": high}
