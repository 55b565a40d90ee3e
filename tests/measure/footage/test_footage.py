"""Films of every kind: what is read, and what is refused."""

from __future__ import annotations

import struct
import subprocess
import sys
import zlib

import av
import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.footage import from_array
from measure.footage.formats import open_footage
from measure.footage.writers import Clock, write_film


@pytest.fixture
def stack():
    return np.random.default_rng(0).integers(0, 255, (12, 48, 64), dtype=np.uint8)


def test_a_lossless_avi_gives_back_every_grey_level(stack, tmp_path):
    write_film(tmp_path / "film.avi", stack)
    film = open_footage(tmp_path / "film.avi")
    frames = list(film.pictures())
    assert (film.frames, film.width, film.height, film.bits) == (12, 64, 48, 8)
    assert [number for number, _ in frames] == list(range(12))
    assert np.array_equal([picture for _, picture in frames], stack)


def test_the_rate_of_a_container_is_not_the_cameras(stack, tmp_path):
    write_film(tmp_path / "film.avi", stack)
    assert open_footage(tmp_path / "film.avi").fps is None


@pytest.mark.parametrize("suffix", ["tif", "png", "bmp"])
def test_pictures_keep_their_depth_and_come_in_the_order_of_their_numbers(suffix, tmp_path):
    deep = suffix != "bmp"
    stack = np.random.default_rng(1).integers(0, 4095 if deep else 255, (11, 32, 40)).astype(np.uint16 if deep else np.uint8)
    for n, picture in enumerate(stack):
        cv2.imwrite(str(tmp_path / f"run2_{n + 8}.{suffix}"), picture)
    film = open_footage(tmp_path)
    assert film.bits == (16 if deep else 8)
    assert np.array_equal([picture for _, picture in film.pictures()], stack)


def test_a_gap_in_the_numbering_is_a_missing_frame_and_is_said(stack, tmp_path):
    write_film(tmp_path / "film", stack)
    (tmp_path / "film" / "frame_0005.png").unlink()
    film = open_footage(tmp_path / "film")
    assert film.frames == 12
    assert [number for number, _ in film.pictures()] == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11]
    assert "4 to 6" in film.remarks[0]


def test_a_cut_avi_promises_more_than_it_holds(stack, tmp_path):
    write_film(tmp_path / "film.avi", stack)
    data = (tmp_path / "film.avi").read_bytes()
    (tmp_path / "cut.avi").write_bytes(data[: len(data) // 2])
    film = open_footage(tmp_path / "cut.avi")
    assert film.frames == 12 > len(list(film.pictures()))


@pytest.mark.parametrize(("codec", "name", "lost"), [("MJPG", "film.avi", {6}), ("mp4v", "film.mp4", {6, 7, 8, 9, 10, 11})])
def test_a_damaged_picture_is_missing_and_so_is_what_is_built_on_it(codec, name, lost, tmp_path):
    """The sixth of twelve pictures, one of them standing alone in the .mp4; the .avi's all do."""
    speckle = cv2.GaussianBlur(np.random.default_rng(3).normal(128.0, 300.0, (64, 96)).astype(np.float32), (0, 0), 3.0)
    grey = [np.clip(speckle[n : n + 48, :64], 0, 255).astype(np.uint8) for n in range(12)]
    writer = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter.fourcc(*codec), 25.0, (64, 48), False)
    for picture in grey:
        writer.write(picture)
    writer.release()
    whole = dict(open_footage(tmp_path / name).pictures())
    assert list(whole) == list(range(12))
    with av.open(str(tmp_path / name)) as container:
        sixth = [packet for packet in container.demux(video=0) if packet.size][6]
    data = bytearray((tmp_path / name).read_bytes())
    assert sixth.pos is not None
    middle = sixth.pos + sixth.size // 2
    data[middle : middle + 60] = bytes(60)
    (tmp_path / name).write_bytes(data)
    film = open_footage(tmp_path / name)
    sound = dict(film.pictures())
    assert film.frames == 12
    assert set(range(12)) - set(sound) == lost
    assert all(np.array_equal(picture, whole[number]) for number, picture in sound.items())


@pytest.mark.parametrize(("depth", "kind"), [(10, "yuv420p10le"), (12, "gray12le"), (8, "yuyv422"), (8, "bgr24")])
def test_containers_keep_their_depth(depth, kind, tmp_path):
    """Written without loss by the library that decodes."""
    grey = (
        np.random.default_rng(4).integers(16 << (depth - 8), 235 << (depth - 8), (3, 48, 64)).astype(np.uint16 if depth > 8 else np.uint8)
    )
    name = tmp_path / ("film.avi" if depth == 8 else "film.mkv")
    with av.open(str(name), "w") as container:
        stream = container.add_stream("rawvideo" if depth == 8 else "ffv1", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, kind
        for picture in grey:
            frame = av.VideoFrame(64, 48, kind)
            _fill(frame, kind, picture)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    film = open_footage(name)
    assert (film.bits, film.frames) == (depth, 3)
    for (_, found), picture in zip(film.pictures(), grey, strict=True):
        assert np.array_equal(found, picture)


def _fill(frame, kind, picture):
    """A grey picture in the pixels of a format; neutral colours."""
    for n, plane in enumerate(frame.planes):
        if kind == "bgr24":
            pixels = np.repeat(picture, 3, axis=1)
        elif kind == "yuyv422":
            pixels = np.stack([picture, np.full_like(picture, 128)], axis=2).reshape(48, 128)
        else:
            pixels = picture if n == 0 else np.full((24, 32), 512, np.uint16)
        rows = np.zeros((plane.height, plane.line_size), np.uint8)
        rows[:, : pixels.shape[1] * pixels.itemsize] = np.ascontiguousarray(pixels).view(np.uint8)
        plane.update(rows.tobytes())


CONTAINERS = [
    ("film.mpg", "mpeg2video", "yuv420p", None), ("film.ts", "libx264", "yuv420p", None), ("film.wmv", "wmv2", "yuv420p", None),
    ("film.gif", "gif", "gray", None), ("film.y4m", "wrapped_avframe", "gray", None), ("film.mkv", "libx265", "yuv420p10le", None),
    ("film.mov", "prores_ks", "yuv422p10le", None), ("film.bin", "libx264", "yuv420p", "h264"), ("film.mp4", "libx264", "yuv420p", None),
]  # fmt: skip


@pytest.mark.parametrize(("name", "codec", "pixels", "kind"), CONTAINERS)
def test_films_as_people_have_them_are_read_frame_by_frame(name, codec, pixels, kind, tmp_path):
    """A bright bar that moves 4 px a frame shows which frame is which, whatever the code made of its grey values."""
    with av.open(str(tmp_path / name), "w", format=kind) as container:
        stream = container.add_stream(codec, rate=25)
        stream.width, stream.height, stream.pix_fmt = 128, 96, pixels
        for n in range(12):
            picture = np.full((96, 128), 40, np.uint8)
            picture[:, 20 + 4 * n : 40 + 4 * n] = 200
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)
            frame.pts = n
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    film = open_footage(tmp_path / name)
    frames = list(film.pictures())
    assert [number for number, _ in frames] == list(range(12))
    assert film.frames == 12
    centres = [np.flatnonzero(picture.mean(axis=0) > picture.mean()).mean() for _, picture in frames]
    assert np.abs(np.array(centres) - 29.5 - 4 * np.arange(12)).max() < 1.0


def _spoilt(data, chance):
    """A copy of a file, cut or with bytes changed: a few anywhere, a few in its head, or a stretch."""
    spoilt = bytearray(data)
    way = chance.integers(4)
    if way == 0:
        return spoilt[: chance.integers(1, len(data))]
    if way == 3:
        start = chance.integers(len(data))
        spoilt[start : start + 100] = chance.bytes(len(spoilt[start : start + 100]))
        return spoilt
    for place in chance.integers(len(data) if way == 1 else 600, size=20):
        spoilt[place] = chance.integers(256)
    return spoilt


@pytest.mark.parametrize(("codec", "name"), [("MJPG", "film.avi"), ("mp4v", "film.mp4"), ("FFV1", "film.mkv")])
def test_spoilt_films_end_in_pictures_or_one_sentence(codec, name, stack, tmp_path):
    writer = cv2.VideoWriter(str(tmp_path / name), cv2.VideoWriter.fourcc(*codec), 25.0, stack.shape[:0:-1], False)
    for picture in stack:
        writer.write(picture)
    writer.release()
    data, chance = (tmp_path / name).read_bytes(), np.random.default_rng(5)
    read = 0
    for _ in range(60):
        (tmp_path / name).write_bytes(_spoilt(data, chance))
        try:
            film = open_footage(tmp_path / name)
            numbers = [number for number, _ in film.pictures()]
        except InputError:
            continue
        assert numbers == sorted(set(numbers))
        read += len(numbers)
    assert read > 100


def test_pictures_of_two_sizes_are_two_films(stack, tmp_path):
    write_film(tmp_path / "film", stack)
    cv2.imwrite(str(tmp_path / "film" / "frame_0003.png"), stack[0][:-2])
    with pytest.raises(InputError, match=r"frame_0003.png: is 64 x 46 px"):
        list(open_footage(tmp_path / "film").pictures())


def test_a_picture_that_unpacks_to_gigabytes_is_refused_before_decoding(tmp_path):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", 60000, 60000, 8, 0, 0, 0, 0)
    bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(bytes(1000))) + chunk(b"IEND", b"")
    for n in range(2):
        (tmp_path / f"f{n}.png").write_bytes(bomb)
    with pytest.raises(InputError, match="60000 x 60000 px"):
        open_footage(tmp_path)


OPENED_WITH_LITTLE_MEMORY = """
import sys
from pathlib import Path
import cv2
import measure.common.limits
from measure import InputError, open_footage
measure.common.limits.DECODER_BYTES = 2**22
try:
    open_footage(Path(sys.argv[1]))
except InputError as refused:
    print(refused)
"""


def test_a_decoder_that_wants_too_much_memory_ends_in_a_sentence(tmp_path):
    """A folder of pictures of 24 megapixels, and a decoder that may take a few megabytes, in a process with nothing freed to fill again."""
    for n in range(2):
        cv2.imwrite(str(tmp_path / f"f{n}.png"), np.zeros((6000, 4000), np.uint16))
    told = subprocess.run([sys.executable, "-c", OPENED_WITH_LITTLE_MEMORY, str(tmp_path)], capture_output=True, text=True, check=True)
    assert "takes more than" in told.stdout
    assert open_footage(tmp_path).width == 4000


def test_the_memory_of_the_rest_is_not_limited_after_decoding(stack, tmp_path):
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    write_film(tmp_path / "film.avi", stack)
    list(open_footage(tmp_path / "film.avi").pictures())
    assert resource.getrlimit(resource.RLIMIT_AS) == before


@pytest.mark.parametrize("kind", ["film.avi", "film.mraw", "film"])
def test_memory_does_not_grow_with_the_film(kind, tmp_path):
    """Ten times as many frames are read with the same few pictures in memory."""
    import tracemalloc

    taken = []
    for frames in (20, 200):
        path = tmp_path / str(frames) / kind
        path.parent.mkdir()
        noise = np.random.default_rng(0).integers(0, 255, (120, 160), dtype=np.uint8)
        write_film(path, (np.roll(noise, n, axis=0) for n in range(frames)), clock=Clock(100.0))
        film = open_footage(path)
        tracemalloc.start()
        assert sum(1 for _ in film.pictures()) == frames
        taken.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert taken[1] < taken[0] + 8 * 120 * 160  # a few more may be on their way at a time


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("text.avi", b"#EXTM3U\nhttp://example.org/film.mp4\n", "is not a film"),
        ("empty.avi", b"", "is empty"),
        ("head.avi", b"RIFF\x00\x10\x00\x00AVI LIST", "no frame of it can be decoded"),
        ("head.mp4", b"\x00\x00\x00\x18ftypisom" + bytes(200), "no frame of it can be decoded"),
    ],
)
def test_what_is_not_a_film_is_refused_in_one_sentence(name, content, says, tmp_path):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=says):
        open_footage(tmp_path / name)


def test_an_address_is_not_a_file(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        open_footage(tmp_path / "http://example.org/film.mp4")


def test_a_folder_without_numbers_has_no_order(tmp_path):
    for name in ("first.png", "second.png"):
        cv2.imwrite(str(tmp_path / name), np.zeros((32, 32), np.uint8))
    with pytest.raises(InputError, match="has no number in its name"):
        open_footage(tmp_path)


def test_an_array_is_a_film():
    assert from_array(np.zeros((3, 20, 30), np.uint16), fps=100.0).fps == 100.0
    with pytest.raises(InputError, match="uint8 or uint16"):
        from_array(np.zeros((3, 20, 30)))  # type: ignore[arg-type]
