"""How exactly the platform comes out of a film, theta_z from one camera included, and how fast.

    python tests/benchmarks/bench_platform.py [--json FILE] [--frames N] [--films N]

Made footage of the rig at 0.5 mm per pixel, tracked as any film; the gap to its exact truth, beside the stated sigma.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from bench_tracking import show
from tracking_methods import match_template
from tracking_scenes import MIDDLE

from measure.correlation.steepest_descent import AFFINE, TRANSLATION
from measure.correlation.tracking import track_marks
from measure.film.track import track
from measure.footage.footage import from_array
from measure.footage.formats import open_footage
from measure.footage.writers import Clock, write_film
from measure.geometry.camera import Camera
from measure.synthetic.made_film import (
    MadeMark,
    Scene,
    deployment_scene,
    pictures,
    project_for,
    true_motion,
)
from measure.tables.trajectory import Trajectory


def small_scene(**changed):
    """The shipped film's scene in a smaller picture, for motions that do not rise far; three rows of marks as an option."""
    wide = deployment_scene()
    camera = Camera(0.5e-3, (152.0, 110.0), 0.0, 3.0, (152.0, 110.0))
    fields = {"marks": wide.marks, "radius_m": wide.radius_m, "half_height_m": wide.half_height_m, "noise": 1.5, "background": 0.1}
    return Scene(304, 200, camera, **{**fields, **changed})


def turning(frames, seeds, **changed):
    """theta_z from 0 to 30 deg while the platform drifts, tilts and rolls a little."""
    time_s = np.linspace(0.0, 1.0, 401)
    motion = {
        "x_m": 0.004 * np.sin(3 * time_s), "z_m": 0.3 + 0.01 * time_s, "theta_y_rad": 0.03 * np.sin(4 * time_s),
        "theta_x_rad": 0.01 * np.sin(5 * time_s), "y_m": 0.003 * np.sin(2 * time_s), "theta_z_rad": np.radians(30.0) * time_s,
    }  # fmt: skip
    scene = small_scene(**changed)
    project = project_for(scene, frames - 1.0, 0.3)
    units = {"m": ("mm", 1e3), "rad": ("deg", np.degrees(1.0))}
    return _gaps(Trajectory(time_s, motion), scene, project, seeds, units)


def flat(frames, seeds):
    """Six flat marks of 41 px, 200 px apart, that shift and roll: the plane fit at its limit, px and rad."""
    camera = Camera(0.5e-3, (300.0, 140.0))
    marks = tuple(MadeMark(a, h, 0.022) for h in (-0.03, 0.03) for a in (-0.014, 0.0, 0.014))
    scene = Scene(600, 280, camera, marks, radius_m=7.0, half_height_m=0.06, noise=1.5, background=0.1)
    time_s = np.linspace(0.0, 1.0, 201)
    motion = Trajectory(time_s, {"x_m": 0.003 * np.sin(5 * time_s), "z_m": 0.005 * time_s, "theta_y_rad": 0.02 * np.sin(7 * time_s)})
    project = project_for(scene, frames - 1.0, 0.0, subset=41)
    project = project.model_copy(update={"platform": project.platform.model_copy(update={"radius_m": None})})
    return _gaps(motion, scene, project, seeds, {"m": ("px", 1 / 0.5e-3), "rad": ("rad", 1.0)})


def _gaps(motion, scene, project, seeds, units):
    """Gap to the truth and stated sigma of each channel, over films with other textures and other noise.

    All frames of a film share the noise of its reference image, so that one film alone says little about a sigma.
    """
    gaps, sigmas, fps = {}, {}, project.film.fps
    truth = true_motion(motion, scene, fps).trajectory
    for seed in range(seeds):
        film = from_array(np.array(list(pictures(motion, scene, fps=fps, seed=seed))))
        seen = track(film, project).trajectory
        for channel, values in seen.channels.items():
            gaps.setdefault(channel, []).append((values - truth.channels[channel])[1:])
            sigmas.setdefault(channel, []).append(seen.sigma[channel][1:])
    return dict(_gap_row(channel, np.array(gaps[channel]), np.array(sigmas[channel]), units) for channel in gaps)


def _gap_row(channel, gap, sigma, units):
    unit, factor = units[channel.rsplit("_", 1)[1]]
    return f"{channel.rsplit('_', 1)[0]}, {unit}", {
        "rmse": factor * np.sqrt(np.nanmean(gap**2)),
        "max": factor * np.nanmax(np.abs(gap)),
        "sigma": factor * np.nanmedian(sigma),
        "rms_over_sigma": np.sqrt(np.nanmean((gap / sigma) ** 2)),
        "inside_95_percent": 100 * np.nanmean(np.abs(gap) < 1.96 * sigma),
        "frames_lost": int(np.isnan(gap).sum()),
    }


def rates(frames):
    """Frames per second of processor time at 1280 x 1024, six marks of 41 px on a moving speckle, one core, film in memory.

    Machines differ and one machine differs from minute to minute, so template matching with a parabola (six windows with 16 px of
    way to each side, their places given) is timed before each row; of_template is the ratio.
    """
    cv2.setNumThreads(1)
    film, places = _large_film(frames)
    rows = {}
    for name, warp, rod in (
        ("translation", TRANSLATION, False),
        ("affine", AFFINE, False),
        ("robust (a rod over every mark)", AFFINE, True),
    ):
        used = film
        if rod:
            used = film.copy()
            for x, _ in places:
                used[1:, :, int(x) + 5 : int(x) + 11] = 30
        track_marks(from_array(used[:3]), places, 1000.0, 41, warp)
        template = _template_rate(used, places)
        start = time.process_time()
        marks = track_marks(from_array(used), places, 1000.0, 41, warp)
        rate = frames / (time.process_time() - start)
        rows[name] = {
            "frames_per_s": rate,
            "template_per_s": template,
            "of_template": rate / template,
            "lost": int((~marks.observed).sum()),
        }
    return rows


def _template_rate(film, places):
    """Frames per second of matchTemplate with a parabola, for as many marks."""
    windows = [(slice(int(y) - MIDDLE, int(y) + MIDDLE + 1), slice(int(x) - MIDDLE, int(x) + MIDDLE + 1)) for x, y in places]
    start = time.process_time()
    for picture in film:
        for window in windows:
            match_template([film[0][window], picture[window]])
    return len(film) / (time.process_time() - start)


def files(frames):
    """The same film from a mapped .mraw and from a compressed .avi, by wall time, beside what merely reads the pictures."""
    cv2.setNumThreads(1)
    film, places = _large_film(frames)
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, codec in (("film.mraw", ""), ("ffv1.avi", "FFV1"), ("mjpg.avi", "MJPG")):
            write_film(Path(folder) / name, film, codec or "FFV1", Clock(1000.0))
            footage = open_footage(Path(folder) / name)
            track_marks(_beginning(footage), places, 1000.0, 41, TRANSLATION)
            start = time.perf_counter()
            read = sum(int(picture[0, 0]) >= 0 for _, picture in footage.pictures())
            decoded = time.perf_counter() - start
            start = time.perf_counter()
            marks = track_marks(footage, places, 1000.0, 41, TRANSLATION)
            spent = time.perf_counter() - start
            rows[name] = {"frames_per_s": read / spent, "reading_alone_per_s": read / decoded, "lost": int((~marks.observed).sum())}
    return rows


def _beginning(footage):
    """Its first pictures as they come, for what is only done once in a process."""
    return from_array(np.stack([picture for _, picture in islice(footage.pictures(), 3)]))


def _large_film(frames):
    """A speckled picture that moves 3.5 px down per frame, in whole rows and by interpolation between them."""
    chance = np.random.default_rng(0)
    texture = cv2.GaussianBlur(chance.normal(0.0, 1.0, (1024 + 4 * frames, 1280)).astype(np.float32), (0, 0), 1.6)
    still = 120.0 + 40.0 * texture / texture.std()
    grain = chance.normal(0.0, 1.5, (1024, 1280)).astype(np.float32)
    film = np.empty((frames, 1024, 1280), np.uint8)
    for n in range(frames):
        top = 4 * frames - 3.5 * n
        part = top - int(top)
        rows = still[int(top) - 1 : int(top) + 1023] * (1 - part) + still[int(top) : int(top) + 1024] * part
        film[n] = np.clip(np.rint(rows + np.roll(grain, 37 * n, axis=1)), 0, 255)
    places = [(x, y) for y in (100.0, 180.0) for x in (300.0, 640.0, 980.0)]
    return film, places


def main():
    """Measure everything and print it."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--json", type=Path)
    options.add_argument("--frames", type=int, default=31)
    options.add_argument("--films", type=int, default=10, help="films with other textures and other noise")
    given = options.parse_args()
    result = {
        "six flat marks": flat(given.frames, given.films),
        "theta_z from 0 to 30 deg, speckle": turning(given.frames, given.films),
        "rates at 1280 x 1024": rates(220),
        "from files, translation": files(220),
    }
    for title, rows in result.items():
        show(title, rows)
    if given.json:
        given.json.write_text(json.dumps(result, indent=2, default=float))


if __name__ == "__main__":
    main()
