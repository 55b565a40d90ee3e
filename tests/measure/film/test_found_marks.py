"""Marks that are found by themselves sit on what moves, and the verdict is not `ok` where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from calibration import consistent

from measure.film.moving_places import find_motion, places_that_move
from measure.film.one_body import one_body
from measure.film.track import track
from measure.footage.footage import from_array
from measure.geometry.film_project import make_project
from measure.synthetic.cluttered import cluttered_pictures, cluttered_scene

PROJECT = {"film": {"fps": 100.0}, "scale": {"mm_per_px": 1.0}}


def _made(seed):
    scene = cluttered_scene(seed)
    return scene, from_array(np.array(list(cluttered_pictures(scene, seed))))


def _first(film):
    return next(film.pictures())[1].astype(float)


def _off_px(scene, tracked):
    """Median distance of the trajectory from the truth, px."""
    z, x = (1e3 * tracked.trajectory.channels[channel] for channel in ("z_m", "x_m"))
    return float(np.nanmedian(np.hypot(x - scene.shift_px[:, 0], z + scene.shift_px[:, 1])))


@pytest.mark.parametrize("seed", [0, 3, 9])
def test_marks_are_put_on_what_falls_and_not_on_the_rule_beside_it(seed):
    scene, film = _made(seed)
    places, subset = places_that_move(find_motion(film), 31, 12, fixed=False)
    assert len(places) >= 3
    for x, y in places:
        square = scene.silhouette[round(y) - subset // 2 : round(y) + subset // 2 + 1, round(x) - subset // 2 : round(x) + subset // 2 + 1]
        assert square.mean() > 0.5


def test_a_thing_that_falls_past_clutter_is_measured():
    scene, film = _made(1)
    tracked = track(film, make_project(PROJECT))
    assert tracked.summary["verdict"] == "ok"
    assert _off_px(scene, tracked) < 0.05


def test_a_film_in_which_nothing_moves_says_so():
    _, film = _made(2)
    still = np.repeat(_first(film)[None], 8, axis=0)
    noisy = np.clip(np.rint(still + np.random.default_rng(0).normal(0.0, 1.0, still.shape)), 0, 255).astype(np.uint8)
    assert not find_motion(from_array(noisy)).anything
    assert track(from_array(noisy), make_project(PROJECT)).summary["verdict"] == "still"
    chosen = make_project({**PROJECT, "marks": {"place_px": [(60.0, 60.0), (120.0, 150.0)]}})
    assert track(from_array(noisy), chosen).summary["verdict"] == "still"


def test_a_change_of_the_light_is_no_motion():
    _, film = _made(2)
    darker = np.stack([np.rint(_first(film) * (1.0 - 0.03 * n)) for n in range(8)]).astype(np.uint8)
    assert not find_motion(from_array(darker)).anything


@pytest.fixture
def two_bodies(speckled):
    """Three marks that rise by 40 px, three that go to the right by 40 px, one at rest, one seen in two frames."""

    def make(frames=12):
        from measure.correlation.mark_tracker import Observation
        from measure.correlation.marks import gather, not_observed
        from measure.correlation.reference_image import reference
        from measure.correlation.tracking import responses

        picture = speckled(size=240)
        places = [(40, 180), (80, 180), (120, 180), (40, 60), (80, 60), (120, 60), (180, 120), (200, 200)]
        ways = [(0, -40)] * 3 + [(40, 0)] * 3 + [(0, 0)] * 2
        rows = []
        for t in np.linspace(0.0, 1.0, frames):
            at = [(x + t * dx, y + t * dy) for (x, y), (dx, dy) in zip(places, ways, strict=True)]
            rows.append([Observation(x, y, 1e-4 * np.eye(2), 0.99, 1.0, 0.0, "ok") for x, y in at[:-1]])
            rows[-1].append(Observation(*at[-1], 1e-4 * np.eye(2), 0.99, 1.0, 0.0, "ok") if len(rows) < 3 else not_observed("lost"))
        marks = [reference(picture, x, y, 21) for x, y in places]
        return gather(np.arange(frames) / 100.0, [f"m{i}" for i in range(8)], responses(marks), rows)

    return make


def test_what_does_not_move_as_one_body_is_left_out_with_its_reason(two_bodies):
    found = one_body(two_bodies())
    assert len(found.marks.names) == 3
    reasons = {(one.x_px, one.y_px): one.reason for one in found.left_out}
    assert "stands still" in reasons[180.0, 120.0]
    assert "lost" in reasons[200.0, 200.0]
    assert sum("one body" in reason for reason in reasons.values()) == 3
    assert found.rivals == 3


def test_marks_on_a_wheel_are_one_body_although_they_move_apart(two_bodies):
    from dataclasses import replace

    marks = two_bodies()
    start, angle = marks.reference_px, np.radians(np.linspace(0.0, 60.0, len(marks.time_s)))
    arm = start - [120.0, 120.0]
    x = 120.0 + np.outer(np.cos(angle), arm[:, 0]) - np.outer(np.sin(angle), arm[:, 1])
    y = 120.0 + np.outer(np.sin(angle), arm[:, 0]) + np.outer(np.cos(angle), arm[:, 1])
    found = one_body(replace(marks, x_px=x, y_px=y).only(np.arange(8) < 7))
    assert len(found.marks.names) == 7
    assert not found.rivals


def test_a_chosen_mark_without_texture_is_dropped_and_said():
    scene, film = _made(1)
    rows, columns = np.nonzero(scene.silhouette)
    centre = (float(columns.mean()), float(rows.mean()))
    alone = track(film, make_project({**PROJECT, "marks": {"place_px": [centre], "subset_px": 25}}))
    tracked = track(film, make_project({**PROJECT, "marks": {"place_px": [(3.0, 3.0), centre], "subset_px": 25}}))
    assert tracked.marks.names == ["m2"]
    assert "border" in tracked.summary["left_out"][0]["reason"]
    assert tracked.trajectory is not None
    assert alone.trajectory is not None
    assert np.array_equal(tracked.trajectory.channels["z_m"], alone.trajectory.channels["z_m"])


@pytest.mark.calibrate
def test_the_right_body_is_found_in_19_of_20_scenes_and_none_is_ok_on_the_wrong_one(calibration_seed, share_of, validation_table):
    right, ok = [], []
    for number in range(share_of(40)):
        scene, film = _made(calibration_seed + number)
        tracked = track(film, make_project(PROJECT))
        right.append(_off_px(scene, tracked) < 1.0)
        ok.append(tracked.summary["verdict"] == "ok")
    wrong = int(np.sum(np.array(ok) & ~np.array(right)))
    row = {"scenes": len(right), "right body": sum(right), "ok": sum(ok), "ok on the wrong body": wrong}
    validation_table("marks found before still clutter", [row], "One textured thing that moves; aim 19 of 20, none ok on the wrong body.")
    assert wrong == 0
    assert consistent(sum(right), len(right), 0.95, 1.0), row
