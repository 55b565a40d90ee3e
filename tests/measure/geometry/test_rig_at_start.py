"""What a film takes from a model file: height and radius of the platform at the start."""

from __future__ import annotations

import pytest

from measure.commands.track_video_options import options, project_from
from measure.common.errors import InputError
from measure.geometry.rig_at_start import read_rig_at_start

JOINTS = "platform_joints_m = [[0.03, 0.04, 0.0], [0.0, 0.05, 0.0], [0.0, 0.05, 0.0], [0.0, 0.05, 0.0], [0.0, 0.05, 0.0], [0.0, 0.05, 0.0]]"


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(f"[geometry]\nstowed_height_m = 0.25\n{JOINTS}\n[release]\nposition_m = [0.1, 0.0, 0.01]\n")
    return path


def test_the_start_is_the_stowed_height_moved_by_the_release_and_the_radius_that_of_the_joints(model):
    rig = read_rig_at_start(model)
    assert rig.start_height_m == pytest.approx(0.26)
    assert rig.radius_m == pytest.approx(0.05)


def test_options_and_the_project_file_count_more_than_the_model(model, tmp_path):
    alone = project_from(options().parse_args(["film.avi", "--model", str(model)]))
    assert (alone.platform.start_height_m, alone.platform.radius_m) == (pytest.approx(0.26), pytest.approx(0.05))
    (tmp_path / "film.toml").write_text("schema = 1\n[platform]\nstart_height_m = 0.0\n")
    words = ["film.avi", "--model", str(model), "--project", str(tmp_path / "film.toml"), "--radius-m", "0.07", "--distance-m", "3"]
    given = project_from(options().parse_args(words))
    assert (given.platform.start_height_m, given.platform.radius_m, given.camera.distance_m) == (0.0, 0.07, 3.0)


@pytest.mark.parametrize(("text", "said"), [("", "no \\[geometry\\] table"), ("[geometry]\nplatform_joints_m = 3\n", "no usable")])
def test_a_model_without_geometry_is_answered_with_the_lines_to_add(tmp_path, text, said):
    (tmp_path / "model.toml").write_text(text)
    with pytest.raises(InputError, match=rf"(?s){said}.*Add\n\[geometry\]\nstowed_height_m = .*--start-height-m H"):
        read_rig_at_start(tmp_path / "model.toml")
