"""Versions of the program and its libraries, and `--version`, looked up only when they are asked for."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from contextlib import suppress
from typing import Any, NoReturn


def versions_of(packages: Iterable[str]) -> dict[str, str]:
    """The versions of installed packages by their names; what is not installed is left out."""
    from importlib import metadata

    found = {}
    for name in packages:
        with suppress(metadata.PackageNotFoundError):
            found[name] = metadata.version(name)
    return found


def installed_version() -> str:
    """The version of the installed distribution, or a sentence where it is not installed."""
    return versions_of(["unspool"]).get("unspool", "unknown: not installed, used from its sources")


class ShowVersion(argparse.Action):
    """Print the command's name and version, and end."""

    def __init__(self, option_strings: Any, dest: str, **words: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, **words)

    def __call__(self, parser: argparse.ArgumentParser, *rest: object) -> NoReturn:
        """End the command with its version on standard output."""
        del rest
        print(f"{parser.prog.split()[0]} {installed_version()}")
        parser.exit()
