"""Pictures to films: an avi, a Photron film with its notes, or a folder of numbered pictures."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from measure.common.errors import InputError
from measure.common.output import replacing, write_text
from measure.footage.footage import Picture


@dataclass(frozen=True)
class Clock:
    """What a camera notes beside its pictures.

    Attributes
    ----------
    fps : float
        Capture rate, frames per second.
    exposure_s : float
        Exposure time, s; 0 where it is not known.
    bits : int
        Depth of a pixel.
    """

    fps: float
    exposure_s: float = 0.0
    bits: int = 8


def write_film(path: Path, pictures: Iterable[Picture], codec: str = "FFV1", clock: Clock | None = None) -> None:
    """Write a film.

    Parameters
    ----------
    path : Path
        `.avi` (8 bit, grey or blue-green-red), `.mraw` (any depth, with a clock) or a folder (any depth).
    pictures : iterable of (height, width) or (height, width, 3) arrays
    codec : str
        Of an avi: four letters that OpenCV knows; FFV1 is lossless.
    clock : Clock, optional

    Raises
    ------
    InputError
        16 bit for an avi, an unknown codec, a folder that holds something already, an .mraw without a clock.
    """
    kind = path.suffix.lower()
    if kind == ".avi":
        _write_avi(path, pictures, codec)
    elif kind == ".mraw" and clock is not None:
        _write_mraw(path, pictures, clock)
    elif kind == "":
        _write_folder(path, pictures)
    else:
        raise InputError(f"{path}: films are written as .avi, as .mraw with a capture rate, or into a folder; name one of these.")


def _write_mraw(path: Path, pictures: Iterable[Picture], clock: Clock) -> None:
    """Pixels one after the other, 8 or 16 bit, and the notes in a .cih beside them."""
    count, shape = 0, (0, 0)
    with replacing(path) as temporary, open(temporary, "wb") as file:
        for picture in pictures:
            file.write(picture.astype("<u2" if picture.dtype == np.uint16 else np.uint8).tobytes())
            count, shape = count + 1, picture.shape
    notes = {
        "Record Rate(fps)": f"{clock.fps:g}", "Shutter Speed(s)": f"{clock.exposure_s:.9f}", "Total Frame": count,
        "Image Width": shape[1], "Image Height": shape[0], "Color Bit": 8 if clock.bits == 8 else 16,
        "EffectiveBit Depth": clock.bits, "EffectiveBit Side": "Lower",
    }  # fmt: skip
    lines = ["#Camera Information Header", *(f"{name} : {value}" for name, value in notes.items())]
    write_text(path.with_suffix(".cih"), "\n".join(lines) + "\n")


def _write_avi(path: Path, pictures: Iterable[Picture], codec: str) -> None:
    with replacing(path) as temporary:
        writer = None
        for picture in pictures:
            if picture.dtype != np.uint8:
                raise InputError(f"{path}: an avi holds 8 bit, the pictures have more; write a folder instead.")
            if writer is None:
                size = (picture.shape[1], picture.shape[0])
                writer = cv2.VideoWriter(str(temporary), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*codec), 25.0, size, picture.ndim == 3)
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
