"""What the tests of the film side share: made pictures with exact truth."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from measure.geometry.camera import Camera
from measure.synthetic.made_film import MadeMark, Scene
from measure.tables.trajectory import Trajectory

REAL = Path(__file__).resolve().parents[2].parent / "shared" / "real"


@pytest.fixture
def real_footage() -> Path:
    """Films made by others; a test that wants them is skipped where they are absent."""
    if not (REAL / "footage").is_dir():
        pytest.skip(f"real footage is not there: {REAL / 'footage'}")
    return REAL / "footage"


def _centres(size, grain, seed):
    return np.random.default_rng(seed).uniform(-12, size + 12, (int(size**2 / (3 * grain**2)), 2))


def _pattern(centres, size, grain):
    """Sum of Gaussians; each is a product of one along x and one along y."""
    along = np.arange(size, dtype=np.float32)
    across = np.exp(-0.5 * ((along - centres[:, :1].astype(np.float32)) / grain) ** 2)
    down = np.exp(-0.5 * ((along - centres[:, 1:].astype(np.float32)) / grain) ** 2)
    return down.T @ across


@cache
def _extremes(size, grain, seed):
    pattern = _pattern(_centres(size, grain, seed), size, grain)
    return float(pattern.min()), float(pattern.max())


@pytest.fixture(scope="session")
def speckled():
    """A speckle pattern as a sum of Gaussians, so that a shifted picture is exact and not interpolated."""

    def make(shift=(0.0, 0.0), *, grain=1.6, seed=0, size=72, noise=1.5, contrast=130.0, noise_seed=0, turn=0.0):
        middle = size // 2
        c, s = np.cos(turn), np.sin(turn)
        turned = (_centres(size, grain, seed) - middle) @ np.array([[c, s], [-s, c]]) + middle
        low, high = _extremes(size, grain, seed)
        grey = 60.0 + contrast * (_pattern(turned + np.asarray(shift), size, grain) - low) / (high - low)
        noisy = grey + np.random.default_rng(noise_seed).normal(0.0, noise, grey.shape)
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)

    return make


@pytest.fixture
def rig():
    """A small made rig: six speckled marks on a cylinder, and a deployment that turns and drifts a little."""

    def make(*, seconds=0.2, rise=0.06, theta_z=0.0, roll=0.03, distance=3.0, rods=(), **changed):
        time = np.arange(0.0, seconds + 1e-9, 0.002)
        s = time / time[-1]
        motion = {
            "x_m": 0.003 * np.sin(3 * s),
            "z_m": 0.252 + rise * s**2 * (3 - 2 * s),
            "theta_y_rad": roll * np.sin(4 * s),
            "theta_z_rad": theta_z * np.sin(np.pi / 2 * s),
        }
        camera = Camera(0.5e-3, (128.0, 210.0), 0.0, distance, (128.0, 128.0))
        marks = tuple(MadeMark(a, h, 0.017) for h in (-0.011, 0.011) for a in (-0.5, 0.0, 0.5))
        scene = Scene(256, 256, camera, marks, radius_m=0.055, half_height_m=0.024, rods=tuple(rods), **changed)
        return Trajectory(time, motion, name="made"), scene

    return make
