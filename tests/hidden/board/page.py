"""The scoreboard as text for a terminal and as a markdown page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .further import Split
from .scoring import Scored
from .tally import confusion, headline, held_out_gap, split_rates, strata


def printed(method: str, rows: Sequence[Scored], splits: Sequence[Split] = ()) -> str:
    """Headline, strata, confusion and what went wrong, for a terminal."""
    gap = held_out_gap(rows)
    lines = [f"== {method}: {len(rows)} cases", *map(str, (*headline(rows), *split_rates(splits)))]
    if gap["cases"]:
        lines.append(f"{'3 x, standard: held-out gap over noise, median':<58s} {_gap(gap)}   {gap['goal']}")
    lines += ["", *map(str, strata(rows)), "", "what acted -> what was said"]
    lines += [f"  {true:<44s} {_counts(said)}" for true, said in confusion(rows).items()]
    lines += ["", "cases to look at", *(_to_look_at(row) for row in rows if _is_wrong(row))]
    return "\n".join(lines)


def _counts(said: Mapping[str, int]) -> str:
    return ", ".join(f"{name} {n}" if n > 1 else name for name, n in said.items())


def _is_wrong(row: Scored) -> bool:
    right = {"none": not row.names, "unknown": row.verdict == "unknown"}.get(row.expected, row.class_correct)
    return not right


def _to_look_at(row: Scored) -> str:
    spec = row.spec
    hidden = " + ".join(spec.hidden) or "nothing"
    said = "; ".join("/".join(finding) for finding in row.said)
    case = f"{spec.token}  {hidden} {spec.size:g} x  {spec.run_set} {spec.noise} {spec.engine}"
    return f"  {case}: {row.verdict} {said} ({row.processor_s:.0f} s)"


def markdown(found: Mapping[str, Any], subset: str, sources: str) -> str:
    """The page: methods side by side, then the confusion of each."""
    methods = list(found)
    first = found[methods[0]]
    lines = ["# Scoreboard", "", f"Subset `{subset}`, {first['cases']} cases, sources `{sources}`. 95 % intervals in brackets.", ""]
    lines += _table("", "headline", found)
    lines += [_row("held-out gap over noise, median", [_gap(found[m]["held_out_gap"]) for m in methods], first["held_out_gap"]["goal"])]
    lines += ["", "## By size, run set and engine", "", *_table("", "strata", found)]
    for method in methods:
        lines += ["", f"## What acted, and what {method} said", "", "| acted | said |", "| --- | --- |"]
        lines += [f"| {true} | {_counts(said)} |" for true, said in found[method]["confusion"].items()]
    return "\n".join(lines) + "\n"


def _table(lead: str, part: str, found: Mapping[str, Any]) -> list[str]:
    methods = list(found)
    rates = {method: {row["name"]: row for row in found[method][part]} for method in methods}
    names = list(dict.fromkeys(name for method in methods for name in rates[method]))
    goals = {name: next(r[name]["goal"] for r in rates.values() if name in r) for name in names}
    lines = [_row(lead, methods, "goal"), _row("---", ["---"] * len(methods), "---")]
    return lines + [_row(name, [_share(rates[m].get(name)) for m in methods], goals[name]) for name in names]


def _row(name: str, cells: Sequence[str], goal: str) -> str:
    return "| " + " | ".join([name, *cells, goal]) + " |"


def _share(row: Mapping[str, Any] | None) -> str:
    if row is None or not row["cases"]:
        return "-"
    low, high = row["ci95"]
    return f"{100 * row['share']:.0f} % of {row['cases']} ({100 * low:.0f} to {100 * high:.0f})"


def _gap(row: Mapping[str, Any]) -> str:
    if not row["cases"]:
        return "-"
    low, high = row["ci95"]
    return f"{row['median']:.2f} ({low:.2f} to {high:.2f})"
