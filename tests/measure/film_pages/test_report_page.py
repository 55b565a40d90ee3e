"""The page with the result: pictures under a slider, curves in step, quality, remarks, provenance."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from measure import read_trajectory
from measure.commands.track_video import main
from measure.footage.writers import write_film


@pytest.fixture(scope="module")
def result(tmp_path_factory, speckled) -> Path:
    """A rising film of 14 frames, of which one is used from the third on, with one mark that cannot be tracked."""
    folder = tmp_path_factory.mktemp("report")
    write_film(folder / "film.avi", [speckled((0.0, -1.5 * n), seed=3, size=140, noise_seed=n) for n in range(14)])
    words = [str(folder / "film.avi"), "--fps", "250", "--mark", "60,80", "--mark", "95,75.5", "--mark", "3,3", "--mm-per-px", "0.5"]
    words += ["--from", "0.008", "-o", str(folder / "out.csv"), "--report", str(folder / "page.html"), "--pictures", str(folder / "look")]
    assert main([*words, "--quiet"]) == 0
    return folder


def test_the_slider_moves_pictures_marks_and_curves(result, browser):
    table = read_trajectory(result / "out.csv")
    assert np.allclose(table.time_s, np.arange(2, 14) / 250)
    browser.open(result / "page.html")
    assert browser.value("document.getElementById('frame').max") == "11"
    seen = []
    for k in (0, 7):
        browser.value(f"(() => {{const f = document.getElementById('frame'); f.value = {k}; f.dispatchEvent(new Event('input'))}})()")
        browser.value("new Promise((done) => setTimeout(done, 100))")
        seen.append(browser.value("[document.getElementById('said').textContent, document.getElementById('now').textContent, "
                                  "document.querySelector('.now').getAttribute('x1'), view.canvas.toDataURL()]"))  # fmt: skip
        assert seen[-1][0].startswith(f"{k + 2}, {(k + 2) / 250:g}")
    assert f"z {1e3 * table.channels['z_m'][7]:.2f}"[:5] in seen[1][1]
    assert float(seen[1][2]) > float(seen[0][2])
    assert seen[0][3] != seen[1][3]
    assert browser.complaints == []
    assert browser.asked_for == [(result / "page.html").resolve().as_uri()]


def test_a_click_on_a_curve_goes_to_that_frame(result, browser):
    browser.open(result / "page.html")
    box = browser.value("(() => {const s = document.querySelector('#curves svg'); s.scrollIntoView({block: 'center'}); "
                        "const b = s.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]})()")  # fmt: skip
    browser.click(box[0] + 0.985 * box[2], box[1] + box[3] / 2)
    assert browser.value("document.getElementById('frame').value") == "11"


def test_it_says_what_was_left_out_what_made_it_and_where_marks_were(result, browser):
    browser.open(result / "page.html")
    text = browser.value("document.body.innerText")
    for part in ("ok", "3.0, 3.0 px: its subset", "12 of 12 frames", "0.008 to 0.052 s", "m1", "sha256", "0.5 mm/px"):
        assert part in text, part
    assert browser.value("document.querySelectorAll('.strip rect').length") == 2


@pytest.mark.parametrize("width", [1280, 390])
def test_nothing_is_wider_than_the_window(result, browser, width):
    browser.open(result / "page.html", width=width)
    assert browser.value("document.documentElement.scrollWidth") <= width


def test_the_first_frame_is_drawn_in_the_pixels_of_the_film(result):
    """The squares around the marks, read off the picture, are those of the film."""
    drawn = np.asarray(cv2.imread(str(result / "look" / "first_frame.png"))).astype(int)
    assert drawn.shape[:2] == (140, 140)
    rows, columns = np.nonzero(drawn[..., 1] - drawn[..., 2] > 60)
    assert abs(columns.min() - (60 - 15.5)) <= 1
    assert abs(columns.max() - (95 + 15.5)) <= 1
    assert abs(rows.max() - (80 + 15.5)) <= 1


def test_without_a_scale_the_marks_are_the_curves(tmp_path, speckled, browser):
    write_film(tmp_path / "film.avi", [speckled((0.0, -1.5 * n), seed=3, size=140, noise_seed=n) for n in range(6)])
    words = [str(tmp_path / "film.avi"), "--fps", "250", "--mark", "60,80", "--marks", str(tmp_path / "m.csv"), "--quiet"]
    assert main([*words, "--report", str(tmp_path / "page.html")]) == 0
    browser.open(tmp_path / "page.html")
    assert browser.value("document.querySelectorAll('#curves svg').length") == 2
    assert browser.complaints == []
