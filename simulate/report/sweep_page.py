"""The page of a sweep: how many runs fail, which factors matter, and how well the forces must agree."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.pages.figure import Band, Figure, Line, Panel
from measure.pages.page import facts_of, number
from measure.pages.sections import Bars, Section, Table, sections_html
from measure.pages.summary import Number, Summary

if TYPE_CHECKING:
    from simulate.sweeps.result import SweepResult

_TERMS = 20
_LEVELS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # of the second factor
_LOOKS = ("two", "five", "three", "one", "four")
_NEARLY = 0.9  # of the largest share, from which on a factor is named beside it
_MOST_FAILED = 5.0  # percent, up to which a rig is called good here


def sweep_html(result: SweepResult, report: Mapping[str, Any], sentences: Sequence[str]) -> str:
    """The whole page.

    Parameters
    ----------
    report : as the command's JSON has it. sentences : on tolerances, as the command prints them.
    """
    name, unit = result.sweep.model.name, result.unit
    terms = {key: value for key, value in report["coefficients"].items() if key != "1"}
    largest = dict(sorted(terms.items(), key=lambda row: -abs(row[1]))[:_TERMS])
    fresh = report["fresh"]
    checked = (
        f"On {fresh['runs']} fresh runs the regression is off by {number(fresh['rms'], 3)} {unit} (rms); the response itself is "
        f"{number(fresh['rms_of_response'], 3)} {unit}."
        if fresh["rms"] is not None
        else "There was no run to check the regression with."
    )
    bars = Bars(
        "coefficients",
        f"The {len(largest)} largest of {len(terms)} coefficients in coded factors (blue up, orange down)",
        unit,
        largest,
        "factors",
    )
    sections = [
        Section("How the runs are spread", figures=[_histogram(result)]),
        Section(
            "Which factors matter",
            [checked],
            formula=report["formula"],
            bars=[bars] if largest else [],
            tables=[*_indices(report), _factors(report)],
        ),
        *_two_factors(result),
        *_tolerance(report, sentences),
        *([Section("Warnings", listed=report["warnings"])] if report["warnings"] else []),
    ]
    return sections_html(
        f"A sweep of “{name}”", f"unspool · sweep-deployments · {name}", _summary(result, report, sentences), sections, report["provenance"]
    )


def _summary(result: SweepResult, report: Mapping[str, Any], sentences: Sequence[str]) -> Summary:
    failed, limit = report["failed_percent"], result.failure_deg
    interval = report["failed_interval_percent"]
    sure = "" if interval is None else f" (95 % interval {interval[0]:.2f} to {interval[1]:.2f} %)"
    ended = f"; {report['diverged']} diverged" if report["diverged"] else ""
    step = report["step"]
    sensitive = 100 * step["sensitive_probes"] / step["probes"]
    exact = (
        "exact to what the step search asks for"
        if step["largest_error_deg"] is None
        else f"theta_z good to {step['largest_error_deg']:.1g} deg"
    )
    shares = {key: value for key, value in report["variability_percent"].items() if key != "1"}
    most = max(shares.values(), default=0.0)
    foremost = [key for key, share in shares.items() if share > _NEARLY * most]
    numbers = [
        Number("runs", str(report["runs"]), f"{report['design']} design, {len(report['factors'])} factors"),
        Number(f"beyond {limit:g} deg", f"{failed:.3g} %", f"{report['failed_before_stop_percent']:.3g} % before the first stop", "given"),
    ]
    if foremost:
        share = sum(shares[key] for key in foremost)
        numbers.append(Number("most of it by", ", ".join(foremost), f"together {share:.3g} % of the variability", "effect"))
    return Summary(
        f"{failed:.3g} % fail" + ended,
        "bad" if report["diverged"] else "good" if failed < _MOST_FAILED else "doubt",
        f"{failed:.3g} % of {report['runs']} runs turn beyond {limit:g} deg{sure}{ended}.",
        [f"Steps up to {1e3 * step['step_s']:.3g} ms, {exact}; {sensitive:.0f} % of the runs are sensitive to the release."],
        numbers,
        sentences,
        facts_of(report["provenance"], rig=result.sweep.model.name, data=f"simulated, seed {report['provenance'].get('seed', 0)}"),
    )


def _histogram(result: SweepResult) -> Figure:
    counts, edges = result.histogram()
    x = np.repeat(edges, 2)[1:-1]
    runs = np.repeat(counts, 2).astype(float)
    top = 1.05 * float(counts.max(initial=1))
    limits = [] if result.limit is None else [float(sign * result.limit) for sign in (-1, 1)]
    lines = [Line("limit of a failure", np.array([at, at]), np.array([0.0, top]), "limit") for at in limits if edges[0] <= at <= edges[-1]]
    band = Band("runs", x, np.zeros(len(x)), runs, "one")
    panel = Panel("runs", lines, (band,), 240, limits=(0.0, top))
    return Figure("responses", f"{result.response} of {int(counts.sum())} runs", f"{result.response}, {result.unit}", [panel])


def _two_factors(result: SweepResult) -> list[Section]:
    """The response over the two factors with the largest effects, all others in their middle."""
    places = result.largest_pair
    if places is None:
        return []
    values = result.map(*places)
    levels = np.linspace(-1.0, 1.0, len(values))
    factors = [result.sweep.factors[place] for place in places]
    at = [int(np.argmin(np.abs(levels - level))) for level in _LEVELS]
    lines = [Line(f"{factors[1].letter} = {levels[k]:g}", levels, values[:, k], look) for k, look in zip(at, _LOOKS, strict=True)]
    along, across = (f"{factor.key} ({factor.letter})" for factor in factors)
    words = f"{along} along, {across} as curves; -1 and 1 are the ends of their ranges."
    panel = Panel(f"{result.response}, {result.unit}", lines, height_px=260)
    return [
        Section(
            "The response over two factors",
            figures=[Figure("two-factors", "All others in their middle", f"{factors[0].letter}, coded", [panel], words)],
        )
    ]


def _tolerance(report: Mapping[str, Any], sentences: Sequence[str]) -> list[Section]:
    tolerance = report["tolerance"]
    if not tolerance["curve"]:
        return []
    from scipy.stats import norm

    spreads = np.array([point["spread_N"] for point in tolerance["curve"]])
    factor = float(norm.ppf((1 + tolerance["probability"]) / 2)) * float(np.linalg.norm(tolerance["slope_deg_per_N"]))
    lines = [
        Line("simulated", 1e3 * spreads, np.array([point["angle_deg"] for point in tolerance["curve"]]), "effect"),
        Line("by the slopes", 1e3 * spreads, factor * spreads, "limit"),
    ]
    title = f"Angle kept in {100 * tolerance['probability']:g} % of the runs"
    figure = Figure(
        "tolerance", title, "spread of the stored forces, mN (one standard deviation)", [Panel("abs(theta_z), deg", lines, height_px=240)]
    )
    return [Section("How well the forces must agree", figures=[figure], listed=sentences)]


def _factors(report: Mapping[str, Any]) -> Table:
    share = report["variability_percent"]
    rows = [[row["letter"], row["key"], row["low"], row["high"], share.get(row["letter"], float("nan"))] for row in report["factors"]]
    return Table("factors", "Factors and their ranges", ["letter", "key", "low", "high", "share of the variability, %"], rows)


def _indices(report: Mapping[str, Any]) -> list[Table]:
    """Sensitivity indices with intervals, where the runs were chosen for them."""
    found = report.get("indices")
    if not found or not found.get("indices"):
        return []
    kinds = found["indices"]
    letters = list(next(iter(kinds.values())))
    rows = [[letter, *(_ranged(kind[letter]) for kind in kinds.values())] for letter in letters]
    return [Table("indices", "Sensitivity indices, 95 % intervals", ["factor", *(name.replace("_", " ") for name in kinds)], rows)]


def _ranged(row: Mapping[str, Any]) -> str:
    low, high = row["interval"]
    return f"{row['value']:.3g} ({low:.3g} to {high:.3g})"
