"""How figures are saved: names as they are written, and the same bytes for the same figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
"""Colours that the colour-blind tell apart (Okabe and Ito 2008), without black and without yellow, which is lost on white."""

_NO_TIME = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def save_figure(figure: Any, target: Path | IO[bytes], kind: str, dpi: int = 110) -> None:
    """Write a matplotlib figure.

    Parameters
    ----------
    target : file, or something that takes bytes.
    kind : png, svg or pdf, which holds no time of its making.
    """
    import matplotlib

    _plain(figure)
    with matplotlib.rc_context({"svg.hashsalt": "unspool"}):
        figure.savefig(target, format=kind, dpi=dpi, metadata=_NO_TIME[kind])


def save_pages(figures: Sequence[Any], target: Path) -> None:
    """Write matplotlib figures as the pages of one pdf, which holds no time of its making."""
    from matplotlib.backends.backend_pdf import PdfPages

    with PdfPages(target, metadata=_NO_TIME["pdf"]) as pages:
        for figure in figures:
            _plain(figure)
            pages.savefig(figure, dpi=200)


def _plain(figure: Any) -> None:
    """No formulas: a file or a model may have a $ in its name."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if "$" in text.get_text():
            text.set_parse_math(False)
