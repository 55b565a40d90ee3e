"""Tables of the page of an explanation, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from identify.estimation.parameters import BASE, lines_of
from identify.selection.explanation import Explanation
from measure.pages.csv_address import csv_address
from measure.pages.in_use import in_use, shown_as
from simulate.model.model import per_leg

_MOST_CORRELATED = 12


def tables(found: Explanation, result: Mapping[str, Any]) -> dict[str, Any]:
    """All of them by the names that the template has for them."""
    detectable = [
        [one["name"], name, _size(name, size), _size(name, one["easiest_shape"][name])]
        for one in result["detectable"]
        for name, size in one["parameters"].items()
    ]
    sizes = [(one["name"], name, size) for one in result["detectable"] for name, size in one["parameters"].items()]
    return {
        "law": law(found),
        "by_run": [
            [one["run"], one["channel"], one["before"], one["after"], "held out" if one["held_out"] else "fitted"]
            for one in result["gap"]["by_run"]
        ],
        "where": [
            [w["run"], w["channel"], w["phase"], w["from_s"], w["to_s"], w["share_percent"], w["depends_on"]] for w in result["where"]
        ],
        "detectable": detectable,
        "detectable_csv": csv_address(
            {"effect": [s[0] for s in sizes], "parameter": [s[1] for s in sizes], "size, SI": [s[2] for s in sizes]}
        ),
        "noise": [[n.run, n.channel, _noise(n.channel, n.sigma), n.lag1, n.outliers_percent] for n in found.noise],
        "correlations": correlations(found),
        **tests(found, result),
    }


def _size(name: str, value: float) -> str:
    return "–" if value is None or not np.isfinite(value) else in_use(name, value)


def _noise(channel: str, sigma: float) -> str:
    factor, unit, _ = shown_as(channel)
    return f"{factor * sigma:.3g} {unit}"


def law(found: Explanation) -> list[list[Any]]:
    """The force law as given, refitted, and with what was found."""
    before, after = found.before, found.after
    model = before.problem.model
    given = [*lines_of(model), float(np.mean(per_leg(model.actuator.initial_force_N)))]
    shifts = [fit.problem.base_shifts(fit.q) for fit in (before, after)]
    errors = [float(np.sqrt(max(after.covariance[i, i], 0.0))) * after.problem.parameters[i].scale for i in range(len(BASE))]
    return [
        [name, float(given[i]), float(given[i] + shifts[0][i]), float(given[i] + shifts[1][i]), errors[i]] for i, name in enumerate(BASE)
    ]


def correlations(found: Explanation) -> dict[str, Any] | None:
    """Of the law and of what was found, as far as it moved."""
    names = found.after.problem.reported[:_MOST_CORRELATED]
    covariance = found.after.covariance_of(names)
    sizes = np.sqrt(np.diag(covariance))
    moved = sizes > 0.0
    if moved.sum() < 2:
        return None
    kept = covariance[np.ix_(moved, moved)] / np.outer(sizes[moved], sizes[moved])
    return {"names": [name for name, free in zip(names, moved, strict=True) if free], "rows": kept.tolist()}


def tests(found: Explanation, result: Mapping[str, Any]) -> dict[str, Any]:
    """Further tests that would tell the foremost name from its rivals."""
    rows = result["next_experiments"]
    if not rows:
        return {"tests": []}
    return {
        "tests": [[row["condition"], row["runs"], *(f"{100 * p:.0f} %" for p in row["splits"].values())] for row in rows],
        "tests_heads": ["test", "runs", *rows[0]["splits"]],
        "tests_of": found.findings[0].name,
    }
