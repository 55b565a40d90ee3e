"""What every page begins with: the verdict, a sentence that can be quoted, a few figures, what to do next, and what it is made from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

Tone = Literal["good", "doubt", "bad"]


@dataclass(frozen=True)
class Number:
    """A large figure: what it is, its value as text, and a remark below it. look : colour, as of a curve."""

    label: str
    value: str
    remark: str = ""
    look: str = ""


@dataclass(frozen=True)
class Summary:
    """The first screen.

    word : the verdict. tone : its colour. sentence : the finding, to be quoted. further : what else one has to know. numbers : in the order
    in which they are read. next_steps : what to do now. facts : rig, data, date and versions, by their names.
    """

    word: str
    tone: Tone
    sentence: str
    further: Sequence[str] = ()
    numbers: Sequence[Number] = ()
    next_steps: Sequence[str] = ()
    facts: Mapping[str, str] = field(default_factory=dict)
