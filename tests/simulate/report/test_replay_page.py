"""The page that plays a deployment: right by itself, whole without any address, and alive in a browser."""

import json
import re
import shutil
import subprocess

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from measure.tables.trajectory import Trajectory
from simulate.commands import simulate_deployment
from simulate.deployment.deploy import deploy
from simulate.files.model_file import write_model
from simulate.model.model import Simulation
from simulate.report.replay_page import playing_html

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def data_of(page):
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found.group(1))


@pytest.fixture
def run(lopsided):
    from dataclasses import replace

    return deploy(replace(lopsided, name="</script><b>odd & bold", simulation=Simulation(0.5, 1000.0)))


def test_the_drawn_legs_are_as_long_as_the_simulated_ones(run):
    data = data_of(playing_html(run))
    for frame in (0, 150, len(data["time"]) - 1):
        turned = Rotation.from_quat(data["quaternion"][frame], scalar_first=True).apply(data["joints"]) + data["place"][frame]
        lengths = np.linalg.norm(turned - np.array(data["base"]), axis=1)
        assert lengths == pytest.approx(data["length"][frame], abs=1e-5)
        sample = round(data["time"][frame] * 1000)
        assert data["force"][frame] == pytest.approx(run.leg_force_N[sample], rel=1e-5)


def test_a_measured_pose_is_drawn_where_it_was_measured_and_turned_as_it_was(run):
    measured = Trajectory(run.time_s[:301:4], {name: values[:301:4] for name, values in run.channels.items()}, name="film.csv")
    data = data_of(playing_html(run, measured))
    frame = 100
    assert data["measured"]["place"][frame] == pytest.approx(data["place"][frame], abs=1e-5)
    ours, theirs = np.array(data["quaternion"][frame]), np.array(data["measured"]["quaternion"][frame])
    assert abs(ours @ theirs) == pytest.approx(1.0, abs=1e-6)
    assert data["measured"]["place"][-1] is None, "nothing was measured at the end"
    curve = data["panels"][0]["lines"][0]
    assert curve["measured"]["values"][10] == pytest.approx(1e3 * measured.channels["z_m"][10], rel=1e-5)


def test_no_outside_address_and_no_word_of_a_model_becomes_markup(run):
    page = playing_html(run)
    assert not re.search(r"(?:src|href)\s*=|https?://|@import|url\(", page)
    assert "default-src 'none'" in page
    assert "<b>odd" not in page


def test_a_measurement_without_a_page_is_refused(tmp_path, prototype, capsys):
    write_model(prototype, tmp_path / "m.toml")
    assert simulate_deployment.main([str(tmp_path / "m.toml"), "-o", str(tmp_path / "t.csv"), "--measured", "film.csv"]) == 2
    assert "name one with --page" in capsys.readouterr().err
    assert not (tmp_path / "t.csv").exists()


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_browser_plays_the_page_without_an_error_and_without_asking_for_anything(tmp_path, prototype):
    write_model(prototype, tmp_path / "m.toml")
    words = [str(tmp_path / "m.toml"), "-o", str(tmp_path / "t.csv"), "--page", str(tmp_path / "p.html"), "--quiet"]
    assert simulate_deployment.main(words) == 0
    browser = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=2000", f"--user-data-dir={tmp_path}"]
    page = f"{(tmp_path / 'p.html').as_uri()}#t=0.4"
    shown = subprocess.run([*browser, "--dump-dom", page], capture_output=True, text=True, timeout=120, check=True).stdout
    body = re.search(r"<body[^>]*>", shown)
    assert body
    assert 'data-ready="400"' in body.group()
    assert "data-error" not in body.group()
    assert 'data-frame="159"' in body.group(), "0.4 s of 1 s in 400 frames"
    assert re.search(r"<output[^>]*>0\.39[0-9] s", shown)
    assert len(re.findall(r"<td>[-0-9.]+</td>", shown)) == 18
    drawn = tmp_path / "p.png"
    subprocess.run([*browser, f"--screenshot={drawn}", "--window-size=1200,800", page], capture_output=True, timeout=120, check=True)
    assert blue_pixels(drawn) > 500, "the platform is drawn"


def blue_pixels(path):
    from matplotlib.image import imread

    red, green, blue = np.moveaxis(imread(path)[..., :3], -1, 0)
    return int(np.sum((blue > red + 0.2) & (blue > green + 0.05)))
