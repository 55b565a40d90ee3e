"""A run as a film: rendered pixel by pixel, then followed by track-video as anybody would."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from measure.commands.track_video import main as track_video
from measure.geometry.film_project import write_project
from measure.synthetic.made_film import deployment_scene, project_for, render
from measure.tables.trajectory import CHANNELS, Trajectory, read_trajectory
from simulate.model.model import Model

from .camera import Motion, angles_of
from .campaigns import FPS, FRAMES, Deployment

_RATE_HZ = 2000.0


def tracked(motion: Motion, run: Deployment, model: Model, seed: int) -> Trajectory:
    """The table that track-video makes of a film of this motion; the film itself is thrown away."""
    assert model.geometry is not None
    scene = deployment_scene()
    with tempfile.TemporaryDirectory() as place:
        film, project, table = (Path(place) / name for name in ("film.avi", "film.toml", "film.csv"))
        render(_waiting(motion, run.instant_s), scene, film, fps=FPS, seed=seed, frames=FRAMES)
        write_project(project_for(scene, FPS, start_height_m=model.geometry.stowed_height_m), project)
        status = track_video([str(film), "--project", str(project), "-o", str(table), "--quiet"])
        if status != 0:
            raise RuntimeError(f"track-video ended with {status} on a made film")
        return read_trajectory(table)


def _waiting(motion: Motion, instant_s: float) -> Trajectory:
    """The motion with the time before the release in front, at 2 kHz."""
    waits = round(instant_s * _RATE_HZ)
    time = np.arange(round(motion.time_s[-1] * _RATE_HZ)) / _RATE_HZ
    place, turn = motion.at(time)
    curves = dict(zip(CHANNELS, (*place.T, *angles_of(turn)), strict=True))
    channels = {name: np.concatenate([np.full(waits, values[0]), values]) for name, values in curves.items()}
    return Trajectory(np.arange(waits + len(time)) / _RATE_HZ, channels)
