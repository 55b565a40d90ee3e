"""The page of a comparison: a model against loops and deployments, run by run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from identify.gap.comparison import Comparison
from identify.gap.gap_test import p_words
from identify.report.gap_figures import CurveRow, Stage, figure_of, largest, last_cycle, loop_curves, opened_name
from measure.pages.figure import Figure
from measure.pages.in_use import shown_as
from measure.pages.page import facts_of, number
from measure.pages.sections import Section, Table, sections_html
from measure.pages.summary import Number, Summary

_OPEN = 6  # figures that are not folded


def compare_html(found: Comparison, next_words: Sequence[str], note: Mapping[str, Any]) -> str:
    """The whole page.

    Parameters
    ----------
    next_words : what to do now. note : provenance.
    """
    name = found.fit.problem.model.name
    rows = [CurveRow(curve.run, curve.channel, (Stage("model", "given", curve),)) for curve in found.curves]
    first = largest(rows)
    ordered = [first, *(one for one in rows if one is not first)]
    figures = [_figure(found, one, f"run-{i + 1}") for i, one in enumerate(ordered)]
    numbers = Table(
        "comparison",
        "Error and fit of every channel; nrmse is of the measured range",
        ["run", "channel", "rmse", "largest", "nrmse, %", "fit, %", "noise", "gap over noise"],
        [_row(one) for one in rows],
    )
    sections = [Section("Where one sees the difference best", figures=figures[:1]), Section("Numbers", tables=[numbers])]
    sections += [Section("Other runs and channels", figures=figures[1:_OPEN])] if figures[1:] else []
    sections += [Section(f"{len(figures) - _OPEN} more", figures=figures[_OPEN:], folded=True)] if figures[_OPEN:] else []
    return sections_html(
        f"The model “{name}” against its measurements",
        f"unspool · compare-model · {name}",
        _summary(found, first, next_words, note),
        sections,
        note,
    )


def _summary(found: Comparison, first: CurveRow, next_words: Sequence[str], note: Mapping[str, Any]) -> Summary:
    rms, noise = number(found.fit.rms, 3), found.gap_is_noise
    factor, unit, label = shown_as(first.channel)
    size = f"{factor * float(np.max(np.abs(first.without.gap))):.3g} {unit}"
    ending = "which is noise" if noise else "which is more than noise"
    numbers = [
        Number("gap over noise", rms, "1 is noise alone", "given"),
        Number("largest difference", size, f"{label} of {first.run}", "given"),
        Number("worst fit", f"{min(curve.numbers['fit_percent'] for curve in found.curves):.3g} %", "100 % is all of what was measured"),
    ]
    if np.isfinite(found.dispersion_percent):
        numbers.append(Number("repeated runs differ by", f"{found.dispersion_percent:.2g} %", "of the measured elevation"))
    return Summary(
        "the gap is noise" if noise else "there is a gap",
        "good" if noise else "doubt",
        f"The model meets the measurements to {rms} times their noise, {ending} ({p_words(found.test.p_value)}).",
        [f"One sees it best in the {label} of {first.run}: {100 * first.visible:.2g} % of what was measured."],
        numbers,
        next_words,
        facts_of(
            note,
            rig=found.fit.problem.model.name,
            data=f"{len({c.run for c in found.curves})} runs, {found.fit.problem.measured} measured values",
        ),
    )


def _row(one: CurveRow) -> list[Any]:
    factor, unit, label = shown_as(one.channel)
    n = one.without.numbers
    lengths = [f"{factor * n[key]:.3g} {unit}" for key in ("rmse", "max_abs")]
    return [
        one.run,
        opened_name(label),
        *lengths,
        n["nrmse_percent"],
        n["fit_percent"],
        f"{factor * n['noise_sigma']:.2g} {unit}",
        one.over_noise,
    ]


def _figure(found: Comparison, one: CurveRow, name: str) -> Figure:
    problem = found.fit.problem
    loop = next((loop for loop in problem.loops if loop.run.name == one.run), None)
    if loop is None:
        return figure_of(one, name=name)
    samples = next(block.samples for block in problem.blocks if block.run == one.run)
    return loop_curves(one, 1e3 * loop.data.elongation_m[samples], last_cycle(loop.data.cycles.reversals, samples), name)
