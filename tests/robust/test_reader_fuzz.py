"""Whatever stands in a file, every reader gives its content or one sentence: drawn files, text and binary, of each kind that is read."""

from __future__ import annotations

import copy
import json
import shutil
import time
import tomllib
import warnings
from dataclasses import dataclass
from typing import Any

import c3d
import cv2
import h5py
import numpy as np
import pytest
import tomli_w
from fuzzing import damaged, documents, drawn, drawn_for, read_or_refused, text_tables
from hypothesis import strategies as st
from odd_inputs import DEMO, ROOT, moving_pictures, places_in
from scipy.io import savemat

from identify.campaign.campaign_file import read_list
from identify.campaign.runs import read_campaign
from measure.footage.formats import open_footage
from measure.footage.writers import write_film
from measure.geometry.film_project import read_project
from measure.readers.column_mapping import ColumnMapping, read_mapping
from measure.readers.loop_file import read_loop_file
from measure.readers.measurement import read_measurement
from simulate.files.model_file import read_model

MINUTES = 10
NOTE = "Neither read nor refused: a traceback, or 20 s of processor time without an end. It is to be 0, or the test fails."
EXAMPLES = {"text": 25, "documents": 25, "films": 15, "read apart": 3}
MAPPED = ColumnMapping({"time": "1", "elongation": "2", "force": "3"}, {"time": "s", "elongation": "mm", "force": "N"})


@dataclass
class Kind:
    """Files of one kind: what they are, how they are drawn, their ending, and what reads them."""

    name: str
    strategy: Any
    ending: str
    read: Any


def pictures_of(path):
    """Read a film as commands do, but only its beginning."""
    footage = open_footage(path)
    for _, (_, picture) in zip(range(5), footage.pictures(), strict=False):
        assert np.asarray(picture).size


def second_picture(path):
    """Read a picture as the second of a folder whose first is good."""
    frames = path.parent / "frames"
    shutil.rmtree(frames, ignore_errors=True)
    frames.mkdir()
    shutil.copy(path.parent / f"a{path.suffix}", frames / f"frame1{path.suffix}")
    shutil.copy(path, frames / f"frame2{path.suffix}")
    pictures_of(frames)


def text_kinds(folder):
    records = [{"time_s": 0.1 * k, "elongation_m": 0.01 * k, "force_N": 2.8} for k in range(12)]
    seeds = [json.dumps(records).encode(), json.dumps({"data": [list(row.values()) for row in records]}).encode()]
    lvm = "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t2\t\nSamples\t3\t3\n***End_of_Header***\t\t\n"
    seeds.append((lvm + "X_Value\tA\tB\n" + "\n".join(f"{k}\t{k}\t2.8" for k in range(9))).encode())
    yield Kind("loop", text_tables(), ".csv", lambda path: read_loop_file(path, ColumnMapping()))
    yield Kind("loop with a mapping", text_tables(), ".txt", lambda path: read_loop_file(path, MAPPED))
    yield Kind("loop or trajectory", text_tables(), ".csv", read_measurement)
    trc = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tUnits\n100\tmm\nFrame#\tTime\tA\t\t\tB\t\t\tC\n\t\tX1\tY1\tZ1\n\n"
    trc += "\n".join(f"{k}\t{k / 100}\t0\t1\t{k}\t100\t0\t{k}\t0\t100\t{k}" for k in range(1, 9))
    yield Kind("TRC, damaged", damaged([trc.encode()]), ".trc", lambda path: read_measurement(path, ColumnMapping(up="z")))
    track = "mass_A\t\t\nt\tx\ty\n" + "\n".join(f"{k / 100:.9E}\t1.0E-1\t{k / 10:.9E}" for k in range(9))
    in_metres = ColumnMapping(units={"position": "m"})
    yield Kind("Tracker's table, damaged", damaged([track.encode()]), ".txt", lambda path: read_measurement(path, in_metres))
    yield Kind("JSON or LabVIEW text, damaged", damaged(seeds), ".json", lambda path: read_loop_file(path, ColumnMapping()))


def document_kinds(folder):
    campaign = '[[run]]\nfile = "a.csv"\nhold_out = true\n[run.model]\nplatform.mass_kg = 1.0\n'
    mapping = '[columns]\ntime = "t"\nforce = "F"\n[units]\ntime = "ms"\nforce = "kN"\n'
    for name, text, read in (
        ("model", (ROOT / "datasets" / "prototype.toml").read_text(encoding="utf-8"), read_model),
        ("film project", (DEMO / "film.toml").read_text(encoding="utf-8"), read_project),
        ("campaign", campaign, read_list),
        ("mapping", mapping, read_mapping),
    ):
        good = tomllib.loads(text)
        documented = documents(lambda good=good: copy.deepcopy(good), list(places_in(good)))
        yield Kind(name, documented.map(lambda document: tomli_w.dumps(document).encode("utf-8", "replace")), ".toml", read)
        yield Kind(f"{name}, damaged", damaged([text.encode()]), ".toml", read)
    rows = "".join(f"{k / 250},{0.25 + k**2 / 4000}\n" for k in range(12))
    (folder / "a.csv").write_text(f"time_s,z_m\n{rows}")
    runs = damaged([b'[[run]]\nfile = "a.csv"\n'])
    yield Kind("campaign with its runs, damaged", runs, ".toml", lambda path: read_campaign([path]))


def film_kinds(folder):
    pictures = list(moving_pictures(np.random.default_rng(4)))
    write_film(folder / "a.avi", pictures)
    cv2.imwrite(str(folder / "a.png"), pictures[0])
    cv2.imwrite(str(folder / "a.jpg"), pictures[0])
    cv2.imwritemulti(str(folder / "a.tif"), pictures)
    for name, read in (("a.avi", pictures_of), ("a.png", second_picture), ("a.jpg", second_picture), ("a.tif", pictures_of)):
        yield Kind(f"{name[2:]} film", damaged([(folder / name).read_bytes()]), name[1:], read)
    (folder / "film.mraw").write_bytes(bytes(6 * 64 * 64))
    size = "Total Frame : 6\nImage Width : 64\nImage Height : 64\nColor Bit : 8\nFile Format : MRaw\n"
    head = "#Camera Information Header\nRecord Rate(fps) : 1000\n" + size
    yield Kind("cih film", damaged([head.encode()]), ".cih", pictures_of)


def read_apart_kinds(folder):
    table = {"time_s": np.arange(30) * 0.1, "elongation_m": np.sin(np.arange(30)), "force_N": np.cos(np.arange(30))}
    savemat(folder / "a.mat", table)
    with h5py.File(folder / "a.h5", "w") as file:
        for name, values in table.items():
            file[name] = values
    write_points(folder / "a.c3d")
    up = ColumnMapping(up="z")
    yield Kind("c3d points", damaged([(folder / "a.c3d").read_bytes()]), ".c3d", lambda path: read_measurement(path, up))
    for name in ("a.mat", "a.h5"):
        content = (folder / name).read_bytes()
        yield Kind(f"{name[2:]} table", damaged([content]), name[1:], lambda path: read_loop_file(path, ColumnMapping()))


def write_points(path):
    writer = c3d.Writer(point_rate=100.0)
    writer.set_point_labels(["A", "B", "C"])
    place = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]])
    writer.add_frames([(np.pad(place + k, ((0, 0), (0, 2))).astype(np.float32), np.zeros((0, 0))) for k in range(8)])
    with open(path, "wb") as file, warnings.catch_warnings(action="ignore"):
        writer.write(file)


KINDS = {"text": text_kinds, "documents": document_kinds, "films": film_kinds, "read apart": read_apart_kinds}


def tried(folder, group):
    """A strategy for the files of a group, the check of one, and how many of each kind were read and refused so far."""
    kinds = list(KINDS[group](folder))
    strategy = st.integers(0, len(kinds) - 1).flatmap(lambda k: st.tuples(st.just(k), kinds[k].strategy))
    counts = {kind.name: {"read": 0, "refused": 0, "neither": 0} for kind in kinds}

    def check(example):
        kind, content = kinds[example[0]], example[1]
        path = folder / f"film{kind.ending}"
        path.write_bytes(content)
        fate = "neither"
        try:
            fate = "read" if read_or_refused(kind.read, path) else "refused"
        finally:
            counts[kind.name][fate] += 1

    return strategy, check, counts


@pytest.mark.parametrize("group", sorted(KINDS))
def test_a_drawn_file_is_read_or_refused_in_a_sentence(tmp_path, group):
    strategy, check, _ = tried(tmp_path, group)
    drawn(strategy, check, EXAMPLES[group], seed=1)


@pytest.mark.calibrate
@pytest.mark.parametrize("group", sorted(KINDS))
def test_ten_minutes_of_drawn_files_are_read_or_refused_in_a_sentence(tmp_path, group, share_of, calibration_seed, validation_table):
    strategy, check, counts = tried(tmp_path, group)
    begun = time.monotonic()
    try:
        drawn_for(strategy, check, share_of(60 * MINUTES), calibration_seed)
    finally:
        minutes = (time.monotonic() - begun) / 60
        rows = [{"kind": name, "files": sum(fates.values()), **fates} for name, fates in counts.items()]
        total = {"kind": f"all, in {minutes:.1f} minutes", **{name: sum(row[name] for row in rows) for name in list(rows[0])[1:]}}
        validation_table(f"Drawn files: {group}", [*rows, total], NOTE)
