"""Rates with their intervals, stated weights against how often they were right, and the cases to look at."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from board.tally import Rate

from .scoring import Scored
from .sizes import SHOWS

ABOUT = """# Bench board

How often are the answers of `explain-gap` right where the noise has a memory and the model file is not exact? This page is
written by

    make bench SEED=7 SHARE=0.25       # a share of 120 cases; the whole is an hour on two quiet cores

| kind | what acts | cases |
| --- | --- | --- |
| nothing | the model file is right within its tolerances | 40 |
| errors | mass off by 2 to 5 %, inertia by 20 %, joints by 1 mm, stops by a factor of 3 to 7, force of a run by 2 to 5 % | 30 |
| effects | an effect of the catalogue at five times the detectable size | 30 |
| outside | a force that no catalogue holds, at ten times the detectable size | 20 |

Every case has what a laboratory has without knowing: platform mass (0.5 %), inertia (5 %), centre of mass (0.5 mm), joints
(0.3 mm), stops (30 %), stored force of each run (0.5 %), releases, a force law off by some per cent, noise with a lag-1
correlation of 0 to 0.8 (half of it in the load cell), in some cases 20 to 80 % of it white, 1 % of outliers, 4 % of missing
frames, values in steps.
Three or four deployments, the last one held out; six loops for most, films or the elevation alone for the others. Scipy's
LSODA on a right-hand side of its own, or MuJoCo, moves the platform. *Detectable* is found as on the
[scoreboard](scoreboard.md), along straight lines up to the stops (of what acts there behind them, too), with the tolerances free
and the noise as loud as its memory makes it; what the model file itself states with a tolerance must stand out from that as well.
To a large effect law and releases may bend by more than straight lines predict. The table of cases says how many times the
detectable size is left once all that is free has bent to it; from 1.5 times on, which a test finds in 95 of 100, runs *show* it.
How much of an error of the model file shows is counted along straight lines, too: what a hundredth of it changes, times a hundred.
A wrong mass is asked with loops only: without them another force law looks the same up to the stops.
A case with an error of the model file is drawn anew, up to 30 times, until its runs show the error: what they cannot show nobody
can name. An effect that the runs of its case cannot show at any size counts as nothing.

A class is *honest* where the gap of the runs held out loses 70 % of what is more than noise. *Right* for nothing is
`no-gap`; for an error or an effect, what acts stands in a finding and nothing beside it; for a force from outside, `unknown`,
`partly` or an honest class.
"""
BINS = (0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)
_LISTED = 5


def rate(name: str, rows: Iterable[Scored], hit: Callable[[Scored], bool], goal: str) -> Rate:
    """The share of rows that are hits."""
    rows = list(rows)
    return Rate(name, sum(hit(row) for row in rows), len(rows), goal)


def headline(rows: Sequence[Scored]) -> list[Rate]:
    """What the board is judged by."""
    nothing, errors, effects, outside = (
        [row for row in rows if row.expected == kind] for kind in ("nothing", "errors", "effects", "outside")
    )
    return [
        rate("nothing: a gap is seen", nothing, lambda r: r.verdict != "no-gap", "at most 2 of 40"),
        rate("nothing: a wrong name", nothing, lambda r: r.names, "0 of 40"),
        rate("model file: named, or in the class", errors, lambda r: r.found, "at least 25 of 30"),
        rate("model file: the same of those that these runs show", [r for r in errors if r.multiple >= SHOWS], lambda r: r.found, ""),
        rate("model file: physics invented", errors, lambda r: r.invented, "at most 1 of 30"),
        rate("effects: class-correct", effects, lambda r: r.class_correct, "at least 27 of 30"),
        rate("effects: the same of those that these runs show", [r for r in effects if r.multiple >= SHOWS], lambda r: r.class_correct, ""),
        rate("effects: a wrong name", effects, lambda r: r.wrong, "at most 1 of 30"),
        rate("outside: unknown, partly, or an honest class", outside, lambda r: r.honest, "at least 16 of 20"),
        rate("outside: the draft removes 70 % of the held-out excess", outside, lambda r: r.draft_worth_having, "at least 12 of 20"),
        Rate("95 % intervals that hold the truth", sum(r.inside for r in rows), sum(r.intervals for r in rows), "90 to 99 %"),
        rate("names that make the held-out gap larger", [r for r in rows if r.names], lambda r: r.worse, ""),
        rate("the same of names said alone", [r for r in rows if r.verdict == "named"], lambda r: r.worse, "none"),
        rate("no answer", rows, lambda r: r.verdict == "failed", "none"),
    ]


def calibration(rows: Sequence[Scored]) -> list[tuple[str, float, Rate]]:
    """For each range of stated weights: its words, the mean weight, and how often the hypothesis was the truth."""
    stated = [(weight, row.is_true(name)) for row in rows for name, weight in row.weights.items()]
    found = []
    for low, high in pairwise(BINS):
        here = [(weight, true) for weight, true in stated if low <= weight < high or weight == high == 1.0]
        if here:
            mean = float(np.mean([weight for weight, _ in here]))
            found.append((f"{low:g} to {high:g}", mean, Rate("", sum(true for _, true in here), len(here))))
    return found


def times(rows: Sequence[Scored]) -> list[tuple[str, int, float, float]]:
    """Processor time by verdict: cases, median and largest, s."""
    by_verdict = {word: [row.processor_s for row in rows if row.verdict == word] for word in sorted({row.verdict for row in rows})}
    return [(word, len(spent), float(np.median(spent)), max(spent)) for word, spent in by_verdict.items()]


def printed(rows: Sequence[Scored]) -> str:
    """For a terminal."""
    wrong = [row for row in rows if not row.right]
    return "\n".join([*map(str, headline(rows)), "", "cases to look at", *(f"  {_words(row)}" for row in wrong)])


def as_json(rows: Sequence[Scored]) -> dict[str, Any]:
    """Everything for JSON."""
    return {
        "headline": [one.as_dict() for one in headline(rows)],
        "calibration": [{"stated": words, "mean": mean, **one.as_dict()} for words, mean, one in calibration(rows)],
        "processor_s": [dict(zip(("verdict", "cases", "median", "largest"), one, strict=True)) for one in times(rows)],
        "cases": [{"token": row.spec.token, **row.spec.as_dict(), "verdict": row.verdict, "right": row.right} for row in rows],
    }


def markdown(rows: Sequence[Scored], about: str) -> str:
    """The page of a run."""
    lines = [ABOUT, "## Rates", "", f"{about} 95 % intervals after Clopper and Pearson in brackets.", ""]
    lines += table(["what", "found", "interval", "aim"], [[one.name, *_share(one), one.goal] for one in headline(rows)])
    stated = [[words, f"{mean:.3f}", *_share(one)] for words, mean, one in calibration(rows)]
    lines += ["", "## Stated weights", "", *table(["weight", "mean", "right", "interval"], stated)]
    spent = [[word, n, f"{median:.0f}", f"{largest:.0f}"] for word, n, median, largest in times(rows)]
    lines += ["", "## Processor time", "", *table(["verdict", "cases", "median, s", "largest, s"], spent)]
    head = ["kind", "acts", "times detectable", "runs", "verdict", "said", "right", "time, s"]
    lines += ["", "## Cases", "", *table(head, [_cells(row) for row in rows])]
    return "\n".join(lines) + "\n"


def table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> list[str]:
    """Lines of a markdown table."""
    return [f"| {' | '.join(map(str, cells))} |" for cells in (head, ["---"] * len(head), *rows)]


def _share(one: Rate) -> list[str]:
    low, high = one.interval
    return [f"{one.hits} of {one.cases}", f"({100 * low:.0f} to {100 * high:.0f} %)" if one.cases else "-"]


def _cells(row: Scored) -> list[str]:
    spec = row.spec
    shown, right = f"{row.multiple:.1f}" if row.multiple else "", "yes" if row.right else "no"
    return [spec.kind, spec.hidden or "nothing", shown, spec.runs, row.verdict, _said(row), right, f"{row.processor_s:.0f}"]


def _said(row: Scored) -> str:
    return "; ".join(" or ".join(finding) for finding in row.said)


def _words(row: Scored) -> str:
    spec = row.spec
    first = sorted(row.weights.items(), key=lambda one: -one[1])[:_LISTED]
    weights = ", ".join(f"{name} {weight:.3f}" for name, weight in first)
    return f"{spec.token}  {spec.hidden or 'nothing'}, {spec.runs}: {row.verdict} {_said(row)} [{weights}] ({row.processor_s:.0f} s)"
