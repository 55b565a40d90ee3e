"""Files that are complete or absent, and the note in each of them of what made it."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import re
import shutil
import signal
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from measure.common.errors import InputError
from measure.common.version import versions_of

_KEY = ".unspool-"
_TEMPORARY = re.compile(r"\.unspool-[0-9a-f]{16}-")
_LONGEST_SUFFIX = 12
_appeared = 0  # blocks of `all_or_none` that have ended well and had something to write
_INTERRUPTS = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGALRM") if hasattr(signal, name)]
_together: list[list[tuple[Path, Path]]] = []  # by block of `all_or_none`: temporary files that wait for their names

_REPORTED_PACKAGES = ("unspool", "numpy", "scipy", "numba", "lmfit", "opencv-python-headless", "av")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary file beside `path`; it takes the name of `path` once the block has ended well.

    Whatever happens in the block, `path` holds its old content or the whole new one, never half. A link stays a link,
    and the file behind it is replaced. Within `all_or_none` it takes its name together with the others.

    Raises
    ------
    InputError
        The folder does not exist or cannot be written, or `path` is a folder, a device or a pipe.
    """
    path = regular(Path(path))
    temporary = _temporary_beside(path)
    try:
        yield temporary
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        if _together:
            _together[-1].append((temporary, path))
        else:
            os.replace(temporary, path)
    except BaseException as error:
        temporary.unlink(missing_ok=True)
        if isinstance(error, OSError) and error.filename in (None, str(temporary)):
            raise InputError(f"{path}: cannot be written ({error.strerror or error}).") from error
        raise


def _temporary_beside(path: Path) -> Path:
    try:
        handle, name = tempfile.mkstemp(prefix=temporary_prefix(path), suffix=path.suffix[:_LONGEST_SUFFIX], dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}). Name a folder that exists and is yours.") from error
    os.close(handle)
    return Path(name)


def temporary_prefix(path: Path) -> str:
    """How the names of the temporary files begin that stand beside `path` while it is written: our key, and nobody else's files."""
    return f"{_KEY}{hashlib.sha256(os.fsencode(path.name)).hexdigest()[:16]}-"


def is_temporary(path: Path) -> bool:
    """Whether a file is what a killed run has left of one that it was writing."""
    return _TEMPORARY.match(path.name) is not None and path.is_file() and not path.is_symlink()


@contextmanager
def all_or_none() -> Iterator[None]:
    """Whatever is written through `replacing` in the block appears when the block has ended well, all of it, or none of it."""
    _together.append([])
    try:
        yield
    except BaseException:
        for temporary, _ in _together.pop():
            temporary.unlink(missing_ok=True)
        raise
    _move_all(_together.pop())


def _move_all(staged: list[tuple[Path, Path]]) -> None:
    """Give all files their names; where one cannot have it, those before it get their old content back."""
    global _appeared
    moved: list[tuple[Path, Path | None]] = []
    olds: list[Path] = []
    with _undisturbed():
        try:
            for temporary, path in staged:
                old = _second_name(path) if path.exists() else None
                olds += [] if old is None else [old]
                os.replace(temporary, path)
                moved.append((path, old))
            _appeared += bool(staged)
        except OSError as error:
            for path, old in reversed(moved):
                _put_back(path, old)
            raise InputError(f"{error.filename2 or error.filename}: cannot be written ({error.strerror}); nothing was.") from error
        finally:
            for left in [*olds, *(temporary for temporary, _ in staged)]:
                left.unlink(missing_ok=True)


def appearances() -> int:
    """How often results have appeared together in this process: what is stopped after that has left them, whole."""
    return _appeared


def _second_name(path: Path) -> Path:
    """A second name for the old content; a copy where the disk knows no second names."""
    second = path.with_name(f"{temporary_prefix(path)}old-{os.getpid()}")
    second.unlink(missing_ok=True)
    try:
        os.link(path, second)
    except OSError:
        shutil.copy2(path, second)
    return second


def _put_back(path: Path, old: Path | None) -> None:
    if old is None:
        path.unlink(missing_ok=True)
    else:
        os.replace(old, path)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Ctrl-C and the like wait until the block has ended; some milliseconds.

    A signal goes to any thread of a process that takes it, and its handler to the main thread: so the handlers wait, not the thread.
    """
    if threading.current_thread() is not threading.main_thread():  # no handler runs here
        yield
        return
    asked: list[int] = []
    before = {number: handler for number in _INTERRUPTS if (handler := signal.getsignal(number)) is not None}
    for number in before:
        signal.signal(number, lambda number, frame: asked.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(asked):
            signal.raise_signal(number)


def regular(path: Path) -> Path:
    """Where `path` leads, if a file can be put there; renaming onto a device would remove the device.

    Raises
    ------
    InputError
        It is a folder, a device, a pipe, or a link that leads back to itself.
    """
    try:
        real = path.resolve()
        is_folder, is_other = real.is_dir(), real.exists() and not real.is_file()
    except (OSError, RuntimeError) as error:
        raise InputError(f"{path}: cannot be written ({getattr(error, 'strerror', None) or 'its links form a circle'}).") from None
    if is_folder:
        raise InputError(f"{path}: is a folder, and a file is to be written. Name a file in it.")
    open_file_of_a_process = str(path.parent.resolve()).startswith("/proc/") or (
        path.is_symlink() and str(path.readlink()).startswith("/proc/")
    )
    if open_file_of_a_process or is_other:
        raise InputError(f"{path}: is a device or a pipe, and cannot be replaced as a whole. Name a file.")
    return real


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_text(path: Path, text: str) -> None:
    """Write a whole text file, or nothing."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def json_text(result: Mapping[str, Any]) -> str:
    """JSON as every command writes it: numbers that are not finite become null, arrays become lists.

    JSON has no NaN; a value that could not be computed is `null`, and the key beside it says why.
    """
    return json.dumps(_plain(result), indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {_plain(str(key)): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path | str):
        return str(value).encode("utf-8", "backslashreplace").decode("utf-8")  # a name need not be UTF-8
    return value


def write_json(path: Path, result: Mapping[str, Any]) -> None:
    """Write `result` as JSON, whole or not at all."""
    write_text(path, json_text(result))


def provenance(inputs: Iterable[Path] = (), seed: int | None = None, command: Iterable[str] | None = None) -> dict[str, Any]:
    """What made a result: command line, inputs with their SHA-256, versions and seed.

    It holds no time and no machine, so the same input and seed give the same bytes.

    Parameters
    ----------
    inputs : files that went in; of a folder, every file in it.
    seed : the seed of whatever chance there was.
    command : the words of the command, by default those of this process.
    """
    words = list(sys.argv if command is None else command)
    note: dict[str, Any] = {
        "command": " ".join([Path(words[0]).name, *words[1:]]) if words else "",
        "inputs": [{"file": str(path), "sha256": sha256(path)} for path in inputs],
        "versions": {"python": platform.python_version(), **versions_of(_REPORTED_PACKAGES)},
    }
    if seed is not None:
        note["seed"] = seed
    return note


def write_provenance(path: Path, note: Mapping[str, Any]) -> Path:
    """Write the note beside a table that has no room for it: `drift.csv` gets `drift.csv.provenance.json`."""
    beside = provenance_beside(path)
    write_json(beside, note)
    return beside


def provenance_beside(path: Path) -> Path:
    """Where the note on a table stands."""
    return Path(f"{path}.provenance.json")


def sha256(path: Path) -> str:
    """SHA-256 of a file, or of a folder's files in the order of their names (names included)."""
    digest = hashlib.sha256()
    path = Path(path)
    if path.is_dir():
        for inner in sorted(p for p in path.rglob("*") if p.is_file()):
            digest.update(inner.relative_to(path).as_posix().encode())
            digest.update(bytes.fromhex(sha256(inner)))
        return digest.hexdigest()
    with open(path, "rb") as file:
        for block in iter(lambda: file.read(1 << 20), b""):
            digest.update(block)
    return digest.hexdigest()
