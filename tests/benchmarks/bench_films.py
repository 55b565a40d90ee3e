"""Marks of every kind in films of every kind, against exact truth, beside template matching and pyramidal Lucas-Kanade.

    python tests/benchmarks/bench_films.py [--json FILE] [--films N] [--kind KIND]

A drum with six marks rises by 100 mm at 0.5 mm per pixel and turns by 30 deg. Every film is tracked from its file as
`track-video` would, with the true places, scale and geometry; the other methods get the same decoded pictures.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import av
import cv2
import numpy as np
from bench_tracking import show

from measure.film.track import track
from measure.footage.footage import from_array
from measure.footage.formats import open_footage
from measure.footage.writers import write_film
from measure.geometry.camera import Camera
from measure.synthetic.made_film import MadeMark, Rod, Scene, pictures, project_for, true_motion
from measure.tables.trajectory import Trajectory

FPS, FRAMES, OFF_PX = 100.0, 60, 0.5
CODECS = {
    "H.264, crf 23": ("libx264", "yuv420p", {"crf": "23"}), "H.264, crf 30": ("libx264", "yuv420p", {"crf": "30"}),
    "HEVC, 10 bit": ("libx265", "yuv420p10le", {"crf": "28", "x265-params": "log-level=error"}),
}  # fmt: skip
SCENES = {
    "plain": {}, "laboratory light": {"light": 0.7, "light_gradient": 0.3, "noise": 3.0}, "rolling shutter": {"readout_s": 0.005},
    "rods": {"rods": (Rod(106.0, 0.0, 110.0, 383.0, 4.0), Rod(196.0, 0.0, 191.0, 383.0, 4.0))},
}  # fmt: skip
LENS = {"focal_px": 6000.0, "distortion": (-8.0, 0.0, 0.0, 0.0)}
"""Moves the corners of the picture by 3 px."""

CONDITIONS = ("plain", "laboratory light", *CODECS, "MJPG", "lens distortion", "rolling shutter", "shake", "rods")


def drum(kind, seed, shake_px=0.0):
    """A drum at rest for 80 ms that then rises, drifts, tilts and turns; its marks and their subset, px."""
    rng = np.random.default_rng(seed)
    time = np.arange(-1, FRAMES + 1) / FPS
    s = np.clip((time - 0.08) / 0.48, 0.0, 1.0)
    tilt = np.radians(rng.uniform(-1.5, 1.5, 2))
    size, azimuth = rng.uniform(0.014, 0.018), rng.uniform(0.40, 0.55)
    marks = tuple(MadeMark(a, h, size, kind) for h in (-0.0115, 0.0115) for a in (-azimuth, 0.0, azimuth))
    place = (152.0 + rng.uniform(0.0, 1.0), 330.0 + rng.uniform(0.0, 1.0))
    scene = Scene(304, 384, Camera(0.5e-3, place, 0.0, 3.0, (152.0, 190.0)), marks, 0.07, 0.0235, background=0.05, rays=4)
    shake = np.random.default_rng([seed, 2]).normal(0.0, 0.5e-3 * shake_px, (2, len(time)))
    shake[:, :2] = 0.0
    motion = {
        "x_m": 0.004 * np.sin(3.0 * s) + shake[0], "z_m": 0.10 * s**2 * (3.0 - 2.0 * s) + shake[1],
        "theta_x_rad": tilt[0] * np.sin(3.0 * s), "theta_y_rad": tilt[1] * s**2, "theta_z_rad": np.radians(30.0) * s**2,
    }  # fmt: skip
    return Trajectory(time, motion), scene, 2 * int(1000.0 * size * 0.75) + 1


def film(kind, condition, seed, folder):
    """Footage, project, true trajectory and true places of the marks, (frames, marks, 2) px."""
    motion, scene, subset = drum(kind, seed, 0.3 if condition == "shake" else 0.0)
    scene = replace(scene, **SCENES.get(condition, {}))
    project = project_for(scene, FPS, 0.0, subset)
    truth = true_motion(_seen(motion), scene, FPS, FRAMES)
    places = np.stack([truth.x_px, truth.y_px], axis=-1)
    made = pictures(_seen(motion), scene, fps=FPS, seed=seed, frames=FRAMES)
    if condition == "lens distortion":
        camera = replace(scene.camera, **LENS)
        made = _through_lens(motion, scene, camera, seed)
        places = camera.with_distortion(places)
        listed = project.marks.model_copy(update={"place_px": tuple(map(tuple, places[0].tolist()))})
        optics = project.camera.model_copy(update=LENS)
        origin = tuple(camera.with_distortion(np.array(scene.camera.origin_px)).tolist())
        platform = project.platform.model_copy(update={"origin_px": origin})
        project = project.model_copy(update={"marks": listed, "camera": optics, "platform": platform})
    return _written(np.array(list(made)), condition, folder), project, truth.trajectory, places


def _seen(motion):
    """Without the sample before the first frame."""
    return Trajectory(motion.time_s[1:] - motion.time_s[1], {name: values[1:] for name, values in motion.channels.items()})


def _through_lens(motion, scene, camera, seed):
    """Rendered twice as fine without noise, bent there, and averaged, so that what is interpolated is finer than a pixel."""
    fine_camera = replace(
        scene.camera, m_per_px=scene.camera.m_per_px / 2, origin_px=tuple(2 * np.array(scene.camera.origin_px) + 0.5),
        principal_px=tuple(2 * np.array(scene.camera.principal_px) + 0.5),
    )  # fmt: skip
    fine = replace(scene, width=2 * scene.width, height=2 * scene.height, camera=fine_camera, rays=2, noise=0.0)
    at = np.stack(np.meshgrid(np.arange(fine.width), np.arange(fine.height)), axis=-1)
    source = (2 * camera.without_distortion((at - 0.5) / 2) + 0.5).astype(np.float32)
    rng = np.random.default_rng([seed, 3])
    for picture in pictures(_seen(motion), fine, fps=FPS, seed=seed, frames=FRAMES):
        bent = cv2.remap(picture.astype(np.float32), source[..., 0], source[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
        coarse = cv2.resize(bent, (scene.width, scene.height), interpolation=cv2.INTER_AREA)
        yield np.clip(np.rint(coarse + rng.normal(0.0, scene.noise, coarse.shape)), 0, 255).astype(np.uint8)


def _written(stack, condition, folder):
    if condition == "MJPG":
        write_film(folder / "film.avi", stack, "MJPG")
        return open_footage(folder / "film.avi")
    if condition not in CODECS:
        return from_array(stack)
    codec, pixels, options = CODECS[condition]
    with av.open(str(folder / "film.mp4"), "w") as container:
        stream = container.add_stream(codec, rate=25, options=options)
        stream.height, stream.width = stack[0].shape
        stream.pix_fmt = pixels
        for picture in stack:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="gray").reformat(format=pixels)))
        container.mux(stream.encode(None))
    return open_footage(folder / "film.mp4")


def template_path(stack, places, half):
    """matchTemplate with a parabola, around the last place; no place where the score is below 0.8. (frames, marks, 2) px."""
    found = np.full((len(stack), *places.shape), np.nan)
    for i, (x, y) in enumerate(np.rint(places).astype(int)):
        patch = stack[0][y - half : y + half + 1, x - half : x + half + 1]
        column, row = x, y
        for t, picture in enumerate(stack):
            left, top = max(0, column - half - 24), max(0, row - half - 24)
            part = picture[top : row + half + 25, left : column + half + 25]
            if min(part.shape) <= 2 * half + 3:
                break
            scores = cv2.matchTemplate(part, patch, cv2.TM_CCOEFF_NORMED)
            r, c = np.unravel_index(int(scores[1:-1, 1:-1].argmax()), (scores.shape[0] - 2, scores.shape[1] - 2))
            column, row = left + c + 1 + half, top + r + 1 + half
            if scores[r + 1, c + 1] >= 0.8:
                peak = [_vertex(scores[r + 1, c : c + 3]), _vertex(scores[r : r + 3, c + 1])]
                found[t, i] = places[i] + [column - x, row - y] + np.array(peak)
    return found


def _vertex(three):
    a, b, c = map(float, three)
    return 0.5 * (a - c) / (a - 2 * b + c)


def lucas_kanade_path(stack, places, half):
    """cv2.calcOpticalFlowPyrLK from frame to frame; no place from where it reports none. (frames, marks, 2) px."""
    size, found = (2 * half + 1, 2 * half + 1), [places.astype(np.float32)]
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
    kept = np.ones(len(places), bool)
    for before, after in pairwise(stack):
        now, status, _ = cv2.calcOpticalFlowPyrLK(before, after, np.nan_to_num(found[-1]), None, winSize=size, maxLevel=3, criteria=stop)
        kept &= status[:, 0] == 1
        found.append(np.where(kept[:, None], now, np.nan).astype(np.float32))
    return np.array(found, float)


def _errors(found, places):
    """rms px and sightings off by over 0.5 px, of all after the first frame."""
    gap = (found - places)[1:]
    return np.sqrt(np.nanmean(gap**2)), int((np.hypot(gap[..., 0], gap[..., 1]) > OFF_PX).sum())


def row(kind, condition, films):
    """One line of the table."""
    ratios, turns, numbers = {}, [], []
    for seed in range(films):
        with tempfile.TemporaryDirectory() as folder:
            footage, project, truth, places = film(kind, condition, seed, Path(folder))
            tracked = track(footage, project)
            stack = np.array([picture for _, picture in footage.pictures()])
        marks, table = tracked.marks, tracked.trajectory
        for channel, values in table.channels.items():
            gap = (values - truth.channels[channel])[1:]
            ratios.setdefault(channel, []).append(gap / table.sigma[channel][1:])
            turns += [gap] if channel == "theta_z_rad" else []
        seen = np.stack([marks.x_px, marks.y_px], axis=-1)
        sigma = np.sqrt(np.diagonal(marks.covariance_px2, axis1=2, axis2=3))
        ratios.setdefault("marks", []).append(((seen - places) / sigma)[1:])
        stack = (stack >> (footage.bits - 8)).astype(np.uint8)
        half = project.marks.subset_px // 2
        others = [_errors(path(stack, places[0], half), places) for path in (template_path, lucas_kanade_path)]
        numbers.append([*_errors(seen, places), int((~marks.observed).sum()), *np.ravel(others)])
    inside = {name: 100 * np.mean(np.abs(of)[np.isfinite(of)] < 1.96) for name, of in ratios.items()}
    numbers = np.array(numbers)
    rms = np.sqrt(np.mean(numbers[:, [0, 3, 5]] ** 2, axis=0))
    of_pose = {name: share for name, share in inside.items() if name != "marks"}
    return {
        "rms, px": rms[0], "theta_z, deg": np.degrees(np.sqrt(np.nanmean(np.square(turns)))), "marks inside, %": inside["marks"],
        "pose inside, %": np.mean(list(of_pose.values())), "worst channel, %": min(of_pose.values()),
        "theta_z inside, %": inside["theta_z_rad"], "off": int(numbers[:, 1].sum()), "unseen": int(numbers[:, 2].sum()),
        "template rms": rms[1], "template off": int(numbers[:, 4].sum()), "LK rms": rms[2], "LK off": int(numbers[:, 6].sum()),
    }  # fmt: skip


def main():
    """Measure everything and print it."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--json", type=Path)
    options.add_argument("--films", type=int, default=3, help="films for each line")
    options.add_argument("--kind", action="append", choices=("speckle", "dot", "quadrant"))
    given = options.parse_args()
    cv2.setNumThreads(1)
    result = {}
    for kind in given.kind or ("speckle", "dot", "quadrant"):
        result[kind] = {condition: row(kind, condition, given.films) for condition in CONDITIONS}
        show(f"{kind}, {given.films} films of {6 * (FRAMES - 1)} sightings a line", result[kind])
    if given.json:
        given.json.write_text(json.dumps(result, indent=2, default=float))


if __name__ == "__main__":
    main()
