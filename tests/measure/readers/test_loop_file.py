"""Files as laboratories write them end either in the right numbers or in one sentence that says what to do."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from measure import InputError
from measure.readers.column_mapping import ColumnMapping, pairs, read_mapping, write_mapping
from measure.readers.formats.matlab import vectors
from measure.readers.loop_file import read_loop_file
from measure.readers.stated_conditions import Claim

T = np.arange(40) * 0.5
U = np.round(12.0 * np.sin(0.3 * T), 3)
F = np.round(2.8 + 0.1 * np.cos(0.3 * T), 4)


def rows(*columns, delimiter=",", form="{:.4f}"):
    return [delimiter.join(form.format(value) for value in row) for row in zip(*columns, strict=True)]


def written(tmp_path, lines, encoding="utf-8", name="bench.csv", end="\n"):
    path = tmp_path / name
    path.write_bytes((end.join(lines) + end).encode(encoding))
    return path


def check(loop, time=T, elongation=U / 1000.0, force=F):
    assert loop.time_s == pytest.approx(time)
    assert loop.elongation_m == pytest.approx(elongation)
    assert loop.force_N == pytest.approx(force)


def test_own_columns_need_no_options(tmp_path):
    loop, _ = read_loop_file(written(tmp_path, ["time_s,elongation_m,force_N", *rows(T, U / 1000, F, form="{:.9f}")]))
    check(loop)


def test_a_unit_in_the_header_is_taken(tmp_path):
    loop, _ = read_loop_file(
        written(tmp_path, ["Time [ms];Elongation (mm);Force (kN)", *rows(T * 1e3, U, F / 1e3, delimiter=";", form="{:.9f}")])
    )
    check(loop)


def test_tab_without_header_by_number(tmp_path):
    mapping = ColumnMapping({"time": "1", "elongation": "4", "force": "3"}, {"time": "ms", "elongation": "mm", "force": "kN"})
    loop, understood = read_loop_file(written(tmp_path, rows(T * 1e3, U * 0 + 3.4, F / 1e3, U, delimiter="\t", form="{:.7f}")), mapping)
    check(loop)
    assert "delimiter tab" in understood.table.written
    assert "column 2" in loop.other


@pytest.mark.parametrize("delimiter", [";", "\t"])
def test_decimal_commas(tmp_path, delimiter):
    lines = [line.replace(".", ",") for line in rows(T, U, F, delimiter=delimiter)]
    loop, understood = read_loop_file(written(tmp_path, [delimiter.join(("time_s", "elongation_mm", "force_N")), *lines]))
    check(loop)
    assert "decimal comma" in understood.table.written


def test_quoted_numbers_with_decimal_commas_between_commas(tmp_path):
    lines = [",".join(f'"{value:.4f}"'.replace(".", ",") for value in row) for row in zip(T, U, F, strict=True)]
    check(read_loop_file(written(tmp_path, ['"time_s","elongation_mm","force_N"', *lines]))[0])


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_encodings_and_byte_order_marks(tmp_path, encoding):
    lines = ["Prüfstand 3, Federweg", "time_s,elongation (µm),force_N", *rows(T, U * 1e3, F)]
    check(read_loop_file(written(tmp_path, lines, encoding, end="\r\n"))[0])


def test_a_row_of_units_below_the_names_and_lines_above_them(tmp_path):
    lines = ["Rig: A", "Date: today", "Zeit,Weg,Kraft", "s,mm,kN", *rows(T, U, F / 1e3, form="{:.8f}")]
    loop, understood = read_loop_file(written(tmp_path, lines), ColumnMapping({"time": "Zeit", "elongation": "Weg", "force": "Kraft"}))
    check(loop)
    assert understood.table.notes == ("Rig: A", "Date: today")


def test_two_rows_below_the_names_are_no_data(tmp_path):
    lines = [
        "Time\tAxial Displacement\tAxial Force",
        "s\tmm\tkN",
        "(abs)\t(abs)\t(tared)",
        *rows(T, U, F / 1e3, delimiter="\t", form="{:.8f}"),
    ]
    mapping = ColumnMapping({"elongation": "Axial Displacement", "force": "Axial Force"})
    check(read_loop_file(written(tmp_path, lines), mapping)[0])


def test_a_first_step_of_280_ms_and_jitter_keep_their_times(tmp_path):
    t = np.concatenate([[0.0], 280.0 + np.cumsum(np.random.default_rng(0).integers(9, 13, 39))])
    check(read_loop_file(written(tmp_path, ["time_ms,elongation_mm,force_N", *rows(t, U, F)]))[0], time=t / 1e3)


def test_rows_in_the_wrong_order_are_sorted_and_it_is_said(tmp_path):
    order = np.concatenate([np.arange(20, 40), np.arange(20)])
    order[3], order[4] = order[4], order[3]
    loop, _ = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *rows(T[order], U[order], F[order])]))
    check(loop)
    assert loop.remarks[0].startswith("time goes back at 2 of 40 rows")


def test_a_record_written_backwards_is_turned_round(tmp_path):
    loop, _ = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *rows(T[::-1], U[::-1], F[::-1])]))
    check(loop)


def test_doubled_rows_count_once_and_rows_of_one_instant_by_their_mean(tmp_path):
    lines = rows(T, U, F)
    loop, _ = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *lines, *lines[-7:]]))
    check(loop)
    assert "7 of 47 rows have the time of another one; they are the same and count once" in loop.remarks
    twice = np.repeat(T, 2)
    loop, _ = read_loop_file(
        written(
            tmp_path, ["time_s,elongation_mm,force_N", *rows(twice, np.interp(twice, T, U), np.repeat(F, 2) + np.tile([-0.01, 0.01], 40))]
        )
    )
    check(loop)
    assert "their mean was taken" in loop.remarks[0]


def test_gaps_and_an_uneven_clock_are_said(tmp_path):
    t = np.concatenate([[0.0], 280.0 + np.cumsum(np.random.default_rng(0).integers(9, 15, 39))])
    loop, _ = read_loop_file(written(tmp_path, ["time_ms,elongation_mm,force_N", *rows(t, U, F)]))
    assert loop.remarks[0].startswith("no samples for 0.294 s after 0 s")
    assert "the clock is uneven" in loop.remarks[1]
    even, _ = read_loop_file(written(tmp_path, ["time_ms,elongation_mm,force_N", *rows(T, U, F)]))
    assert even.remarks == []


def test_two_clocks_are_said(tmp_path):
    loop, _ = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *rows(T, U, F)]), ColumnMapping(sample_period_s=0.4))
    assert loop.time_s[-1] == pytest.approx(0.4 * 39)
    assert 'column "time_s" says 0.5 s from sample to sample, and 0.4 s were given' in loop.remarks[0]


def test_trailing_comma_and_empty_first_column_are_no_columns(tmp_path):
    lines = [",time_s,elongation_mm,force_N,", *("," + line + "," for line in rows(T, U, F))]
    check(read_loop_file(written(tmp_path, lines))[0])


def test_blanks_as_delimiter(tmp_path):
    lines = ["  time_s   elongation_mm  force_N", *("   " + "    ".join(line.split(",")) for line in rows(T, U, F))]
    check(read_loop_file(written(tmp_path, lines))[0])


def test_volts_with_a_factor_and_a_sign_turned_round(tmp_path):
    path = written(tmp_path, ["time_s,u,f", *rows(T, -U / 25.4, F / 50.0, form="{:.9f}")])
    mapping = ColumnMapping({"elongation": "u", "force": "f"}, {"elongation": "in*-1", "force": "V*50"})
    check(read_loop_file(path, mapping)[0])


def test_a_sample_period_stands_in_for_a_missing_time(tmp_path):
    check(read_loop_file(written(tmp_path, ["elongation_mm,force_N", *rows(U, F)]), ColumnMapping(sample_period_s=0.5))[0])


def test_a_mapping_file_says_again_what_the_options_said(tmp_path):
    mapping = ColumnMapping({"force": "Load (kN)"}, {"force": "kN"}, delimiter="tab", header=False, sample_period_s=0.01)
    write_mapping(mapping, tmp_path / "rig.toml")
    assert read_mapping(tmp_path / "rig.toml") == mapping


def test_everything_that_is_wrong_with_a_mapping_file_is_said_at_once(tmp_path):
    path = tmp_path / "rig.toml"
    path.write_text(
        'delimitre = "tab"\nheader = "no"\nencoding = {a = 1}\nsample_period_s = -1\n'
        '[columns]\nforse = "x"\ntime = 1\nelongation = 1.5\n[units]\nforce = "kM"\ntime = "s"\n'
    )
    with pytest.raises(InputError) as caught:
        read_mapping(path)
    said = str(caught.value)
    for sentence in (
        'unknown key "delimitre"; did you mean "delimiter"?',
        "header should be a valid boolean, found 'no'",
        "encoding must be a single value",
        "--sample-period -1",
        '"kM" is no unit of force',
        "columns.elongation should be",
    ):
        assert sentence in said
    path.write_text('units = "mm"\n[columns]\nforse = "x"\n')
    with pytest.raises(InputError, match=r'(?s)a loop has no forse; did you mean "force"\?.*units must be a table'):
        read_mapping(path)


def test_what_was_understood_is_shown_with_five_rows(tmp_path):
    _, understood = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *rows(T, U, F)]))
    shown = understood.sentences()
    assert "delimiter comma, decimal point, header in line 1, 40 rows" in shown[0]
    assert len(shown) == 1 + 3 + 5


REFUSED = {
    "no force, a likely one named": (
        ["time_s,elongation_mm,Load (kN),Spare (kN)", *rows(T, U, F, F)],
        {},
        'no column for the force; found .*\nAdd --column force="Load \\(kN\\)" --unit force=kN, or rename it to force_N',
    ),
    "no unit": (["time_s,elongation,force_N", *rows(T, U, F)], {}, "which unit is the elongation in"),
    "unit of something else": (["time_s,elongation_mm,force_N", *rows(T, U, F)], {"units": {"force": "mm"}}, "no unit of force"),
    "volts without a factor": (["time_s,elongation_mm,f", *rows(T, U, F)], {"units": {"force": "V"}}, "volts need a factor"),
    "a cut last line": (["time_s,elongation_mm,force_N", *rows(T, U, F), "20.0,3."], {}, "line 42: 2 cells where the other rows have 3"),
    "a short header": (["time_s,elongation_mm", *rows(T, U, F)], {}, "2 names stand above 3 columns"),
    "no number in a cell": (["time_s,elongation_mm,force_N", *rows(T, U, F), "20.0,3.0,---"], {}, 'line 42: the force is "---"'),
    "an empty cell": (["time_s,elongation_mm,force_N", *rows(T, U, F), "20.0,,1"], {}, "line 42: the elongation is empty"),
    "a clock set back": (
        ["time_s,elongation_mm,force_N", *rows(T, U, F), *rows(T + 0.1, -U, F)],
        {},
        "line 42: time goes from 19.5 back to 0.1",
    ),
    "two elongations at one instant": (
        ["time_s,elongation_mm,force_N", *rows(T, U, F), "19.5,9,1"],
        {},
        "line 41: 2 rows have the time 19.5 s",
    ),
    "no header and no numbers given": (rows(T, U, F), {}, "no header, so no column for the time"),
    "no such column": (["time_s,elongation_mm,force_N", *rows(T, U, F)], {"columns": {"force": "forse_N"}}, 'did you mean "force_N"'),
    "no table": (["hello", "world"], {}, "no table of numbers"),
    "empty": ([""], {}, "is empty"),
    "two force columns": (["time_s,elongation_mm,force_N,force_kN", *rows(T, U, F, F)], {}, "2 columns for the force"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_unusable_files_end_in_one_sentence(tmp_path, case):
    lines, options, sentence = REFUSED[case]
    with pytest.raises(InputError, match=sentence):
        read_loop_file(written(tmp_path, lines), ColumnMapping(**options))


def test_a_comma_that_may_be_a_thousand_is_not_guessed(tmp_path):
    lines = ["time_s\telongation_um\tforce_N", *(f"{1 + k}\t{1 + k},250\t{2 + k},500" for k in range(30))]
    with pytest.raises(InputError, match="decimal comma or a thousand"):
        read_loop_file(written(tmp_path, lines))
    loop, _ = read_loop_file(written(tmp_path, lines), ColumnMapping(decimal="comma"))
    assert loop.force_N[0] == 2.5


def test_a_binary_file_is_no_table(tmp_path):
    path = tmp_path / "x.csv"
    path.write_bytes(bytes(range(256)) * 10)
    with pytest.raises(InputError, match="is not text"):
        read_loop_file(path)


def test_an_option_for_an_unknown_quantity_names_the_nearest():
    with pytest.raises(InputError, match='did you mean "force"'):
        ColumnMapping({"forse": "x"})
    with pytest.raises(InputError, match="given twice"):
        pairs("--column", ["force=a", "force=b"])


def test_a_matlab_file_is_read_by_the_names_of_its_variables(tmp_path):
    savemat(tmp_path / "run.mat", {"dist": U[:, None], "rig": {"forc": F}, "Ts": 0.5, "f": 1.5, "note": "x"})
    mapping = ColumnMapping({"elongation": "dist", "force": "rig.forc"}, {"elongation": "mm", "force": "N"}, sample_period_s=0.5)
    loop, understood = read_loop_file(tmp_path / "run.mat", mapping)
    check(loop)
    assert understood.claims == [Claim("a note in it", "frequency", 1.5)]


def test_a_matlab_file_without_options_names_its_variables(tmp_path):
    savemat(tmp_path / "run.mat", {"dist": U, "forc": F, "Ts": 0.5})
    with pytest.raises(InputError, match=r'found "dist", "forc"(.|\n)*Ts = 0.5'):
        read_loop_file(tmp_path / "run.mat")


def test_a_matlab_file_that_is_cut_or_new_is_refused_with_what_to_do(tmp_path):
    savemat(tmp_path / "run.mat", {"dist": U, "forc": F})
    raw = (tmp_path / "run.mat").read_bytes()
    (tmp_path / "cut.mat").write_bytes(raw[:300])
    (tmp_path / "new.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + bytes(600))
    for name in ("cut.mat", "new.mat"):
        with pytest.raises(InputError, match="-v7"):
            read_loop_file(tmp_path / name)


def test_a_frequency_in_the_name_is_a_claim(tmp_path):
    _, understood = read_loop_file(written(tmp_path, ["time_s,elongation_mm,force_N", *rows(T, U, F)], name="A_0.25Hz_12mm.csv"))
    assert understood.claims == [Claim("its name", "frequency", 0.25), Claim("its name", "travel", 0.012)]


@pytest.mark.parametrize("packed", [False, True])
def test_matlab_numbers_of_every_type_are_those_that_were_saved(tmp_path, packed):
    saved = {kind: np.arange(24).reshape(4, 6).astype(kind) for kind in ("f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8")}
    others = {
        "deep": {"a": {"b": np.linspace(0, 1, 7)}},
        "text": "hello",
        "complex": np.array([1j, 2.0]),
        "cell": np.array([1, "x"], object),
    }
    savemat(tmp_path / "all.mat", {**saved, **others}, do_compression=packed)
    found = vectors(tmp_path / "all.mat").values
    assert np.array_equal(found.pop("deep.a.b"), np.linspace(0, 1, 7))
    assert len(found) == 6 * len(saved)
    for kind, values in saved.items():
        assert np.array_equal(np.stack([found[f"{kind}[{k}]"] for k in range(1, 7)], axis=1), values)


REAL = Path("../shared/real/loops/mr-damper-0V")


@pytest.mark.skipif(not REAL.is_dir(), reason="../shared/real is absent")
def test_a_real_matlab_file_holds_what_its_table_holds():
    mapping = ColumnMapping({"elongation": "dist", "force": "forc"}, {"elongation": "mm", "force": "N"}, sample_period_s=0.01)
    loop, _ = read_loop_file(REAL / "ensaio1.1.mat", mapping)
    table, _ = read_loop_file(REAL / "f0.840Hz_A12.19mm.csv")
    assert loop.elongation_m == pytest.approx(table.elongation_m, abs=1e-9)
    assert loop.force_N == pytest.approx(table.force_N, abs=1e-3)


def test_a_table_in_json_is_refused_from_a_size_on_that_would_fill_the_memory(tmp_path):
    path = tmp_path / "bench.json"
    with open(path, "wb") as file:
        file.write(b'[{"time_s": 0.0,')
        file.truncate(300_000_000)
    with pytest.raises(InputError, match="has 300 MB, and a table in JSON has at most 200 MB"):
        read_loop_file(path)
