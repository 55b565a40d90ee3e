"""What is written in any dialect is read back bit for bit, and the fast and the explaining way through a file say the same."""

from __future__ import annotations

import random
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from measure import InputError, read_table
from measure.readers.column_mapping import ColumnMapping
from measure.readers.column_names import name_fits
from measure.readers.loop_file import read_loop_file
from measure.readers.stated_conditions import conditions
from measure.tables import number_columns
from measure.tables.frames import unit_in_name
from measure.tables.number_columns import Dialect, NumberColumns, RaggedRow
from measure.tables.units import split_unit

DELIMITERS = {"tab": "\t", "semicolon": ";", "comma": ",", "bar": "|", "space": "  "}
ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "cp1252"]
NUMBERED = ColumnMapping({"time": "1", "elongation": "2", "force": "3"}, {"time": "s", "elongation": "m", "force": "N"})
finite = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def samples(draw):
    """A time that increases, an elongation and a force of any finite bits, (32, 3)."""
    columns = [np.resize(draw(st.lists(finite, min_size=1, max_size=9)), 32) for _ in range(2)]
    return np.column_stack([draw(st.floats(1e-9, 1e9)) * np.arange(32.0), *columns])


def text_of(table, delimiter, decimal, quoted, header):
    """The table as a laboratory would write it; shortest digits that mean the same bits."""
    cells = [[repr(float(value)).replace(".", "," if decimal == "comma" else ".") for value in row] for row in table]
    quote = '"' if quoted else ""
    rows = [[f"{quote}{cell}{quote}" for cell in row] for row in [*([["time", "elongation", "force"]] if header else []), *cells]]
    return "\n".join(DELIMITERS[delimiter].join(row) for row in rows) + "\n"


def outcome(read, path):
    """The bits of the numbers, or the sentence that a file is refused with."""
    try:
        found = read(path)
    except InputError as error:
        return str(error)
    loop = found[0] if isinstance(found, tuple) else found
    columns = loop.to_frame().to_numpy()
    return columns.tobytes() if columns.dtype == float else repr(columns.tolist())


@pytest.mark.parametrize("quoted", [False, True])
@pytest.mark.parametrize("decimal", ["point", "comma"])
@pytest.mark.parametrize("delimiter", DELIMITERS)
@settings(max_examples=10)
@given(
    table=samples(), header=st.booleans(), encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "cp1252"]), end=st.sampled_from("\n\r")
)
def test_what_is_written_in_a_dialect_is_read_back_bit_for_bit(delimiter, decimal, quoted, table, header, encoding, end):
    quotes = (quoted or (delimiter, decimal) == ("comma", "comma")) and delimiter != "space"
    mapping = ColumnMapping(NUMBERED.columns, NUMBERED.units, delimiter, decimal, header=header)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bench.txt"
        path.write_bytes(text_of(table, delimiter, decimal, quotes, header).replace("\n", end).encode(encoding))
        loop, _ = read_loop_file(path, mapping)
    assert loop.to_frame().to_numpy().tobytes() == table.tobytes()


PIECES = [",", ";", "\t", "\n", '"', "nan", "inf", "1e999", "-", ".", ",,", "1_0", "\u00a0", "\u0661", "\x0c", "#", "0x1", " ", "e", "+"]


def mutated(text, rng):
    for _ in range(rng.randint(1, 3)):
        place = rng.randrange(len(text) + 1)
        kind = rng.randrange(4)
        if kind < 2:
            text = text[:place] + rng.choice(PIECES) + text[place:]
        elif kind == 2:
            text = text[:place] + text[place + rng.randint(1, 9) :]
        else:
            text = text[:place] or text
    return text


@pytest.mark.parametrize("seed", range(4))
def test_the_fast_and_the_explaining_way_say_the_same_of_damaged_files(tmp_path, monkeypatch, seed):
    rng = random.Random(seed)
    table = np.column_stack([np.arange(30) * 0.5, np.sin(np.arange(30.0)), np.cos(np.arange(30.0))])
    own = text_of(table, "comma", "point", False, False)
    texts = [
        "time_s,elongation_m,force_N\n" + own,
        text_of(table, "semicolon", "comma", False, True),
        text_of(table, "space", "point", False, True),
    ]
    for _ in range(60):
        path = tmp_path / "table.csv"
        path.write_text(mutated(rng.choice(texts), rng), encoding="utf-8")
        for read in (read_table, lambda path: read_loop_file(path, NUMBERED), read_loop_file):
            fast = outcome(read, path)
            with monkeypatch.context() as patch:
                patch.setattr(number_columns, "_plain_block", lambda *_: None)
                assert outcome(read, path) == fast


def taken(lines, dialect, fast):
    """The bits, the odd cells, or the ragged row of two columns."""
    columns = NumberColumns(2, len(lines), dialect)
    try:
        columns.add_lines(lines) if fast else columns.add_rows(dialect.rows(lines))
    except RaggedRow as error:
        return error.row, error.found
    return columns.values.tobytes(), columns.odd, columns.filled


@pytest.mark.parametrize("dialect", [Dialect(), Dialect(";", True), Dialect(None)])
def test_no_character_is_read_in_two_ways(dialect):
    between = dialect.separator or " "
    for code in (*range(1, 0x300), *range(0x660, 0x66A), 0x1680, *range(0x2000, 0x2070)):
        for cell in (f"1{chr(code)}", f"{chr(code)}1", f"1{chr(code)}2"):
            if "\n" not in cell and "\r" not in cell:
                lines = [f"{cell}{between}2", f"3{between}4"]
                assert taken(lines, dialect, True) == taken(lines, dialect, False), hex(code)


def test_a_point_in_a_file_of_decimal_commas_is_no_number(tmp_path):
    path = tmp_path / "bench.csv"
    rows = "\n".join(f"{k},0;1,5;{k},25" for k in range(30))
    path.write_text(f"time_s;elongation_mm;force_N\n{rows}\n30,0;1.500;2,0\n")
    with pytest.raises(InputError, match=r'line 32: the elongation is "1\.500", no number'):
        read_loop_file(path)


def test_one_odd_block_among_plain_ones_changes_no_other(tmp_path):
    table = np.column_stack([np.arange(40_000.0), np.sin(np.arange(40_000.0)), np.cos(np.arange(40_000.0))])
    text = text_of(table, "comma", "point", False, False)
    path = tmp_path / "long.csv"
    path.write_text("time_s,elongation_m,force_N,remark\n" + text.replace("\n", ",\n").replace("20000.0,", "20000.0, ", 1))
    loop, _ = read_loop_file(path)
    assert loop.to_frame().to_numpy().tobytes() == table.tobytes()
    path.write_text(path.read_text().replace("30000.0,", "30000.0,x", 1))
    with pytest.raises(InputError, match='line 30002: the elongation is "x'):
        read_loop_file(path)


@pytest.mark.parametrize("odd", ["1" * 100_000 + "x", "1" * 100_000 + ".x", "1," * 50_000 + "x", "." * 100_000, "1" * 100_000 + "e"])
def test_a_cell_of_a_hundred_thousand_signs_does_not_take_the_square_of_them(tmp_path, odd):
    rows = [f"{0.1 * k:.1f};{0.01 * k:.2f};2.8" for k in range(12)]
    (tmp_path / "bench.txt").write_text("\n".join(["time_s;elongation_m;force_N", *rows, f"1.2;{odd};2.8"]) + "\n")
    begun = time.process_time()
    with pytest.raises(InputError):
        read_loop_file(tmp_path / "bench.txt", ColumnMapping())
    assert time.process_time() - begun < 2.0


@pytest.mark.parametrize(
    "note",
    [
        "a" + "\t" * 100_000 + "x",
        "a" + " \t" * 50_000 + "=",
        "a: 1" + " " * 100_000 + "1",
        "a" + " " * 100_000 + "1",
        "-" * 100_000 + "a: 1",
        "a: " + "1" * 100_000 + "1 x 1",
    ],
)
def test_a_note_of_a_hundred_thousand_signs_neither(tmp_path, note):
    begun = time.process_time()
    assert conditions(tmp_path / "bench.txt", [note, "amplitude: 20 mm"], None)["amplitude"] == 20.0
    assert time.process_time() - begun < 2.0


def test_a_header_of_a_hundred_thousand_signs_neither():
    begun = time.process_time()
    assert name_fits("1" * 100_000 + "x", "force") == 0
    assert (name_fits("Kraft 2", "force"), name_fits("load3 cell", "force")) == (2, 2)
    assert unit_in_name("m_" * 50_000) == ""
    assert unit_in_name("speed_m_per_s") == "m/s"
    assert split_unit("a" + " " * 100_000 + "b") == ("a" + " " * 100_000 + "b", "")
    assert split_unit("Load   [kN]") == ("Load", "kN")
    assert time.process_time() - begun < 2.0


@pytest.mark.parametrize("name", ["x" * 100_000, "力" * 100_000, "x [" + "力" * 100_000 + "]"])
def test_a_long_name_of_a_column_is_not_said_whole(tmp_path, name):
    rows = [f"{0.1 * k:.1f};{0.01 * k:.2f};2.8" for k in range(12)]
    (tmp_path / "bench.txt").write_text("\n".join([f"Zeit;Weg;{name}", *rows]) + "\n", encoding="utf-8")
    (tmp_path / "own.csv").write_text(
        "\n".join([f"time_s,{name},force_N", *(row.replace(";", ",") for row in rows)]) + "\n", encoding="utf-8"
    )
    for path, read in ((tmp_path / "bench.txt", read_loop_file), (tmp_path / "own.csv", read_table)):
        with pytest.raises(InputError) as refusal:
            read(path)
        assert len(str(refusal.value)) < 2000
