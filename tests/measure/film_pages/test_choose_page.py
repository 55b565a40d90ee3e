"""The page on which marks and scale are chosen, driven by clicks."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from measure.commands.track_video import main
from measure.footage.formats import open_footage
from measure.footage.writers import write_film
from measure.geometry.film_project import make_project, read_project

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"

TYPED = {
    "#fps": 250,
    "[data-key='film.exposure_s']": 0.0002,
    "#subset": 25,
    "#mm-per-px": 0.5,
    "[data-key='platform.radius_m']": 0.07,
    "[data-key='platform.start_height_m']": 0.252,
    "[data-key='camera.distance_m']": 3,
    "#principal-0": 152,
    "#principal-1": 512,
}
"""What cannot be clicked, by the field it is typed into."""


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("choose") / "page.html"
    assert main([str(DEMO / "film.avi"), "--choose", str(path), "--quiet"]) == 0
    return path


def on_screen(browser, x, y):
    """Where a place of the film is in the window."""
    return browser.value(
        f"(() => {{const b = view.canvas.getBoundingClientRect(), p = view.screen([{x}, {y}]); return [b.left + p[0], b.top + p[1]]}})()"
    )


def chosen(browser):
    return make_project(tomllib.loads(browser.value("document.getElementById('toml').value")))


def look_at(browser, x, y, scale=8.0):
    """Zoom in on a place, and bring it to the middle of the view."""
    browser.value("document.getElementById('picture').scrollIntoView({block: 'center'})")
    browser.value(f"view.zoom({scale} / view.scale)")
    browser.value(f"(() => {{const m = view.middle(); view.pan((m[0] - {x}) * view.scale, (m[1] - {y}) * view.scale)}})()")


@pytest.mark.slow
def test_clicks_on_the_demo_film_give_the_project_that_is_shipped(page, browser):
    shipped = read_project(DEMO / "film.toml")
    browser.open(page)
    assert shipped.marks.place_px is not None
    assert shipped.platform.origin_px is not None
    for x, y in shipped.marks.place_px:
        look_at(browser, x, y)
        browser.click(*on_screen(browser, x, y))
    browser.press("[data-tool=origin]")
    look_at(browser, *shipped.platform.origin_px)
    browser.click(*on_screen(browser, *shipped.platform.origin_px))
    for selector, value in TYPED.items():
        browser.write(selector, str(value))
    found = chosen(browser)
    assert np.abs(np.array(found.marks.place_px) - shipped.marks.place_px).max() <= 0.0051
    assert np.abs(np.array(found.platform.origin_px) - shipped.platform.origin_px).max() <= 0.0051
    exact = {"marks": found.marks.model_copy(update={"place_px": shipped.marks.place_px})}
    assert found.model_copy(update=exact) == shipped
    assert browser.value("document.querySelectorAll('#missing li').length") == 0
    assert browser.value("[...document.querySelectorAll('#marks td:nth-child(4)')].every((cell) => cell.textContent.startsWith('good'))")
    assert "--mark=77.34,994.6" in browser.value("document.getElementById('options').textContent")


def test_the_page_asks_for_nothing_and_complains_of_nothing(page, browser):
    browser.open(page)
    assert browser.asked_for == [page.resolve().as_uri()]
    assert browser.complaints == []
    assert "http" not in page.read_text(encoding="utf-8").replace("http-equiv", "").replace("http://www.w3.org/2000/svg", "")


@pytest.mark.slow
def test_lines_and_time_are_dragged(page, browser):
    browser.open(page)
    browser.press("[data-tool=stick]")
    look_at(browser, 150, 970, 3.0)
    browser.drag(on_screen(browser, 100, 970), on_screen(browser, 200, 970))
    assert any("length" in text for text in browser.value("[...document.querySelectorAll('#missing li')].map((one) => one.textContent)"))
    browser.write("#length", "50")
    browser.press("[data-tool=plumb]")
    look_at(browser, 150, 970, 3.0)
    browser.drag(on_screen(browser, 60, 930), on_screen(browser, 62, 1000))
    browser.drag(on_screen(browser, 62, 1000), on_screen(browser, 63, 1005))  # by its end
    browser.write("#fps", "250")
    browser.value("(() => {for (const [id, k] of [['first', 25], ['last', 100]]) {const f = document.getElementById(id); f.value = k; "
                  "f.dispatchEvent(new Event('input'))}})()")  # fmt: skip
    found = chosen(browser)
    assert np.allclose(np.array(found.scale.from_px_mm, dtype=float), (100, 970, 200, 970, 50), atol=0.02)
    assert np.allclose(np.array(found.scale.plumb_px, dtype=float), (60, 930, 63, 1005), atol=0.02)
    assert (found.film.from_s, found.film.to_s) == (0.1, 0.4)
    assert "--from 0.1 --choose" in browser.value("document.getElementById('other-first').textContent")
    assert browser.complaints == []


def test_a_project_that_is_given_is_shown_and_kept(browser, tmp_path):
    (tmp_path / "given.toml").write_text((DEMO / "film.toml").read_text() + "focal_px = 6000.0\n")
    film = str(DEMO / "film.avi")
    assert main([film, "--project", str(tmp_path / "given.toml"), "--choose", str(tmp_path / "page.html"), "--quiet"]) == 0
    browser.open(tmp_path / "page.html")
    assert chosen(browser) == read_project(tmp_path / "given.toml")


def test_texture_is_rated_as_the_command_would(browser, page):
    """A place that the command refuses is not to be used; one that it takes is rated by what is possible at best."""
    from measure.correlation.tracking import why_unusable

    browser.open(page)
    (_, first), *_ = open_footage(DEMO / "film.avi").pictures()
    places = [(float(x), float(y)) for y in range(20, 1010, 90) for x in range(20, 290, 45)] + [(77.3, 994.6), (5.0, 5.0), (152.0, 949.2)]
    usable = [not why_unusable(first, place, 25) for place in places]
    rated = browser.value(f"{[list(place) for place in places]}.map((place) => texture.rated(place, 25).use)")
    agree = np.array(usable) == np.array(rated)
    assert agree.mean() > 0.97
    assert agree[-3:].all()
    sigma = browser.value("texture.rated([152, 949.2], 25).sigma")
    assert 0.0005 < sigma < 0.0016  # which the command states


@pytest.mark.parametrize("width", [1280, 390])
def test_nothing_is_wider_than_the_window(page, browser, width):
    browser.open(page, width=width)
    browser.press("#suggest")
    assert browser.value("document.querySelectorAll('#marks tr').length") > 3
    assert browser.value("document.documentElement.scrollWidth") <= width


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--choose", "page.png"], "name it so"),
        (["--choose", "page.html", "-o", "out.csv"], "leave -o away"),
        (["--choose", "page.html", "--fps", "100", "--from", "9"], "outside of the film"),
    ],
)
def test_wrong_options_end_in_one_sentence_and_nothing_is_written(options, says, tmp_path, capsys, monkeypatch):
    write_film(tmp_path / "film.avi", np.random.default_rng(0).integers(0, 255, (5, 32, 48), dtype=np.uint8))
    monkeypatch.chdir(tmp_path)
    assert main(["film.avi", *options]) == 2
    assert says in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["film.avi"]


def test_a_hostile_name_stays_text(tmp_path, browser):
    film = tmp_path / "</script><img src=x onerror=alert(1)>.avi"
    film = tmp_path / film.name.replace("/", "")
    write_film(film, np.random.default_rng(0).integers(0, 255, (5, 64, 64), dtype=np.uint8))
    assert main([str(film), "--choose", str(tmp_path / "page.html"), "--quiet"]) == 0
    browser.open(tmp_path / "page.html")
    assert browser.value("document.querySelectorAll('img[src=x]').length") == 0
    assert browser.complaints == []
