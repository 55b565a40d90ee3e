"""Pictures in folders and stacks: names with several numbers, fractions as grey values, several pictures in one file."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.formats import open_footage
from measure.footage.picture_file import picture_kind, picture_size


@pytest.fixture
def stack():
    return np.random.default_rng(0).integers(0, 255, (6, 48, 64), dtype=np.uint8)


def _frames(path):
    return np.array([picture for _, picture in open_footage(path).pictures()])


@pytest.mark.parametrize(
    "name",
    ["run3_{n:03d}_250fps", "{n}_cam2", "2026-05-03_shot12_{n:05d}", "cam1_{n:04d}_t{t:06d}us", "a{n}b{n}", "im_{t}_{n:03d}"],
)
def test_the_number_that_varies_counts(name, stack, tmp_path):
    for n, picture in enumerate(stack):
        cv2.imwrite(str(tmp_path / (name.format(n=n + 8, t=(n + 8) * 4000 + n % 2) + ".png")), picture)
    film = open_footage(tmp_path)
    assert film.frames == 6
    assert film.remarks == ()
    assert np.array_equal(_frames(tmp_path), stack)


def test_two_films_in_one_folder_are_refused(stack, tmp_path):
    for n, picture in enumerate(stack):
        cv2.imwrite(str(tmp_path / f"run{n // 3}_{n % 3}.png"), picture)
    with pytest.raises(InputError, match="same number"):
        open_footage(tmp_path)


def test_whole_numbers_stored_as_fractions_stay_whole(stack, tmp_path):
    for n, picture in enumerate(stack):
        cv2.imwrite(str(tmp_path / f"f_{n}.tif"), picture.astype(np.float32))
    assert np.array_equal(_frames(tmp_path), stack)


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (-3.0, 3.0), (0.0, 1e5)])
def test_fractions_are_spread_over_sixteen_bits_by_one_line_for_the_whole_film(low, high, tmp_path):
    values = np.random.default_rng(1).uniform(low, high, (4, 40, 50)).astype(np.float32)
    for n, picture in enumerate(values):
        cv2.imwrite(str(tmp_path / f"f_{n}.tif"), picture)
    found = _frames(tmp_path).astype(float)
    slope, offset = np.polyfit(values.ravel(), found.ravel(), 1)
    assert np.abs(found - slope * values - offset).max() <= 0.51
    assert slope * (high - low) > 30000
    assert 0 < found.min() < found.max() < 65535


def test_a_picture_with_values_that_are_not_numbers_is_refused(tmp_path):
    for n in range(2):
        cv2.imwrite(str(tmp_path / f"f_{n}.tif"), np.full((40, 50), np.nan, np.float32))
    with pytest.raises(InputError, match="not numbers"):
        open_footage(tmp_path)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_a_tiff_with_many_pictures_is_a_film(dtype, stack, tmp_path):
    cv2.imwritemulti(str(tmp_path / "stack.tif"), [picture.astype(dtype) for picture in stack])
    film = open_footage(tmp_path / "stack.tif")
    assert (film.frames, film.width, film.height, film.bits) == (6, 64, 48, 8 if dtype == np.uint8 else 16)
    assert np.array_equal(_frames(tmp_path / "stack.tif"), stack)


def test_a_stack_longer_than_what_is_decoded_at_once_comes_in_order(monkeypatch, stack, tmp_path):
    monkeypatch.setattr("measure.footage.tiff_stack._AT_ONCE_BYTES", 4 * 48 * 64)
    cv2.imwritemulti(str(tmp_path / "stack.tif"), list(stack))
    assert np.array_equal(_frames(tmp_path / "stack.tif"), stack)


def test_spoilt_stacks_end_in_pictures_or_one_sentence(stack, tmp_path):
    cv2.imwritemulti(str(tmp_path / "stack.tif"), list(stack), [cv2.IMWRITE_TIFF_COMPRESSION, 1])
    data, rng = (tmp_path / "stack.tif").read_bytes(), np.random.default_rng(5)
    read = 0
    for n in range(40):
        spoilt = bytearray(data[: rng.integers(8, len(data))] if n % 2 else data)
        for place in rng.integers(len(spoilt), size=3):
            spoilt[place] = rng.integers(256)
        (tmp_path / "spoilt.tif").write_bytes(spoilt)
        try:
            read += len(_frames(tmp_path / "spoilt.tif"))
        except InputError:
            continue
    assert read > 20


def test_a_single_picture_is_no_film_and_a_stack_is_no_frame(stack, tmp_path):
    cv2.imwrite(str(tmp_path / "one.tif"), stack[0])
    with pytest.raises(InputError, match="is a single picture"):
        open_footage(tmp_path / "one.tif")
    for n in range(2):
        cv2.imwritemulti(str(tmp_path / f"s_{n}.tiff"), list(stack[:3]))
    (tmp_path / "one.tif").unlink()
    with pytest.raises(InputError, match="holds 3 pictures"):
        open_footage(tmp_path)


def test_a_folder_of_jpegs_is_a_film(stack, tmp_path):
    smooth = [cv2.GaussianBlur(picture, (0, 0), 3.0) for picture in stack]
    for n, picture in enumerate(smooth):
        cv2.imwrite(str(tmp_path / f"f_{n}.jpg"), picture, [cv2.IMWRITE_JPEG_QUALITY, 98, cv2.IMWRITE_JPEG_PROGRESSIVE, n % 2])
    assert np.abs(_frames(tmp_path).astype(int) - smooth).max() <= 4


@pytest.mark.parametrize("suffix", ["png", "tif", "bmp", "jpg"])
def test_the_size_is_known_before_decoding(suffix, stack, tmp_path):
    file = tmp_path / f"f.{suffix}"
    cv2.imwrite(str(file), stack[0])
    data = file.read_bytes()
    kind = picture_kind(data[:16])
    assert kind is not None
    assert picture_size(data, kind) == (64, 48)
    assert picture_size(data[:12], kind) is None
