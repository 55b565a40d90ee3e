"""Files that are complete or absent, and the note in each of them of what made it."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any

from measure.common.errors import InputError

_REPORTED_PACKAGES = ("unspool", "numpy", "scipy", "numba", "lmfit", "opencv-python-headless", "av")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary file beside `path`; it takes the name of `path` once the block has ended well.

    Whatever happens in the block, `path` holds its old content or the whole new one, never half. A link stays a link,
    and the file behind it is replaced.

    Raises
    ------
    InputError
        The folder does not exist or cannot be written, or `path` is a folder, a device or a pipe.
    """
    path = _regular(Path(path))
    try:
        handle, name = tempfile.mkstemp(prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}). Name a folder that exists and is yours.") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        with open(temporary, "rb") as written:
            os.fsync(written.fileno())
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def _regular(path: Path) -> Path:
    """Where `path` leads, if a file can be put there; renaming onto a device would remove the device."""
    real = path.resolve()
    if real.is_dir():
        raise InputError(f"{path}: is a folder, and a file is to be written. Name a file in it.")
    open_file_of_a_process = str(path.parent.resolve()).startswith("/proc/") or (
        path.is_symlink() and str(path.readlink()).startswith("/proc/")
    )
    if open_file_of_a_process or (real.exists() and not real.is_file()):
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
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Path):
        return str(value)
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
        "versions": {"python": platform.python_version(), **_versions()},
    }
    if seed is not None:
        note["seed"] = seed
    return note


def write_provenance(path: Path, note: Mapping[str, Any]) -> Path:
    """Write the note beside a table that has no room for it: `drift.csv` gets `drift.csv.provenance.json`."""
    beside = Path(f"{path}.provenance.json")
    write_json(beside, note)
    return beside


def _versions() -> dict[str, str]:
    found = {}
    for name in _REPORTED_PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


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
