"""Everything that a command reads, what its files name included, so that no output is put in its place."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path


def files_read(given: Namespace) -> list[Path]:
    """Model, effects, mapping and measurements of `compare-model` and `explain-gap`, with the files that a list of runs names.

    Raises
    ------
    InputError
        A list of runs cannot be read.
    """
    from identify.campaign.runs import files_of

    mapping = [given.mapping] if given.mapping else []
    return [given.model, *given.effects, *mapping, *files_of(given.measured)]
