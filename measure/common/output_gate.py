"""The one gate for what a command writes: all of it is checked together before any work, and appears together or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

from measure.common.errors import InputError
from measure.common.file_kinds import kind_of, kind_written
from measure.common.output import all_or_none, regular, temporary_prefix
from measure.common.running.run_lock import locked


@dataclass(frozen=True)
class Outputs:
    """All that a command writes and reads.

    files : by what they are in a sentence ("--json"); None where one is not wanted.
    folders : likewise, each with the names of the files that are written into it.
    inputs : files and folders that are read, those included that other inputs name (a campaign, a project, a mapping).
    kinds : what is written (see `file_kinds`), by the same names as in `files`, where neither these nor the ending of the file say it.
    """

    files: Mapping[str, Path | None] = field(default_factory=dict)
    folders: Mapping[str, tuple[Path | None, Collection[str]]] = field(default_factory=dict)
    inputs: Sequence[Path] = ()
    kinds: Mapping[str, str] = field(default_factory=dict)

    def require_usable(self) -> None:
        """Check everything; for a command that leaves the writing to others.

        Raises
        ------
        InputError
            All that is wrong at once: an output is an input or lies in a folder that is read, has no folder that can be written, is a
            folder where a file is meant or the other way round, is named twice, or would replace a file of another kind.
        """
        wrong = [*self._wrong_folders(), *self._wrong_files(), *self._doubled()]
        wrong = wrong or [*self._inputs_among_them(), *self._unwritable()]
        wrong = wrong or [*self._of_other_kinds()]
        if wrong:
            raise InputError("\n".join(dict.fromkeys(wrong)))

    @contextmanager
    def held(self) -> Iterator[None]:
        """Check everything, and keep other runs away while the block lasts.

        Raises
        ------
        InputError
            As `require_usable`; or another run is writing there.
        """
        self.require_usable()
        with locked([path.resolve() for _, path in (*self._all_files(), *self._all_folders())]):
            self._remove_leftovers()
            yield

    @contextmanager
    def together(self) -> Iterator[None]:
        """What is written in the block appears at its end, all of it, or nothing; folders are made for it where there are none."""
        made = [path for _, path in self._all_folders() if not path.exists()]
        try:
            for path in made:
                path.mkdir()
            with all_or_none():
                yield
        except BaseException:
            for path in reversed(made):
                with suppress(OSError):  # not empty: then somebody else has put something there
                    path.rmdir()
            raise

    def _all_folders(self) -> list[tuple[str, Path]]:
        return [(label, path) for label, (path, _) in self.folders.items() if path is not None]

    def _all_files(self) -> list[tuple[str, Path]]:
        named = [(label, path) for label, path in self.files.items() if path is not None]
        inside = [(label, path / name) for label, (path, names) in self.folders.items() if path is not None for name in names]
        return [*named, *inside]

    def _wrong_folders(self) -> Iterator[str]:
        made = {path.absolute() for _, path in self._all_folders()}
        for _, path in self._all_folders():
            try:
                if path.exists() and not path.is_dir():
                    yield f"{path}: is a file, and a folder is written. Name another folder."
                elif not path.exists() and path.absolute().parent not in made:
                    yield from _wrong_parent(path)
            except (OSError, RuntimeError) as error:
                yield f"{path}: cannot be a folder ({_why(error)}). Name another."

    def _wrong_files(self) -> Iterator[str]:
        made = {path.absolute() for _, path in self._all_folders()}
        for _, path in self._all_files():
            try:
                if not (path.absolute().parent in made and not path.parent.exists()):
                    yield from _wrong_parent(path)
                    _require_possible(path)
                real = regular(path)
                if real.exists() and not os.access(real, os.W_OK):
                    yield f"{path}: is write-protected. Name another file, or allow writing it."
                elif real.parent != path.parent.resolve():
                    yield from _wrong_parent(real)
            except InputError as error:
                yield str(error)
            except (OSError, RuntimeError) as error:
                yield f"{path}: cannot be a file ({_why(error)}). Name another."

    def _doubled(self) -> Iterator[str]:
        seen: dict[Path, str] = {}
        for label, path in (*self._all_folders(), *self._all_files()):
            with suppress(OSError, RuntimeError):
                known = seen.setdefault(path.resolve(), label)
                if known != label:
                    yield f"{path}: is what both {known} and {label} write. Give each output its own name."

    def _inputs_among_them(self) -> Iterator[str]:
        inputs = [path for path in self.inputs if path.exists()]
        folders = [path.resolve() for path in inputs if path.is_dir()]
        ids = {_identity(path): path for path in inputs if not path.is_dir()}
        for _, path in (*self._all_files(), *self._all_folders()):
            found = ids.get(_identity(path)) if path.exists() else None
            if found is not None:
                alias = "" if path == found else f", under the name {found}"
                yield f"{path}: is an input{alias}, and inputs are never written. Name another file."
            for folder in folders:
                if path.resolve().is_relative_to(folder):
                    yield f"{path}: is or lies in {folder}, a folder that is an input, and inputs are never written. Name another place."

    def _of_other_kinds(self) -> Iterator[str]:
        """A result replaces an older file of its own kind only: a name that was mistyped takes no model, measurement or film away."""
        for label, path in self._all_files():
            written, found = self.kinds.get(label) or kind_written(label, path), kind_of(path) if path.exists() else None
            if written and found and found != written:
                yield (
                    f"{path}: holds {found}, and {label} writes {written}; a result replaces only what is of its own kind. "
                    "Name another file, or move this one away."
                )

    def _unwritable(self) -> Iterator[str]:
        """Whether something can be put into each folder, by trying."""
        places = {path.resolve().parent for _, path in self._all_files()} | {path.resolve().parent for _, path in self._all_folders()}
        for folder in sorted(places):
            if not folder.exists():
                continue
            try:
                with tempfile.TemporaryFile(dir=folder):
                    pass
            except OSError as error:
                yield f"{folder}: nothing can be written there ({error.strerror}). Name a folder that is yours."

    def _remove_leftovers(self) -> None:
        """What a killed run left beside the outputs, by its name: the lock is ours, so nobody writes there now."""
        for _, path in self._all_files():
            real = path.resolve()
            with suppress(OSError):
                for left in real.parent.glob(f"{temporary_prefix(real)}*"):
                    left.unlink(missing_ok=True)


def beside(path: Path, ending: str) -> Path:
    """The file beside `path` with another ending, `drift.png` of `drift.csv`; of a path without a name something that can be refused."""
    return path.with_name(path.stem + ending) if path.name else path / ending


def _wrong_parent(path: Path) -> Iterator[str]:
    parent = path.absolute().parent
    if not parent.is_dir():
        yield (
            f"{path}: "
            + (f"{parent} is no folder." if parent.exists() else f"the folder {path.parent} does not exist.")
            + (" Make it, or name another.")
        )


def _require_possible(path: Path) -> None:
    """Raise what the system has to say against a name, such as its length, whether or not it exists yet."""
    with suppress(FileNotFoundError):
        os.lstat(path)


def _identity(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_dev, found.st_ino


def _why(error: Exception) -> str:
    return getattr(error, "strerror", None) or "its links form a circle"
