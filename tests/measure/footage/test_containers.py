"""How a file is told to be a film by its first bytes, how many pictures it promises, and directories of TIFF written by hand."""

from __future__ import annotations

import struct
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.container import Promise, is_container, promised
from measure.footage.tiff_directory import is_tiff, page_sizes
from measure.footage.time_stamps import frame_clock
from measure.footage.writers import Clock, write_film

HEADS = {
    "avi": b"RIFF\x10\0\0\0AVI LIST",
    "matroska": b"\x1aE\xdf\xa3\x01\0\0\0",
    "gif": b"GIF89a",
    "yuv4mpegpipe": b"YUV4MPEG2 W16 H16",
    "mpeg": b"\0\0\1\xba\x44",
    "asf": b"0&\xb2u\x8ef\xcf\x11\xa6\xd9",
    "mov ftyp": b"\0\0\0\x20ftypisom",
    "mov moov": b"\0\0\1\0moov",
    "mov mdat": b"\0\0\1\0mdat",
    "mov wide": b"\0\0\0\x08wide",
    "h264": b"\0\0\0\1\x67\x42",
    "h264 with a delimiter": b"\0\0\0\1\x09\x10",
    "hevc": b"\0\0\0\1\x40\1\x0c",
}


@pytest.mark.parametrize("name", HEADS)
def test_a_container_begins_with_its_mark_and_nowhere_else(name):
    head = HEADS[name] + bytes(400)
    assert is_container(head)
    assert not is_container(b"x" + head)
    assert not is_container(HEADS[name][:3])
    mark = 4 if name.startswith("mov") else 0
    assert not is_container(head[:mark] + b"\x7f" + head[mark + 1 :])


def test_a_riff_file_that_is_no_avi_is_no_film():
    assert not is_container(b"RIFF\x10\0\0\0WAVEfmt " + bytes(400))


@pytest.mark.parametrize(("before", "packet"), [(0, 188), (4, 192)])
def test_packets_of_a_transport_stream_begin_alike(before, packet):
    stream = bytearray(400)
    stream[before::packet] = b"\x47" * len(stream[before::packet])
    assert is_container(bytes(stream))
    stream[before + packet] = 0
    assert not is_container(bytes(stream))
    assert not is_container(bytes(stream[: before + packet]))


def stream_of(**known) -> Any:
    return SimpleNamespace(**{"frames": 0, "average_rate": 25, "duration": None, "time_base": None, **known})


def test_a_film_promises_what_its_head_counts_or_as_many_as_its_duration_has():
    whole: Any = SimpleNamespace(duration=2_000_000)
    assert promised(whole, stream_of(frames=7, duration=100, time_base=0.1)) == Promise(counted=7)
    assert promised(whole, stream_of(duration=30, time_base=0.1)) == Promise(by_duration=75)
    assert promised(whole, stream_of()) == Promise(by_duration=50)
    assert promised(whole, stream_of(average_rate=None)) == Promise()
    unknown: Any = SimpleNamespace(duration=None)
    assert promised(unknown, stream_of()) == Promise()


def test_two_stamps_are_frames_and_no_rate_and_none_is_no_film():
    assert frame_clock(np.array([5, 9])).numbers.tolist() == [0, 1]
    assert (frame_clock(np.array([], int)).frames, frame_clock(np.array([], int)).dropped) == (0, 0)


def test_a_step_is_a_multiple_of_the_usual_one_to_a_quarter():
    for stretch, dropped in ((2.2, 1), (1.8, 1), (2.3, 0), (3.1, 2)):
        steps = np.full(20, 1000.0)
        steps[9] = 1000.0 * stretch
        clock = frame_clock(np.rint(np.cumsum(steps)).astype(int))
        assert clock.dropped == dropped, stretch
        assert clock.frames == 20 + dropped
    assert frame_clock(np.array([0, 10, 20, 30, 30 + 10 * 10_000, 40 + 10 * 10_000])).dropped == 9_999
    assert frame_clock(np.array([0, 10, 20, 30, 30 + 10 * 10_001, 40 + 10 * 10_001])).dropped == 0


def test_what_was_dropped_is_said_by_the_frames_on_either_side():
    stamps = np.array([0, 1, 2, 4, 5, 8, 9, 11, 12, 14, 15, 16, 17, 18, 19, 20]) * 10
    (said,) = frame_clock(stamps).remarks
    assert said == "5 frames were dropped by the time stamps (frame 2 to 4, 5 to 8, 9 to 11, ...)"
    uneven = frame_clock(np.cumsum([0, 100, 150, 100, 150, 100, 150]))
    assert uneven.instants == pytest.approx(np.cumsum([0, 0.8, 1.2, 0.8, 1.2, 0.8, 1.2]))
    assert uneven.remarks == ("the frame rate varies: 80 to 120 % of the usual step; the time stamps are used",)


def directory(order, big, sizes, *, short=True, tags=0):
    """A TIFF without pixels: a header and one directory for each size."""
    where, count = ("Q", "Q") if big else ("I", "H")
    mark = {"<": b"II", ">": b"MM"}[order] + struct.pack(order + "H", 43 if big else 42)
    head = mark + (struct.pack(order + "HHQ", 8, 0, 16) if big else struct.pack(order + "I", 8))
    data = bytearray(head)
    for k, (width, height) in enumerate(sizes):
        rows = [(300, 4, 0)] * tags + [(256, 3 if short else 4, width), (257, 3 if short else 4, height)]
        entry = bytearray(struct.pack(order + count, len(rows)))
        for tag, kind, value in rows:
            room = 8 if big else 4
            entry += struct.pack(order + ("HHQ" if big else "HHI"), tag, kind, 1)
            entry += struct.pack(order + ("H" if kind == 3 else "I"), value).ljust(room, b"\0")
        following = len(data) + len(entry) + struct.calcsize("=" + where) if k + 1 < len(sizes) else 0
        data += entry + struct.pack(order + where, following)
    return bytes(data)


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("big", [True, False])
@pytest.mark.parametrize("short", [True, False])
def test_directories_of_every_kind_of_tiff_give_the_sizes_of_its_pictures(order, big, short):
    sizes = [(640, 480), (32, 17), (65_000, 3)]
    data = directory(order, big, sizes, short=short)
    assert is_tiff(data)
    assert page_sizes(data) == sizes
    assert page_sizes(memoryview(directory(order, big, sizes, short=short, tags=5))) == sizes
    assert page_sizes(data[:-9]) == sizes[:2]
    assert page_sizes(data[:4]) == []


def test_a_chain_of_directories_that_bites_its_tail_or_is_too_long_ends():
    data = bytearray(directory("<", False, [(640, 480)]))
    data[-4:] = struct.pack("<I", 8)
    assert page_sizes(bytes(data)) == [(640, 480)]
    assert page_sizes(directory("<", False, [(640, 480)], tags=510)) == [(640, 480)]
    assert page_sizes(directory("<", False, [(640, 480)], tags=511)) == []
    for head in (b"II*", b"II\0*", b"IM*\0", b"MM*\0"):
        assert not is_tiff(head)


def test_films_are_written_into_what_was_named_or_not_at_all(tmp_path):
    pictures = np.zeros((2, 20, 32), np.uint8)
    write_film(tmp_path / "frames", pictures)
    assert sorted(file.name for file in (tmp_path / "frames").iterdir()) == ["frame_0000.png", "frame_0001.png"]
    with pytest.raises(InputError, match="holds something already"):
        write_film(tmp_path / "frames", pictures)
    with pytest.raises(InputError, match="an avi holds 8 bit"):
        write_film(tmp_path / "a.avi", pictures.astype(np.uint16))
    with pytest.raises(InputError, match=r"films are written as \.avi"):
        write_film(tmp_path / "a.mraw", pictures)
    write_film(tmp_path / "a.mraw", pictures, clock=Clock(250.0, 1e-3))
    notes = (tmp_path / "a.cih").read_text()
    for line in (
        "Record Rate(fps) : 250",
        "Shutter Speed(s) : 0.001000000",
        "Total Frame : 2",
        "Image Width : 32",
        "Image Height : 20",
        "Color Bit : 8",
    ):
        assert line in notes
    assert (tmp_path / "a.mraw").stat().st_size == 2 * 20 * 32
