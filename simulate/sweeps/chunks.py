"""Responses of a sweep, piece by piece on disk: an interrupted sweep can go on, and no result needs to fit into memory."""

from __future__ import annotations

import hashlib
import inspect
import json
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.common.output import replacing, sha256, write_text
from simulate.files.model_file import document_of
from simulate.sweeps.sweep import Sweep


def key_of(sweep: Sweep) -> str:
    """What a piece depends on: model, factors, design with its seed, the effects' formulas, and version, as one hash."""
    formulas = [sha256(Path(inspect.getfile(type(effect)))) for effect in sweep.model.effects]
    parts = [document_of(sweep.model), [asdict(factor) for factor in sweep.factors], asdict(sweep.design), formulas]
    return hashlib.sha256(json.dumps([*parts, metadata.version("unspool")]).encode()).hexdigest()


@dataclass(frozen=True)
class Chunks:
    """A folder of pieces and the sweep that they belong to; iterated over, the responses of one piece after the other."""

    folder: Path
    sweep: Sweep

    def open(self, resume: bool) -> None:
        """Make the folder; keep what stands in it where the sweep is to be resumed, else begin anew.

        Raises
        ------
        InputError
            It is to be resumed, and the pieces belong to another model, design or version.
        """
        note, key = self.folder / "key", key_of(self.sweep)
        if resume and note.is_file() and note.read_text(encoding="utf-8") != key:
            raise InputError(f"{self.folder}: holds pieces of another model, design or version; leave --resume out to begin anew.")
        if self.folder.exists() and not (resume and note.is_file()):
            shutil.rmtree(self.folder)
        self.folder.mkdir(exist_ok=True)
        write_text(note, key)

    @property
    def missing(self) -> list[tuple[int, int]]:
        """The pieces that are not there yet."""
        return [piece for piece in self.sweep.pieces() if not self._path(piece[0]).is_file()]

    def keep(self, computed: Iterable[tuple[int, Array]]) -> Iterator[int]:
        """Write pieces as they come; their first runs, one by one."""
        for first, answers in computed:
            with replacing(self._path(first)) as temporary, open(temporary, "wb") as file:
                np.save(file, answers)
            yield first

    def __iter__(self) -> Iterator[Array]:
        """Responses piece by piece, in order; all must be there."""
        for first, _ in self.sweep.pieces():
            yield np.load(self._path(first), allow_pickle=False)

    def remove(self) -> None:
        """Throw the pieces away, once the result stands."""
        shutil.rmtree(self.folder)

    def _path(self, first: int) -> Path:
        return self.folder / f"{first:09d}.npy"
