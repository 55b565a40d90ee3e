"""Responses of an unfinished sweep, piece by piece on disk, so that an interrupted one can go on."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from measure.errors import InputError
from measure.output import replacing, write_text
from measure.tables import Array

from .model_file import document_of
from .sweep import Sweep, run_on


def key_of(sweep: Sweep, seed: int) -> str:
    """What a piece depends on: model, factors, design, seed and version, as one hash."""
    design = sweep.design
    parts = [document_of(sweep.model), [asdict(factor) for factor in sweep.factors], design.kind, design.runs, list(design.words), seed]
    return hashlib.sha256(json.dumps([*parts, metadata.version("unspool")]).encode()).hexdigest()


@dataclass(frozen=True)
class Chunks:
    """A folder of pieces and the sweep that they belong to."""

    folder: Path
    key: str

    def open(self, resume: bool) -> None:
        """Make the folder; keep what stands in it where the sweep is to be resumed, else begin anew.

        Raises
        ------
        InputError
            It is to be resumed, and the pieces belong to another model, design or version.
        """
        note = self.folder / "key"
        if resume and note.is_file() and note.read_text(encoding="utf-8") != self.key:
            raise InputError(f"{self.folder}: holds pieces of another model, design or version; leave --resume out to begin anew.")
        if self.folder.exists() and not (resume and note.is_file()):
            shutil.rmtree(self.folder)
        self.folder.mkdir(exist_ok=True)
        write_text(note, self.key)

    def run(self, sweep: Sweep, workers: int | None) -> Iterator[tuple[int, Array]]:
        """Like `run_on`, reading the pieces that are there and keeping those that are not."""
        known = {first: path for first, _ in sweep.pieces() if (path := self._path(first)).is_file()}
        for first, answers in run_on(sweep, workers, known):
            if first not in known:
                with replacing(self._path(first)) as temporary, open(temporary, "wb") as file:
                    np.save(file, answers)
            yield first, answers

    def remove(self) -> None:
        """Throw the pieces away, once the result stands."""
        shutil.rmtree(self.folder)

    def _path(self, first: int) -> Path:
        return self.folder / f"{first:09d}.npy"
