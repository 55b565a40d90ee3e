"""Pictures with exact truth for the tracking benchmarks: formulas evaluated at every pixel, nothing interpolated."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

CONTRAST, NOISE, SUBSET, SIZE = 130.0, 1.5, 41, 96
MIDDLE = SIZE // 2
OPTICS_PX = 0.7
"""Blur of the edges of quadrant and dot, one standard deviation."""


@njit(cache=True)
def _speckles(u, v, centres, grain):
    made = np.zeros(u.shape)
    reach = 25.0 * grain * grain
    for i in range(u.shape[0]):
        for j in range(u.shape[1]):
            for k in range(len(centres)):
                r2 = (u[i, j] - centres[k, 0]) ** 2 + (v[i, j] - centres[k, 1]) ** 2
                if r2 < reach:
                    made[i, j] += math.exp(-0.5 * r2 / grain**2)
    return made


@dataclass(frozen=True)
class Pattern:
    """A mark: speckle with a grain in px, quadrant or dot."""

    kind: str
    grain: float = 1.0
    seed: int = 0

    @property
    def name(self) -> str:
        return f"speckle {self.grain:g}" if self.kind == "speckle" else self.kind

    def values(self, u, v):
        """Brightness at places (u, v) of the mark, about 0 to 1."""
        if self.kind == "speckle":
            low, high, centres = self._grains()
            return (_speckles(u, v, centres, self.grain) - low) / (high - low)
        from scipy.special import erf

        edge = math.sqrt(2.0) * OPTICS_PX
        if self.kind == "quadrant":
            return 0.5 + 0.5 * erf(u / edge) * erf(v / edge)
        return 0.5 - 0.5 * erf((np.hypot(u, v) - 12.0) / edge)

    def _grains(self):
        if self not in _KNOWN:
            chance = np.random.default_rng(self.seed)
            centres = chance.uniform(-70, 70, (int(140**2 / (3.0 * self.grain**2)), 2))
            grid = np.mgrid[-20:21, -20:21].astype(float)
            still = _speckles(grid[1], grid[0], centres, self.grain)
            _KNOWN[self] = (still.min(), still.max(), centres)
        return _KNOWN[self]


_KNOWN: dict = {}


def picture(pattern, *, noise_seed=0, noise=NOISE, **scene):
    """A picture of a mark as a camera delivers it: `bare` with noise, in whole grey levels."""
    return noisy(bare(pattern, **scene), noise_seed, noise)


def noisy(grey, noise_seed, noise=NOISE):
    """Grey values with noise added, rounded to 8 bit."""
    return np.clip(np.rint(grey + np.random.default_rng(noise_seed).normal(0.0, noise, grey.shape)), 0, 255).astype(np.uint8)


def bare(pattern, *, shift=(0.0, 0.0), matrix=None, blur=(0.0, 0.0), light=None, cover=None, size=SIZE):
    """Grey values without noise, size px downwards and SIZE across, of the mark with its centre at MIDDLE + shift.

    matrix : (2, 2) turn and stretch. blur : motion during the exposure, px. light : function of (grey, x, y).
    cover : function of (grey, x, y) that puts something in front.
    """
    y, x = np.mgrid[:size, :SIZE].astype(float)
    inverse = np.eye(2) if matrix is None else np.linalg.inv(matrix)
    grey = np.zeros(x.shape)
    steps = np.linspace(-0.5, 0.5, 33) if any(blur) else [0.0]
    for step in steps:
        dx, dy = x - MIDDLE - shift[0] - step * blur[0], y - MIDDLE - shift[1] - step * blur[1]
        u, v = inverse[0, 0] * dx + inverse[0, 1] * dy, inverse[1, 0] * dx + inverse[1, 1] * dy
        grey += pattern.values(u, v) / len(steps)
    grey = 60.0 + CONTRAST * grey
    grey = grey if light is None else light(grey, x - MIDDLE, y - MIDDLE)
    return grey if cover is None else cover(grey, x, y)


def bound_px(pattern):
    """Cramer-Rao bound of the shift between two pictures: sigma sqrt(2) / sqrt(sum of squared slopes); the mean of x and y."""
    half = SUBSET // 2
    y, x = np.mgrid[-half - 1 : half + 2, -half - 1 : half + 2].astype(float)
    step = 1e-3
    along_x = (pattern.values(x + step, y) - pattern.values(x - step, y))[1:-1, 1:-1] * CONTRAST / (2 * step)
    along_y = (pattern.values(x, y + step) - pattern.values(x, y - step))[1:-1, 1:-1] * CONTRAST / (2 * step)
    sigma = math.sqrt(NOISE**2 + 1.0 / 12.0)
    return 0.5 * sum(sigma * math.sqrt(2.0) / math.sqrt((slope**2).sum()) for slope in (along_x, along_y))
