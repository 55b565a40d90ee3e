"""What an answer is worth against the truth, case by case."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .making import sealed_file
from .running import Answer
from .specs import Spec

SPEAKS = ("named", "class", "several")


@dataclass(frozen=True)
class Scored:
    """An answer with the truth beside it.

    true : names of what acts and these runs can show. said : for each finding its name and equivalents.
    alike : names that cannot be told from the single true effect. sound : drawn as large as it was meant to be.
    inside, intervals : of the sizes' 95 % intervals, how many hold the truth.
    """

    spec: Spec
    expected: str
    true: tuple[str, ...]
    alike: tuple[str, ...]
    sound: bool
    verdict: str
    said: tuple[tuple[str, ...], ...]
    held_out: float | None
    inside: int
    intervals: int
    processor_s: float

    @property
    def names(self) -> bool:
        """Whether anything was named."""
        return self.verdict in SPEAKS and bool(self.said)

    @property
    def class_correct(self) -> bool:
        """Whether every true effect stands in a finding, as its name or among its equivalents, and no finding is beside the truth."""
        found = all(any(name in finding for finding in self.said) for name in self.true)
        return self.names and found and not self.wrong

    @property
    def wrong(self) -> bool:
        """Whether a finding holds no true effect, neither as its name nor among its equivalents."""
        return self.names and any(not set(finding) & set(self.true) for finding in self.said)

    @property
    def beyond_class(self) -> bool:
        """Whether a finding holds neither a true effect nor one that these runs cannot tell from it."""
        return self.names and any(not set(finding) & {*self.true, *self.alike} for finding in self.said)

    @property
    def top_one(self) -> bool:
        """Whether the one true effect is what was named first."""
        return self.names and len(self.true) == 1 and self.said[0][0] == self.true[0]


def scored(specs: Sequence[Spec], answers: Sequence[Answer], folder: Path) -> list[Scored]:
    """All answers scored; the seals are broken here and nowhere before."""
    return [score_case(spec, answer, folder) for spec, answer in zip(specs, answers, strict=True)]


def score_case(spec: Spec, answer: Answer, folder: Path) -> Scored:
    """One answer scored."""
    return score(spec, answer, json.loads(sealed_file(folder, spec).read_text(encoding="utf-8")))


def score(spec: Spec, answer: Answer, sealed: dict[str, Any]) -> Scored:
    """One answer against its truth."""
    seen = [effect for effect in sealed["effects"] if effect["identifiable"]]
    result = answer.result
    findings = result.get("effects", [])
    inside = [held for effect in seen for held in _held(effect, findings)]
    held_out = result.get("gap", {}).get("held_out", {}).get("after", {}).get("rms_over_noise")
    return Scored(
        spec,
        sealed["expected"],
        tuple(effect["name"] for effect in seen),
        tuple(name for effect in seen for name in effect["class"]),
        all(effect["identifiable"] and abs(effect["multiple"] / spec.size - 1.0) < 0.1 for effect in sealed["effects"]),
        "failed" if answer.failed else result["verdict"],
        tuple((finding["name"], *finding.get("equivalents", [])) for finding in findings),
        held_out,
        sum(inside),
        len(inside),
        answer.processor_s,
    )


def _held(effect: dict[str, Any], findings: Sequence[dict[str, Any]]) -> list[bool]:
    """Whether each size of a true effect lies within the interval given for it; nothing where it was not named or no interval is given."""
    for finding in findings:
        given = finding.get("parameters", {})
        if finding["name"] == effect["name"]:
            return [
                given[key]["ci95"][0] <= effect["values"][key] <= given[key]["ci95"][1]
                for key in effect["sizes"]
                if key in given and given[key].get("ci95") and given[key].get("identifiable", True)
            ]
    return []
