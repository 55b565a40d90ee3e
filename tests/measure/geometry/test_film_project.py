"""The project file of a film: all that is wrong at once, what is written is read back, a schema for editors."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from measure.common.errors import InputError
from measure.geometry.film_project import json_schema, make_project, project_text, read_project, write_project

WRONG = """schema = 2
colour = 3
[film]
fsp = 3
fps = -1.0
[marks]
place_px = [[70, 30], [1], ["a", 2]]
warp = "afine"
[scale]
from_px_mm = [1, 2, 3, 4, 0]
[platfrom]
x = 1
[camera]
distortion = [1, 2, 3, 4, 5, 6]
"""


def test_everything_that_is_wrong_is_said_at_once(tmp_path):
    (tmp_path / "p.toml").write_text(WRONG)
    with pytest.raises(InputError) as refused:
        read_project(tmp_path / "p.toml")
    said = str(refused.value).splitlines()
    assert said[0].startswith(str(tmp_path / "p.toml"))
    expected = (
        "schema should be less than or equal to 1, found 2",
        'unknown key "colour"',
        'unknown key "film.fsp"; did you mean "fps"?',
        "film.fps should be greater than 0, found -1.0",
        "marks.place_px, entry 2, entry 2 is missing",
        "marks.place_px, entry 3, entry 1 should be a valid number, found 'a'",
        "marks.warp should be 'translation', 'euclidean' or 'affine', found 'afine'",
        "scale.from_px_mm, entry 5 should be greater than 0, found 0",
        'unknown key "platfrom"; did you mean "platform"?',
        "camera.distortion should have at most 5 numbers",
    )
    assert len(said) == len(expected)
    for sentence in expected:
        assert any(sentence in line for line in said), sentence


@pytest.mark.parametrize("text", ["fps = ", "[film]\nfps = 1\nfps = 2\n", "\x00"])
def test_what_is_not_toml_is_said_with_its_line(text, tmp_path):
    (tmp_path / "p.toml").write_text(text)
    with pytest.raises(InputError, match="is not TOML"):
        read_project(tmp_path / "p.toml")


_length = st.floats(1e-6, 1e6)
_pixel = st.floats(-1e6, 1e6)
_tables = st.fixed_dictionaries(
    {},
    optional={
        "film": st.fixed_dictionaries({}, optional={"fps": _length, "exposure_s": _length, "file": st.text(min_size=1)}),
        "marks": st.fixed_dictionaries({}, optional={"place_px": st.lists(st.tuples(_pixel, _pixel)), "subset_px": st.integers(9, 301)}),
        "scale": st.fixed_dictionaries({}, optional={"mm_per_px": _length, "up_deg": st.floats(-180, 180), "depth_mm": _pixel}),
        "camera": st.fixed_dictionaries({}, optional={"distance_m": _length, "distortion": st.lists(st.floats(-1, 1), max_size=5)}),
    },
)


@given(_tables)
def test_what_is_written_is_read_back_to_the_last_digit(tables):
    project = make_project(tables)
    assert make_project(tomllib.loads(project_text(project))) == project


def test_a_file_saved_by_an_editor_with_a_byte_order_mark_is_read(tmp_path):
    write_project(make_project({"film": {"fps": 250.0}}), tmp_path / "p.toml")
    (tmp_path / "p.toml").write_bytes(b"\xef\xbb\xbf" + (tmp_path / "p.toml").read_bytes())
    assert read_project(tmp_path / "p.toml").film.fps == 250.0


def test_the_schema_names_every_key_and_says_what_it_is():
    schema = json_schema()
    for section in schema["$defs"].values():
        assert section["additionalProperties"] is False
        for key, rules in section["properties"].items():
            assert len(rules["description"]) > 3, key
    assert set(schema["properties"]) == {"schema", "film", "marks", "scale", "platform", "camera"}


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        *(("film", "fps", value) for value in (True, "250", "1_0", [250.0])),
        *(("marks", "subset_px", value) for value in (True, "31", 31.5)),
        ("marks", "place_px", [[True, 2.0]]),
        ("scale", "from_px_mm", [0.0, 0.0, 9.0, 9.0, "1"]),
        *((section, key, True) for section, key in (("scale", "up_deg"), ("platform", "start_height_m"), ("camera", "focal_px"))),
        ("camera", "distortion", [0.1, True]),
        ("film", "fields", 1),
        ("film", "fields", "yes"),
    ],
)
def test_a_number_is_no_truth_value_and_not_in_quotes(section, key, value):
    with pytest.raises(InputError, match=f"{section}.{key}"):
        make_project({section: {key: value}})
