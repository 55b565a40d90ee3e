"""Phantom films written by hand, byte by byte, as the camera's format has them."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.footage import check_size
from measure.footage.formats import open_footage
from measure.footage.phantom import is_cine

FRAMES, ROWS, COLUMNS = 3, 18, 24
SETUP = 1024


def packed(pixels, bits):
    if bits in (8, 16):
        return pixels.astype("<u2" if bits == 16 else np.uint8).tobytes()
    text = "".join(f"{pixel:0{bits}b}" for pixel in pixels.ravel())
    return bytes(int(text[i : i + 8], 2) for i in range(0, len(text), 8))


def cine(stack, bits, *, levels=0, notes=8, note_length=None, rate=500, shutter_us=250, mark=b"ST", compression=0, rows=None, spare=0):
    """The bytes of a film; packed pictures lie the right way up, the others lowest row first where their height is positive."""
    packing = {10: 256, 12: 1024}.get(bits, 0)
    height = ROWS if rows is None else rows
    setup = bytearray(SETUP)
    setup[140:142] = mark
    struct.pack_into("<II", setup, 768, rate, shutter_us)
    at_bitmap, at_setup = 44, 84
    at_offsets = at_setup + SETUP
    begin = at_offsets + 8 * len(stack)
    pictures = []
    for picture in stack:
        body = packed(picture[::-1] if height > 0 and packing == 0 else picture, bits)
        length = notes if note_length is None else note_length
        note = struct.pack("<I", length) + bytes(notes - 8) + struct.pack("<I", len(body)) if notes else bytes(spare)
        pictures.append(note + body)
    offsets = [begin + sum(map(len, pictures[:k])) for k in range(len(stack))]
    count = len(stack)
    header = struct.pack("<2sHHHiIiIIIIQ", b"CI", 44, compression, 1, 0, count, 0, count, at_bitmap, at_setup, at_offsets, 0)
    bitmap = struct.pack("<IiiHHIIiiII", 40, COLUMNS, height, 1, 8 if bits == 8 else 16, packing, 0, 0, 0, 0, levels)
    return header + bitmap + bytes(setup) + struct.pack(f"<{count}Q", *offsets) + b"".join(pictures)


def stack_of(bits, frames=FRAMES):
    return np.random.default_rng(bits).integers(0, 2**bits, (frames, ROWS, COLUMNS))


def opened(tmp_path, data):
    (tmp_path / "film.cine").write_bytes(data)
    return open_footage(tmp_path / "film.cine")


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
@pytest.mark.parametrize("notes", [0, 8, 40])
def test_every_depth_is_read_bit_for_bit_with_the_cameras_clock(tmp_path, bits, notes):
    film = opened(tmp_path, cine(stack_of(bits), bits, notes=notes))
    assert (film.width, film.height, film.bits, film.frames) == (COLUMNS, ROWS, bits, FRAMES)
    assert (film.fps, film.exposure_s) == (500.0, pytest.approx(250e-6))
    numbers, pictures = zip(*film.pictures(), strict=True)
    assert numbers == (0, 1, 2)
    assert np.array_equal(pictures, stack_of(bits))


def test_a_film_of_negative_height_has_its_highest_row_first(tmp_path):
    film = opened(tmp_path, cine(stack_of(8), 8, rows=-ROWS))
    assert np.array_equal([picture for _, picture in film.pictures()], stack_of(8))


@pytest.mark.parametrize(("levels", "bits"), [(4096, 12), (1024, 10), (65536, 16), (0, 16)])
def test_of_sixteen_bits_those_count_that_the_camera_filled(tmp_path, levels, bits):
    assert opened(tmp_path, cine(stack_of(8), 16, levels=levels)).bits == bits


def test_without_notes_the_pixels_begin_behind_what_is_left_over_between_two_pictures(tmp_path):
    film = opened(tmp_path, cine(stack_of(8), 8, notes=0, spare=12))
    assert np.array_equal([picture for _, picture in film.pictures()], stack_of(8))


def test_a_note_that_states_another_size_or_a_length_beyond_the_file_is_none(tmp_path):
    for length in (7, 10**6):
        film = opened(tmp_path, cine(stack_of(8), 8, notes=8, note_length=length))
        assert np.array_equal([picture for _, picture in film.pictures()], stack_of(8))


@pytest.mark.parametrize(
    ("changed", "clock"), [({"mark": b"XX"}, (None, None)), ({"rate": 0}, (None, 250e-6)), ({"shutter_us": 0}, (500.0, None))]
)
def test_what_the_camera_did_not_note_is_not_known(tmp_path, changed, clock):
    film = opened(tmp_path, cine(stack_of(8), 8, **changed))
    assert (film.fps, film.exposure_s) == (clock[0], clock[1] and pytest.approx(clock[1]))


def test_a_film_that_is_cut_gives_the_pictures_that_are_whole(tmp_path):
    whole = cine(stack_of(8), 8)
    assert len(list(opened(tmp_path, whole[:-1]).pictures())) == FRAMES - 1
    assert len(list(opened(tmp_path, whole).pictures())) == FRAMES
    for length in (44, 80, 84 + SETUP + 8 * FRAMES - 1):
        with pytest.raises(InputError, match="cut or damaged"):
            opened(tmp_path, whole[:length])


def test_a_film_without_frames_or_packed_otherwise_is_refused(tmp_path):
    with pytest.raises(InputError, match="cut or damaged"):
        opened(tmp_path, cine(stack_of(8, 0), 8))
    with pytest.raises(InputError, match="compression 1, packing 0, 8 bit"):
        opened(tmp_path, cine(stack_of(8), 8, compression=1))


def test_a_cine_is_known_by_its_mark_and_the_lengths_of_its_headers():
    head = cine(stack_of(8), 8)[:44]
    assert is_cine(head)
    assert is_cine(b"\0\0" + head[2:])
    assert not is_cine(head[:43])
    for place in (0, 2, 3, 24, 25):
        assert not is_cine(head[:place] + b"\x05" + head[place + 1 :])


def test_pictures_from_sixteen_pixels_to_64_megapixels_are_accepted():
    for size in ((16, 16), (16, 4_000_000), (8000, 8000)):
        check_size("film", *size)
    for size in ((15, 400), (400, 15), (8000, 8001)):
        with pytest.raises(InputError, match=f"{size[0]} x {size[1]} px; accepted are 16 x 16 px to 64 megapixels"):
            check_size("film", *size)
