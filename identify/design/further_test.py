"""A further test, as plain data: what is done differently, and how likely it tells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Condition:
    """What is done differently. changes : as in [run.model]; a loop has its frequency and amplitude instead."""

    words: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    longer: float = 1.0
    frequency_Hz: float = 0.0
    amplitude_m: float = 0.0


@dataclass(frozen=True)
class NextTest:
    """A test, of how many runs, and how likely it would split the foremost effect from each of its rivals, by name."""

    condition: Condition
    chances: Mapping[str, float]
    runs: int = 1

    @property
    def surest(self) -> float:
        """The best of its chances."""
        return max(self.chances.values())
