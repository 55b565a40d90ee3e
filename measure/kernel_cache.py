"""Compiled kernels kept on disk, and thrown away when any source beside them has changed.

numba recompiles a kept kernel when its own file changes, not when a function that it calls has changed in another file;
after an edit or an upgrade it would go on running the old code.
"""

from __future__ import annotations

import hashlib
from pathlib import Path


def discard_stale(folder: Path) -> None:
    """Remove the kept kernels of a package folder unless they were made from the sources that stand there now.

    A folder that cannot be written keeps no kernels there, and is left alone.
    """
    cache = folder / "__pycache__"
    stamp = cache / "kernels.sha256"
    digest = _digest(folder)
    try:
        if stamp.exists() and stamp.read_text() == digest:
            return
        cache.mkdir(exist_ok=True)
        for kept in (*cache.glob("*.nbi"), *cache.glob("*.nbc")):
            kept.unlink(missing_ok=True)
        stamp.write_text(digest)
    except OSError:
        return


def _digest(folder: Path) -> str:
    digest = hashlib.sha256()
    for source in sorted(folder.glob("*.py")):
        digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()
