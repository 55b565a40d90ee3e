"""What is said of one fitted number."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Word = Literal["ok", "at-bound", "not-identifiable", "did-not-converge", "data-bad", "model-does-not-apply"]


@dataclass(frozen=True)
class Estimate:
    """A fitted number: value, one standard deviation, 95 % interval, and whether the data determine it."""

    value: float
    stderr: float
    ci95: tuple[float, float]
    verdict: Word
