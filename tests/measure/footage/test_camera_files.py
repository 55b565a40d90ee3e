"""Films in the cameras' own formats, bit for bit."""

from __future__ import annotations

import struct
import time

import cv2
import numpy as np
import pytest

from measure.common.errors import InputError
from measure.correlation.tracking import track_marks
from measure.footage.formats import open_footage
from measure.footage.packed_pixels import unpack_10, unpack_12


def _frames(path):
    return [picture for _, picture in open_footage(path).pictures()]


def _picture(path) -> np.ndarray:
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    assert picture is not None
    return picture


def test_packed_pixels_come_apart_as_they_were_put_together():
    for bits, unpack in ((10, unpack_10), (12, unpack_12)):
        pixels = np.random.default_rng(bits).integers(0, 2**bits, 4096)
        text = "".join(f"{pixel:0{bits}b}" for pixel in pixels)
        packed = np.array([int(text[i : i + 8], 2) for i in range(0, len(text), 8)], np.uint8)
        assert np.array_equal(unpack(packed, 4096), pixels)


def test_cine_of_8_bit_is_bit_for_bit(real_footage):
    frames = _frames(real_footage / "cine" / "example_8bpp.cine")
    assert len(frames) == 11
    assert np.array_equal(frames[10], _picture(real_footage / "cine" / "example_8bpp_frame_11.tiff"))
    region = _picture(real_footage / "cine" / "example_8bpp_frame_10_roi_0.tiff")
    assert np.array_equal(frames[10][30:90, 70:170], region)
    mean = _picture(real_footage / "cine" / "avg_frame_8_bit.tif")
    assert np.array_equal(np.sum(frames, axis=0, dtype=int) // len(frames), mean)


def test_cine_of_packed_10_bit_is_bit_for_bit(real_footage):
    film = open_footage(real_footage / "cine" / "packed_12bpp.cine")
    frames = [picture for _, picture in film.pictures()]
    assert (film.bits, film.fps, film.exposure_s, len(frames)) == (10, 100.0, 99e-6, 6)
    eight = [np.rint(frame * (255.0 / 1023.0)).astype(np.uint8) for frame in frames]
    assert np.array_equal(eight[0], _picture(real_footage / "cine" / "packed_12bpp_frame_60.tiff"))
    assert np.array_equal(eight[0][17:37, 169:207], _picture(real_footage / "cine" / "packed_12bpp_frame_60_roi_1.tiff"))
    assert np.array_equal(eight[5][61:107, 84:173], _picture(real_footage / "cine" / "packed_12bpp_frame_65_roi_0.tiff"))


def test_cine_of_16_bit_is_bit_for_bit(real_footage):
    film = open_footage(real_footage / "cine" / "phantom_v7_raw_16bpp.cine")
    first = next(picture for _, picture in film.pictures())
    assert (film.bits, film.fps, film.exposure_s) == (12, 80.0, 0.012)
    assert first.max() > 255
    eight = np.floor(first * (255.0 / 4095.0)).astype(np.uint8)
    assert np.array_equal(eight, _picture(real_footage / "cine" / "phantom_v7_raw_16bpp_frame_238292.tiff"))
    region = _picture(real_footage / "cine" / "phantom_v7_raw_16bpp_frame_238292_roi_0.tiff")
    assert np.array_equal(eight[20:37, 38:63], region)


def test_a_cut_cine_promises_more_than_it_holds(real_footage, tmp_path):
    data = (real_footage / "cine" / "packed_12bpp.cine").read_bytes()
    (tmp_path / "cut.cine").write_bytes(data[: int(0.6 * len(data))])
    film = open_footage(tmp_path / "cut.cine")
    assert film.frames == 6 > len(list(film.pictures())) > 0
    (tmp_path / "stub.cine").write_bytes(data[:100])
    with pytest.raises(InputError, match="cut or damaged"):
        open_footage(tmp_path / "stub.cine")


def test_the_falling_ball_falls_straight(real_footage):
    film = open_footage(real_footage / "falling-ball-12bit" / "ball_12bit.mraw")
    assert (film.fps, film.exposure_s, film.bits, film.frames) == (30000.0, 2e-5, 12, 15)
    assert film.fps is not None
    marks = track_marks(film, [(176.0, 110.0)], film.fps, subset=145)
    assert marks.observed.all()
    for values, limit in ((marks.x_px[:, 0], 0.002), (marks.y_px[:, 0], 0.006)):
        straight = np.polyval(np.polyfit(marks.time_s, values, 1), marks.time_s)
        assert np.sqrt(np.mean((values - straight) ** 2)) < limit


@pytest.mark.parametrize(("bits", "side", "factor"), [(8, "Lower", 1), (12, "Lower", 1), (16, "Lower", 1), (16, "Higher", 16)])
def test_a_photron_film_with_plain_notes_is_bit_for_bit(bits, side, factor, tmp_path):
    effective = min(bits, 12)
    stack = np.random.default_rng(0).integers(0, 2**effective, (3, 20, 32)).astype(np.uint16)
    if bits == 12:
        pairs = stack.reshape(-1, 2)
        body = (
            np.stack([pairs[:, 0] >> 4, (pairs[:, 0] & 15) << 4 | pairs[:, 1] >> 8, pairs[:, 1] & 255], axis=1).astype(np.uint8).tobytes()
        )
    else:
        body = (stack * factor).astype("<u2" if bits == 16 else np.uint8).tobytes()
    (tmp_path / "film.mraw").write_bytes(body)
    (tmp_path / "film.cih").write_text(
        "#Camera Information Header\nRecord Rate(fps) : 500\nShutter Speed(s) : 1/2000\nTotal Frame : 3\nImage Width : 32\n"
        f"Image Height : 20\nColor Bit : {bits}\nEffectiveBit Depth : {effective}\nEffectiveBit Side : {side}\n"
    )
    film = open_footage(tmp_path / "film.mraw")
    assert (film.fps, film.exposure_s, film.bits, film.remarks) == (500.0, 0.0005, effective, ())
    assert np.array_equal([picture for _, picture in film.pictures()], stack)
    (tmp_path / "film.mraw").write_bytes(body[: len(body) // 2])
    assert "promise" in open_footage(tmp_path / "film.cih").remarks[0]


def test_a_photron_film_without_its_notes_cannot_be_read(tmp_path):
    (tmp_path / "film.mraw").write_bytes(bytes(1000))
    with pytest.raises(InputError, match="not beside it"):
        open_footage(tmp_path / "film.mraw")
    (tmp_path / "film.cih").write_text("Image Width : 10\n")
    with pytest.raises(InputError, match="no value for Image Height"):
        open_footage(tmp_path / "film.mraw")


def test_a_cine_that_claims_a_gigapixel_is_refused(tmp_path):
    header = struct.pack("<2sHHHiIiIIIIQ", b"CI", 44, 0, 1, 0, 1, 0, 1, 44, 0, 84, 0)
    bitmap = struct.pack("<IiiHHIIiiII", 40, 60000, 60000, 1, 8, 0, 0, 0, 0, 0, 0)
    (tmp_path / "big.cine").write_bytes(header + bitmap + bytes(64))
    with pytest.raises(InputError, match="60000 x 60000"):
        open_footage(tmp_path / "big.cine")


NOTES = {
    "Record Rate(fps)": "500",
    "Shutter Speed(s)": "1/2000",
    "Total Frame": "3",
    "Image Width": "32",
    "Image Height": "20",
    "Color Bit": "8",
}


def with_notes(folder, **odd):
    """A film of three dark pictures with a line of its notes changed."""
    (folder / "film.mraw").write_bytes(bytes(3 * 20 * 32))
    lines = {**NOTES, **{key.replace("_", " "): value for key, value in odd.items()}}
    (folder / "film.cih").write_text("#Camera Information Header\n" + "".join(f"{key} : {value}\n" for key, value in lines.items()))
    return folder / "film.cih"


@pytest.mark.parametrize("shutter", ["1e999999999", "1/1e999999999", "1e999999999/1", "9" * 100_000, "1_0", "nan"])
def test_a_shutter_that_no_camera_has_is_unknown_at_once(tmp_path, shutter):
    begun = time.process_time()
    assert open_footage(with_notes(tmp_path, **{"Shutter Speed(s)": shutter})).exposure_s is None
    assert time.process_time() - begun < 0.5


@pytest.mark.parametrize("key", ["Total_Frame", "Image_Width", "Color_Bit"])
@pytest.mark.parametrize("value", ["1e999", "1_0", "nan", "٣", "9" * 100_000])
def test_a_note_that_is_no_plain_number_is_refused_by_its_name(tmp_path, key, value):
    with pytest.raises(InputError, match=f"{key.replace('_', ' ')} is .*not a number"):
        open_footage(with_notes(tmp_path, **{key: value}))


@pytest.mark.parametrize(
    ("shutter", "exposure_s"), [("1/2000", 5e-4), ("2000", 5e-4), ("0.0005", 5e-4), ("2/4", 0.5), ("1", 1.0), ("0", None)]
)
def test_a_shutter_is_a_fraction_its_denominator_or_seconds(tmp_path, shutter, exposure_s):
    assert open_footage(with_notes(tmp_path, **{"Shutter Speed(s)": shutter})).exposure_s == (exposure_s and pytest.approx(exposure_s))


def test_notes_in_xml_count_before_plain_ones_and_nanoseconds_before_a_fraction(tmp_path):
    path = with_notes(tmp_path)
    size = "<resolution><width>16</width><height>30</height></resolution><colorInfo><bit>16</bit></colorInfo>"
    effective = "<effectiveBit><depth>10</depth><side>Higher</side></effectiveBit>"
    record = (
        "<recordInfo><recordRate>750</recordRate><shutterSpeed>50</shutterSpeed><shutterSpeedNsec>20000</shutterSpeedNsec></recordInfo>"
    )
    frames = "<frameInfo><totalFrame>2</totalFrame></frameInfo>"
    path.with_suffix(".cihx").write_text(f"junk<cih>{frames}{record}<imageDataInfo>{size}{effective}</imageDataInfo></cih>rest")
    film = open_footage(tmp_path / "film.mraw")
    assert (film.width, film.height, film.frames, film.bits, film.fps, film.exposure_s) == (16, 30, 2, 10, 750.0, pytest.approx(2e-5))
    assert film.remarks == ()
    values = np.arange(2 * 16 * 30).reshape(2, 30, 16)
    (tmp_path / "film.mraw").write_bytes((values << 6).astype("<u2").tobytes())
    assert np.array_equal([picture for _, picture in open_footage(tmp_path / "film.mraw").pictures()], values)


@pytest.mark.parametrize(("key", "value"), [("Color Bit", "10"), ("Total Frame", "0"), ("Record Rate(fps)", "0")])
def test_notes_of_no_film_are_refused(tmp_path, key, value):
    with pytest.raises(InputError, match="grey films of 8, 12 or 16 bit are read"):
        open_footage(with_notes(tmp_path, **{key: value}))


def test_notes_that_declare_entities_are_refused(tmp_path):
    path = with_notes(tmp_path).with_suffix(".cihx")
    path.write_text('junk<cih><!ENTITY b "c">&b;</cih>')
    with pytest.raises(InputError, match="declares entities"):
        open_footage(path)


@pytest.mark.parametrize("line", ["a" + " " * 200_000 + "b", " " * 200_000, "a:" + " " * 200_000 + "b c", "a" * 200_000])
def test_a_long_line_in_the_notes_does_not_take_the_square_of_its_length(tmp_path, line):
    path = with_notes(tmp_path)
    path.write_text(path.read_text() + line + "\n")
    begun = time.process_time()
    assert open_footage(path).frames == 3
    assert time.process_time() - begun < 2.0
