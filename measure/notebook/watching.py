"""Progress for scripts and notebooks, to be handed to what takes long."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from typing import Any


def progress_of(what: str = "") -> Callable[..., Iterator[Any]]:
    """A bar for whatever is worked through: `track(footage, project, progress_of("frames"))`, `sweep(model, progress=progress_of("runs"))`.

    Parameters
    ----------
    what : stands before the bar.

    Returns
    -------
    function
        Takes what is gone through, and its number where that is known, and gives the same with a bar. In a notebook the bar is one of
        its own where ipywidgets is installed, and one of letters in the output of the cell elsewhere.
    """

    def watched(items: Iterable[Any], total: int | None = None) -> Iterator[Any]:
        bar, where = _bar_and_place()
        return iter(bar(items, desc=what or None, total=total, file=where, leave=False))

    return watched


def _bar_and_place() -> tuple[Any, Any]:
    """The kind of bar, and where it is drawn: in a notebook standard output, which stands below the cell."""
    from importlib.util import find_spec

    if "ipykernel" not in sys.modules:
        from tqdm import tqdm

        return tqdm, sys.stderr
    if find_spec("ipywidgets") is not None:
        from tqdm.notebook import tqdm as drawn

        return drawn, sys.stdout
    from tqdm import tqdm

    return tqdm, sys.stdout
