"""One film in many containers and with many tables of time stamps: the marks are where they are in the plain pictures."""

from __future__ import annotations

from fractions import Fraction

import av
import cv2
import numpy as np
import pytest

from measure.correlation.marks import MISSING
from measure.correlation.tracking import track_marks
from measure.footage.footage import from_array
from measure.footage.formats import open_footage
from measure.footage.writers import Clock, write_film

FRAMES, PLACES, FPS = 14, [(40.0, 60.0), (88.0, 62.0)], 100.0
LOSSLESS_PX, COMPRESSED_PX, PALETTE_PX = 0.02, 0.1, 0.1


@pytest.fixture(scope="module")
def stack():
    """A blurred random picture that moves by parts of a pixel."""
    wide = cv2.GaussianBlur(np.random.default_rng(3).normal(0.0, 1.0, (200, 200)).astype(np.float32), (0, 0), 1.6)
    wide = 128.0 + 45.0 * wide / wide.std()
    rng = np.random.default_rng(4)
    shown = []
    for n in range(FRAMES):
        shift = np.array([[1, 0, -30 + 0.31 * n], [0, 1, -40 - 1.27 * n]], np.float32)
        moved = cv2.warpAffine(wide, shift, (128, 112), flags=cv2.INTER_CUBIC)
        shown.append(np.clip(np.rint(moved + rng.normal(0.0, 1.0, moved.shape)), 16, 235).astype(np.uint8))
    return np.array(shown)


@pytest.fixture(scope="module")
def plain(stack):
    return track_marks(from_array(stack), PLACES, FPS, 25)


def _tracked(path):
    return track_marks(open_footage(path), PLACES, FPS, 25)


def _encoded(path, stack, codec, pixels, options=None, stamps=None, kind=None):
    """Written by the library that decodes; `stamps` in units of 1/12800 s."""
    base = Fraction(1, 12800)
    with av.open(str(path), "w", format=kind) as container:
        stream = container.add_stream(codec, rate=25, options=options or {})
        assert isinstance(stream, av.VideoStream)
        stream.height, stream.width = stack[0].shape
        stream.pix_fmt = pixels
        if stamps is not None:
            stream.time_base = stream.codec_context.time_base = base
        for n, picture in enumerate(stack):
            frame = _frame(picture, pixels)
            if stamps is not None:
                frame.pts, frame.time_base = int(stamps[n]), base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def _frame(picture, pixels):
    """Grey values as they are in the brightness of a format; its colours are neutral."""
    if not pixels.startswith("yuv"):
        return av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)
    frame = av.VideoFrame(picture.shape[1], picture.shape[0], pixels)
    deep = pixels.endswith("le")
    for n, plane in enumerate(frame.planes):
        shape = picture.shape if n == 0 else (plane.height, plane.width)
        values = picture.astype(np.uint16) * 4 if deep and n == 0 else np.full(shape, 512 if deep else 128) if n else picture
        rows = np.zeros((plane.height, plane.line_size), np.uint8)
        data = np.ascontiguousarray(values, dtype="<u2" if deep else np.uint8).view(np.uint8)
        rows[:, : data.shape[1]] = data
        plane.update(rows.tobytes())
    return frame


@pytest.mark.parametrize(
    ("name", "codec", "pixels", "options", "limit"),
    [
        ("film.mkv", "ffv1", "gray", {}, LOSSLESS_PX), ("film.avi", "rawvideo", "bgr24", {}, LOSSLESS_PX),
        ("film.mp4", "libx264", "yuv420p", {"qp": "0"}, LOSSLESS_PX), ("film.ts", "libx264", "yuv420p", {"qp": "0"}, LOSSLESS_PX),
        ("film.mov", "libx264", "yuv420p", {"qp": "0"}, LOSSLESS_PX), ("film.mts", "libx264", "yuv420p", {"qp": "0"}, LOSSLESS_PX),
        ("film.y4m", "wrapped_avframe", "gray", {}, LOSSLESS_PX),
        ("deep.mp4", "libx265", "yuv420p10le", {"x265-params": "lossless=1:log-level=error"}, LOSSLESS_PX),
        ("film.mov", "prores_ks", "yuv422p10le", {}, LOSSLESS_PX), ("film.gif", "gif", "gray", {}, PALETTE_PX),
        ("film.mpg", "mpeg2video", "yuv420p", {"b": "8000000"}, COMPRESSED_PX),
        ("film.wmv", "wmv2", "yuv420p", {"b": "8000000"}, COMPRESSED_PX),
    ],
)  # fmt: skip
def test_a_film_is_the_same_in_every_container(name, codec, pixels, options, limit, stack, plain, tmp_path):
    path = tmp_path / name
    _encoded(path, stack, codec, pixels, options, kind="mpegts" if name.endswith(".mts") else None)
    found = _tracked(path)
    assert np.allclose(found.time_s, plain.time_s)
    assert np.abs(found.x_px - plain.x_px).max() < limit
    assert np.abs(found.y_px - plain.y_px).max() < limit


@pytest.mark.parametrize("name", ["png", "tif", "bmp", "stack.tif", "float", "film.mraw"])
def test_a_film_is_the_same_as_pictures(name, stack, plain, tmp_path):
    path = tmp_path / name
    if name == "stack.tif":
        cv2.imwritemulti(str(path), list(stack))
    elif name == "film.mraw":
        write_film(path, stack, clock=Clock(FPS))
    else:
        path.mkdir()
        for n, picture in enumerate(stack):
            values = picture if name != "float" else (picture / 255.0).astype(np.float32)
            cv2.imwrite(str(path / f"run2_{n:03d}_100fps.{'tif' if name == 'float' else name}"), values)
    found = _tracked(path)
    assert np.abs(found.x_px - plain.x_px).max() < LOSSLESS_PX
    assert np.abs(found.y_px - plain.y_px).max() < LOSSLESS_PX


@pytest.mark.parametrize("name", ["film.mp4", "film.mkv"])
@pytest.mark.parametrize("table", ["even", "dropped", "varying", "late"])
def test_a_film_is_the_same_under_every_table_of_time_stamps(name, table, stack, plain, tmp_path):
    """A step is 128 units, 10 ms; the codec is lossless."""
    even = 128 * np.arange(FRAMES)
    kept = np.setdiff1d(np.arange(FRAMES), [4, 9, 10]) if table == "dropped" else np.arange(FRAMES)
    stamps = {"even": even, "dropped": even[kept], "late": even + 12800, "varying": even + np.arange(FRAMES) ** 2 * 4}[table]
    _encoded(tmp_path / name, stack[kept], "libx264", "yuv420p", {"qp": "0"}, stamps)
    found = _tracked(tmp_path / name)
    assert len(found.time_s) == FRAMES
    assert list(np.flatnonzero(found.status[:, 0] == MISSING)) == sorted(set(range(FRAMES)) - set(kept.tolist()))
    assert np.abs(found.x_px - plain.x_px)[kept].max() < LOSSLESS_PX
    assert np.abs(found.y_px - plain.y_px)[kept].max() < LOSSLESS_PX
    if table == "varying":
        rounded = 1e-6 if name == "film.mp4" else 0.06  # Matroska keeps whole milliseconds
        assert np.allclose(np.diff(found.time_s) / found.time_s[-1], np.diff(stamps) / stamps[-1], rtol=rounded)
    else:
        assert np.allclose(found.time_s, plain.time_s)
