"""The page of an explanation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from identify.report import gap_figures
from identify.report.explained import page_rows
from identify.report.explained.alone import bars_of_gaps, candidates, names_left
from identify.report.explained.films_seen import frame_of
from identify.report.explained.replayed import scene
from identify.report.explained.rig_drawing import rig_drawing
from identify.report.explained.story import checks, summary_of, sureness, times
from identify.report.explained.variants import switched, variants_of
from identify.report.result import result_of
from identify.selection.explanation import Explanation
from identify.selection.verdict import Finding
from measure.pages.csv_address import csv_address
from measure.pages.in_use import in_use, percent
from measure.pages.page import number, page_html
from simulate.report.effect_text import text_of

_PAGE = Path(__file__).with_name("explain.html.j2")
_SIDEWAYS = "x_m"
_MOST_OTHERS = 24


def report_html(
    found: Explanation,
    title: str,
    notes: Mapping[str, str],
    missing_force_file: str | None = None,
    *,
    note: Mapping[str, Any] | None = None,
) -> str:
    """The whole page.

    Parameters
    ----------
    notes : headings and plain texts that stand last.
    missing_force_file : where the table of the missing force was written, where something is left.
    note : provenance.
    """
    result, variants = result_of(found, missing_force_file), variants_of(found)
    rows = gap_figures.curve_rows(found, variants)
    shown = {
        "summary": summary_of(found, note or {}, result),
        "rig": found.before.problem.model.name,
        "r": result,
        "effects": [_effect(found, finding) for finding in found.findings],
        "notes": dict(notes),
        "note": note,
        "switches": switched(found),
        "states": [{"state": state, "gap": times(found.over_noise(fit))} for state, fit in variants.items()],
        "gap_words": _gap_words(found, result),
        "checks": checks(found),
        **_figures(found, rows),
        **_seen(found, rows),
        **_candidates(found),
        **page_rows.tables(found, result),
    }
    return page_html(_PAGE, title, **shown)


def _effect(found: Explanation, finding: Finding) -> dict[str, Any]:
    """An effect in words, formula, drawing and numbers."""
    text = text_of(type(finding.effect))
    docs = {row["name"]: row["is"] for row in text.parameters}
    flat = zip(finding.effect.flat_names(), finding.effect.flat(), finding.ci95, finding.stderr, strict=True)
    rows = [
        [
            name,
            in_use(name, float(value), [] if np.isnan(stderr) else ci95.tolist()) + (" (not identifiable)" if np.isnan(stderr) else ""),
            docs[name.split("[")[0]],
        ]
        for name, value, ci95, stderr in flat
    ]
    looks = " ".join(
        part
        for part in (text.in_loop and f"In a loop: {text.in_loop}", text.in_deployment and f"In a deployment: {text.in_deployment}")
        if part
    )
    return {
        "name": " or ".join((finding.name, *finding.equivalents)),
        "says": " ".join(part for part in (text.opening, looks) if part),
        "formula": text.formula,
        "rows": rows,
        "worth": f"It closes {100 * finding.share:.3g} % of the gap. Twice the log evidence gained: {number(finding.delta_bic)}.",
        "drawing": rig_drawing(found.before.problem.model, [finding.effect]),
    }


def _gap_words(found: Explanation, result: Mapping[str, Any]) -> str:
    gap = result["gap"]
    given, before, after = (times(gap[key]["rms_over_noise"]) for key in ("as_given", "before", "after"))
    words = (
        f"The model as given misses the measurements by {given} times their noise. With its force law refitted it still misses by {before}"
    )
    return f"{words}; with what was found by {after}." if found.findings else f"{words}."


def _figures(found: Explanation, rows: list[gap_figures.CurveRow]) -> dict[str, Any]:
    """The first figure, elevation and lateral channel beside it, the best run held out, and all the rest."""
    films = {film.run.name for film in found.before.problem.films}
    ours = [one for one in rows if not one.held_out]
    first = gap_figures.largest(ours)
    deployed = [one for one in ours if one.run in films]
    run = gap_figures.largest(deployed).run if deployed else ""
    beside = [one for one in deployed if one.run == run and one.channel in ("z_m", _SIDEWAYS) and one is not first]
    held = [one for one in rows if one.held_out]
    out = gap_figures.largest_over_noise(held) if held else None
    rest = [one for one in rows if not any(one is shown for shown in (first, *beside, out))][:_MOST_OTHERS]
    missing, located = found.missing, found.located
    return {
        "first": gap_figures.figure_of(first, name="gap", tall=True),
        "beside": [gap_figures.figure_of(one, name=f"gap-{i + 2}") for i, one in enumerate(beside)],
        "held": None if out is None else gap_figures.figure_of(out, name="held-out"),
        "others": [gap_figures.any_figure(found, one, f"run-{i + 1}") for i, one in enumerate(rest)],
        "loop_figure": gap_figures.loop_figure(found),
        "missing": missing and gap_figures.force_figure(missing, "missing-force", "The force that no effect explains"),
        "located": located and gap_figures.force_figure(located, "located", "The force that was missing at first"),
    }


def _seen(found: Explanation, rows: list[gap_figures.CurveRow]) -> dict[str, Any]:
    """The picture of the film, and the run in space."""
    runs = [film.run for film in found.before.problem.films]
    names = {run.name for run in runs}
    films = [one for one in rows if one.run in names and not one.held_out]
    if not films:
        return {"frame": None, "scene": None}
    frame, run = frame_of(runs), gap_figures.largest(films).run
    words = f"{run} in space, measured in black, the model in colour."
    return {"frame": frame and frame[1], "scene": scene(found, run), "scene_words": words}


def _candidates(found: Explanation) -> dict[str, Any]:
    """Bars of the gap that each candidate leaves, of the probabilities, and the rest as a table."""
    if not found.ranking:
        return {"candidates": []}
    tried, before = candidates(found), found.over_noise(found.before)
    bars = bars_of_gaps(tried, before)
    weights = [row for i, row in enumerate(sorted(found.weights.items(), key=lambda row: -row[1])[:8]) if i < 3 or row[1] > 1e-3]
    return {
        "candidates": bars,
        "before": before,
        "linearised": any(not one.fitted for one in tried),
        "candidates_csv": csv_address(
            {"effect": [c.name for c in tried], "gap left over noise": [c.left for c in tried], "probability": [c.weight for c in tried]}
        ),
        "weights": [
            {"name": name, "text": percent(weight), "share": weight, "look": "effect" if i == 0 else ""}
            for i, (name, weight) in enumerate(weights)
        ],
        "weights_csv": csv_address({"answer": list(found.weights), "probability": list(found.weights.values())}),
        "rest": [
            [row.name, row.delta_bic, percent(row.weight), "fitted" if row.fitted else "linearised"]
            for row in names_left(found, tried)[:40]
        ],
        "sureness": sureness(found),
    }
