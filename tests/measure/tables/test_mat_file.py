"""Tables as MATLAB files: every number and unit arrives, and the same table gives the same bytes."""

import numpy as np
import pytest
from scipy.io import loadmat

from measure import InputError, Loop, Trajectory, write_mat
from measure.tables.mat_file import HasFrame

T = np.linspace(0.0, 1.0, 20)
LOOP = Loop(T, 0.1 + 0.01 * np.sin(6 * T), 2.8 + 0.1 * np.cos(6 * T), other={"oil pressure (bar)": 3 + T})


def test_a_loop_arrives_in_matlab_with_its_units(tmp_path):
    write_mat(LOOP, tmp_path / "l.mat")
    read = loadmat(tmp_path / "l.mat", simplify_cells=True)["loop"]
    np.testing.assert_array_equal(read["force_N"], LOOP.force_N)
    np.testing.assert_array_equal(read["oil_pressure_bar"], 3 + T)
    assert read["units"]["force_N"] == "N"
    assert read["units"]["elongation_m"] == "m"


def test_what_was_not_seen_is_nan_and_words_are_words(tmp_path):
    x = np.where(T > 0.5, np.nan, T)
    film = Trajectory(T, {"x_m": x}, status=["ok"] * 19 + ["lost"])
    write_mat(film, tmp_path / "t.mat", name="film 1")
    read = loadmat(tmp_path / "t.mat", simplify_cells=True)["film_1"]
    np.testing.assert_array_equal(read["x_m"], x)
    assert list(read["status"])[-2:] == ["ok", "lost"]


def test_rows_that_have_names_keep_them(tmp_path):
    from pandas import DataFrame

    class Fit:
        def to_frame(self) -> DataFrame:
            return DataFrame({"value": [1.0, 2.0]}, index=["b_l_N", "beta_per_m"])

    fit: HasFrame = Fit()
    write_mat(fit, tmp_path / "f.mat")
    read = loadmat(tmp_path / "f.mat", simplify_cells=True)["fit"]
    assert list(read["row"]) == ["b_l_N", "beta_per_m"]
    assert list(read["value"]) == [1.0, 2.0]


def test_the_same_table_gives_the_same_bytes_and_no_folder_a_sentence(tmp_path):
    write_mat(LOOP, tmp_path / "a.mat")
    write_mat(LOOP, tmp_path / "b.mat")
    assert (tmp_path / "a.mat").read_bytes() == (tmp_path / "b.mat").read_bytes()
    assert b"Created on" not in (tmp_path / "a.mat").read_bytes()
    with pytest.raises(InputError, match="cannot be written"):
        write_mat(LOOP, tmp_path / "no" / "a.mat")
