"""The further test that an answer recommends, done: the case again with one run more.

The run is made by the same truth under the condition of the answer's `next_experiments`; the question is asked again, and the class has
been split where the true effect is still in it, something else has gone, and nothing has come.
"""

from __future__ import annotations

import shutil
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from identify.criteria import LIKELY
from measure.common.output import write_text

from .campaigns import FRAMES, Campaign, Deployment, Seen, Shaking, deployment, shaking
from .making import Case, case_folder, drawn_case, listed, tables_of
from .running import Answer, ask_all, in_turn
from .scoring import Scored, score_case
from .specs import Spec

_FIRST_FILM = Seen(("x_m", "z_m", "theta_y_rad"), zeroed=True, tells_sigma=True)


@dataclass(frozen=True)
class Split:
    """A class before and after the recommended test. predicted : how likely the answer said that it would be split, at worst."""

    spec: Spec
    before: Scored
    after: Scored
    predicted: float

    @property
    def smaller(self) -> bool:
        """Whether something has gone from the class and the truth has stayed, whatever else has come."""
        return self.after.class_correct and bool(set(self.before.said[0]) - set(self.after.said[0]))

    @property
    def split(self) -> bool:
        """Whether, besides, nothing has come: another effect that these data do not exclude is no step ahead."""
        return self.smaller and set(self.after.said[0]) < set(self.before.said[0])

    @property
    def settled(self) -> bool:
        """Whether the truth is left alone."""
        return self.split and len(self.after.said[0]) == 1


def splits(rows: Sequence[Scored], answers: Sequence[Answer], method: str, folder: Path, **how: Any) -> list[Split]:
    """Do the recommended test for every class that holds the truth, and ask again; a class for which none is recommended is left."""
    classes = {
        row.spec.token: (row, answer.result["next_experiments"][0])
        for row, answer in zip(rows, answers, strict=True)
        if row.verdict == "class" and row.class_correct and _recommends(answer)
    }
    makers = {token: _maker(row.spec, test, folder) for token, (row, test) in classes.items()}
    again = ask_all(in_turn(makers), method, folder / f"{method}-further.jsonl", **how)
    return [
        Split(row.spec, row, score_case(row.spec, again[token], folder), min(test["splits"].values(), default=float("nan")))
        for token, (row, test) in classes.items()
    ]


def _recommends(answer: Answer) -> bool:
    """Whether the answer says that its best test is likely to split the class."""
    predicted = answer.result.get("next_experiments")
    return bool(predicted) and max(predicted[0]["splits"].values()) >= LIKELY


def _maker(spec: Spec, test: Mapping[str, Any], folder: Path) -> Any:
    return lambda: with_further_run(spec, test, folder)


def with_further_run(spec: Spec, test: Mapping[str, Any], folder: Path) -> Path:
    """A copy of the case with the recommended runs behind the others, each let go for itself."""
    place = folder / "further" / spec.token
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(case_folder(folder, spec), place)
    case = drawn_case(spec)
    chance = np.random.default_rng([int(spec.token, 16), 1])
    rows = tomllib.loads((place / "campaign.toml").read_text(encoding="utf-8"))["run"]
    for _ in range(test.get("runs", 1)):
        run = further_run(spec, case, test, chance)
        campaign = Campaign((run,)) if isinstance(run, Deployment) else Campaign((), (run,))
        (table,) = tables_of(case.model, campaign, spec, chance)
        rows.append(listed(place, len(rows) + 1, run, table))
    write_text(place / "campaign.toml", tomli_w.dumps({"run": rows}))
    return place


def further_run(spec: Spec, case: Case, test: Mapping[str, Any], chance: np.random.Generator) -> Deployment | Shaking:
    """The run that a recommended test describes, let go and measured as the others were."""
    known, before = case.rig.known, case.campaign
    if test["kind"] == "loop":
        return shaking(spec, known, test["frequency_Hz"], test["amplitude_m"], False, False, chance)
    like = before.deployments[0] if before.deployments else _FIRST_FILM
    seen = Seen(tuple(test.get("channels") or like.channels), like.zeroed, like.tells_sigma)
    run = deployment(spec, known, _dotted(test["model"]), seen, False, chance)
    return replace(run, frames=round(FRAMES * test.get("times_as_long", 1.0)))


def _dotted(tables: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """`[run.model]` as keys with points, lists as tuples, as a model holds them."""
    return {f"{table}.{key}": _fixed(value) for table, entries in tables.items() for key, value in entries.items()}


def _fixed(value: Any) -> Any:
    return tuple(_fixed(entry) for entry in value) if isinstance(value, list | tuple) else value
