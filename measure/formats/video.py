"""Films in a container (avi, mp4, mov, mkv), decoded by OpenCV's FFmpeg: grey values only, forward only."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import cv2
import numpy as np

from ..errors import InputError
from ..footage import Footage, Picture, check_size
from ..memory import limited

_LOCAL_ONLY = "protocol_whitelist;file"


def is_container(head: bytes) -> bool:
    """Whether a file that begins with these bytes is an avi, mp4, mov or mkv."""
    riff = head[:4] == b"RIFF" and head[8:12] == b"AVI "
    return riff or head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide") or head[:4] == b"\x1aE\xdf\xa3"


@dataclass(frozen=True)
class VideoFile(Footage):
    """A film in a container. Its nominal rate is the player's, not the camera's, and is not used."""

    path: Path = Path()

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame, until the file ends or cannot be decoded; the next one is decoded while the last one is used."""
        film = _capture(self.path)
        try:
            with ThreadPoolExecutor(1) as decoder:
                coming = decoder.submit(self._decoded, film)
                for number in count():
                    picture = coming.result()
                    if picture is None:
                        return
                    coming = decoder.submit(self._decoded, film)
                    yield number, picture
        finally:
            film.release()

    def _decoded(self, film: cv2.VideoCapture) -> Picture | None:
        """The next picture; None at the end."""
        with limited(self.path):
            read, picture = film.read()
        return _luma(picture, self.width, self.height) if read else None


def open_video(path: Path) -> Footage:
    """Open a film in a container and decode one frame of it.

    Raises
    ------
    InputError
        It cannot be opened, or holds no frame that can be decoded.
    """
    film = _capture(path)
    try:
        width, height = int(film.get(cv2.CAP_PROP_FRAME_WIDTH)), int(film.get(cv2.CAP_PROP_FRAME_HEIGHT))
        promised = film.get(cv2.CAP_PROP_FRAME_COUNT)
        if film.isOpened():
            check_size(path, width, height)
        with limited(path):
            read, first = film.read() if film.isOpened() else (False, None)
    finally:
        film.release()
    if not read or first is None:
        raise InputError(
            f"{path}: begins like a film, but no frame of it can be decoded; it is cut or damaged. Copy it again from the camera."
        )
    return VideoFile(str(path), width, height, 8 * first.dtype.itemsize, max(int(promised), 1), path=path)


def _capture(path: Path) -> cv2.VideoCapture:
    """A decoder that reads local files only, hands out grey values, and leaves standard error to us."""
    os.environ["OPENCV_FFMPEG_CAPTURE_OPTIONS"] = _LOCAL_ONLY
    os.environ["OPENCV_FFMPEG_LOGLEVEL"] = "-8"
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    with limited(path):
        film = cv2.VideoCapture(str(path.resolve()), cv2.CAP_FFMPEG, [cv2.CAP_PROP_CONVERT_RGB, 0])
    film.set(cv2.CAP_PROP_CONVERT_RGB, 0)
    return film


def _luma(picture: np.ndarray, width: int, height: int) -> Picture:
    """The grey values of what the decoder hands out: the luma plane, or a colour picture made grey."""
    if picture.ndim == 3 and picture.shape[2] == 3:
        return cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)  # type: ignore[return-value]
    if picture.ndim == 3:
        picture = picture[:, :, 0]
    return picture[:height, :width]
