"""What is wrong with a channel of a record, in one word each, and what is done about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

FaultWord = Literal["saturated", "quantised", "hum", "spikes", "dwells", "drift", "lag", "filter", "sign", "unit", "swapped"]
Consequence = Literal["left out", "widened", "modelled", "refused", "named"]


@dataclass(frozen=True)
class Fault:
    """One fault of one channel.

    channel : "force", "elongation" or "time". loop : name of the file. size : in the unit of the channel, N, m or s.
    consequence : "left out", the samples do not count; "widened", the intervals are wider; "modelled", it was taken out or is part of
    the fit; "refused", nothing that is fitted to it can be trusted; "named", nothing was done.
    """

    word: FaultWord
    channel: str
    loop: str
    consequence: Consequence
    size: float
    sentence: str
