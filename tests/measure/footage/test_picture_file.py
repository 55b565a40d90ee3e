"""Picture files: what they are, how large, and what their grey values are."""

from __future__ import annotations

import struct

import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.footage.picture_file import in_whole_levels, picture_kind, picture_size, read_mask, read_picture, to_grey, whole_levels

GREY = np.random.default_rng(0).integers(0, 255, (20, 33), dtype=np.uint8)
KINDS = {".png": "png", ".tif": "tiff", ".bmp": "bmp", ".jpg": "jpeg"}


@pytest.mark.parametrize("suffix", KINDS)
def test_kind_and_size_stand_in_the_first_bytes(suffix):
    data = cv2.imencode(suffix, GREY)[1].tobytes()
    assert picture_kind(data[:16]) == KINDS[suffix]
    assert picture_size(data, KINDS[suffix]) == (33, 20)
    assert picture_size(data[:12], KINDS[suffix]) is None


def test_a_bmp_with_its_highest_row_first_and_a_jpeg_with_a_long_comment_have_their_size():
    bmp = bytearray(cv2.imencode(".bmp", GREY)[1].tobytes())
    bmp[22:26] = struct.pack("<i", -20)
    assert picture_size(bytes(bmp), "bmp") == (33, 20)
    jpeg = cv2.imencode(".jpg", GREY)[1].tobytes()
    comment = b"\xff\xfe" + struct.pack(">H", 5 + 2) + b"\xff\xc0\0\0\0"
    assert picture_size(jpeg[:2] + comment + jpeg[2:], "jpeg") == (33, 20)
    assert picture_size(jpeg[:2] + b"\x00" + jpeg[3:], "jpeg") is None


def test_what_is_no_picture_has_no_kind():
    for head in (b"GIF89a", b"\x89PX", b"\xff\xd8\x00", b"BN00", b"    "):
        assert picture_kind(head) is None


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32, np.float64])
def test_colours_are_weighted_as_the_eye_does_and_a_fourth_channel_counts_nothing(dtype):
    """Rec. 601: 0.299 red, 0.587 green, 0.114 blue; OpenCV has blue first."""
    blue, green, red = (np.full((2, 2), value, dtype) for value in (200, 100, 50))
    expected = 0.114 * 200 + 0.587 * 100 + 0.299 * 50
    for rest in ([], [np.full((2, 2), 255, dtype)]):
        grey = to_grey(np.stack([blue, green, red, *rest], axis=-1))
        assert grey == pytest.approx(np.full((2, 2), expected), abs=0.51 if np.dtype(dtype).kind == "u" else 0.05)
    assert np.array_equal(to_grey(green), green)  # type: ignore[arg-type]
    assert np.array_equal(to_grey(np.stack([green, blue], axis=-1)), green)  # type: ignore[arg-type]


def test_a_type_of_number_that_no_camera_writes_is_none():
    assert to_grey(np.zeros((2, 2), np.int16)) is None


def test_a_picture_of_another_size_and_what_is_none_is_refused(tmp_path):
    path = tmp_path / "a.png"
    cv2.imwrite(str(path), GREY)
    assert np.array_equal(read_picture(path, (33, 20)), GREY)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="is 33 x 20 px, the film 20 x 33 px"):
        read_picture(path, (20, 33), "the film")
    path.write_bytes(b"no picture at all")
    with pytest.raises(InputError, match=r"is not a \.png picture"):
        read_picture(path)
    path.write_bytes(cv2.imencode(".png", GREY)[1].tobytes()[:20])
    assert read_picture(path) is None


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65535), (np.float32, 1.0)])
def test_white_pixels_of_a_mask_belong_to_marks_and_half_grey_ones_do_not(tmp_path, dtype, white):
    mask = np.zeros((20, 33), dtype)
    mask[3:9, 4:20] = white
    mask[12:14, 4:20] = dtype(0.498 * white)
    mask[16:18, 4:20] = dtype(0.51 * white)
    path = tmp_path / "mask.tif"
    cv2.imwrite(str(path), mask)
    found = read_mask(path, 33, 20)
    expected = np.zeros((20, 33), bool)
    expected[3:9, 4:20] = expected[16:18, 4:20] = True
    assert np.array_equal(found, expected)
    with pytest.raises(InputError, match="the film 33 x 21 px"):
        read_mask(path, 33, 21)


def test_whole_numbers_stay_and_fractions_take_the_middle_half_of_sixteen_bits():
    assert whole_levels(GREY) == (1.0, 0.0)
    for unchanged in ([[0.0, 64.0]], [[0.0, 65535.0]], [[5.0, 5.0]]):
        assert whole_levels(np.array(unchanged)) == (1.0, 0.0)
    for spread in ([[0.0, 63.0]], [[-1.0, 80.0]], [[0.0, 65536.0]], [[0.5, 80.0]], [[0.1, 0.9]]):
        values = np.array(spread)
        assert in_whole_levels(values, whole_levels(values)) == pytest.approx(np.array([[16384, 49152]]))


def test_levels_are_rounded_and_kept_within_sixteen_bits_and_what_is_no_number_is_none():
    assert in_whole_levels(np.array([[-3.0, 1.4, 1.6, 70000.0]]), (1.0, 0.0)).tolist() == [[0, 1, 2, 65535]]  # type: ignore[union-attr]
    assert in_whole_levels(np.array([[1.0, np.nan]]), (1.0, 0.0)) is None
    assert in_whole_levels(GREY, (7.0, 7.0)) is GREY
