"""A page made of sections: words, figures, bars and tables, behind the summary that every page begins with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from measure.pages.csv_address import csv_address
from measure.pages.figure import Figure
from measure.pages.page import number, page_html
from measure.pages.summary import Summary

_TEMPLATE = Path(__file__).with_name("sections.html.j2")


@dataclass(frozen=True)
class Table:
    """A table. rows : cells, the first of which names its row; numbers stand on the right. name : of its CSV, without an ending."""

    name: str
    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[Any]]

    @property
    def csv(self) -> str:
        """The table as an address that holds it."""
        return csv_address({head: [row[i] for row in self.rows] for i, head in enumerate(self.heads)})


@dataclass(frozen=True)
class Bars:
    """Sizes as bars, the longest as wide as there is room. sizes : by what they are sizes of. what : they are, with the unit."""

    name: str
    caption: str
    what: str
    sizes: Mapping[str, float]
    of: str = ""

    @property
    def heads(self) -> list[str]:
        """Heads of the two columns."""
        return [self.of or "name", self.what]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """As the template draws them; what is below nought has the other colour."""
        most = max((abs(size) for size in self.sizes.values()), default=0.0) or 1.0
        return [
            {"name": name, "text": number(size), "share": abs(size) / most, "look": "effect" if size >= 0.0 else "given"}
            for name, size in self.sizes.items()
        ]

    @property
    def csv(self) -> str:
        """The sizes as an address that holds them."""
        return csv_address({self.heads[0]: list(self.sizes), self.what: list(self.sizes.values())})


@dataclass(frozen=True)
class Section:
    """A part of a page. folded : whether it is opened by hand, and left out of what is printed."""

    head: str
    paragraphs: Sequence[str] = ()
    figures: Sequence[Figure] = ()
    tables: Sequence[Table] = ()
    bars: Sequence[Bars] = ()
    listed: Sequence[str] = ()
    formula: str = ""
    folded: bool = False


def sections_html(title: str, kicker: str, summary: Summary, sections: Sequence[Section], note: Mapping[str, Any] | None = None) -> str:
    """The whole page.

    Parameters
    ----------
    kicker : the line above the title, such as the command and the rig. note : provenance.
    """
    return page_html(_TEMPLATE, title, kicker=kicker, summary=summary, sections=sections, note=note)
