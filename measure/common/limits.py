"""A limit to the memory that a decoder may take, so that a hostile file ends in a sentence and not in a dead machine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from measure.common.errors import InputError

DATASET_ENDINGS = (".h5", ".nc")
"""Of files that hold a whole data set: HDF5 and netCDF."""

DECODER_BYTES = 3 * 2**30
"""What decoding may take on top of what the process has: the largest picture taken is 64 megapixels, a few copies of it fit."""


@contextmanager
def limited(path: Path | str, most: int | None = None) -> Iterator[None]:
    """Within the block the process cannot grow by more than `most` bytes; where the system knows no such limit there is none.

    Raises
    ------
    InputError
        The block asked for more.
    """
    import cv2

    before = _restrict(DECODER_BYTES if most is None else most)
    try:
        yield
    except (MemoryError, cv2.error) as error:
        if isinstance(error, cv2.error) and error.code != cv2.Error.StsNoMem:
            raise InputError(f"{path}: cannot be decoded ({error.err or error}); it is damaged. Copy it again from the camera.") from None
        raise InputError(f"{path}: decoding it takes more than {(most or DECODER_BYTES) / 2**30:.1f} GB. Crop or scale the film.") from None
    finally:
        _release(before)


def _restrict(more: int) -> tuple[int, int] | None:
    """Set the soft limit of the address space to the present size and `more`; returns the old limits."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        return None
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = pages * resource.getpagesize() + more
    if soft != resource.RLIM_INFINITY:
        wanted = min(wanted, soft)
    resource.setrlimit(resource.RLIMIT_AS, (wanted, hard))
    return soft, hard


def _release(before: tuple[int, int] | None) -> None:
    if before is not None:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, before)
