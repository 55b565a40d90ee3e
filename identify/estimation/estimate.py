"""What is said of one fitted number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Word = Literal[
    "ok", "approximate", "at-bound", "not-identifiable", "loops-disagree", "did-not-converge", "data-bad", "model-does-not-apply"
]


@dataclass(frozen=True)
class Estimate:
    """A fitted number: value, one standard deviation, 95 % interval, and whether the data determine it."""

    value: float
    stderr: float
    ci95: tuple[float, float]
    verdict: Word
