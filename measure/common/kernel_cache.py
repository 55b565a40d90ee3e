"""Compiled kernels kept on disk, and thrown away when any source beside them has changed.

numba recompiles a kept kernel when its own file changes, not when a function that it calls has changed in another file;
after an edit or an upgrade it would go on running the old code.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path


def discard_stale(package: Path, *rooms: str) -> None:
    """Remove the kept kernels of a package's rooms unless they were made from the sources that stand there now.

    Parameters
    ----------
    package : folder of the package; its cache folder keeps the stamp.
    rooms : folders below it whose kernels call each other, "." for the package's own; by default only that.

    A folder that cannot be written keeps no kernels there, and is left alone.
    """
    folders = [package / room for room in rooms or (".",)]
    stamp = package / "__pycache__" / "kernels.sha256"
    digest = _digest(folders)
    try:
        if stamp.exists() and stamp.read_text() == digest:
            return
        stamp.parent.mkdir(exist_ok=True)
        for kept in (file for folder in folders for file in (folder / "__pycache__").glob("*.nb[ic]")):
            kept.unlink(missing_ok=True)
        stamp.write_text(digest)
    except OSError:
        return


def _digest(folders: Iterable[Path]) -> str:
    digest = hashlib.sha256()
    for source in (source for folder in folders for source in sorted(folder.glob("*.py"))):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()
