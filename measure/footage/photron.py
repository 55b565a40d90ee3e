"""Photron films: `.mraw` with the camera's notes beside it in a `.cih` or `.cihx`; memory-mapped."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from measure.common.errors import InputError, clipped
from measure.common.inputs import number_in
from measure.footage.footage import Footage, Picture, check_size
from measure.footage.packed_pixels import unpack

SUFFIXES = (".mraw", ".cih", ".cihx")
_LARGEST_NOTE = 4 * 2**20

_KEYS = {
    "width": ("Image Width", "imageDataInfo/resolution/width"),
    "height": ("Image Height", "imageDataInfo/resolution/height"),
    "frames": ("Total Frame", "frameInfo/totalFrame"),
    "fps": ("Record Rate(fps)", "recordInfo/recordRate"),
    "shutter": ("Shutter Speed(s)", "recordInfo/shutterSpeed"),
    "shutter_ns": ("Shutter Speed(ns)", "recordInfo/shutterSpeedNsec"),
    "stored_bits": ("Color Bit", "imageDataInfo/colorInfo/bit"),
    "bits": ("EffectiveBit Depth", "imageDataInfo/effectiveBit/depth"),
    "side": ("EffectiveBit Side", "imageDataInfo/effectiveBit/side"),
}
"""What is read from the notes: its name in a `.cih`, its path in a `.cihx`."""


@dataclass(frozen=True)
class PhotronFilm(Footage):
    """A Photron film.

    Attributes
    ----------
    path : Path
    stored_bits : int
        Of a pixel in the file: 8, 12 (packed) or 16.
    shift : int
        Unused low bits of it.
    """

    path: Path = Path()
    stored_bits: int = 8
    shift: int = 0

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame; the stream ends where the file does."""
        size = -(-self.width * self.height * self.stored_bits // 8)
        data = np.memmap(self.path, np.uint8, mode="r")
        for number in range(min(self.frames, len(data) // size)):
            picture = unpack(data[number * size : (number + 1) * size], self.stored_bits, self.width, self.height)
            yield number, np.right_shift(picture, self.shift, dtype=np.uint16) if self.shift else picture


def open_photron(path: Path) -> Footage:
    """Open an `.mraw`, named by itself or by its notes.

    Parameters
    ----------
    path : Path
        `.mraw`, `.cih` or `.cihx`.

    Returns
    -------
    Footage
        With the capture rate and exposure that the camera noted.

    Raises
    ------
    InputError
        Film or notes are missing, the notes lack something or are damaged, the pixels are of an unknown kind.
    """
    notes_path = _notes_beside(path) if path.suffix.lower() == ".mraw" else path
    film = next((p for p in (path.with_suffix(".mraw"), path.with_suffix(".MRAW")) if p.is_file()), None)
    if film is None:
        raise InputError(f"{path}: its film {path.with_suffix('.mraw').name} is not beside it. Copy both files from the camera.")
    notes = _read_notes(notes_path)
    width, height, frames, stored, fps = (_whole(notes, key, notes_path) for key in ("width", "height", "frames", "stored_bits", "fps"))
    check_size(notes_path, width, height)
    if stored not in (8, 12, 16) or frames < 1 or fps < 1:
        raise InputError(f"{notes_path}: {frames} frames of {stored} bit at {fps} frames/s; grey films of 8, 12 or 16 bit are read.")
    bits = min(_whole({"bits": str(stored), **notes}, "bits", notes_path), stored)
    shift = stored - bits if notes.get("side", "Lower").lower() == "higher" and stored == 16 else 0
    return PhotronFilm(
        str(film), width, height, bits, frames, float(fps), _exposure(notes),
        _remarks(film, frames * -(-width * height * stored // 8)), path=film, stored_bits=stored, shift=shift,
    )  # fmt: skip


def _notes_beside(film: Path) -> Path:
    for suffix in (".cihx", ".cih"):
        if film.with_suffix(suffix).is_file():
            return film.with_suffix(suffix)
    raise InputError(f"{film}: the camera's notes {film.stem}.cihx or {film.stem}.cih are not beside it. Copy both files from the camera.")


def _remarks(film: Path, promised: int) -> tuple[str, ...]:
    held = film.stat().st_size
    return () if held == promised else (f"holds {held} bytes where its notes promise {promised}",)


def _read_notes(path: Path) -> Mapping[str, str]:
    """The values of `_KEYS` that the notes hold, as text."""
    data = path.read_bytes()[:_LARGEST_NOTE]
    start, end = data.find(b"<cih>"), data.rfind(b"</cih>")
    if start >= 0 and end > start:
        return _from_xml(data[start : end + 6], path)
    pairs = [line.partition(":") for line in data.decode("latin-1").splitlines()]
    rows = {name.strip(): value.strip() for name, sign, value in pairs if sign and name.strip() and "#" not in name}
    if not rows:
        raise InputError(f"{path}: is not a note of the camera; no <cih> and no lines of name : value. Copy it again from the camera.")
    return {key: rows[name] for key, (name, _) in _KEYS.items() if name in rows}


def _from_xml(data: bytes, path: Path) -> Mapping[str, str]:
    if b"<!" in data:
        raise InputError(f"{path}: declares entities, which no camera writes. Copy it again from the camera.")
    try:
        tree = ElementTree.fromstring(data)
    except ElementTree.ParseError as error:
        raise InputError(f"{path}: its notes are damaged ({error}). Copy it again from the camera.") from error
    found = {key: tree.findtext(place) for key, (_, place) in _KEYS.items()}
    return {key: text.strip() for key, text in found.items() if text is not None}


def _whole(notes: Mapping[str, str], key: str, path: Path) -> int:
    text = notes.get(key)
    if text is None:
        raise InputError(f"{path}: has no value for {_KEYS[key][0]}. Copy it again from the camera.")
    try:
        return int(number_in(text))
    except ValueError:
        raise InputError(f'{path}: {_KEYS[key][0]} is "{clipped(text)}", which is not a number. Copy it again from the camera.') from None


def _exposure(notes: Mapping[str, str]) -> float | None:
    """Seconds: given in nanoseconds, as a fraction (1/50000), or as the fraction's denominator."""
    try:
        if "shutter_ns" in notes:
            return number_in(notes["shutter_ns"]) * 1e-9
        above, _, below = notes["shutter"].partition("/")
        value = number_in(above) / number_in(below or "1")
        return 1.0 / value if value > 1.0 else value or None
    except (KeyError, ValueError, ZeroDivisionError):
        return None
