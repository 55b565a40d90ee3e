"""The command, from the outside."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from measure import read_trajectory
from measure.commands.track_video import main
from measure.footage.writers import write_film


@pytest.fixture(scope="module")
def rising(speckled) -> list[np.ndarray]:
    """A speckled picture that rises by 1.5 px a frame."""
    return [speckled((0.0, -1.5 * n), seed=3, size=140, noise_seed=n) for n in range(12)]


@pytest.fixture
def film(rising, tmp_path) -> Path:
    write_film(tmp_path / "film.avi", rising)
    return tmp_path / "film.avi"


def _run(film, tmp_path, *more):
    return main([str(film), "--fps", "250", "--mark", "60,80", "--mark", "95,75.5", "-o", str(tmp_path / "out.csv"), "--quiet", *more])


def test_a_rising_platform_rises_in_millimetres(film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--start-height-m", "0.252", "--json", str(tmp_path / "r.json")) == 0
    table = read_trajectory(tmp_path / "out.csv")
    assert np.allclose(table.time_s, np.arange(12) / 250)
    assert np.abs(table.channels["z_m"] - 0.252 - 0.75e-3 * np.arange(12)).max() < 2e-5
    assert np.abs(table.channels["theta_y_rad"]).max() < 2e-3
    assert set(table.sigma) == {"x_m", "z_m", "theta_y_rad"}
    assert json.loads((tmp_path / "r.json").read_text())["verdict"] == "ok"
    assert (tmp_path / "out.png").stat().st_size > 5000
    assert (tmp_path / "out.csv.provenance.json").exists()


def test_the_summary_says_how_far_the_platform_went_and_its_instants_where_there_are_enough_frames(film, rising, tmp_path):
    found = []
    for frames in (12, 6):
        write_film(tmp_path / "film.avi", rising[:frames])
        assert _run(film, tmp_path, "--mm-per-px", "0.5", "--json", str(tmp_path / "r.json")) == 0
        found.append(json.loads((tmp_path / "r.json").read_text())["platform"])
    assert [one["frames_with_pose"] for one in found] == [12, 6]
    assert [one["range"]["z_m"] for one in found] == [pytest.approx(0.75e-3 * steps, abs=2e-5) for steps in (11, 5)]
    assert [set(one["instants"]) for one in found] == [{"release_s", "fastest_s", "end_of_stroke_s"}, set()]


def test_pictures_of_the_marks_are_written_where_asked(film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--pictures", str(tmp_path / "look")) == 0
    assert {p.name for p in (tmp_path / "look").iterdir()} == {"first_frame.png", "contact_sheet.png", "quality.png"}


def test_the_overlay_shows_every_frame_with_its_marks(film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--overlay", str(tmp_path / "seen.avi")) == 0
    shown = cv2.VideoCapture(str(tmp_path / "seen.avi"))
    frames = []
    while (read := shown.read())[0]:
        frames.append(read[1].astype(int))
    assert len(frames) == 12
    green = frames[-1][..., 1] - frames[-1][..., 2]
    rows, columns = np.nonzero(green > 60)
    assert abs(columns.min() / 4 - (60 - 15.5)) < 2.0
    assert abs(rows.max() / 4 - (80 - 1.5 * 11 + 15.5)) < 2.0


def test_a_film_compared_with_itself_a_frame_later_does_not_disperse(rising, film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5") == 0
    (tmp_path / "out.csv").rename(tmp_path / "first.csv")
    write_film(tmp_path / "late.avi", rising[1:])
    options = ["--mark", "60,78.5", "--mark", "95,74", "--mm-per-px", "0.5", "--start-height-m", "0.00075", "--quiet", "--fps", "250"]
    files = ["-o", str(tmp_path / "out.csv"), "--compare", str(tmp_path / "first.csv"), "--json", str(tmp_path / "r.json")]
    assert main([str(tmp_path / "late.avi"), *options, *files]) == 0
    found = json.loads((tmp_path / "r.json").read_text())["dispersion"][0]
    assert abs(found["shift_s"] - 0.004) < 2e-4
    assert found["channels"]["z_m"]["rms_percent"] < 0.5
    assert (tmp_path / "out.dispersion.png").stat().st_size > 5000


def test_a_known_length_gives_the_same_scale(film, tmp_path):
    assert _run(film, tmp_path, "--scale-from", "10,10,40,50,25") == 0
    assert abs(read_trajectory(tmp_path / "out.csv").channels["z_m"][-1] - 0.5e-3 * 1.5 * 11) < 2e-5


def test_a_painted_mask_is_used_and_kept_in_the_project(film, tmp_path):
    mask = np.zeros((140, 140), np.uint8)
    for x, y in ((60, 80), (95, 75)):
        cv2.circle(mask, (x, y), 13, 255, -1)
    cv2.imwrite(str(tmp_path / "mask.png"), mask)
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--mask", str(tmp_path / "mask.png")) == 0
    first = (tmp_path / "out.csv").read_bytes()
    assert main(["--project", str(tmp_path / "out.project.toml"), "-o", str(tmp_path / "again.csv"), "--quiet"]) == 0
    assert (tmp_path / "again.csv").read_bytes() == first
    assert _run(film, tmp_path, "--mm-per-px", "0.5") == 0
    assert (tmp_path / "out.csv").read_bytes() != first


def test_what_is_not_known_of_the_scale_is_said(film, tmp_path, capsys):
    options = ["--fps", "250", "--mark", "60,80", "--scale-from", "10,10,40,50,25", "-o", str(tmp_path / "out.csv")]
    assert main([str(film), *options, "--json", str(tmp_path / "r.json")]) == 0
    assert json.loads((tmp_path / "r.json").read_text())["scale"]["relative_sigma"] == pytest.approx(0.5 * np.sqrt(2) / 50)
    assert "0.5 mm/px +- 1.4 %" in capsys.readouterr().out


def test_the_project_file_repeats_the_run(film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--up", "2.5", "--subset", "25") == 0
    first = (tmp_path / "out.csv").read_bytes()
    assert main(["--project", str(tmp_path / "out.project.toml"), "-o", str(tmp_path / "again.csv"), "--quiet"]) == 0
    assert (tmp_path / "again.csv").read_bytes() == first


def test_a_project_file_is_read_and_never_written(film, tmp_path):
    """With comments and half of what a run needs; what repeats the run stands beside the output."""
    project = tmp_path / "mine.toml"
    project.write_text(
        "# measured by Anna\n[film]\nfps = 250.0   # set on the camera\n[scale]\nmm_per_px = 0.5\n[marks]\nplace_px = [[60, 80]]\n"
    )
    before = project.read_bytes()
    assert main([str(film), "--project", str(project), "-o", str(tmp_path / "out.csv"), "--quiet"]) == 0
    assert project.read_bytes() == before
    first = (tmp_path / "out.csv").read_bytes()
    assert main(["--project", str(tmp_path / "out.project.toml"), "-o", str(tmp_path / "again.csv"), "--quiet"]) == 0
    assert (tmp_path / "again.csv").read_bytes() == first


def test_a_project_file_beside_the_output_is_not_written_either(film, tmp_path):
    assert _run(film, tmp_path, "--mm-per-px", "0.5") == 0
    project = tmp_path / "out.project.toml"
    project.write_text("# our camera\n" + project.read_text())
    before = project.read_bytes()
    same = ["--project", str(project), "-o", str(tmp_path / "out.csv"), "--quiet"]
    assert main(same) == 0
    assert not (tmp_path / "out.repeat.project.toml").exists()
    assert main([*same, "--mm-per-px", "0.25"]) == 0
    assert project.read_bytes() == before
    assert "mm_per_px = 0.25" in (tmp_path / "out.repeat.project.toml").read_text()


@pytest.mark.parametrize("option", ["-o", "--marks", "--json", "--overlay"])
def test_an_input_is_never_an_output(option, film, tmp_path, capsys):
    before = film.read_bytes()
    assert main([str(film), "--fps", "250", "--mark", "60,80", "--mm-per-px", "0.5", option, str(film)]) == 2
    assert "is an input" in capsys.readouterr().err
    assert film.read_bytes() == before


def test_all_that_is_missing_is_asked_for_at_once_and_the_film_before_that(film, tmp_path, capsys):
    assert main([str(film), "--compare", str(film)]) == 2
    said = capsys.readouterr().err
    for part in ("no capture rate", "no scale", "--compare needs", "--start-height-m", "--radius-m", "--distance-m"):
        assert part in said
    assert main([str(tmp_path / "none.avi")]) == 2
    assert "no such file" in (said := capsys.readouterr().err)
    assert "capture rate" not in said


def test_what_is_assumed_is_said_and_nothing_where_all_is_given(film, tmp_path, capsys):
    options = [str(film), "--fps", "250", "--mark", "60,80", "--mm-per-px", "0.5", "-o", str(tmp_path / "out.csv")]
    assert main(options) == 0
    said = capsys.readouterr().out
    assert all(option in said for option in ("--start-height-m", "--radius-m", "--distance-m"))
    assert main([*options, "--start-height-m", "0.25", "--radius-m", "0.5", "--distance-m", "3"]) == 0
    assert "assumed   no" not in capsys.readouterr().out


def test_marks_table_has_a_row_per_frame_and_mark(film, tmp_path):
    assert main([str(film), "--fps", "250", "--mark", "60,80", "--marks", str(tmp_path / "marks.csv"), "--quiet"]) == 0
    rows = (tmp_path / "marks.csv").read_text().splitlines()
    assert rows[0].startswith("frame,time_s,mark,x_px,y_px,zncc,status")
    assert len(rows) == 13
    assert not (tmp_path / "trajectory.csv").exists()


def test_a_cut_film_ends_with_status_one_and_is_called_incomplete(film, tmp_path, capsys):
    data = film.read_bytes()
    film.write_bytes(data[: int(0.6 * len(data))])
    assert main([str(film), "--fps", "250", "--mark", "60,80", "--mm-per-px", "0.5", "-o", str(tmp_path / "out.csv")]) == 1
    assert "the film is incomplete" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--mm-per-px", "0.5"], "carries no capture rate"),
        (["--fps", "250"], "no scale, so no metres"),
        (["--fps", "250", "--mm-per-px", "-1"], "scale.mm_per_px"),
        (["--fps", "nan", "--mm-per-px", "1"], "finite number"),
        (["--fps", "250", "--mm-per-px", "1", "--subset", "30"], "odd number"),
        (["--fps", "250", "--mm-per-px", "1", "--mark", "1"], "not 2 numbers"),
        (["--fps", "250", "--mm-per-px", "1", "--mark", "3,3"], "reaches over the border"),
        (["--fps", "250", "--mm-per-px", "1", "--marc", "3,3"], "--mark"),
        (["--fps", "250", "--mm-per-px", "1", "--scale-from", "0,0,1,1,1"], "give one"),
        (["--fps", "250", "--rule", "5,5,135,135,1", "--mark", "60,80"], "no graduation"),
        (["--fps", "250", "--mm-per-px", "1", "--plumb", "5,5,5,500"], "reaches out of the picture"),
        (["--fps", "250", "--mm-per-px", "1", "--checkerboard", "boards"], "give both"),
        (["--fps", "250", "--scale-from", "5,5,5,5,10"], "px apart"),
        (["--fps", "250", "--mm-per-px", "1", "--overlay", "seen.mp4"], "name it so"),
        (["--fps", "250", "--mm-per-px", "1", "--compare", "other.csv"], "no such file"),
        (["--fps", "250", "--mm-per-px", "1", "--json", "/nowhere/r.json"], "does not exist"),
    ],
)
def test_wrong_options_end_in_one_sentence_and_nothing_is_written(options, says, film, tmp_path, capsys):
    before = sorted(tmp_path.iterdir())
    output = [] if "no scale" in says else ["-o", str(tmp_path / "out.csv")]
    assert main([str(film), *output, *options]) == 2
    assert says in capsys.readouterr().err
    assert sorted(tmp_path.iterdir()) == before


def test_the_warp_is_an_option_and_shown_in_the_project(film, tmp_path, capsys):
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--warp", "translation") == 0
    assert 'warp = "translation"' in (tmp_path / "out.project.toml").read_text()
    assert _run(film, tmp_path, "--mm-per-px", "0.5", "--warp", "perspective") == 2
    assert "'translation', 'euclidean' or 'affine'" in capsys.readouterr().err


def test_an_unknown_key_of_the_project_is_answered_with_the_nearest(film, tmp_path, capsys):
    (tmp_path / "p.toml").write_text("schema = 1\n[platform]\nradius_mm = 60\n")
    assert main([str(film), "--project", str(tmp_path / "p.toml")]) == 2
    assert 'did you mean "radius_m"?' in capsys.readouterr().err


def test_a_missing_film_is_said(tmp_path, capsys):
    assert main([str(tmp_path / "none.avi"), "--fps", "250", "--mm-per-px", "1"]) == 2
    assert "no such file" in capsys.readouterr().err
