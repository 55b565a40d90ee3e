"""What a file holds is found from its content; a result replaces a file of its own kind, and no other."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.common.file_kinds import (
    DATA,
    FIGURE,
    FILM,
    FITTED,
    HDF5,
    JSON,
    LOOP,
    MAPPING,
    MEASUREMENT,
    MODEL,
    PAGE,
    PICTURE,
    PROJECT,
    PYTHON,
    RUNS,
    TABLE,
    TOML,
    XML,
    kind_of,
    kind_written,
)
from measure.common.output import write_json, write_text
from measure.common.output_gate import Outputs
from measure.footage.writers import write_film

MODEL_TEXT = 'schema = 1\nname = "rig"\n[actuator]\nb_l_N = 2.79\n'
ROWS = "".join(f"{0.1 * k:.1f},{0.01 * k:.2f},2.8\n" for k in range(9))
CONTENTS = {
    "by hand": (MODEL_TEXT, MODEL),
    "fitted": (f'{MODEL_TEXT}[provenance]\ncommand = "fit-actuator"\n', FITTED),
    "list of runs": ('[[run]]\nfile = "a.csv"\n', RUNS),
    "project": ("schema = 1\n[film]\nfps = 250.0\n[platform]\nradius_m = 0.1\n", PROJECT),
    "mapping": ('[columns]\ntime = "t"\n[units]\ntime = "ms"\n', MAPPING),
    "other toml": ("[tool.ruff]\nline-length = 100\n", TOML),
    "result": ('{"verdict": "ok"}\n', JSON),
    "list in JSON": ("[1, 2]\n", JSON),
    "trajectory": (f"time_s,z_m,x_m\n{ROWS}", TABLE),
    "loop": (f"time_s,elongation_m,force_N\n{ROWS}", LOOP),
    "curve": (f"file,time_s,elongation_m,force_N,fitted_N\n{ROWS}", TABLE),
    "coefficients": ("name,coefficient_deg,variability_percent\nA,1.0,20.0\n", TABLE),
    "of a bench": (f"Test 4, 2024-05-06\nZeit;Weg;Kraft\n{ROWS.replace(',', ';')}", MEASUREMENT),
    "of a clock": ("".join(f"2024-05-06 09:00:0{k}\t{k}.5\t-2.8\n" for k in range(9)), MEASUREMENT),
    "in UTF-16": (f"Time\tLoad\n{ROWS.replace(',', chr(9))}".encode("utf-16"), MEASUREMENT),
    "page": ("<!DOCTYPE html>\n<html></html>", PAGE),
    "drawing": ('<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg"></svg>', FIGURE),
    "mechanism": ("<mujoco></mujoco>", XML),
    "figure": (b"\x89PNG\r\n\x1a\n\x00\x00", FIGURE),
    "photograph": (b"\xff\xd8\xff\xe0\x00", PICTURE),
    "of a camera": (b"\x00\x00\x00\x18ftypmp42\x00", FILM),
    "of a bench in HDF5": (b"\x89HDF\r\n\x1a\n\x00", HDF5),
    "raw": (bytes(range(256)), DATA),
    "words": ("the old result\n", None),
    "nothing": ("", None),
    "blanks": ("\n\n", None),
}


def laid(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("name", CONTENTS)
def test_the_kind_of_a_file_is_found_from_its_content(tmp_path, name):
    content, kind = CONTENTS[name]
    assert kind_of(laid(tmp_path / "anything.txt", content)) == kind


def test_a_film_and_a_program_are_known_too(tmp_path):
    write_film(tmp_path / "a.avi", np.zeros((3, 16, 16), dtype=np.uint8))
    assert kind_of(tmp_path / "a.avi") == FILM
    assert kind_of(laid(tmp_path / "own.py", "import math\n")) == PYTHON
    assert kind_of(tmp_path / "absent") is None


@pytest.mark.parametrize("option", ["--json", "--page", "--figure", "--marks", "--save-mapping"])
def test_a_result_replaces_only_what_is_of_its_own_kind(tmp_path, option):
    """A lab that types `--json rig.toml` keeps its rig.toml."""
    for name, (content, kind) in CONTENTS.items():
        path = laid(tmp_path / "old", content)
        outputs = Outputs({option: path})
        if kind in (None, kind_written(option, path)):
            outputs.require_usable()
            continue
        with pytest.raises(InputError, match=r"old: holds .*, and .* writes .*\. Name another file"), outputs.held():
            raise AssertionError(name)
        assert kind_of(path) == kind


def test_results_are_replaced_without_being_asked_whatever_they_are_called_and_without_a_note_beside_them(tmp_path):
    path = tmp_path / "result.toml"
    for count in range(2):
        outputs = Outputs({"--json": path}, {"--output": (tmp_path, ["fitted.toml"])})
        with outputs.held(), outputs.together():
            write_json(path, {"count": count})
            write_text(tmp_path / "fitted.toml", f"{MODEL_TEXT}[provenance]\ncount = {count}\n")
    assert kind_of(path) == JSON


def test_a_command_says_what_it_writes_where_the_ending_does_not(tmp_path):
    path = laid(tmp_path / "law", CONTENTS["loop"][0])
    Outputs({"--output": path}).require_usable()
    with pytest.raises(InputError, match="holds a measured loop, and --output writes a model"):
        Outputs({"--output": path}, kinds={"--output": FITTED}).require_usable()


def test_a_file_in_a_folder_of_results_is_kept_likewise(tmp_path):
    laid(tmp_path / "extended.toml", MODEL_TEXT)
    with pytest.raises(InputError, match=r"extended\.toml: holds a model that no command has written"):
        Outputs({}, {"--output": (tmp_path, ["report.html", "extended.toml"])}).require_usable()
