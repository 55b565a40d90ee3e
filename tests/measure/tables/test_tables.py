"""The two tables survive the disk to the last digit, and a table that is wrong is refused at its line."""

from __future__ import annotations

import csv
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from measure import (
    Loop,
    Trajectory,
    read_loop,
    read_table,
    read_trajectory,
    write_loop,
    write_trajectory,
)
from measure.common.errors import InputError
from measure.tables.csv_cells import write_columns
from measure.tables.loop import LOOP_COLUMNS
from measure.tables.trajectory import CHANNELS

LOOP = "time_s,elongation_m,force_N\n0.0,0.001,2.79\n0.1,0.002,2.80\n0.2,0.003,2.81\n"
TRAJECTORY = "time_s,x_m,sigma_x_m,status\n0.0,0.001,1e-5,ok\n0.1,,,lost\n0.2,0.003,1e-5,ok\n"

finite = st.floats(allow_nan=False, allow_infinity=False)
times = st.lists(finite, min_size=2, max_size=12, unique=True).map(sorted)


@pytest.fixture
def file(tmp_path):
    def make(text, name="table.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return make


def refused(read, path):
    """The sentence that a table is refused with."""
    with pytest.raises(InputError) as caught:
        read(path)
    return str(caught.value)


@st.composite
def loops(draw):
    time = draw(times)
    column = st.lists(finite, min_size=len(time), max_size=len(time))
    gappy = st.lists(st.floats(allow_infinity=False), min_size=len(time), max_size=len(time))
    return Loop(np.array(time), np.array(draw(column)), np.array(draw(column)), other={"pressure_bar": np.array(draw(gappy))})


@st.composite
def trajectories(draw):
    time = draw(times)

    def column(values):
        return st.lists(values, min_size=len(time), max_size=len(time))

    names = draw(st.lists(st.sampled_from(CHANNELS), min_size=1, unique=True))
    seen = st.floats(allow_infinity=False)
    sigma = st.one_of(st.just(np.nan), st.floats(min_value=1e-300, allow_infinity=False, allow_nan=False))
    channels = {name: np.array(draw(column(seen))) for name in names}
    sigmas = {name: np.array(draw(column(sigma))) for name in draw(st.lists(st.sampled_from(names), unique=True))}
    status = draw(st.one_of(st.just(()), column(st.sampled_from(["ok", "partial", "lost", "missing"]))))
    return Trajectory(np.array(time), channels, sigmas, status)


def alike(first, second):
    return np.array_equal(first, second, equal_nan=True)


@given(loops())
def test_a_loop_survives_the_disk_to_the_last_digit(loop):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "loop.csv"
        write_loop(loop, path)
        back = read_loop(path)
    for column in LOOP_COLUMNS:
        assert getattr(back, column).tobytes() == getattr(loop, column).tobytes()
    assert alike(back.other["pressure_bar"], loop.other["pressure_bar"])


@given(trajectories())
def test_a_trajectory_survives_the_disk_to_the_last_digit(trajectory):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "trajectory.csv"
        write_trajectory(trajectory, path)
        back = read_table(path)
    assert isinstance(back, Trajectory)
    assert back.time_s.tobytes() == trajectory.time_s.tobytes()
    assert set(back.channels) == set(trajectory.channels)
    assert set(back.sigma) == set(trajectory.sigma)
    assert all(alike(back.channels[name], values) for name, values in trajectory.channels.items())
    assert all(alike(back.sigma[name], values) for name, values in trajectory.sigma.items())
    assert list(back.status) == list(trajectory.status)


@given(trajectories())
def test_the_same_table_gives_the_same_bytes(trajectory):
    with TemporaryDirectory() as folder:
        first, second = Path(folder) / "first.csv", Path(folder) / "second.csv"
        write_trajectory(trajectory, first)
        write_trajectory(read_trajectory(first), second)
        assert first.read_bytes() == second.read_bytes()


def test_what_was_not_seen_is_empty_and_never_zero(tmp_path):
    seen = Trajectory(np.array([0.0, 0.1]), {"z_m": np.array([0.252, np.nan])}, {"z_m": np.array([1e-5, np.nan])})
    write_trajectory(seen, tmp_path / "z.csv")
    assert (tmp_path / "z.csv").read_text() == "time_s,z_m,sigma_z_m\n0.0,0.252,1e-05\n0.1,,\n"


def test_a_table_tells_what_it_is_by_its_columns(file):
    assert isinstance(read_table(file(LOOP)), Loop)
    assert isinstance(read_table(file(TRAJECTORY)), Trajectory)


def test_a_byte_order_mark_and_windows_line_ends_change_nothing(file):
    plain = read_loop(file(LOOP))
    foreign = read_loop(file(b"\xef\xbb\xbf" + LOOP.replace("\n", "\r\n").encode(), "foreign.csv"))
    assert foreign.force_N.tobytes() == plain.force_N.tobytes()


def test_further_columns_of_numbers_come_along_and_words_do_not(file):
    rows = LOOP.replace("force_N\n", "force_N,bar,remark\n").replace("2.79\n", "2.79,5,cold\n").replace("2.80\n", "2.80,,warm\n")
    loop = read_loop(file(rows.replace("2.81\n", "2.81,7,warm\n")))
    assert set(loop.other) == {"bar"}
    assert alike(loop.other["bar"], np.array([5.0, np.nan, 7.0]))


def test_a_cut_last_line_is_refused_with_its_number(file):
    assert ", line 4: 2 cells and 3 columns; the file is cut" in refused(read_loop, file(LOOP[: LOOP.rindex(",")]))


def test_a_cell_too_many_is_refused_with_its_line(file):
    assert ", line 3: 4 cells and 3 columns" in refused(read_loop, file(LOOP.replace("2.80", "2,80")))


def test_an_empty_line_amid_the_rows_is_refused_and_at_the_end_is_not(file):
    assert ", line 3: 0 cells" in refused(read_loop, file(LOOP.replace("0.1,", "\n0.1,")))
    assert len(read_loop(file(LOOP + "\n\n")).time_s) == 3


def test_lines_are_counted_as_an_editor_counts_them_also_behind_a_cell_of_two_lines(file):
    text = LOOP.replace("force_N\n", "force_N,remark\n").replace("2.79\n", '2.79,"first\nsecond"\n').replace("2.80\n", "x,-\n")
    assert ", line 4: force_N" in refused(read_loop, file(text.replace("2.81\n", "2.81,-\n")))


@pytest.mark.parametrize("cell", ["nan", "NaN", "", "-", "2.8_0", "two", "0x1", "=2+1"])
def test_a_cell_that_is_no_number_is_refused_with_file_and_line(file, cell):
    path = file(LOOP.replace("2.80", cell))
    said = refused(read_loop, path)
    assert f"{path}, line 3: force_N is " in said
    assert "not a number" in said


@pytest.mark.parametrize("cell", ["inf", "-Infinity", "1e999"])
def test_an_infinite_force_is_refused_with_file_and_line(file, cell):
    assert ", line 3: force_N is " in refused(read_loop, file(LOOP.replace("2.80", cell)))


@pytest.mark.parametrize("cell", ["nan", "inf", "lost"])
def test_a_position_is_a_number_or_empty(file, cell):
    assert ", line 2: x_m" in refused(read_trajectory, file(TRAJECTORY.replace("0.001", cell)))


def test_an_empty_time_is_refused(file):
    assert ", line 3: time_s is empty" in refused(read_trajectory, file(TRAJECTORY.replace("0.1,", ",")))


@pytest.mark.parametrize("time", ["0.0", "-1"])
def test_time_that_does_not_increase_is_refused_with_its_line(file, time):
    said = refused(read_loop, file(LOOP.replace("0.1,", f"{time},")))
    assert ", line 3: time_s goes from 0 to" in said
    assert "Sort the rows" in said


def test_a_standard_deviation_of_zero_is_refused_with_its_line(file):
    assert ", line 4: sigma_x_m is 0;" in refused(read_trajectory, file(TRAJECTORY.replace("0.003,1e-5", "0.003,0")))


def test_a_sigma_without_its_channel_is_refused(file):
    assert "sigma_z_m stands without z_m" in refused(read_trajectory, file(TRAJECTORY.replace("sigma_x_m", "sigma_z_m")))


def test_an_unknown_column_is_answered_with_the_nearest(file):
    assert 'unknown column "theta_z_deg"; did you mean "theta_z_rad"?' in refused(
        read_trajectory, file(TRAJECTORY.replace("x_m,sigma_x_m", "x_m,theta_z_deg"))
    )


def test_a_loop_without_a_force_is_told_which_options_would_name_it(file):
    said = refused(read_loop, file(LOOP.replace("force_N", "Load (kN)")))
    assert 'line 1: no column for the force; found "time_s", "elongation_m", "Load (kN)".\nAdd --column force=' in said


def test_a_table_without_time_or_without_any_channel_is_refused(file):
    assert "no column time_s" in refused(read_trajectory, file(TRAJECTORY.replace("time_s", "t")))
    assert "no channel beside time_s" in refused(read_trajectory, file("time_s,status\n0,ok\n1,ok\n"))


def test_two_columns_of_one_name_are_refused(file):
    assert 'two columns are named "force_N"' in refused(read_loop, file(LOOP.replace("elongation_m", "force_N")))


@pytest.mark.parametrize("text", ["", "\n", "time_s,elongation_m,force_N\n", LOOP[: LOOP.index("0.1")]])
def test_a_table_without_rows_is_refused(file, text):
    assert "line 1: no header" in (said := refused(read_loop, file(text))) or "at least two are needed" in said


@pytest.mark.parametrize("content", [b"\xff\xfe\x00t\x00i", b"PK\x03\x04\x80\x81", LOOP.encode("utf-16")])
def test_a_file_that_is_no_text_is_refused(file, content):
    assert "is not a CSV in UTF-8" in refused(read_loop, file(content))


def test_a_missing_file_is_refused(tmp_path):
    assert "no such file" in refused(read_table, tmp_path / "nothing.csv")


@given(st.sampled_from("=+-@"), st.sampled_from(["", " ", "\t", "\r"]), st.text(max_size=8))
def test_words_that_a_spreadsheet_would_run_are_disarmed(sign, blank, rest):
    with TemporaryDirectory() as folder:
        path = Path(folder) / "words.csv"
        write_columns({"file": [blank + sign + rest], sign + "header": [1.0]}, path)
        with open(path, newline="", encoding="utf-8") as written:
            header, row = csv.reader(written)
    assert header[1] == f"'{sign}header"
    assert row[0].startswith("'")
    assert row[0].replace(" ", "") == f"'{blank}{sign}{rest}".replace("\r", "").replace(" ", "")


def test_negative_numbers_are_no_formulas(tmp_path):
    write_columns({"u_m": [-0.5, np.float64(-1e-300)], "count": [-3, np.int64(-4)]}, tmp_path / "n.csv")
    assert (tmp_path / "n.csv").read_text() == "u_m,count\n-0.5,-3\n-1e-300,-4\n"


def test_columns_of_different_lengths_leave_no_file(tmp_path):
    with pytest.raises(ValueError, match="shorter"):
        write_columns({"a": [1.0, 2.0], "b": [1.0]}, tmp_path / "n.csv")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("shape", [(2, 1), (3,), ()])
def test_a_loop_in_memory_is_checked_like_one_from_a_file(shape):
    with pytest.raises(InputError, match="columns differ in length"):
        Loop(np.array([0.0, 0.1]), np.zeros(shape), np.zeros(2))


def test_a_further_column_of_another_length_is_refused():
    with pytest.raises(InputError, match="columns differ in length"):
        Loop(np.array([0.0, 0.1]), np.zeros(2), np.zeros(2), other={"bar": np.zeros(3)})


def test_a_channel_that_is_none_is_answered_with_the_nearest():
    with pytest.raises(InputError, match=r'"z_mm" is not a channel of a trajectory; did you mean "z_m"\?'):
        Trajectory(np.array([0.0, 0.1]), {"z_mm": np.zeros(2)})


def test_a_status_for_some_rows_only_is_refused():
    with pytest.raises(InputError, match="status has 1 rows and time_s 2"):
        Trajectory(np.array([0.0, 0.1]), {"z_m": np.zeros(2)}, status=["ok"])


def test_a_table_of_thousands_of_columns_is_refused(file):
    with pytest.raises(InputError, match="5000 columns; a table has at most 2000"):
        read_table(file(",".join(f"c{k}" for k in range(5000)) + "\n"))


def test_a_quoted_cell_without_an_end_is_refused_in_a_sentence(file):
    with pytest.raises(InputError, match="a cell has more than 131072 characters"):
        read_table(file(f'time_s,x_m\n0,"{"1" * 200_000}"\n'))


def test_a_table_says_what_it_holds_in_a_line():
    time = np.array([0.0, 0.1, 0.25])
    loop = Loop(time, time, time, other={"pressure_bar": time}, name="a.csv")
    assert repr(loop) == "Loop(a.csv: 3 rows, time_s, elongation_m, force_N, pressure_bar)"
    assert (
        repr(Trajectory(time, {"x_m": time, "theta_z_rad": time}, name="b.csv")) == "Trajectory(b.csv: 3 rows to 0.25 s, x_m, theta_z_rad)"
    )
