"""Rods in front of the platform of a synthetic film."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from measure.synthetic.scene import Rod, Scene

Array = NDArray[np.float64]

_SAMPLES = 8
"""Samples of a pixel along each side."""


def rod_cover(scene: Scene) -> tuple[Array, Array]:
    """Which part of each pixel the rods cover.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    cover, grey : (height, width) arrays
        Covered share, and the albedo of the rod that covers it.
    """
    cover, grey = np.zeros((scene.height, scene.width)), np.zeros((scene.height, scene.width))
    for rod in scene.rods:
        own = _covered(rod, cover.shape)
        cover, grey = np.maximum(cover, own), np.where(own > 0, rod.grey, grey)
    return cover, grey


def _covered(rod: Rod, shape: tuple[int, ...]) -> Array:
    """Share of each pixel within the strip, from samples over its area."""
    rows, columns = np.indices(shape)
    length = np.hypot(rod.x2 - rod.x1, rod.y2 - rod.y1)
    along = np.array([rod.x2 - rod.x1, rod.y2 - rod.y1]) / length
    offsets = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
    covered = np.zeros(shape)
    for dy in offsets:
        for dx in offsets:
            x, y = columns + dx - rod.x1, rows + dy - rod.y1
            beside, before = along[0] * y - along[1] * x, along[0] * x + along[1] * y
            covered += (np.abs(beside) < rod.width / 2) & (np.abs(before - length / 2) < length / 2)
    return covered / _SAMPLES**2
