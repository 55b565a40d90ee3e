"""Exports of benches, one of each kind made with a seeded generator: the numbers that were measured, or one sentence with what to type."""

from __future__ import annotations

import json
import shlex
import sys
import zipfile

import numpy as np
import pytest

from measure import InputError
from measure.common.errors import OptionsMissing
from measure.readers.column_mapping import ColumnMapping
from measure.readers.loop_file import read_loop_file
from measure.tables.units import unit_of

CHANCE = np.random.default_rng(28)
T = np.arange(60) / 100.0
U = np.round(250.0 + 40.0 * np.sin(2.0 * np.pi * T) + CHANCE.normal(0.0, 0.01, 60), 5)  # mm
F = np.round(2.8 + 0.05 * np.sign(np.cos(2.0 * np.pi * T)) + CHANCE.normal(0.0, 1e-3, 60), 5)  # N


def check(loop, time=T, elongation=U / 1000.0, force=F):
    assert loop.time_s == pytest.approx(time, abs=1e-9)
    assert loop.elongation_m == pytest.approx(elongation)
    assert loop.force_N == pytest.approx(force)


def rows(*columns, sign=".", between=",", digits=6):
    return [between.join(f"{cell:.{digits}f}".replace(".", sign) for cell in row) for row in zip(*columns, strict=True)]


def written(folder, lines, name="bench.txt", encoding="utf-8", end="\r\n"):
    path = folder / name
    path.write_bytes((lines if isinstance(lines, str) else end.join(lines) + end).encode(encoding))
    return path


def blocks(names="Time\tAxial Displacement\tAxial Force", size=20):
    """A test machine's export: a preamble, and names and units above every block of rows."""
    head = ["Cyclic Acquisition\t\t\tTime:\t20,048\tSec\t14/12/2021 9:40:47", f"Points:\t{size}"]
    made = ["MTS***|MPT|**", ""]
    for k in range(0, 60, size):
        part = slice(k, k + size)
        made += ["", *head, names if k else "Time\tAxial Displacement\tAxial Force", "Sec\tmm\tkgf"]
        made += rows(T[part], U[part], F[part] / 9.80665, sign=",", between="\t", digits=9)
    return made


def test_blocks_with_text_between_them_are_one_record(tmp_path):
    loop, understood = read_loop_file(written(tmp_path, [*blocks(), "End of test"]))
    check(loop)
    assert "lines of text between the rows left out" in understood.sentences()[0]
    assert "Points:\t20" in understood.table.notes


def test_a_damaged_row_in_a_later_block_is_named_by_its_line(tmp_path):
    lines = blocks()
    place = next(k for k, line in enumerate(lines) if line.startswith("0,550"))
    for cells, sentence in (("0,55\t252,1", "2 cells where the other rows have 3"), ("0,55\t252,1\t---", 'the force is "---"')):
        damaged = [*lines[:place], cells, *lines[place + 1 :]]
        with pytest.raises(InputError, match=rf"line {place + 1}: {sentence}"):
            read_loop_file(written(tmp_path, damaged))


def test_a_block_of_other_columns_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"line 31: the columns of this block are named otherwise"):
        read_loop_file(written(tmp_path, blocks(names="Time\tAxial Force\tAxial Displacement")))


def test_a_preamble_of_three_cells_is_not_taken_for_the_names(tmp_path):
    body = [",".join(f'"{cell:.6f}"'.replace(".", ",") for cell in row) for row in zip(T, U, F, strict=True)]
    check(read_loop_file(written(tmp_path, ['Specimen : Length,"50,0",mm', "Time,Extension,Load", "(s),(mm),(N)", *body]))[0])


@pytest.mark.parametrize(
    ("unit", "newtons"),
    [("kgf", 9.80665), ("gf", 9.80665e-3), ("ozf", 0.2780138509537812), ("Newton", 1.0), ("KN", 1e3), ("公斤力", 9.80665)],
)
def test_units_of_force_in_every_spelling(unit, newtons):
    assert unit_of("force", unit).factor == pytest.approx(newtons, rel=1e-12)


STAMPS = {
    "ISO": lambda s: f"2025-01-02 23:59:{59 + s:09.6f}" if s < 1 else "",
    "ISO with T and zone": lambda s: f"2025-01-02T03:04:{5 + s:09.6f}Z",
    "German": lambda s: f"02.01.2025 03:04:{5 + s:09.6f}".replace(".", ",").replace(",", ".", 2),
    "American, half days": lambda s: f"1/2/2025 3:04:{5 + s:09.6f} PM",
    "time of day": lambda s: f"03:04:{5 + s:09.6f}",
}


@pytest.mark.parametrize("kind", STAMPS)
def test_stamps_are_seconds_since_the_first(tmp_path, kind):
    body = [f"{STAMPS[kind](t)};{row}" for t, row in zip(T, rows(U, F, between=";"), strict=True)]
    loop, _ = read_loop_file(written(tmp_path, ["Timestamp;Displacement (mm);Force (N)", *body]))
    check(loop)
    assert "taken by the usual names" in loop.remarks[0]


def test_a_clock_runs_on_over_midnight_and_a_date_may_stand_in_a_column_of_its_own(tmp_path):
    for with_date in (False, True):
        clock = [np.datetime64("2025-01-31T23:59:59.700") + np.timedelta64(round(1000 * t), "ms") for t in T]
        shown = [str(c).replace("T", ",") if with_date else str(c).split("T")[1] for c in clock]
        body = [f"{stamp},{row}" for stamp, row in zip(shown, rows(U, F), strict=True)]
        names = ["Date,Time" if with_date else "Time", "Displacement (mm)", "Force (N)"]
        check(read_loop_file(written(tmp_path, [",".join(names), *body]))[0])


def test_a_date_that_may_be_day_or_month_first_is_not_guessed(tmp_path):
    body = [f"0{1 + k // 30}/02/2025 03:04:{k:02d},{row}" for k, row in enumerate(rows(U, F))]
    with pytest.raises(InputError, match="may be day/month or month/day"):
        read_loop_file(written(tmp_path, ["Timestamp,Displacement (mm),Force (N)", *body]))


def test_a_stamp_that_is_none_is_named_by_its_line(tmp_path):
    body = [f"03:04:{5 + t:09.6f},{row}" for t, row in zip(T, rows(U, F), strict=True)]
    body[30] = "later" + body[30][15:]
    with pytest.raises(InputError, match='line 32: the time is "later"'):
        read_loop_file(written(tmp_path, ["Time,Displacement (mm),Force (N)", *body]))


PAIRS = list(zip(T, U, F, strict=True))
NAMES = ["time_s", "elongation_mm", "force_N"]
JSON = {
    "columns by name": dict(zip(NAMES, (T.tolist(), U.tolist(), F.tolist()), strict=True)),
    "records": [dict(zip(NAMES, row, strict=True)) for row in PAIRS],
    "rows with names": {"columns": NAMES, "index": list(range(60)), "data": PAIRS},
    "columns of pandas": {name: {str(k): row[i] for k, row in enumerate(PAIRS)} for i, name in enumerate(NAMES)},
    "channels with units": {
        "test": {
            "operator": "A",
            "channels": [
                {"name": "time", "unit": "s", "data": T.tolist()},
                {"name": "elongation", "unit": "mm", "data": U.tolist()},
                {"name": "force", "unit": "N", "data": F.tolist()},
            ],
        }
    },
    "inside of a test": {"rig": "A", "test": {"temperature": 21.5, **dict(zip(NAMES, (T.tolist(), U.tolist(), F.tolist()), strict=True))}},
}


@pytest.mark.parametrize("kind", JSON)
def test_json_in_one_line(tmp_path, kind):
    inner = "test." if kind == "inside of a test" else ""
    mapping = ColumnMapping({q: inner + n for q, n in zip(("time", "elongation", "force"), NAMES, strict=True)}) if inner else None
    check(read_loop_file(written(tmp_path, json.dumps(JSON[kind]), "bench.json"), mapping)[0])


def test_json_one_record_a_line(tmp_path):
    check(read_loop_file(written(tmp_path, "\n".join(json.dumps(row) for row in JSON["records"]), "bench.jsonl"))[0])


def refused(path, **options):
    with pytest.raises(OptionsMissing) as caught:
        read_loop_file(path, ColumnMapping(**options))
    return caught.value


def mapping_of(options):
    """The options of a proposal, as the command would take them."""
    words = shlex.split(options)
    given = {"--column": {}, "--unit": {}}
    for option, word in zip(words[::2], words[1::2], strict=True):
        quantity, _, value = word.partition("=")
        given[option][quantity] = value
    return ColumnMapping(given["--column"], given["--unit"])


def test_without_names_the_column_that_grows_is_proposed_for_the_time(tmp_path):
    path = written(tmp_path, rows(U, F, T))
    check(read_loop_file(path, mapping_of(refused(path).options))[0])


def test_rows_without_names_in_json_are_proposed_in_their_order(tmp_path):
    path = written(tmp_path, json.dumps({"data": PAIRS}), "bench.json")
    error = refused(path)
    assert "check the order of the columns and the units" in str(error)
    check(read_loop_file(path, mapping_of(error.options))[0])


@pytest.mark.parametrize("text", ['{"a": [1, 2', "[" * 100_000, '{"a": 1}', "[1e999]", '{"data": [[1, 2], [3]]}', "NaN"])
def test_json_that_holds_no_table_ends_in_one_sentence(tmp_path, text):
    with pytest.raises(InputError, match=r"bench\.json: "):
        read_loop_file(written(tmp_path, text, "bench.json"))


HEADERS = {
    "English": ("Elapsed Time", "Axial Displacement", "Axial Force", "utf-8"),
    "German": ("Prüfzeit", "Standardweg", "Standardkraft", "cp1252"),
    "French": ("Temps", "Déplacement", "Effort", "cp1252"),
    "Chinese": ("时间", "位移", "载荷", "gb18030"),
    "Japanese": ("時間", "変位", "荷重", "cp932"),
    "Chinese, two bytes a letter, no mark": ("时间", "Displacement", "试验力", "utf-16-le"),
}


@pytest.mark.parametrize("language", HEADERS)
def test_the_usual_names_with_units_are_read_in_the_encoding_they_stand_in(tmp_path, language):
    *names, encoding = HEADERS[language]
    header = ";".join(f"{name} ({unit})" for name, unit in zip(names, ("s", "mm", "N"), strict=True))
    wide = ["Notes of the test bench: nothing to say, and that at length"] * 30 if "16" in encoding else []
    loop, understood = read_loop_file(written(tmp_path, [*wide, header, *rows(T, U, F, sign=",", between=";")], encoding=encoding))
    check(loop)
    assert understood.table.written.startswith(encoding)


@pytest.mark.parametrize("language", HEADERS)
def test_without_units_all_names_are_proposed_in_one_message_that_can_be_typed(tmp_path, language):
    *names, _ = HEADERS[language]
    path = written(tmp_path, [";".join([*names, "Count"]), *rows(T, U, F, T, sign=",", between=";")])
    error = refused(path)
    assert "no column for the time, none for the elongation and none for the force" in str(error)
    assert "check the units" in str(error)
    check(read_loop_file(path, mapping_of(error.options))[0])


def test_two_columns_that_may_be_the_elongation_are_not_guessed(tmp_path):
    path = written(tmp_path, ["Time (s),Position (mm),Laser (mm),Force (N)", *rows(T, U, U + 1.0, F)])
    assert '--column elongation="Position (mm)" --unit elongation=mm' in refused(path).options


def test_a_demanded_value_is_no_measured_one(tmp_path):
    names = ["Time (s),Displacement command (mm),Displacement (mm),Force (N)"]
    check(read_loop_file(written(tmp_path, [*names, *rows(T, U + 5.0, U, F)]))[0])


def test_a_column_in_a_unit_of_something_else_is_taken_for_swapped(tmp_path):
    path = written(tmp_path, ["time_s,Weg (mm),Kraft (N)", *rows(T, U, F)])
    error = refused(path, columns={"elongation": "Kraft (N)", "force": "Weg (mm)"})
    assert str(error).count("are two channels swapped?") == 2


def test_what_is_wrong_with_several_files_alike_is_said_once_with_the_whole_line(tmp_path, capsys):
    from identify.commands.fit_actuator import main

    paths = [str(written(tmp_path, ["t,x,Load (kN)", *rows(T, U, F / 1e3, digits=9)], name)) for name in ("a.csv", "b 2.csv")]
    assert main([*paths, "--preview"]) == 2
    said = capsys.readouterr().err.splitlines()
    options = '--column time=t --unit time=s --column elongation=x --unit elongation=mm --column force="Load (kN)" --unit force=kN'
    assert options in said[1]
    assert said[2] == f"The same with {paths[1]}."
    assert said[3] == f"The whole line: fit-actuator {paths[0]} '{paths[1]}' --preview {options}"
    assert main(shlex.split(said[3].partition(": fit-actuator ")[2])) == 0


@pytest.mark.parametrize("again", [0.0, 0.001])
def test_a_time_that_starts_again_is_another_recording(tmp_path, again):
    path = written(tmp_path, [",".join(NAMES), *rows(T, U, F), *rows(T, U + again, F)])
    if again:
        with pytest.raises(InputError, match=r"line 62: time goes from 0.59 back to 0 s .* there are two recordings in the file"):
            read_loop_file(path)
    else:
        check(read_loop_file(path)[0])  # the same rows twice are one recording


def sheet_of(table):
    """The XML of a sheet; text in the cell itself."""
    lines = []
    for r, row in enumerate(table, start=1):
        cells = [(f"{chr(65 + c)}{r}", cell) for c, cell in enumerate(row) if cell != ""]
        shown = [
            f'<c r="{at}" t="inlineStr"><is><t>{cell}</t></is></c>' if isinstance(cell, str) else f'<c r="{at}"><v>{cell!r}</v></c>'
            for at, cell in cells
        ]
        lines.append(f'<row r="{r}">{"".join(shown)}</row>')
    return f'<worksheet xmlns="{MAIN}"><sheetData>{"".join(lines)}</sheetData></worksheet>'


MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
PACKAGE = "http://schemas.openxmlformats.org/package/2006"
SHEET = "application/vnd.openxmlformats-officedocument.spreadsheetml"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"


def xlsx(folder, **sheets):
    """A workbook with these sheets, written by hand."""
    path = folder / "bench.xlsx"
    numbers = range(1, len(sheets) + 1)
    listed = "".join(f'<sheet name="{name}" sheetId="{k}" r:id="r{k}"/>' for k, name in enumerate(sheets, start=1))
    links = "".join(f'<Relationship Id="r{k}" Type="{OFFICE}/worksheet" Target="worksheets/sheet{k}.xml"/>' for k in numbers)
    parts = "".join(f'<Override PartName="/xl/worksheets/sheet{k}.xml" ContentType="{SHEET}.worksheet+xml"/>' for k in numbers)
    main = f'<Override PartName="/xl/workbook.xml" ContentType="{SHEET}.sheet.main+xml"/>'
    rels = '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("[Content_Types].xml", f'<Types xmlns="{PACKAGE}/content-types">{rels}{main}{parts}</Types>')
        root = f'<Relationship Id="r0" Type="{OFFICE}/officeDocument" Target="xl/workbook.xml"/>'
        packed.writestr("_rels/.rels", f'<Relationships xmlns="{PACKAGE}/relationships">{root}</Relationships>')
        book = f'<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}"><sheets>{listed}</sheets></workbook>'
        packed.writestr("xl/workbook.xml", book)
        packed.writestr("xl/_rels/workbook.xml.rels", f'<Relationships xmlns="{PACKAGE}/relationships">{links}</Relationships>')
        for k, table in enumerate(sheets.values(), start=1):
            packed.writestr(f"xl/worksheets/sheet{k}.xml", sheet_of(table))
    return path


TABLE = [["Rig A", ""], [""], ["Zeit", "Weg", "Kraft"], ["s", "mm", "N"], *([float(x) for x in row] for row in PAIRS)]


def test_a_sheet_of_a_workbook_with_names_and_units(tmp_path):
    loop, understood = read_loop_file(xlsx(tmp_path, Notes=[["nothing", "here"]], Data=TABLE))
    check(loop)
    assert understood.table.notes == ("Rig A",)


def test_numbers_that_stand_as_text_with_decimal_commas_in_a_workbook(tmp_path):
    table = [["Zeit (s)", "Weg (mm)", "Kraft (N)"], *([f"{x:.6f}".replace(".", ",") for x in row] for row in PAIRS)]
    check(read_loop_file(xlsx(tmp_path, Data=table))[0])


def test_a_column_of_a_workbook_without_a_name_has_its_number_and_one_of_a_doubled_name_a_second_one(tmp_path):
    table = [["Zeit (s)", "", "Kraft (N)", "Kraft (N)"], *([t, u, f, f + 1.0] for t, u, f in TABLE[4:])]
    with pytest.raises(InputError, match=r'found "Zeit \(s\)", "column 2", "Kraft \(N\)", "Kraft \(N\) \(2\)"'):
        read_loop_file(xlsx(tmp_path, Data=table))


def test_which_of_two_sheets_must_be_said(tmp_path):
    path = xlsx(tmp_path, first=TABLE, second=[TABLE[2], TABLE[3], *([t, u + 1.0, f] for t, u, f in TABLE[4:])])
    with pytest.raises(InputError, match=r'2 sheets \(first, second\). Add --sheet "first"'):
        read_loop_file(path)
    check(read_loop_file(path, ColumnMapping(sheet="second"))[0], elongation=(U + 1.0) / 1000.0)
    with pytest.raises(InputError, match='no sheet "secnd"; did you mean "second"'):
        read_loop_file(path, ColumnMapping(sheet="secnd"))


def test_an_old_workbook_with_dates(tmp_path):
    import xlwt

    book = xlwt.Workbook()
    sheet, style = book.add_sheet("Data"), xlwt.easyxf(num_format_str="YYYY-MM-DD HH:MM:SS.000")
    for c, name in enumerate(("Timestamp", "Displacement (mm)", "Force (N)")):
        sheet.write(0, c, name)
    for r, (t, u, f) in enumerate(PAIRS, start=1):
        sheet.write(r, 0, 45659.128 + float(t) / 86400.0, style)
        sheet.write(r, 1, float(u))
        sheet.write(r, 2, float(f))
    book.save(tmp_path / "bench.xls")
    loop, _ = read_loop_file(tmp_path / "bench.xls")
    assert loop.time_s == pytest.approx(T, abs=2e-3)  # Excel keeps a date to a part of a day
    assert loop.elongation_m == pytest.approx(U / 1000.0)


def test_a_workbook_that_would_unpack_to_more_than_a_table_is_refused_unread(tmp_path):
    path = tmp_path / "bomb.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as packed, packed.open("xl/workbook.xml", "w") as part:
        for _ in range(51):
            part.write(bytes(10_000_000))
    with pytest.raises(InputError, match="unpacks to 510 MB, and 500 MB are the most"):
        read_loop_file(path)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"%PDF-1.7 \x00\xff", "is a PDF document"),
        (b"\x1f\x8b\x08\x00", "is packed with gzip"),
        (b"<html><table><tr><td>1</td></tr></table></html>", "is a web page"),
        (b"PK\x03\x04 cut", "cut or damaged"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600), "cannot be read as a workbook"),
    ],
)
def test_what_is_something_else_is_named(tmp_path, content, sentence):
    path = tmp_path / "bench.xls"
    path.write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        read_loop_file(path)


def universal(folder):
    """Two functions of a universal file in double precision, written by hand, with an even abscissa of time."""
    made = []
    for kind, label, unit, values in ((8, "Laser", "mm", U), (9, "Load cell", "N", F)):
        axes = [(17, "NONE", "s"), (kind, label, unit), (0, "NONE", "NONE"), (0, "NONE", "NONE")]
        made += ["    -1", "    58" + 74 * " ", *(f"{name:<80}" for name in (label, "NONE", "NONE", "NONE", "NONE"))]
        made += [f"{1:5d}{0:10d}{0:5d}{0:10d} {'NONE':>10}{1:10d}{1:4d} {'NONE':>10}{1:10d}{1:4d}"]
        made += [f"{4:10d}{len(T):10d}{1:10d}{0.0:13.5e}{T[1]:13.5e}{0.0:13.5e}"]
        made += [f"{number:10d}{0:5d}{0:5d}{0:5d} {name:<20} {symbol:<20}" for number, name, symbol in axes]
        made += ["".join(f"{value:20.11e}" for value in four) for four in values.reshape(-1, 4)] + ["    -1"]
    return written(folder, made, "bench.uff", end="\n")


def test_the_functions_of_a_universal_file(tmp_path):
    loop, _ = read_loop_file(universal(tmp_path))
    assert loop.elongation_m == pytest.approx(U / 1000.0, rel=1e-5)
    assert loop.force_N == pytest.approx(F, rel=1e-4)


@pytest.mark.parametrize(
    ("module", "extra", "make"),
    [("python_calamine", "excel", lambda at: xlsx(at, Data=TABLE)), ("pyuff", "uff", universal)],
)
def test_a_missing_extra_is_named_with_what_to_do(tmp_path, monkeypatch, module, extra, make):
    path = make(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    with pytest.raises(InputError, match=rf'{module}, which reads it, is not installed. Install it with pip install "unspool\[{extra}\]"'):
        read_loop_file(path)
