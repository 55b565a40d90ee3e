"""Results as tables and in one line: what a notebook shows."""

from __future__ import annotations

import numpy as np
import pytest

import measure
from measure.film.smoothing import smooth
from measure.synthetic.made_film import pictures, project_for


@pytest.fixture(scope="module")
def made():
    from measure.geometry.camera import Camera
    from measure.synthetic.scene import MadeMark, Scene
    from measure.tables.trajectory import Trajectory

    time = np.linspace(0.0, 0.1, 21)
    motion = Trajectory(time, {"z_m": 0.25 + 2.0 * time**2, "theta_z_rad": time})
    marks = tuple(MadeMark(a, h, 0.017) for h in (-0.011, 0.011) for a in (-0.4, 0.4))
    scene = Scene(200, 160, Camera(0.5e-3, (100.0, 100.0), 0.0, 3.0, (100.0, 80.0)), marks, radius_m=0.055, half_height_m=0.024)
    film = measure.from_array(np.array(list(pictures(motion, scene, fps=100.0, seed=1))))
    return film, project_for(scene, 100.0, 0.25)


@pytest.fixture(scope="module")
def tracked(made):
    return measure.track(*made)


def test_a_tracked_film_is_a_frame_of_its_trajectory(tracked):
    frame = tracked.to_frame()
    assert list(frame["time_s"]) == list(tracked.trajectory.time_s)
    assert np.array_equal(frame["z_m"], tracked.trajectory.channels["z_m"])
    assert frame.attrs["units"]["sigma_theta_z_rad"] == "rad"
    assert frame.attrs["units"]["z_m"] == "m"


def test_marks_are_a_frame_with_a_row_for_each_frame_and_mark(tracked):
    frame = tracked.marks.to_frame()
    assert len(frame) == tracked.marks.x_px.size
    third = frame[(frame["frame"] == 3) & (frame["mark"] == "m2")].iloc[0]
    assert third["x_px"] == tracked.marks.x_px[3, 1]
    assert third["sigma_y_px"] == np.sqrt(tracked.marks.covariance_px2[3, 1, 1, 1])
    assert frame.attrs["units"]["x_px"] == "px"


def test_without_a_scale_the_frame_is_that_of_the_marks(made):
    film, project = made
    pixels = measure.track(film, measure.Project(film=project.film, marks=project.marks))
    assert pixels.trajectory is None
    assert list(pixels.to_frame()["mark"][:4]) == ["m1", "m2", "m3", "m4"]


def test_a_dispersion_is_a_frame_of_differences(tracked):
    table = tracked.trajectory
    other = measure.Trajectory(table.time_s, {"z_m": table.channels["z_m"] + 1e-3}, {"z_m": table.sigma["z_m"]})
    found = measure.compare_trajectories(table, other, "higher")
    frame = found.to_frame()
    assert list(frame.columns) == ["time_s", "z_m", "sigma_z_m"]
    assert frame.attrs["units"]["z_m"] == "m"
    assert found.channels["z_m"].summary()["rms"] == pytest.approx(np.sqrt(np.mean(frame["z_m"].dropna() ** 2)))


def test_smoothed_motion_is_a_frame(tracked):
    table = tracked.trajectory
    made = smooth(table.time_s, table.channels["z_m"], table.sigma["z_m"])
    frame = made.to_frame()
    assert np.array_equal(frame["velocity"], made.value[:, 1])
    assert np.array_equal(frame["sigma_acceleration"], made.sigma[:, 2])


def test_every_result_shows_itself_in_a_line(tracked):
    table = tracked.trajectory
    results = [
        tracked, table, tracked.marks, tracked.fit, tracked.project, measure.compare_trajectories(table, table, "itself"),
        smooth(table.time_s, table.channels["z_m"], table.sigma["z_m"]),
    ]  # fmt: skip
    for result in results:
        assert len(repr(result)) < 300
        assert "\n" not in repr(result)
        assert type(result).__name__ in repr(result)


def test_the_front_door_opens_on_every_name_it_shows():
    for name in measure.__all__:
        assert getattr(measure, name) is not None
    assert set(measure.__all__) == set(dir(measure))
