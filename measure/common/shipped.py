"""Files that are installed with the packages: the template of a model, the demonstration's data."""

from __future__ import annotations

from pathlib import Path

_ROOT = Path(__file__).resolve().parents[2]


def shipped(package: str, name: str) -> Path:
    """Where a shipped file or folder is: in its package, or, where the sources are used in place, in `datasets`.

    Parameters
    ----------
    package, name : `simulate` and `prototype.toml`, `identify` and `demo`; pyproject.toml says what goes where.
    """
    installed = _ROOT / package / "shipped" / name
    return installed if installed.exists() else _ROOT / "datasets" / name
