"""Whatever bytes a file holds, the reader gives a loop or one sentence."""

import json
import random

import h5py
import numpy as np
import pytest
import xlwt
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from measure import InputError, Loop
from measure.readers.column_mapping import ColumnMapping
from measure.readers.loop_file import read_loop_file

_T = np.arange(30) * 0.1
_TABLE = np.stack([_T, 12.0 * np.sin(_T), 2.8 + 0.1 * np.cos(_T)], axis=1)
_PIECES = [
    b",",
    b";",
    b"\t",
    b"\n",
    b"\r",
    b'"',
    b"'",
    b"nan",
    b"inf",
    b"1e999",
    b"-",
    b".",
    b",,",
    b"\xff",
    b"\x00",
    b"\xef\xbb\xbf",
    b"kN",
    b"=1+1",
    b"\n\n",
    b"#",
    b"1,000",
    b"{",
    b"]",
    b"Cycle\n",
    b"03:04:05",
    b"2025-01-02 ",
]
_MAPPINGS = [
    ColumnMapping(),
    ColumnMapping({"time": "1", "elongation": "2", "force": "3"}, {"time": "s", "elongation": "mm", "force": "N"}),
]


def seeds(folder):
    header = "time_s,elongation_mm,force_N\n"
    body = "\n".join(",".join(f"{value:.4f}" for value in row) for row in _TABLE) + "\n"
    texts = [header + body, body, (header + body).replace(",", ";").replace(".", ","), (header + "s,mm,N\n" + body).replace(",", "\t")]
    wide = [texts[0].encode("utf-16"), texts[0].encode("utf-16-le"), ("时间" + texts[0]).encode("gb18030")]
    return [text.encode() for text in [*texts, *of_benches(header, body)]] + [*wide, *of_labview(folder)]


def of_benches(header, body):
    """Blocks with text between them, date-time stamps, and JSON as rows, records and columns."""
    lines = body.splitlines()
    blocks = [f"Cycle {k}\nPoints,10\n{header}" + "\n".join(lines[k : k + 10]) + "\n\n" for k in (0, 10, 20)]
    stamped = "Date,Time,Weg (mm),Kraft (N)\n" + "\n".join(f"2025-01-02,03:04:{line}" for line in lines)
    names = header.strip().split(",")
    rows = _TABLE.tolist()
    columns = {name: list(column) for name, column in zip(names, _TABLE.T.tolist(), strict=True)}
    documents = [{"data": rows}, {"columns": names, "data": rows}, [dict(zip(names, row, strict=True)) for row in rows], {"a": columns}]
    return ["MTS\n" + "".join(blocks), stamped, *map(json.dumps, documents)]


def seeds_read_apart(folder):
    """MATLAB's file, packed and plain, HDF5's, and an old workbook."""
    columns = dict(zip(("time_s", "elongation_mm", "force_N"), _TABLE.T, strict=True))
    for packed in (False, True):
        savemat(folder / f"{packed}.mat", columns, do_compression=packed)
    with h5py.File(folder / "seed.h5", "w") as file:
        for name, values in columns.items():
            file.create_dataset(name, data=values, compression="gzip" if name == "force" else None).attrs["units"] = "mm"
    book = xlwt.Workbook()
    sheet = book.add_sheet("Data")
    for c, (name, values) in enumerate(columns.items()):
        for r, cell in enumerate([name, *values.tolist()]):
            sheet.write(r, c, cell)
    book.save(folder / "seed.xls")
    return [(folder / name).read_bytes() for name in ("False.mat", "True.mat", "seed.h5", "seed.xls")]


def of_labview(folder):
    """LabVIEW's binary and text file."""
    columns = dict(zip(("time", "elongation", "force"), _TABLE.T, strict=True))
    with TdmsWriter(folder / "seed.tdms") as writer:
        writer.write_segment([ChannelObject("Test", name, values, {"unit_string": "mm"}) for name, values in columns.items()])
    rows = "\n".join("\t".join(f"{value:.4f}" for value in row) for row in _TABLE)
    head = "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\t\n\t\nChannels\t2\t\nSamples\t30\t30\n"
    lvm = head + "Y_Unit_Label\tmm\tN\nX0\t0.0\t0.0\nDelta_X\t0.1\t0.1\n***End_of_Header***\t\t\nX_Value\telongation\tforce\n" + rows
    return [(folder / "seed.tdms").read_bytes(), lvm.encode()]


def mutated(raw, rng):
    data = bytearray(raw)
    for _ in range(rng.randint(1, 6)):
        place = rng.randrange(len(data) + 1)
        kind = rng.randrange(5)
        if kind == 0:
            data[place:place] = rng.choice(_PIECES)
        elif kind == 1:
            del data[place : place + rng.randint(1, 40)]
        elif kind == 2 and place < len(data):
            data[place] = rng.randrange(256)
        elif kind == 3:
            data = data[:place] or data
        else:
            data[place:place] = data[place : place + rng.randint(1, 60)]
    return bytes(data)


def fuzz(folder, sources, rounds, seed):
    """Read damaged copies of the sources; returns how many were still read."""
    rng, good = random.Random(seed), 0
    for _ in range(rounds):
        path = folder / "fuzzed.csv"
        path.write_bytes(mutated(rng.choice(sources), rng))
        try:
            loop, understood = read_loop_file(path, rng.choice(_MAPPINGS))
        except InputError:
            continue
        assert isinstance(loop, Loop)
        assert understood.sentences()
        good += 1
    return good


def test_damaged_files_end_in_a_loop_or_one_sentence(tmp_path):
    assert fuzz(tmp_path, seeds(tmp_path), 200, seed=1) > 0


@pytest.mark.calibrate
def test_damaged_files_of_another_seed_do_too(tmp_path, calibration_seed, share_of):
    fuzz(tmp_path, seeds(tmp_path), share_of(10_000), calibration_seed)


@pytest.mark.calibrate
def test_damaged_files_that_are_read_in_a_process_of_its_own_do_too(tmp_path, calibration_seed, share_of):
    fuzz(tmp_path, seeds_read_apart(tmp_path), share_of(400), calibration_seed)
