"""Rates with their intervals, and who was taken for whom."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import binomtest

from .further import Split
from .scoring import Scored

Ask = Callable[[Scored], bool]


@dataclass(frozen=True)
class Rate:
    """A share of cases with its 95 % interval (Clopper and Pearson 1934). goal : what it is meant to be, in words."""

    name: str
    hits: int
    cases: int
    goal: str = ""

    @property
    def share(self) -> float:
        """Hits over cases."""
        return self.hits / self.cases if self.cases else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """95 %, exact."""
        if not self.cases:
            return 0.0, 1.0
        found = binomtest(self.hits, self.cases).proportion_ci(0.95, method="exact")
        return float(found.low), float(found.high)

    def as_dict(self) -> dict[str, Any]:
        """For JSON; no share where there is no case."""
        return {
            "name": self.name,
            "hits": self.hits,
            "cases": self.cases,
            "share": self.share if self.cases else None,
            "ci95": list(self.interval),
            "goal": self.goal,
        }

    def __str__(self) -> str:
        low, high = self.interval
        shown = f"{100 * self.share:5.1f} %  ({100 * low:.0f} to {100 * high:.0f})" if self.cases else "    -"
        return f"{self.name:<58s} {self.hits:4d} of {self.cases:<4d} {shown:<24s} {self.goal}"


def rate(name: str, rows: Iterable[Scored], hit: Ask, goal: str = "") -> Rate:
    """The share of rows that are hits."""
    rows = list(rows)
    return Rate(name, sum(hit(row) for row in rows), len(rows), goal)


def single(rows: Sequence[Scored], size: float | None = None, run_set: str | None = None) -> list[Scored]:
    """Cases with one effect of the catalogue that shows, as large as meant, on loops without a zero of their own and no film."""
    return [
        row
        for row in rows
        if row.expected == "effect"
        and len(row.spec.hidden) == 1
        and row.sound
        and not row.spec.own_tare
        and row.spec.noise != "film"
        and size in (None, row.spec.size)
        and run_set in (None, row.spec.run_set)
    ]


def headline(rows: Sequence[Scored]) -> list[Rate]:
    """The rates by which the whole is judged."""
    three, one = single(rows, 3.0, "standard"), single(rows, 1.0, "standard")
    nothing = [row for row in rows if row.expected == "none"]
    unknown = [row for row in rows if row.expected == "unknown"]
    intervals = [row for row in rows if row.intervals]
    alone = [row for row in three if not row.alike]
    return [
        rate("3 x detectable, standard: class-correct", three, lambda r: r.class_correct, "at least 95 %"),
        rate("3 x, standard, class of one: named first", alone, lambda r: r.top_one, "at least 90 %"),
        rate("nothing to be seen: false alarms", nothing, lambda r: r.names, "at most 5 %"),
        rate("from outside the catalogue: said to be unknown", unknown, lambda r: r.verdict == "unknown", "at least 80 %"),
        rate("1 x detectable, standard: wrong names", one, lambda r: r.wrong, "at most 5 %"),
        Rate("95 % intervals that hold the true size", sum(r.inside for r in intervals), sum(r.intervals for r in intervals), "90 to 99 %"),
        rate("no answer", rows, lambda r: r.verdict == "failed", "none"),
    ]


def strata(rows: Sequence[Scored]) -> list[Rate]:
    """The same by size and by run set."""
    made = []
    places = sorted({(row.spec.run_set, row.spec.size) for row in single(rows)})
    for run_set, size in places:
        here = single(rows, size, run_set)
        label = f"{run_set}, {size:g} x"
        made += [
            rate(f"{label}: class-correct", here, lambda r: r.class_correct),
            rate(f"{label}, class of one: named first", [r for r in here if not r.alike], lambda r: r.top_one),
            rate(f"{label}: nothing named", here, lambda r: not r.names),
            rate(f"{label}: wrong names", here, lambda r: r.wrong),
            rate(f"{label}: wrong, and not even alike", here, lambda r: r.beyond_class),
        ]
    for run_set in sorted({row.spec.run_set for row in rows if row.expected == "none"}):
        here = [row for row in rows if row.expected == "none" and row.spec.run_set == run_set]
        made.append(rate(f"{run_set}, nothing to be seen: false alarms", here, lambda r: r.names))
    made += [
        rate("two effects: both, and nothing else", [r for r in rows if r.expected == "several"], lambda r: r.class_correct),
        rate("two effects: a wrong name", [r for r in rows if r.expected == "several"], lambda r: r.wrong),
        rate("from outside the catalogue: a name all the same", [r for r in rows if r.expected == "unknown"], lambda r: r.names),
        rate("loops with zeros of their own: class-correct", [r for r in rows if r.spec.own_tare], lambda r: r.class_correct),
        rate("a film among the runs: class-correct", [r for r in rows if r.spec.noise == "film"], lambda r: r.class_correct),
    ]
    for engine in sorted({row.spec.engine for row in single(rows)}):
        here = [row for row in single(rows) if row.spec.engine == engine and row.spec.size >= 3.0]
        made.append(rate(f"moved by {engine}, 3 x and more: class-correct", here, lambda r: r.class_correct))
    return [found for found in made if found.cases]


def held_out_gap(rows: Sequence[Scored]) -> dict[str, Any]:
    """Gap over noise of runs that took no part, after, where one effect was there to be found at three times what is detectable."""
    values = np.array([row.held_out for row in single(rows, 3.0, "standard") if row.held_out is not None])
    if not len(values):
        return {"cases": 0, "median": None, "ci95": None, "goal": "at most 1.15"}
    draws = np.random.default_rng(0).choice(values, (2000, len(values)))
    low, high = np.quantile(np.median(draws, axis=1), [0.025, 0.975])
    return {"cases": len(values), "median": float(np.median(values)), "ci95": [float(low), float(high)], "goal": "at most 1.15"}


def confusion(rows: Sequence[Scored]) -> dict[str, dict[str, int]]:
    """For each thing that acted, how often what was said: names in the order found, joined; verdicts where nothing was named."""
    table: dict[str, Counter[str]] = {}
    for row in rows:
        true = " + ".join(row.spec.hidden) or "nothing"
        said = " + ".join(finding[0] for finding in row.said) if row.names else row.verdict
        table.setdefault(true, Counter())[said] += 1
    return {true: dict(table[true].most_common()) for true in sorted(table)}


def split_rates(splits: Sequence[Split]) -> list[Rate]:
    """What became of classes once the recommended test was done."""
    if not splits:
        return []
    predicted = np.nanmean([found.predicted for found in splits])
    return [
        Rate("classes that the recommended test splits", sum(s.split for s in splits), len(splits), "at least 80 %"),
        Rate("there, something has gone, whatever else has come", sum(s.smaller for s in splits), len(splits)),
        Rate("there, the truth left alone", sum(s.settled for s in splits), len(splits), f"predicted: {100 * predicted:.0f} %"),
    ]


def tally(rows: Sequence[Scored], splits: Sequence[Split] = ()) -> dict[str, Any]:
    """Everything for JSON."""
    spent = [row.processor_s for row in rows]
    return {
        "cases": len(rows),
        "headline": [found.as_dict() for found in (*headline(rows), *split_rates(splits))],
        "held_out_gap": held_out_gap(rows),
        "strata": [found.as_dict() for found in strata(rows)],
        "confusion": confusion(rows),
        "processor_s": {"median": float(np.median(spent)), "largest": float(np.max(spent))} if spent else None,
    }
