"""Pictures to films: an avi, or a folder of numbered pictures."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from .errors import InputError
from .footage import Picture
from .output import replacing


def write_film(path: Path, pictures: Iterable[Picture], codec: str = "FFV1") -> None:
    """Write 8-bit pictures as an .avi, or pictures of any depth into a folder.

    Raises
    ------
    InputError
        16 bit for an avi, an unknown codec, a folder that holds something already.
    """
    if path.suffix.lower() == ".avi":
        _write_avi(path, pictures, codec)
    elif path.suffix == "":
        _write_folder(path, pictures)
    else:
        raise InputError(f"{path}: films are written as .avi or into a folder; name one or the other.")


def _write_avi(path: Path, pictures: Iterable[Picture], codec: str) -> None:
    with replacing(path) as temporary:
        writer = None
        for picture in pictures:
            if picture.dtype != np.uint8:
                raise InputError(f"{path}: an avi holds 8 bit, the pictures have more; write a folder instead.")
            if writer is None:
                size = (picture.shape[1], picture.shape[0])
                writer = cv2.VideoWriter(str(temporary), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*codec), 25.0, size, False)
                if not writer.isOpened():
                    raise InputError(f'{path}: this OpenCV cannot write "{codec}"; take FFV1 (lossless) or MJPG.')
            writer.write(picture)
        if writer is not None:
            writer.release()


def _write_folder(path: Path, pictures: Iterable[Picture]) -> None:
    path.mkdir(parents=True, exist_ok=True)
    if any(path.iterdir()):
        raise InputError(f"{path}: holds something already; name an empty folder, so that two films are not mixed.")
    for number, picture in enumerate(pictures):
        suffix = ".png" if picture.dtype == np.uint8 else ".tif"
        cv2.imwrite(str(path / f"frame_{number:04d}{suffix}"), picture)
