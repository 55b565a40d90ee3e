"""Readers of other people's formats that are installed on request."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from measure.common.errors import InputError


def required(module: str, path: Path, what: str, extra: str, otherwise: str) -> Any:
    """The library that reads a file.

    Parameters
    ----------
    what : the kind of file, for the sentence. extra : of this project, that brings the library. otherwise : what to do without it.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"{path}: is {what}, and {module}, which reads it, is not installed. "
            f'Install it with pip install "unspool[{extra}]", or {otherwise}.'
        ) from error
