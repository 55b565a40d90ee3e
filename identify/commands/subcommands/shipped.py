"""Files that are installed with the program: the paper's model and the demonstration's data."""

from __future__ import annotations

from pathlib import Path

_IDENTIFY = Path(__file__).resolve().parents[2]


def shipped(name: str) -> Path:
    """Where a shipped file or folder is: in the package, or, where the sources are used in place, in `datasets`.

    Parameters
    ----------
    name : below `datasets`; pyproject.toml says what is installed of it.
    """
    installed = _IDENTIFY / "shipped" / name
    return installed if installed.exists() else _IDENTIFY.parent / "datasets" / name
