"""Figure of sensitivity indices: their sizes with intervals, and how they have come to rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

_COLOURS = ("#1b5e8a", "#c2571a")
_MOST_LINES = 8


def draw_indices(axes: Any, rows: Mapping[str, Mapping[str, Any]], names: tuple[str, str], labels: tuple[str, str]) -> Any:
    """Two indices of every factor side by side as bars with intervals, the largest first; their letters in that order."""
    leading = rows[names[0]]
    letters = sorted(leading, key=lambda letter: -leading[letter]["value"])
    for i, (name, label) in enumerate(zip(names, labels, strict=True)):
        values = np.array([rows[name][letter]["value"] for letter in letters])
        ends = np.array([rows[name][letter]["interval"] for letter in letters])
        places = np.arange(len(letters)) + 0.4 * i - 0.2
        errors = np.abs(ends.T - values)
        axes.bar(places, values, 0.38, yerr=errors, color=_COLOURS[i], error_kw={"lw": 1, "capsize": 2}, label=label)
    axes.set_xticks(range(len(letters)), letters)
    axes.axhline(0.0, color="black", lw=0.6)
    axes.legend(frameon=False, fontsize=8)
    return letters


def draw_convergence(axes: Any, steps: list[Mapping[str, Any]], name: str, letters: list[str]) -> Any:
    """An index of the foremost factors over the number of runs, each within its interval."""
    runs = [step["runs"] for step in steps]
    for i, letter in enumerate(letters[:_MOST_LINES]):
        rows = [step["indices"][name][letter] for step in steps]
        ends = np.array([row["interval"] for row in rows])
        (line,) = axes.plot(runs, [row["value"] for row in rows], "o-", ms=3, lw=1, color=f"C{i}", label=letter)
        axes.fill_between(runs, ends[:, 0], ends[:, 1], color=line.get_color(), alpha=0.12, lw=0)
    axes.set_xscale("log", base=2)
    axes.set(xlabel="runs", title="come to rest")
    axes.legend(frameon=False, fontsize=8, ncols=2)
    return axes


def indices_figure(found: Mapping[str, Any], response: str, unit: str) -> Any:
    """Indices of a sweep as `indices_of` gives them."""
    from matplotlib.figure import Figure

    sobol = found["method"] == "sobol"
    names = ("total", "first_order") if sobol else ("mean_size", "spread")
    labels = ("total", "first order") if sobol else ("mean size", "spread")
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=sobol)
    letters = draw_indices(left, found["indices"], names, labels)
    left.set(ylabel="share of the variance" if sobol else f"effect, {unit}", title=response)
    draw_convergence(right, found["convergence"], names[0], letters)
    return figure
