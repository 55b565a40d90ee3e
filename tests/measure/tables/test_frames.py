"""Tables as pandas frames: nothing is lost on the way there and back, and every column knows its unit."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from measure import InputError, Loop, Trajectory
from measure.tables.frames import frame_of, unit_in_name

T = np.array([0.0, 0.1, 0.2])
LOOP = Loop(T, np.array([0.1, 0.2, 0.3]), np.array([2.8, 2.9, 3.0]), name="one.csv", other={"pressure_bar": np.array([1.0, np.nan, 2.0])})
SEEN = {"x_m": np.array([0.0, np.nan, 2e-3]), "theta_z_rad": T}
TRAJECTORY = Trajectory(T, SEEN, {"x_m": np.full(3, 1e-5)}, ["ok", "lost", "ok"], name="film.csv")


def test_a_loop_survives_its_frame():
    frame = LOOP.to_frame()
    back = Loop.from_frame(frame)
    assert list(frame.columns) == ["time_s", "elongation_m", "force_N", "pressure_bar"]
    assert back.name == "one.csv"
    assert back.force_N.tobytes() == LOOP.force_N.tobytes()
    assert np.array_equal(back.other["pressure_bar"], LOOP.other["pressure_bar"], equal_nan=True)


def test_a_trajectory_survives_its_frame():
    frame = TRAJECTORY.to_frame()
    back = Trajectory.from_frame(frame)
    assert list(frame.columns) == ["time_s", "x_m", "sigma_x_m", "theta_z_rad", "status"]
    assert np.array_equal(back.channels["x_m"], SEEN["x_m"], equal_nan=True)
    assert back.sigma["x_m"].tobytes() == TRAJECTORY.sigma["x_m"].tobytes()
    assert list(back.status) == ["ok", "lost", "ok"]


def test_units_stand_in_the_attributes_of_a_frame():
    assert LOOP.to_frame().attrs["units"] == {"time_s": "s", "elongation_m": "m", "force_N": "N", "pressure_bar": "bar"}
    assert frame_of({"load": [1.0]}, {"load": "kN"}).attrs["units"] == {"load": "kN"}


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("speed_m_per_s", "m/s"),
        ("beta_per_m", "1/m"),
        ("damping_N_s_per_m", "N s/m"),
        ("inertia_kg_m2", "kg m2"),
        ("quadratic_N_per_m2", "N/m2"),
        ("sigma_theta_z_rad", "rad"),
        ("status", ""),
        ("zncc", ""),
        ("theta_z", ""),
    ],
)
def test_a_name_tells_its_unit(name, unit):
    assert unit_in_name(name) == unit


def test_a_frame_is_checked_like_a_file():
    frame = LOOP.to_frame()
    with pytest.raises(InputError, match="no column for the force"):
        Loop.from_frame(frame.drop(columns="force_N"))
    with pytest.raises(InputError, match="must increase"):
        Loop.from_frame(frame.iloc[::-1])
    with pytest.raises(InputError, match="unknown column"):
        Trajectory.from_frame(frame)
    with pytest.raises(InputError, match='two columns are named "x_m"'):
        Trajectory.from_frame(pd.DataFrame([[0.0, 0.0, 1.0]], columns=["time_s", "x_m", "x_m"]))
