"""Open a film: what it is shows in its first bytes, not in its name.

A new format is a module with a function that opens it and a class derived from `Footage`, and one row in `_FORMATS`.
"""

from __future__ import annotations

import stat
from collections.abc import Callable
from pathlib import Path

from measure.common.errors import InputError
from measure.common.inputs import existing_file
from measure.footage import container, phantom, photron, picture_file, tiff_directory, tiff_stack, video
from measure.footage.footage import Footage
from measure.footage.image_folder import open_folder

_FORMATS: tuple[tuple[Callable[[bytes], bool], Callable[[Path], Footage]], ...] = (
    (phantom.is_cine, phantom.open_cine),
    (tiff_directory.is_tiff, tiff_stack.open_stack),
    (container.is_container, video.open_video),
)
"""For each format: whether the first bytes of a file are its own, and what opens it."""

_KNOWN = (
    "avi, mp4, mov, mkv, wmv, mpg, ts, gif, y4m, h264, hevc, Phantom cine, Photron mraw, TIFF with several pictures, "
    "and folders of numbered TIFF, PNG, BMP or JPEG pictures"
)


def open_footage(path: Path | str) -> Footage:
    """Open a film file or a folder of numbered pictures.

    Photron's `.mraw` has no first bytes of its own and goes by its name.

    Parameters
    ----------
    path : Path or str
        A local file or folder.

    Returns
    -------
    Footage
        Nothing but the first picture has been decoded.

    Raises
    ------
    InputError
        Nothing is there, it is not a regular local file, or not a film.

    Examples
    --------
    >>> film = open_footage("deployment.avi")  # doctest: +SKIP
    >>> film.frames, film.width, film.height  # doctest: +SKIP
    (151, 304, 1024)
    """
    path = Path(path)
    if path.is_dir():
        return open_folder(path)
    head = _first_bytes(path)
    if path.suffix.lower() in photron.SUFFIXES:
        return photron.open_photron(path)
    for is_it, opened in _FORMATS:
        if is_it(head):
            return opened(path)
    if picture_file.picture_kind(head):
        raise InputError(f"{path}: is a single picture; a film is a file of frames or a folder of numbered pictures. Name its folder.")
    raise InputError(f"{path}: is not a film; its first bytes are {head[:8]!r}. Known are {_KNOWN}.")


def _first_bytes(path: Path) -> bytes:
    if path.exists() and not stat.S_ISREG(path.stat().st_mode):
        raise InputError(f"{path}: is not a regular file. Copy the film to the disk and name the copy.")
    existing_file(path, what="a film")
    with open(path, "rb") as file:
        head = file.read(container.HEAD_BYTES)
    if not head:
        raise InputError(f"{path}: is empty. Copy the film again from the camera.")
    return head
