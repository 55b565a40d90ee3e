"""What both pages of a film share: one file with its own style, script and pictures, and no address of anywhere else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_HERE = Path(__file__).parent
_ENOUGH_DIGITS = 6


def rendered(template: str, scripts: Sequence[str], data: Mapping[str, Any], **words: Any) -> str:
    """A page of a template beside this module.

    Parameters
    ----------
    template : str
        Name of the template.
    scripts : sequence of str
        Names of its scripts, in the order in which they run.
    data : mapping
        What the scripts read; it stands in the page as JSON.
    words : texts, numbers and tables for the template.

    Returns
    -------
    str
        HTML that asks for nothing outside of itself; everything that comes from the film's side is escaped.
    """
    from jinja2 import Environment

    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    parts = {"style": _text("page.css"), "script": "\n".join(map(_text, scripts))}
    return environment.from_string(_text(template)).render(data=plain(data), **parts, **words)


def _text(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")


def plain(value: Any) -> Any:
    """Arrays to lists of six digits, what is not finite to null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(_short(value).tolist())
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _short(values: NDArray | np.generic) -> NDArray | np.generic:
    """Numbers rounded to six digits of the largest one; texts as they are."""
    if not np.issubdtype(values.dtype, np.floating) or not np.isfinite(values).any():
        return values
    return np.round(np.asarray(values, dtype=float), _ENOUGH_DIGITS - int(np.ceil(np.log10(max(float(np.nanmax(np.abs(values))), 1e-300)))))
