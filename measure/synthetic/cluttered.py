"""Made films of one thing that moves in front of still clutter, with exact truth: where marks are found by themselves.

Background and thing are sums of smooth bumps and straight edges, drawn four times finer than the pixels and averaged, so
that a shift by a fraction of a pixel is a shift and not an interpolation.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.footage.footage import Picture

Array = NDArray[np.float64]

_FINER = 4
SHAPES = ("box", "disc", "bar")


@dataclass(frozen=True)
class ClutteredScene:
    """One thing that moves in front of a background at rest.

    Attributes
    ----------
    background : (4 height, 4 width) array of float32
        Grey levels of 8 bit.
    thing : (4 height, 4 width) array of float32
        The same for the thing, where it is in the first frame.
    belongs : (4 height, 4 width) array of bool
        Where the thing is in the first frame.
    shift_px : (frames, 2) array
        Motion of the thing since the first frame, px.
    noise : float
        Standard deviation, grey levels.
    light : float
        Brightness of the last frame over that of the first.
    """

    background: NDArray[np.float32]
    thing: NDArray[np.float32]
    belongs: NDArray[np.bool_]
    shift_px: Array
    noise: float
    light: float

    @property
    def silhouette(self) -> NDArray[np.bool_]:
        """(height, width): which pixels of the first frame show the thing, in whole or in part."""
        rows, columns = self.belongs.shape
        return np.asarray(self.belongs.reshape(rows // _FINER, _FINER, columns // _FINER, _FINER).any(axis=(1, 3)))


def cluttered_scene(seed: int, width: int = 200, height: int = 240, frames: int = 30) -> ClutteredScene:
    """Draw a scene at random: a textured box, disc or bar that falls, rises or slides past a rule, boxes and speckle at rest.

    Parameters
    ----------
    seed : int
    width, height : int
        px.
    frames : int

    Returns
    -------
    ClutteredScene
    """
    rng = np.random.default_rng(seed)
    background = _clutter(rng, width, height)
    belongs, centre = _shape(rng, width, height)
    level, contrast = rng.uniform(40.0, 200.0), rng.uniform(15.0, 60.0)
    thing = (level + contrast * _speckle(rng, width, height, rng.uniform(1.2, 4.0))).astype(np.float32)
    along = np.array([rng.uniform(-0.1, 0.1) * width, 0.0])
    along[1] = (height - 45.0 - centre[1]) if centre[1] < height / 2 else 45.0 - centre[1]
    time = np.clip(np.linspace(-0.1, 1.0, frames), 0.0, 1.0)
    shift = np.outer(time**2 if rng.random() < 0.5 else time**2 * (3.0 - 2.0 * time), along)
    return ClutteredScene(background, thing, belongs, shift, rng.uniform(0.5, 3.0), rng.uniform(0.8, 1.1))


def cluttered_pictures(scene: ClutteredScene, seed: int) -> Iterator[Picture]:
    """Render the frames.

    Parameters
    ----------
    scene : ClutteredScene
    seed : int
        Of the noise.

    Returns
    -------
    iterator of (height, width) arrays of uint8
    """
    rng = np.random.default_rng([seed, 1])
    rows, columns = (n // _FINER for n in scene.belongs.shape)
    for t, (x, y) in enumerate(scene.shift_px):
        moved = np.array([[1.0, 0.0, _FINER * x], [0.0, 1.0, _FINER * y]])
        fine = (scene.belongs.shape[1], scene.belongs.shape[0])
        cover = cv2.warpAffine(scene.belongs.astype(np.float32), moved, fine)
        seen = cover * cv2.warpAffine(scene.thing, moved, fine) + (1.0 - cover) * scene.background
        picture = cv2.resize(seen, (columns, rows), interpolation=cv2.INTER_AREA)
        picture = cv2.GaussianBlur(picture, (0, 0), 0.5) * scene.light ** (t / max(len(scene.shift_px) - 1, 1))
        yield np.clip(np.rint(picture + rng.normal(0.0, scene.noise, picture.shape)), 0, 255).astype(np.uint8)


def _speckle(rng: np.random.Generator, width: int, height: int, grain_px: float) -> NDArray[np.float32]:
    """Smooth random texture of variance one."""
    size = _FINER * grain_px
    rough = cv2.GaussianBlur(rng.normal(0.0, 1.0, (_FINER * height, _FINER * width)).astype(np.float32), (0, 0), size)
    return np.asarray(rough / rough.std(), np.float32)


def _clutter(rng: np.random.Generator, width: int, height: int) -> NDArray[np.float32]:
    """Speckle, boxes with sharp edges, and a rule with its graduation."""
    grey = rng.uniform(20.0, 200.0) + rng.uniform(0.0, 25.0) * _speckle(rng, width, height, rng.uniform(1.5, 6.0))
    for _ in range(int(rng.integers(0, 12))):
        x, y = rng.integers(0, _FINER * width), rng.integers(0, _FINER * height)
        w, h = _FINER * rng.integers(4, 40, 2)
        grey[y : y + h, x : x + w] = rng.uniform(0.0, 255.0)
    left, pitch = int(rng.integers(0, width - 30)) * _FINER, int(rng.integers(5, 12)) * _FINER
    if rng.random() < 0.7:
        grey[:, left : left + 24 * _FINER] = 225.0
        for row in range(0, _FINER * height, pitch):
            long = 20 if row // pitch % 5 == 0 else 12
            grey[row : row + _FINER, left : left + long * _FINER] = 25.0
    return grey.astype(np.float32)


def _shape(rng: np.random.Generator, width: int, height: int) -> tuple[NDArray[np.bool_], Array]:
    """A box, disc or bar near the upper or lower border, and its centre, px."""
    kind = SHAPES[int(rng.integers(len(SHAPES)))]
    centre = np.array([rng.uniform(55.0, width - 55.0), 45.0 if rng.random() < 0.5 else height - 45.0])
    y, x = (np.indices((_FINER * height, _FINER * width)) + 0.5) / _FINER
    dx, dy = x - centre[0], y - centre[1]
    size = rng.uniform(20.0, 32.0)
    if kind == "disc":
        return np.asarray(np.hypot(dx, dy) < size), centre
    half = (size, size) if kind == "box" else (1.4 * size, 0.6 * size)
    return np.asarray((np.abs(dx) < half[0]) & (np.abs(dy) < half[1])), centre
