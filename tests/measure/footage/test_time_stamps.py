"""What time stamps say: dropped frames, a rate that varies, edit lists; in films written by the library that decodes."""

from __future__ import annotations

import struct
from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from measure.correlation.marks import MISSING
from measure.correlation.tracking import track_marks
from measure.footage.formats import open_footage
from measure.footage.time_stamps import frame_clock


def _stack(count, seed=0):
    """Frames that differ: a window that moves over a blurred random picture."""
    wide = cv2.GaussianBlur(np.random.default_rng(seed).normal(128.0, 300.0, (48 + count, 64)).astype(np.float32), (0, 0), 3.0)
    return [np.ascontiguousarray(np.clip(wide[n : n + 48], 0, 255).astype(np.uint8)) for n in range(count)]


def _write(path, stack, stamps, base=Fraction(1, 12800), codec="mpeg4"):
    """A film whose frames are to be shown at `stamps`, in units of `base` s."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=30)
        assert isinstance(stream, av.VideoStream)
        stream.height, stream.width = stack[0].shape
        stream.pix_fmt, stream.time_base, stream.codec_context.time_base = "yuv420p", base, base
        for picture, stamp in zip(stack, stamps, strict=True):
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuv420p")
            frame.pts, frame.time_base = int(stamp), base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


@pytest.mark.parametrize(("name", "codec"), [("film.mp4", "mpeg4"), ("film.mp4", "libx264"), ("film.mkv", "mpeg4")])
@pytest.mark.parametrize("seed", range(3))
def test_dropped_frames_are_missing_whatever_the_container_counts(name, codec, seed, tmp_path):
    rng = np.random.default_rng(seed)
    kept = np.sort(rng.choice(np.arange(1, 39), 33, replace=False))
    kept = np.array([0, *kept, 39])
    _write(tmp_path / name, _stack(len(kept), seed), kept * 427, codec=codec)
    film = open_footage(tmp_path / name)
    assert [number for number, _ in film.pictures()] == list(kept)
    assert film.frames == 40
    assert film.instants is None
    assert "5 frames were dropped" in film.remarks[0]


def test_a_film_with_dropped_frames_keeps_its_clock(speckled, tmp_path):
    kept = np.array([0, 1, 2, 3, 4, 7, 8, 9, 12, 13])
    pictures = [speckled((0.0, -1.0 * n), seed=3, size=96, noise_seed=n) for n in kept]
    _write(tmp_path / "film.mkv", pictures, kept * 400, codec="ffv1")
    marks = track_marks(open_footage(tmp_path / "film.mkv"), [(48.0, 60.0)], 500.0)
    assert np.allclose(marks.time_s, np.arange(14) / 500.0)
    assert list(np.flatnonzero(marks.status[:, 0] == MISSING)) == [5, 6, 10, 11]
    assert np.abs(marks.y_px[kept, 0] - 60.0 + kept).max() < 0.1


@pytest.mark.parametrize("name", ["film.mp4", "film.mkv"])
def test_a_rate_that_varies_gives_its_own_times(name, tmp_path):
    """As phones write it: every step strays by some percent of a millisecond grid of 1 / 12800 s."""
    steps = np.random.default_rng(1).integers(390, 470, 29)
    stamps = np.concatenate([[0], np.cumsum(steps)])
    _write(tmp_path / name, _stack(30), stamps)
    film = open_footage(tmp_path / name)
    assert (film.frames, len(list(film.pictures()))) == (30, 30)
    times = film.times_s(30, 1.0)
    assert times[0] == 0.0
    rounded = 1e-9 if name == "film.mp4" else 0.04  # Matroska keeps whole milliseconds
    assert np.allclose(np.diff(times) / np.diff(times).mean(), steps / steps.mean(), rtol=rounded)
    assert 0.9 < times[-1] / 29 < 1.1
    assert "varies" in film.remarks[0]


def test_stamps_in_whole_milliseconds_are_evenly_spaced():
    """29.97 frames per second in a Matroska file: steps of 33 and 34."""
    clock = frame_clock(np.rint(np.arange(3000) * 1001 / 30).astype(np.int64))
    assert clock.instants is None
    assert clock.remarks == ()
    assert np.array_equal(clock.numbers, np.arange(3000))


def test_frames_at_twice_the_usual_step_were_dropped_and_those_at_one_and_a_half_were_not():
    usual = np.arange(0, 5000, 100)
    assert list(np.setdiff1d(np.arange(50), frame_clock(np.delete(usual, [7, 8, 30])).numbers)) == [7, 8, 30]
    slower = np.concatenate([usual, usual[-1] + 150 * np.arange(1, 20)])
    clock = frame_clock(slower)
    assert clock.dropped == 0
    assert clock.instants is not None


def test_a_stamp_that_is_unknown_or_goes_back_counts_on():
    clock = frame_clock(np.array([0, 10, 20, 50]))
    assert [clock.number(20, 1), clock.number(50, 2), clock.number(None, 2), clock.number(10, 4)] == [2, 5, 3, 5]


@pytest.mark.parametrize("cut", [1, 4, 9])
def test_frames_before_the_start_of_an_edit_list_are_no_part_of_the_film(cut, tmp_path):
    """The list that a program writes when it trims without encoding again; the pictures before it stay in the file."""
    path = tmp_path / "film.mp4"
    _write(path, _stack(20), 400 * np.arange(20))
    whole = [picture for _, picture in open_footage(path).pictures()]
    data = bytearray(path.read_bytes())
    at = data.index(b"elst")
    version, entries, duration, start = struct.unpack_from(">IIii", data, at + 4)
    assert (version, entries, start) == (0, 1, 0)
    struct.pack_into(">ii", data, at + 12, duration * (20 - cut) // 20, 400 * cut)
    path.write_bytes(data)
    film = open_footage(path)
    frames = list(film.pictures())
    assert film.frames == len(frames) == 20 - cut
    assert [number for number, _ in frames] == list(range(20 - cut))
    assert np.array_equal([picture for _, picture in frames], whole[cut:])
