"""What a design is judged by: a number made of the responses of many deployments of one candidate.

    nominal:RESPONSE    as the model stands             mean:RESPONSE      over the draws
    spread:RESPONSE     one standard deviation          robust:RESPONSE    mean plus two standard deviations
    worst:RESPONSE      of draws and corners            p95:RESPONSE       below it are 95 % of the draws, any p50 to p99.9
    failed_percent      draws beyond the failure angle  cost               of the tolerances that are free

Signed angles count by their size, but for their spread. A run that diverged, or has no such response, counts as infinite.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.model import responses
from simulate.model.responses import RESPONSES, response_named

_KINDS = ("nominal", "mean", "spread", "robust", "worst")
_QUANTILE = re.compile(r"p(?P<percent>\d{2}(\.\d+)?)")
_LIMIT = re.compile(r"(?P<measure>[^<>]+)(?P<side>[<>])(?P<limit>[-+0-9.eE]+)")
FAILED, COST = "failed_percent", "cost"


@dataclass(frozen=True)
class Scenarios:
    """Coded levels of what varies: the first row the middle, then `draws` rows drawn, then the corners of what has two ends."""

    levels: Array
    draws: int

    @property
    def drawn(self) -> slice:
        """Rows that are drawn; the middle where nothing varies."""
        return slice(1, 1 + self.draws) if self.draws else slice(0, 1)


@dataclass(frozen=True)
class Measure:
    """A number to be made small or to be kept to a side of a limit."""

    kind: str
    response: str = ""

    @classmethod
    def of(cls, text: str) -> Measure:
        """From `worst:theta_z_deg`, `p95:stop_force_N`, `failed_percent` or `cost`.

        Raises
        ------
        InputError
            No such measure or response.
        """
        kind, _, response = text.strip().partition(":")
        if kind in (FAILED, COST) and not response:
            return cls(kind)
        if kind not in _KINDS and not _QUANTILE.fullmatch(kind):
            raise InputError(
                f'"{text}" is no measure; give {FAILED}, {COST}, or one of {", ".join(_KINDS)}, p95 and a response, as worst:theta_z_deg.'
            )
        response_named(response)
        return cls(kind, response)

    def __str__(self) -> str:
        return f"{self.kind}:{self.response}" if self.response else self.kind

    def value(self, answers: Array, scenarios: Scenarios, failure_deg: float) -> float:
        """Of the responses (rows, responses.COUNT) of one candidate; `cost` is not made of them."""
        if self.kind == FAILED:
            turned = _sizes(answers[scenarios.drawn], "theta_z_deg")
            return 100.0 * float(np.mean(~(turned <= failure_deg)))
        sizes = _sizes(answers, self.response)
        drawn = sizes[scenarios.drawn]
        if self.kind == "nominal":
            return float(sizes[0])
        if self.kind == "worst":
            return float(np.max(sizes))
        if not np.all(np.isfinite(drawn)):
            return np.inf
        if self.kind == "mean":
            return float(np.mean(drawn))
        if self.kind == "robust":
            return float(np.mean(drawn) + 2.0 * np.std(drawn))
        if self.kind == "spread":
            response = RESPONSES[self.response]
            return float(np.std(answers[scenarios.drawn, response.place] * response.scale))
        return float(np.quantile(drawn, float(self.kind[1:]) / 100.0))


@dataclass(frozen=True)
class Limit:
    """A measure and the side of a number that it must be on."""

    measure: Measure
    below: bool
    limit: float

    @classmethod
    def of(cls, text: str) -> Limit:
        """From `worst:stop_force_N<60` or `nominal:lateral_mm>1`.

        Raises
        ------
        InputError
            It cannot be read.
        """
        found = _LIMIT.fullmatch(text.strip())
        try:
            if found is not None:
                return cls(Measure.of(found["measure"]), found["side"] == "<", float(found["limit"]))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
        raise InputError(f'--subject-to "{text}": is written MEASURE<NUMBER or MEASURE>NUMBER, such as "worst:stop_force_N<60".')

    def __str__(self) -> str:
        return f"{self.measure} {'<' if self.below else '>'} {self.limit:g}"

    def kept(self, value: float) -> bool:
        """Whether a value is on the right side."""
        return value <= self.limit if self.below else value >= self.limit

    def excess(self, value: float) -> float:
        """By how much a value is on the wrong side, as a share of the limit; below zero where it is kept."""
        return (value - self.limit if self.below else self.limit - value) / (abs(self.limit) or 1.0)


def _sizes(answers: Array, name: str) -> Array:
    response = RESPONSES[name]
    sizes = np.abs(answers[:, response.place]) * response.scale
    return np.where(np.isnan(sizes) | ~np.isnan(answers[:, responses.DIVERGED]), np.inf, sizes)
