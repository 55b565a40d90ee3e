"""Results that show themselves: a short text, a table, a figure, and in a notebook all of them at once."""

from __future__ import annotations

import html
from importlib import import_module
from typing import TYPE_CHECKING, Any, ClassVar

if TYPE_CHECKING:
    from pandas import DataFrame

LONGEST = 299  # characters of a text
_ROWS = 12
_PICTURE = "measure.notebook.table_plots.picture_of"


class Shown:
    """A result that shows itself. A class says by whom, `class Loop(Shown, by="module.Showing")`; that is loaded when it is asked for.

    `Showing(result)` has `figure()`, and `text()` and `frame()` where the class has no `__repr__` or `to_frame` of its own.
    """

    _by: ClassVar[str]

    def __init_subclass__(cls, by: str = "", **words: Any) -> None:
        super().__init_subclass__(**words)
        if by:
            cls._by = by

    def _showing(self) -> Any:
        return _loaded(self._by)(self)

    def __repr__(self) -> str:
        text = self._showing().text()
        return text if len(text) <= LONGEST else f"{text[: LONGEST - 5]} ...)"

    def to_frame(self) -> DataFrame:
        """The result as a pandas table; units in `frame.attrs["units"]`."""
        return self._showing().frame()

    def plot(self) -> Any:
        """The result as a matplotlib figure."""
        return self._showing().figure()

    def _repr_html_(self) -> str:
        """What a notebook shows: the text, the first rows of the table, and a small figure."""
        frame = self.to_frame()
        table = frame.to_html(max_rows=_ROWS, float_format=lambda value: f"{value:.4g}", border=0, notebook=True)
        return f"<p><code>{html.escape(repr(self))}</code></p>{table}{_loaded(_PICTURE)(self.plot())}"


def _loaded(name: str) -> Any:
    """What draws is loaded when a figure is asked for; results themselves know nothing of figures."""
    module, _, function = name.rpartition(".")
    return getattr(import_module(module), function)
