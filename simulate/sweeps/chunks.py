"""Responses of a sweep, piece by piece on disk: an interrupted sweep can go on, and no result needs to fit into memory."""

from __future__ import annotations

import hashlib
import inspect
import io
import json
import re
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.common.output import is_temporary, replacing, sha256, write_text
from simulate.files.model_file import document_of
from simulate.sweeps.sweep import Sweep

_NOTE = "key"
_HASH = re.compile("[0-9a-f]{64}")
_OURS = re.compile(r"key|\d{9}\.npy")


def key_of(sweep: Sweep) -> str:
    """What a piece depends on: model, factors, design with its seed, the effects' formulas, and version, as one hash."""
    formulas = [sha256(Path(inspect.getfile(type(effect)))) for effect in sweep.model.effects]
    parts = [document_of(sweep.model), [asdict(factor) for factor in sweep.factors], asdict(sweep.design), sweep.longest_s, formulas]
    return hashlib.sha256(json.dumps([*parts, metadata.version("unspool")]).encode()).hexdigest()


def remove_pieces(folder: Path) -> None:
    """Throw the pieces of a sweep away, once the result stands; nothing else is ever removed.

    Raises
    ------
    InputError
        The folder is not one of a sweep, or holds something else too.
    """
    if require_of_a_sweep(folder):
        for file in sorted(folder.iterdir(), key=lambda file: file.name == _NOTE):  # its note last: until then it is one of a sweep
            file.unlink()
        folder.rmdir()


def require_of_a_sweep(folder: Path) -> bool:
    """Whether a folder carries the note of a sweep; one that is empty or not there has nothing to lose.

    Raises
    ------
    InputError
        It holds something else, or something else too.
    """
    inside = [file for file in sorted(folder.iterdir()) if not is_temporary(file)] if folder.exists() else []
    if not inside:
        return False
    note = folder / _NOTE
    marked = note.is_file() and _HASH.fullmatch(note.read_bytes()[:100].decode("latin-1")) is not None
    foreign = [file.name for file in inside if not _OURS.fullmatch(file.name) or not file.is_file()]
    if folder.is_symlink() or not marked or foreign:
        shown = foreign[0] if foreign else inside[0].name
        raise InputError(
            f"{folder}: is not the work of a sweep alone (it holds {shown}), and is needed for one. Move it, or name another --output."
        )
    return True


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
        note, key = self.folder / _NOTE, key_of(self.sweep)
        begun = require_of_a_sweep(self.folder)
        self._remove_halves()
        if resume and begun and note.read_text(encoding="utf-8") != key:
            raise InputError(f"{self.folder}: holds pieces of another model, design or version; leave --resume out to begin anew.")
        if begun and not resume:
            remove_pieces(self.folder)
        self.folder.mkdir(exist_ok=True)
        write_text(note, key)

    def _remove_halves(self) -> None:
        """What a killed run has left of a piece or of the note."""
        for file in self.folder.iterdir() if self.folder.exists() else ():
            if is_temporary(file):
                file.unlink()

    def give_up(self) -> None:
        """Take the folder away again where no piece stands in it; else there is something to resume."""
        pieces = [file for file in self.folder.iterdir() if file.name != _NOTE] if self.folder.exists() else []
        if not pieces:
            (self.folder / _NOTE).unlink(missing_ok=True)
            with suppress(FileNotFoundError):
                self.folder.rmdir()

    def standing(self) -> list[tuple[int, int]]:
        """The pieces that are there, of this sweep or another that was begun here."""
        return [piece for piece in self.sweep.pieces() if self._path(piece[0]).is_file()]

    @property
    def missing(self) -> list[tuple[int, int]]:
        """The pieces that are not there yet."""
        return [piece for piece in self.sweep.pieces() if not self._path(piece[0]).is_file()]

    def keep(self, computed: Iterable[tuple[int, Array]]) -> Iterator[int]:
        """Write pieces as they come; their first runs, one by one."""
        for first, answers in computed:
            content = io.BytesIO()  # NumPy by itself says nothing of a disk that is full
            np.save(content, answers)
            with replacing(self._path(first)) as temporary:
                temporary.write_bytes(content.getvalue())
            yield first

    def __iter__(self) -> Iterator[Array]:
        """Responses piece by piece, in order; all must be there.

        Raises
        ------
        InputError
            A piece is damaged.
        """
        for first, _ in self.sweep.pieces():
            try:
                yield np.load(self._path(first), allow_pickle=False)
            except (ValueError, EOFError) as error:
                raise InputError(f"{self._path(first)}: is damaged; remove it, and give --resume to have it computed anew.") from error

    def _path(self, first: int) -> Path:
        return self.folder / f"{first:09d}.npy"
