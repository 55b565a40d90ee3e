"""Two runs that write to one place are kept apart: the second one is refused and says so."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from measure.common.errors import InputError

try:
    import fcntl as locks
except ImportError:  # no such locks on this system; then two runs are not kept apart
    locks: Any = None


@contextmanager
def locked(places: Iterable[Path]) -> Iterator[None]:
    """Within the block no other run on this machine writes to these files or folders.

    The locks stand in the folder for temporary files, under a name that is made of the place's own; the system drops them when a
    process ends, however it ends.

    Raises
    ------
    InputError
        Another run has one of them.
    """
    with ExitStack() as held:
        for place in sorted(set(places)):
            held.enter_context(_lock(place))
        yield


@contextmanager
def _lock(place: Path) -> Iterator[None]:
    file = _file_for(place)
    if file is None:
        yield
        return
    handle = _opened(file, place)
    try:
        yield
    finally:
        file.unlink(missing_ok=True)
        os.close(handle)


def _file_for(place: Path) -> Path | None:
    """The lock's file, in a folder that is this user's alone; None where there cannot be one."""
    if locks is None:
        return None
    try:
        folder = Path(tempfile.gettempdir()) / f"unspool-{os.getuid()}"
        folder.mkdir(mode=0o700, exist_ok=True)
        mine = folder.is_dir() and not folder.is_symlink() and folder.stat().st_uid == os.getuid()
    except OSError:
        return None
    return folder / f"{hashlib.sha256(os.fsencode(place)).hexdigest()[:32]}.lock" if mine else None


def _opened(file: Path, place: Path) -> int:
    """The lock, taken; whoever had the file before may have removed it in between, then it is taken anew."""
    while True:
        handle = os.open(file, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
        try:
            locks.flock(handle, locks.LOCK_EX | locks.LOCK_NB)
            if file.exists() and os.path.samestat(os.fstat(handle), os.stat(file)):
                return handle
        except BlockingIOError:
            os.close(handle)
            raise InputError(f"{place}: another run is writing it. Wait until that has ended, or name another output.") from None
        os.close(handle)
