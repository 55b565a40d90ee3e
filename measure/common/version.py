"""`--version`, looked up only when it is asked for."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn


def installed_version() -> str:
    """The version of the installed distribution, or a sentence where it is not installed."""
    from importlib import metadata

    try:
        return metadata.version("unspool")
    except metadata.PackageNotFoundError:
        return "unknown: not installed, used from its sources"


class ShowVersion(argparse.Action):
    """Print the command's name and version, and end."""

    def __init__(self, option_strings: Any, dest: str, **words: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, default=argparse.SUPPRESS, **words)

    def __call__(self, parser: argparse.ArgumentParser, *rest: object) -> NoReturn:
        """End the command with its version on standard output."""
        del rest
        print(f"{parser.prog.split()[0]} {installed_version()}")
        parser.exit()
