"""What an answer to a case of the bench board is worth against its truth."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from board.running import Answer

from .cases import ERRORS, Spec
from .making import sealed_file

NAMES = ("named", "class", "several", "partly")
ABSTAINS = ("unknown", "partly")
WORTH = 0.7  # of the held-out excess, for a draft that is worth having
LEAST_EXCESS = 0.05  # over the noise: below it there is nothing to remove
WORSE = 1.02  # held-out gap after over before, from which names have made it worse


@dataclass(frozen=True)
class Scored:
    """An answer with the truth beside it.

    said : for each finding its name and equivalents. weights : probability of each hypothesis, as stated.
    held_out : gap over noise of the runs that took no part, without and with what was named. drafted : without and with the draft.
    inside, intervals : of the true effect's 95 % intervals, how many hold the truth. multiple : how many times the detectable size.
    """

    spec: Spec
    shown: bool
    verdict: str
    said: tuple[tuple[str, ...], ...]
    weights: Mapping[str, float]
    held_out: tuple[float, float] | None
    drafted: tuple[float, float] | None
    inside: int
    intervals: int
    processor_s: float
    multiple: float = 0.0

    @property
    def expected(self) -> str:
        """The kind of the case; an effect that its runs cannot show is nothing."""
        return self.spec.kind if self.shown else "nothing"

    @property
    def names(self) -> bool:
        """Whether something is said to be missing."""
        return self.verdict in NAMES and bool(self.said)

    @property
    def found(self) -> bool:
        """Whether what is hidden stands in a finding, as its name or among its equivalents."""
        return self.names and any(self.spec.hidden in finding for finding in self.said)

    @property
    def wrong(self) -> bool:
        """Whether a finding stands beside the truth. Part of the answer to a force that nobody knows is no name for it."""
        if self.expected == "outside":
            return self.names and self.verdict not in ABSTAINS and not self.honest
        return self.names and any(self.spec.hidden not in finding or not self.spec.hidden for finding in self.said)

    @property
    def class_correct(self) -> bool:
        """Whether what is hidden was found, and nothing beside it."""
        return self.found and not self.wrong

    @property
    def invented(self) -> bool:
        """Whether a finding holds physics only, where the model file is wrong."""
        return self.names and any(not set(finding) & set(ERRORS) for finding in self.said)

    @property
    def honest(self) -> bool:
        """Whether a force that nobody knows was left unknown, or put in a class that runs held out bear out."""
        if self.verdict in ABSTAINS:
            return True
        return self.verdict == "class" and self.held_out is not None and removed(self.held_out) >= WORTH

    @property
    def draft_worth_having(self) -> bool:
        """Whether a drafted effect removes most of the held-out excess."""
        return self.drafted is not None and removed(self.drafted) >= WORTH

    @property
    def worse(self) -> bool:
        """Whether names were given that make the gap of runs held out larger."""
        return self.names and self.held_out is not None and self.held_out[1] > WORSE * self.held_out[0]

    @property
    def right(self) -> bool:
        """Whether the answer is of the kind that is right."""
        if self.expected == "nothing":
            return self.verdict == "no-gap"
        return self.honest if self.expected == "outside" else self.class_correct

    @property
    def foremost(self) -> tuple[str, float] | None:
        """The hypothesis with the largest weight."""
        return max(self.weights.items(), key=lambda one: one[1]) if self.weights else None

    def is_true(self, hypothesis: str) -> bool:
        """Whether a hypothesis, in the words of the weights, is the truth."""
        return hypothesis == {"nothing": "no-gap", "outside": "unknown"}.get(self.expected, self.spec.hidden)


def removed(gap: tuple[float, float]) -> float:
    """Which part of the excess over the noise is gone: 1 where only noise is left, or where there was nothing to remove."""
    before, after = gap
    if before - 1.0 < LEAST_EXCESS:
        return 1.0 if after <= WORSE * before else 0.0
    return min((before - after) / (before - 1.0), 1.0)


def scored(specs: Sequence[Spec], answers: Sequence[Answer], folder: Path) -> list[Scored]:
    """All answers scored; the seals are broken here and nowhere before."""
    return [
        score(spec, answer, json.loads(sealed_file(folder, spec).read_text(encoding="utf-8")))
        for spec, answer in zip(specs, answers, strict=True)
    ]


def score(spec: Spec, answer: Answer, sealed: Mapping[str, Any]) -> Scored:
    """One answer against its truth."""
    result = answer.result
    findings = result.get("effects", [])
    inside = _held(spec.hidden, sealed["values"], findings)
    draft = result.get("drafted") or {}
    return Scored(
        spec,
        spec.kind not in ("effects", "outside") or sealed["multiple"] > 0.0,
        "failed" if answer.failed else result["verdict"],
        tuple((finding["name"], *finding.get("equivalents", [])) for finding in findings),
        result.get("weights", {}),
        _pair(result.get("gap", {}).get("held_out"), "rms_over_noise"),
        _pair(draft.get("held_out")),
        sum(inside),
        len(inside),
        answer.processor_s,
        sealed["multiple"],
    )


def _pair(gap: Mapping[str, Any] | None, key: str | None = None) -> tuple[float, float] | None:
    if gap is None:
        return None
    before, after = (gap[end] if key is None else gap[end][key] for end in ("before", "after"))
    return float(before), float(after)


def _held(name: str, values: Mapping[str, float], findings: Sequence[Mapping[str, Any]]) -> list[bool]:
    """Whether each true value lies within the interval given for it; nothing where it was not named or no interval is given."""
    given = next((finding.get("parameters", {}) for finding in findings if finding["name"] == name), {})
    shown = {key: given[key]["ci95"] for key in values if given.get(key, {}).get("ci95") and given[key].get("identifiable", True)}
    return [low <= values[key] <= high for key, (low, high) in shown.items()]
