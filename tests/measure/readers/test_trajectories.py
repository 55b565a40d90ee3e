"""Trajectories of other programs: the motion that was written is the one that is read, and a file that says too little asks."""

import time

import numpy as np
import pytest

from measure.common.errors import InputError, OptionsMissing
from measure.geometry.camera import rotation
from measure.readers.column_mapping import ColumnMapping
from measure.readers.measurement import read_measurement
from measure.readers.trajectories.tracker import tracker_head
from measure.tables.trajectory import CHANNELS, Trajectory

pytestmark = pytest.mark.filterwarnings("ignore:No analog data")  # of c3d, when it writes
FRAMES, RATE_HZ = 120, 200.0
TIME = np.arange(FRAMES) / RATE_HZ
BODY = np.array([[0.12, 0.0, 0.01], [-0.06, 0.10, 0.0], [-0.06, -0.10, 0.02], [0.02, 0.03, 0.05]])
NAMES = ("A", "B", "C", "D")


def motion():
    """A pose for each frame, zero in the first: a rise with a turn of more than half a turn, and tilts."""
    s = TIME / TIME[-1]
    return np.stack([0.01 * s, -0.02 * s**2, 0.4 * s**2, 0.05 * s, -0.08 * s**2, 4.0 * s], axis=1)


def points(pose=None, noise_m=0.0):
    """Positions (frames, markers, 3) with z up, around somewhere in the laboratory."""
    pose = motion() if pose is None else pose
    place = np.einsum("kij,mj->kmi", rotation(pose[:, 3:]), BODY - BODY.mean(axis=0)) + pose[:, None, :3]
    return place + np.array([1.0, -2.0, 0.8]) + noise_m * np.random.default_rng(7).normal(size=place.shape)


def y_up(place):
    """The same positions in axes of which y points up: X = x, Y = z, Z = -y."""
    return np.stack([place[..., 0], place[..., 2], -place[..., 1]], axis=-1)


def write_trc(path, place, names=NAMES, unit="mm", scale=1e3):
    head = [
        "PathFileType\t4\t(X/Y/Z)\tfilm.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{RATE_HZ}\t{RATE_HZ}\t{len(place)}\t{len(names)}\t{unit}\t{RATE_HZ}\t1\t{len(place)}",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(len(names)) for axis in "XYZ"),
        "",
    ]
    rows = [
        "\t".join([str(k + 1), f"{k / RATE_HZ:.6f}", *("" if np.isnan(v) else f"{scale * v:.9f}" for v in row.ravel())])
        for k, row in enumerate(place)
    ]
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    return path


def write_c3d(path, place, names=NAMES, up="+Z", across="+X", unit="mm  "):
    import c3d

    writer = c3d.Writer(point_rate=RATE_HZ, point_scale=-1.0, point_units=unit)
    writer.set_point_labels(list(names))
    writer.set_screen_axis(across, up)
    for row in place:
        shown = np.zeros((len(names), 5), np.float32)
        lost = np.isnan(row[:, 0])
        shown[:, :3] = np.where(lost[:, None], 0.0, 1e3 * row)
        shown[lost, 3:] = -1.0
        writer.add_frames([(shown, np.zeros((0, 0)))])
    with open(path, "wb") as file:
        writer.write(file)
    return path


def poses(table):
    return np.stack([table.channels[name] for name in CHANNELS], axis=1)


def read(path, **wanted):
    table = read_measurement(path, ColumnMapping(**wanted))
    assert isinstance(table, Trajectory)
    return table


def test_the_pose_of_a_turning_body_is_read_from_a_trc_file(tmp_path):
    table = read(write_trc(tmp_path / "film.trc", points()), up="z")
    np.testing.assert_allclose(poses(table), motion(), atol=1e-9)
    np.testing.assert_allclose(table.time_s, TIME, atol=1e-9)


def test_the_same_motion_with_y_up_gives_the_same_trajectory(tmp_path):
    table = read(write_trc(tmp_path / "film.trc", y_up(points())), up="y")
    np.testing.assert_allclose(poses(table), motion(), atol=1e-9)


def test_axes_that_point_the_other_way_can_be_named(tmp_path):
    turned = points() @ np.diag([-1.0, 1.0, -1.0])
    table = read(write_trc(tmp_path / "film.trc", turned), up="-z", across="-x")
    np.testing.assert_allclose(poses(table), motion(), atol=1e-9)


def test_a_c3d_file_says_its_axes_unit_and_rate_itself(tmp_path):
    table = read(write_c3d(tmp_path / "film.c3d", y_up(points()), up="+Y"))
    np.testing.assert_allclose(poses(table), motion(), atol=2e-6)  # single precision of millimetres: 1e-7 m
    np.testing.assert_allclose(table.time_s, TIME, atol=1e-9)


def test_an_option_wins_over_what_the_file_says(tmp_path):
    table = read(write_c3d(tmp_path / "film.c3d", points(), up="+Y"), up="z")
    np.testing.assert_allclose(poses(table), motion(), atol=2e-6)


@pytest.mark.parametrize("write", [write_trc, write_c3d])
def test_what_was_not_seen_is_missing_and_two_lost_markers_leave_no_pose(tmp_path, write):
    place = points()
    place[10:20, 3] = np.nan
    place[30:35, 1:3] = np.nan
    table = read(write(tmp_path / f"film.{write.__name__[-3:]}", place), up="z")
    assert set(table.status[10:20]) == {"partial"}
    assert set(table.status[30:35]) == {"lost"}
    lost = np.zeros(FRAMES, bool)
    lost[30:35] = True
    assert np.isnan(poses(table)[lost]).all()
    np.testing.assert_allclose(poses(table)[~lost], motion()[~lost], atol=2e-6)


def test_the_table_begins_where_the_body_is_first_seen(tmp_path):
    place = points()
    place[:4, :3] = np.nan
    table = read(write_trc(tmp_path / "film.trc", place), up="z")
    assert table.time_s[0] == pytest.approx(TIME[4])
    np.testing.assert_allclose(poses(table)[0], 0.0, atol=1e-12)


def test_a_marker_that_comes_later_is_part_of_the_body_from_then_on(tmp_path):
    place = points(noise_m=1e-4)
    place[:60, 3] = np.nan
    table = read(write_trc(tmp_path / "film.trc", place), up="z")
    assert table.sigma["z_m"][80] == pytest.approx(np.sqrt(3 / 4) * table.sigma["z_m"][30], rel=0.1)
    assert (table.status[0], table.status[80]) == ("partial", "ok")


@pytest.mark.parametrize("noise_m", [2e-5, 5e-4])
def test_sigma_is_the_scatter_of_the_pose(tmp_path, noise_m):
    still = np.zeros((FRAMES, 6)) + motion()[70]
    table = read(write_trc(tmp_path / "film.trc", points(still, noise_m)), up="z")
    for name in CHANNELS:
        scatter = np.std(table.channels[name], ddof=1)
        assert scatter == pytest.approx(np.median(table.sigma[name]), rel=4 / np.sqrt(2 * FRAMES)), name


def test_one_marker_gives_its_positions_alone(tmp_path):
    place = points()
    table = read(write_trc(tmp_path / "film.trc", place), up="z", markers=("C",))
    assert tuple(table.channels) == ("x_m", "y_m", "z_m")
    np.testing.assert_allclose(table.channels["z_m"], place[:, 2, 2] - place[0, 2, 2], atol=1e-9)
    assert not table.sigma


def test_three_zeros_are_a_gap_in_a_trc_file(tmp_path):
    place = points()
    place[50, 0] = 0.0
    assert read(write_trc(tmp_path / "film.trc", place), up="z").status[50] == "partial"


def test_a_small_body_in_much_noise_is_still_a_body(tmp_path):
    table = read(write_trc(tmp_path / "film.trc", points(noise_m=8e-3)), up="z")
    assert np.median(table.sigma["z_m"]) == pytest.approx(4e-3, rel=0.2)


REFUSED = {
    "which of its axes points up": ({}, None),
    'no marker "E"': ({"up": "z", "markers": ("A", "B", "E")}, None),
    "two markers fix no rotation": ({"up": "z", "markers": ("A", "B")}, None),
    "one axis": ({"up": "z", "across": "-z"}, None),
    "on one line": ({"up": "z"}, lambda p: p[:, :1] + np.linspace(0, 1, 4)[:, None] * np.array([0.1, 0.2, 0.0])),
    "do not move as one body: they miss it by": ({"up": "z"}, lambda p: np.where(np.arange(4)[:, None] == 3, p[:1], p)),
    "at most 2": ({"up": "z"}, lambda p: np.where(np.arange(4)[:, None] < 2, np.nan, p)),
}


@pytest.mark.parametrize("said", REFUSED)
def test_markers_that_say_too_little_are_refused_with_what_to_do(tmp_path, said):
    wanted, change = REFUSED[said]
    path = write_trc(tmp_path / "film.trc", points() if change is None else change(points()))
    with pytest.raises(InputError, match=said):
        read(path, **wanted)


def test_the_unit_is_asked_for_where_the_file_has_none(tmp_path):
    path = write_trc(tmp_path / "film.trc", points(), unit="")
    with pytest.raises(OptionsMissing, match="--unit position=mm"):
        read(path, up="z")
    np.testing.assert_allclose(poses(read(path, up="z", units={"position": "mm"})), motion(), atol=1e-9)


DAMAGED = {
    "no number": lambda text: text.replace("\n5\t0.02", "\n5\thalf", 1),
    "cells, and the head has": lambda text: text.replace("\n5\t", "\n5\t1\t2\t3\t", 1),
    "each once": lambda text: text.replace("\tB\t", "\tA\t", 1),
    "is no table of markers": lambda text: text[:200],
    "must increase": lambda text: text.replace("\t0.010000\t", "\t0.005000\t", 1),
}


@pytest.mark.parametrize("said", DAMAGED)
def test_a_damaged_trc_file_is_refused(tmp_path, said):
    path = write_trc(tmp_path / "film.trc", points())
    path.write_text(DAMAGED[said](path.read_text()))
    with pytest.raises(InputError, match=said):
        read(path, up="z")


@pytest.mark.parametrize("kept", [3, 600, 3000])
def test_a_cut_c3d_file_is_refused(tmp_path, kept):
    path = write_c3d(tmp_path / "film.c3d", points())
    path.write_bytes(path.read_bytes()[:kept])
    with pytest.raises(InputError, match=r"film\.c3d"):
        read(path)


def tracker(path, head, x, y, theta=None, sign="\t", comma=False):
    columns = [TIME, x, y, *([] if theta is None else [theta])]
    rows = [sign.join("" if np.isnan(v) else f"{v:.9E}" for v in row) for row in np.stack(columns, axis=1)]
    text = "\n".join([*head, *rows]) + "\n"
    path.write_text(text.replace(".", ",") if comma else text, encoding="utf-8")
    return path


X, Z, TURN = 0.3 + 0.01 * TIME, 0.1 + 0.5 * TIME**2, 0.2 * TIME


@pytest.mark.parametrize(
    ("head", "sign", "comma"),
    [
        (["mass_A\t\t", "t\tx\ty"], "\t", False),
        (["#mass A", "t,x,y"], ",", False),
        (["mass_A", "t (s);x (m);y (m)"], ";", True),
        (["t\tx\ty\t"], "\t", True),
    ],
)
def test_trackers_table_is_read_whatever_its_delimiter(tmp_path, head, sign, comma):
    table = read(tracker(tmp_path / "track.txt", head, X, Z, sign=sign, comma=comma), units={"position": "m"})
    np.testing.assert_allclose(table.channels["x_m"], X - X[0], atol=1e-9)
    np.testing.assert_allclose(table.channels["z_m"], Z - Z[0], atol=1e-9)


def test_trackers_angle_is_anticlockwise_and_its_units_stand_in_the_header(tmp_path):
    path = tracker(tmp_path / "track.txt", ["mass_A", "t\tx (cm)\ty (cm)\tθ (deg)"], 100 * X, 100 * Z, np.degrees(1.0 + TURN))
    table = read(path)
    np.testing.assert_allclose(table.channels["theta_y_rad"], -TURN, atol=1e-9)
    np.testing.assert_allclose(table.channels["z_m"], Z - Z[0], atol=1e-9)


def test_gaps_of_trackers_table_are_missing_and_leading_ones_left_away(tmp_path):
    x = np.where((TIME < 0.01) | (np.abs(TIME - 0.2) < 0.02), np.nan, X)
    table = read(tracker(tmp_path / "track.txt", ["t\tx\ty"], x, Z), units={"position": "m"})
    assert table.time_s[0] == pytest.approx(0.01)
    assert np.isnan(table.channels["x_m"]).sum() == np.sum(np.isnan(x)) - 2


@pytest.mark.parametrize("cell", ["a" + " " * 4000 + "x", "x [" + " " * 4000 + "m", "[" * 4000, "x" + " (" * 2000])
def test_a_head_of_thousands_of_blanks_does_not_take_the_square_of_them(tmp_path, cell):
    path, begun = tracker(tmp_path / "track.txt", [f"{cell}\tt\tx\ty"], X, Z), time.process_time()
    assert tracker_head((cell + "\t") * 50 + "\n" + path.read_text()) is not None
    assert time.process_time() - begun < 2.0


def test_trackers_table_without_a_unit_asks_for_it(tmp_path):
    path = tracker(tmp_path / "track.txt", ["t\tx\ty\ttheta"], X, Z, TURN)
    with pytest.raises(OptionsMissing, match="--unit position=UNIT --unit angle=UNIT"):
        read(path)


def test_several_tracks_in_one_table_are_refused(tmp_path):
    path = tracker(tmp_path / "track.txt", ["#multi:", "\tA\t\tB\t", "t\tx\ty\tx"], X, Z, X)
    with pytest.raises(InputError, match="several tracks"):
        read(path, units={"position": "m"})


@pytest.mark.parametrize("force", ["Load (kN)", "F", "Standardkraft"])
def test_a_table_with_a_force_beside_x_and_y_is_a_loop(tmp_path, force):
    path = tracker(tmp_path / "bench.txt", [f"t\tx\ty\t{force}"], X, Z, TURN)
    with pytest.raises(InputError, match="elongation"):
        read(path)
