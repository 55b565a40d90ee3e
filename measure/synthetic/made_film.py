"""Synthetic films with exact truth: a platform with marks on its perimeter in front of a camera, with a prescribed motion.

A test bench for any tracker. Every pixel is the mean of rays cast through it, each evaluated where it meets the
platform's cylinder, on a texture that is a formula and not a picture. Nothing is interpolated, so that the interpolation
of a tracker is tested and not favoured.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.footage.footage import Picture
from measure.geometry.camera import angles, rotation
from measure.geometry.film_project import Project, make_project
from measure.synthetic.rendering import DOT, QUADRANT, SPECKLE, cast
from measure.synthetic.rods import rod_cover
from measure.synthetic.scene import MadeMark, Rod, Scene, deployment_scene
from measure.tables.trajectory import CHANNELS, Trajectory

__all__ = ["MadeMark", "Rod", "Scene", "Truth", "deployment_scene", "pictures", "project_for", "render", "true_motion"]

Array = NDArray[np.float64]
_INSTANTS = np.linspace(-0.4, 0.4, 5)
"""Instants within the exposure at which the scene is rendered, in exposure times."""

_BAND = 4
"""Rows that are read at one instant where the rows of a picture are read one after the other."""

KINDS = {"speckle": SPECKLE, "quadrant": QUADRANT, "dot": DOT}


@dataclass(frozen=True)
class Truth:
    """The exact motion.

    Attributes
    ----------
    trajectory : Trajectory
        At the frames: positions and rotations from the first frame, the height as given.
    x_px, y_px : (frames, marks) arrays
        Centres of the marks, px.
    facing : (frames, marks) array
        Cosine between a mark's normal and the line of sight; the mark is hidden where it is negative.
    """

    trajectory: Trajectory
    x_px: Array
    y_px: Array
    facing: Array


def render(
    trajectory: Trajectory, scene: Scene, path: Path, *, fps: float, seed: int, frames: int | None = None, codec: str = "FFV1"
) -> Truth:
    """Render a film and return the truth.

    Parameters
    ----------
    trajectory : Trajectory
        Any channels, absent ones are zero; frames are taken at `fps` from its first instant to its last, between samples
        by cubic spline.
    scene : Scene
        Platform, marks, camera, light and noise.
    path : Path
        An .avi (lossless, or with another codec that OpenCV knows, such as MJPG), an .mraw (8, 12 or 16 bit, with the
        camera's notes), or a folder for numbered PNG (8 bit) or TIFF pictures.
    fps : float
        Capture rate, frames per second.
    seed : int
        Of textures and noise; the same seed gives the same bytes.
    frames : int, optional
        Number of frames at most.
    codec : str
        Of an .avi.

    Returns
    -------
    Truth
    """
    from measure.footage.writers import Clock, write_film

    truth = true_motion(trajectory, scene, fps, frames)
    clock = Clock(fps, scene.exposure_s, scene.bits)
    write_film(Path(path), pictures(trajectory, scene, fps=fps, seed=seed, frames=frames), codec, clock)
    return truth


def true_motion(trajectory: Trajectory, scene: Scene, fps: float, frames: int | None = None) -> Truth:
    """Where the platform and the marks are in each frame.

    Parameters
    ----------
    trajectory, scene, fps, frames
        As in `render`.

    Returns
    -------
    Truth
    """
    time, pose = _poses(trajectory, fps, frames)
    points, normals = _on_body(scene)
    turn = rotation(pose[:, 3:])
    world = np.einsum("tij,nj->tni", turn, points) + pose[:, None, :3]
    facing = -np.einsum("tij,nj->tni", turn, normals)[..., 1]
    picture = scene.camera.project(world)
    turned = angles(turn @ turn[0].T)
    turned[:, 2] = np.unwrap(turned[:, 2])
    relative: dict[str, Array] = dict(zip(CHANNELS, [*pose[:, :3].T, *turned.T], strict=True))
    relative["z_m"] = relative["z_m"] + _start_height(trajectory)
    return Truth(Trajectory(time, relative, name="truth"), picture[..., 0], picture[..., 1], facing)


def pictures(trajectory: Trajectory, scene: Scene, *, fps: float, seed: int, frames: int | None = None) -> Iterator[Picture]:
    """Render the pictures one after the other.

    Parameters
    ----------
    trajectory, scene, fps, seed, frames
        As in `render`.

    Returns
    -------
    iterator of (height, width) arrays of uint8 or uint16

    Raises
    ------
    InputError
        A depth other than 8, 12 or 16 bit.
    """
    if scene.bits not in (8, 12, 16):
        raise InputError(f"bits {scene.bits}: a synthetic film has 8, 12 or 16 bits. Give one of these.")
    rng = np.random.default_rng(seed)
    dots, table = _textures(scene, np.random.default_rng([seed, 1]))
    time, _ = _poses(trajectory, fps, frames)
    instants = _INSTANTS * scene.exposure_s if scene.exposure_s else np.zeros(1)
    bands = _bands(scene)
    cover, grey = rod_cover(scene)
    top = 2**scene.bits - 1
    step = 2.0 ** (scene.bits - 8)
    across = 1.0 + scene.light_gradient * np.linspace(-0.5, 0.5, scene.width)
    for t in time:
        light = scene.light ** (t / max(time[-1], 1e-9)) * across
        bare = np.vstack([_exposed(band, trajectory, t + delay + instants, dots, table) for band, delay in bands])
        bright = (bare * (1.0 - cover) + grey * cover) * light * 255.0 * step
        noisy = bright + rng.normal(0.0, scene.noise * step, bright.shape)
        yield np.rint(np.clip(noisy, 0, top)).astype(np.uint8 if scene.bits == 8 else np.uint16)


def _start_height(trajectory: Trajectory) -> float:
    return float(trajectory.channels["z_m"][0]) if "z_m" in trajectory.channels else 0.0


def _pose_at(trajectory: Trajectory, time: Array) -> Array:
    """Poses (n, 6) at any instants; positions count from the first sample."""
    from scipy.interpolate import CubicSpline

    inside = np.clip(time, trajectory.time_s[0], trajectory.time_s[-1])
    pose = np.zeros((len(inside), 6))
    for i, channel in enumerate(CHANNELS):
        if channel in trajectory.channels:
            values = trajectory.channels[channel]
            pose[:, i] = CubicSpline(trajectory.time_s, values)(inside) - (values[0] if i < 3 else 0.0)
    return pose


def _poses(trajectory: Trajectory, fps: float, frames: int | None) -> tuple[Array, Array]:
    start, end = trajectory.time_s[[0, -1]]
    most = int(np.floor((end - start) * fps * (1 + 1e-12))) + 1
    time = np.arange(most if frames is None else min(frames, most)) / fps
    return time, _pose_at(trajectory, start + time)


def _on_body(scene: Scene) -> tuple[Array, Array]:
    """Centres and outward normals of the marks on the platform; (marks, 3) each."""
    psi = np.array([mark.azimuth_rad for mark in scene.marks])
    normals = np.stack([np.sin(psi), -np.cos(psi), np.zeros(len(psi))], axis=-1)
    height = np.array([mark.height_m for mark in scene.marks])
    return scene.radius_m * normals + height[:, None] * [0.0, 0.0, 1.0], normals


def _textures(scene: Scene, rng: np.random.Generator) -> tuple[Array, Array]:
    """Speckles of all marks (n, 2), in metres from the mark's centre, and the row of each mark for `cast`."""
    dots, table = [], []
    for mark in scene.marks:
        own = _speckles(mark, rng) if mark.kind == "speckle" else np.empty((0, 2))
        start = sum(len(d) for d in dots)
        table.append([mark.azimuth_rad, mark.height_m, mark.size_m / 2, KINDS[mark.kind], mark.grain_m, start, start + len(own)])
        dots.append(own)
    return np.concatenate([np.empty((0, 2)), *dots]), np.array(table, float).reshape(-1, 7)


def _speckles(mark: MadeMark, rng: np.random.Generator) -> Array:
    """Centres on a jittered grid, so that no part of the mark stays empty."""
    pitch = 2.2 * mark.grain_m
    half = np.arange(-mark.size_m / 2 + pitch / 2, mark.size_m / 2, pitch)
    grid = np.stack(np.meshgrid(half, half), axis=-1).reshape(-1, 2)
    return grid + rng.uniform(-0.5, 0.5, grid.shape) * pitch


def _bands(scene: Scene) -> list[tuple[Scene, float]]:
    """Strips of rows that are read at one instant, each as a scene of its own, and their delay to the middle row, s."""
    if not scene.readout_s:
        return [(scene, 0.0)]
    camera, found = scene.camera, []
    for top in range(0, scene.height, _BAND):
        rows = min(_BAND, scene.height - top)
        x, y = camera.origin_px
        principal = None if camera.principal_px is None else (camera.principal_px[0], camera.principal_px[1] - top)
        seen = replace(camera, origin_px=(x, y - top), principal_px=principal)
        delay = ((top + 0.5 * (rows - 1)) / (scene.height - 1) - 0.5) * scene.readout_s
        found.append((replace(scene, height=rows, camera=seen), delay))
    return found


def _exposed(scene: Scene, trajectory: Trajectory, instants: Array, dots: Array, table: Array) -> Array:
    """The mean of some instants, as `_cast` gives them."""
    return np.asarray(np.mean([_cast(scene, pose, dots, table) for pose in _pose_at(trajectory, instants)], axis=0))


def _cast(scene: Scene, pose: Array, dots: Array, table: Array) -> Array:
    """One instant, without rods, light and noise: albedo of every pixel, (height, width)."""
    camera = scene.camera
    principal = camera.origin_px if camera.principal_px is None else camera.principal_px
    s, c = np.sin(camera.up_rad), np.cos(camera.up_rad)
    away = (np.array(camera.origin_px) - principal) * camera.m_per_px
    view = np.array([camera.m_per_px, principal[0], principal[1], c, s, away @ [c, s], away @ [s, -c], 1.0 / camera.distance_m])
    turn = rotation(pose[3:])
    body = np.array([scene.radius_m, scene.half_height_m, scene.body, scene.background])
    return cast(scene.width, scene.height, scene.rays, view, np.ascontiguousarray(turn), pose[:3], body, table, dots)


def project_for(scene: Scene, fps: float, start_height_m: float, subset: int = 25) -> Project:
    """The project of a synthetic film: true camera and geometry, true reference points of the marks.

    Parameters
    ----------
    scene : Scene
    fps : float
        Capture rate, frames per second.
    start_height_m : float
        Height of the platform's origin in the first frame, m.
    subset : int
        Side of the subset, odd, px.

    Returns
    -------
    Project
    """
    centres, _ = _on_body(scene)
    camera = scene.camera
    distance = {} if np.isinf(camera.distance_m) else {"distance_m": camera.distance_m, "principal_px": camera.principal_px}
    return make_project(
        {
            "film": {"fps": fps, **({"exposure_s": scene.exposure_s} if scene.exposure_s else {})},
            "marks": {"place_px": [tuple(place) for place in camera.project(centres).tolist()], "subset_px": subset},
            "scale": {"mm_per_px": 1e3 * camera.m_per_px, "up_deg": float(np.degrees(camera.up_rad))},
            "platform": {"origin_px": camera.origin_px, "start_height_m": start_height_m, "radius_m": scene.radius_m},
            "camera": {**distance, **({"readout_s": scene.readout_s} if scene.readout_s else {})},
        }
    )
