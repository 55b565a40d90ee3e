"""How figures are saved: names as they are written, and the same bytes for the same figure."""

from __future__ import annotations

from pathlib import Path
from typing import IO, Any

_NO_TIME = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}


def save_figure(figure: Any, target: Path | IO[bytes], kind: str, dpi: int = 110) -> None:
    """Write a matplotlib figure.

    Parameters
    ----------
    target : file, or something that takes bytes.
    kind : png, svg or pdf, which holds no time of its making.
    """
    import matplotlib
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        if "$" in text.get_text():
            text.set_parse_math(False)  # a file or a model may be called so; formulas are not drawn here
    with matplotlib.rc_context({"svg.hashsalt": "unspool"}):
        figure.savefig(target, format=kind, dpi=dpi, metadata=_NO_TIME[kind])
