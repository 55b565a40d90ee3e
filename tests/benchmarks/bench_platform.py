"""How exactly the platform comes out of a film, theta_z from one camera included, and how fast.

    python tests/benchmarks/bench_platform.py [--json FILE] [--frames N]

Made footage of the rig at 0.5 mm per pixel, tracked as any film; the gap to its exact truth, beside the stated sigma.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np
from bench_tracking import show

from measure.camera import Camera
from measure.film import track_platform
from measure.footage import from_array
from measure.made_footage import MadeMark, Scene, deployment_scene, pictures, project_for, true_motion
from measure.reference import AFFINE, TRANSLATION
from measure.tables import Trajectory
from measure.tracking import follow


def small_scene(**changed):
    """The shipped film's scene in a smaller picture, for motions that do not rise far; three rows of marks as an option."""
    wide = deployment_scene()
    camera = Camera(0.5e-3, (152.0, 110.0), 0.0, 3.0, (152.0, 110.0))
    fields = {"marks": wide.marks, "radius_m": wide.radius_m, "half_height_m": wide.half_height_m, "noise": 1.5, "background": 0.1}
    return Scene(304, 200, camera, **{**fields, **changed})


def turning(frames, seed=1, **changed):
    """theta_z from 0 to 30 deg while the platform drifts and rolls a little; gaps and sigmas per channel."""
    time_s = np.linspace(0.0, 1.0, 401)
    motion = {
        "x_m": 0.004 * np.sin(3 * time_s), "z_m": 0.3 + 0.01 * time_s, "theta_y_rad": 0.03 * np.sin(4 * time_s),
        "theta_x_rad": 0.01 * np.sin(5 * time_s), "y_m": 0.003 * np.sin(2 * time_s), "theta_z_rad": np.radians(30.0) * time_s,
    }  # fmt: skip
    return _gaps(Trajectory(time_s, motion), small_scene(**changed), frames, seed)


def _gaps(motion, scene, frames, seed):
    fps = (frames - 1) / motion.time_s[-1]
    film = from_array(np.array(list(pictures(motion, scene, fps=fps, seed=seed))))
    tracked = track_platform(film, project_for(scene, fps, float(motion.channels["z_m"][0])))
    truth = true_motion(motion, scene, fps).trajectory
    rows = {}
    for channel, values in tracked.trajectory.channels.items():
        factor, unit = (1e3, "mm") if channel.endswith("_m") else (np.degrees(1.0), "deg")
        gap = factor * (values - truth.channels[channel])[1:]
        sigma = factor * tracked.trajectory.sigma[channel][1:]
        rows[f"{channel}, {unit}"] = {
            "rmse": np.sqrt(np.nanmean(gap**2)),
            "max": np.nanmax(np.abs(gap)),
            "sigma": np.nanmedian(sigma),
            "inside_95_percent": 100 * np.nanmean(np.abs(gap) < 1.96 * sigma),
            "frames_lost": int(np.isnan(gap).sum()),
        }
    return rows


def flat(frames):
    """Six flat marks of 41 px, 200 px apart, that shift and roll: the plane fit at its limit, px and rad."""
    camera = Camera(0.5e-3, (300.0, 140.0))
    marks = tuple(MadeMark(a, h, 0.022) for h in (-0.03, 0.03) for a in (-0.014, 0.0, 0.014))
    scene = Scene(600, 280, camera, marks, radius_m=7.0, half_height_m=0.06, noise=1.5, background=0.1)
    time_s = np.linspace(0.0, 1.0, 201)
    motion = Trajectory(time_s, {"x_m": 0.003 * np.sin(5 * time_s), "z_m": 0.005 * time_s, "theta_y_rad": 0.02 * np.sin(7 * time_s)})
    project = project_for(scene, frames - 1.0, 0.0, subset=41)
    project = project.model_copy(update={"platform": project.platform.model_copy(update={"radius_m": None})})
    film = from_array(np.array(list(pictures(motion, scene, fps=frames - 1.0, seed=2))))
    tracked = track_platform(film, project).trajectory
    truth = true_motion(motion, scene, frames - 1.0).trajectory
    rows = {}
    for channel, factor in (("x_m", 1 / 0.5e-3), ("z_m", 1 / 0.5e-3), ("theta_y_rad", 1.0)):
        gap = factor * (tracked.channels[channel] - truth.channels[channel])[1:]
        sigma = factor * tracked.sigma[channel][1:]
        rows[channel.replace("_m", ", px").replace("_rad", ", rad")] = {
            "rmse": np.sqrt(np.mean(gap**2)), "max": np.abs(gap).max(), "sigma": np.median(sigma),
            "inside_95_percent": 100 * np.mean(np.abs(gap) < 1.96 * sigma),
        }  # fmt: skip
    return rows


def rates(frames):
    """Frames per second at 1280 x 1024, six marks of 41 px on a moving speckle, one core, film in memory."""
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
        follow(from_array(used[:3]), places, 1000.0, 41, warp)
        start = time.perf_counter()
        marks = follow(from_array(used), places, 1000.0, 41, warp)
        rows[name] = {"frames_per_s": frames / (time.perf_counter() - start), "lost": int((~marks.seen).sum())}
    return rows


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
    options.add_argument("--frames", type=int, default=61)
    given = options.parse_args()
    result = {
        "six flat marks": flat(given.frames),
        "theta_z from 0 to 30 deg, speckle": turning(given.frames),
        "rates at 1280 x 1024": rates(160),
    }
    for title, rows in result.items():
        show(title, rows)
    if given.json:
        given.json.write_text(json.dumps(result, indent=2, default=float))


if __name__ == "__main__":
    main()
