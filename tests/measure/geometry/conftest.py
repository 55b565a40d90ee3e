"""Sightings of a drum, made from exact geometry without any picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from measure.correlation.marks import OK, Marks
from measure.correlation.shape_function_bias import EVEN, NODES, Response
from measure.geometry.body import Body, body_points
from measure.geometry.camera import Camera, on_cylinder, rotation
from measure.geometry.rigid_body import PERSPECTIVE, Fit, fit_platform

PLACES = np.array([[x, y] for y in (300.0, 346.0) for x in (76.0, 152.0, 228.0)])

CAMERA = Camera(0.5e-3, (152.0, 323.0), 0.0, 3.0, (152.0, 190.0))


@dataclass(frozen=True)
class Drum:
    """Six marks on an upright drum that rises, tilts and turns by `turn_deg` in `frames` frames; sigma : of a sighting, px."""

    frames: int = 40
    sigma: float = 0.01
    turn_deg: float = 30.0
    radius_m: float = 0.07
    camera: Camera = CAMERA

    @property
    def pose(self):
        """(frames, 6), m and rad."""
        s = np.linspace(0.0, 1.0, self.frames)
        turn = np.radians([1.0, 1.2, self.turn_deg])
        channels = [0.01 * np.sin(3.0 * s), 0.0 * s, 0.1 * s, turn[0] * np.sin(2.0 * s), turn[1] * np.sin(4.0 * s), turn[2] * s]
        return np.stack(channels, axis=-1)

    @property
    def places_px(self):
        """(frames, 6, 2): where the reference points are, px."""
        return self.carried_px(self.pose)

    def carried_px(self, pose):
        """Where the reference points are under poses (frames, 6), (frames, 6, 2) px."""
        points = on_cylinder(self.camera, PLACES, self.radius_m)
        return self.camera.project(np.einsum("tij,nj->tni", rotation(pose[:, 3:]), points) + pose[:, None, :3])

    def seen(self, error_px) -> Marks:
        """Sightings that are off by error_px, (frames, 6, 2)."""
        shape = (self.frames, len(PLACES))
        weights, affine = np.broadcast_to(EVEN, (len(PLACES), 9, 2, 2)), np.broadcast_to(np.eye(4), (len(PLACES), 4, 4))
        response = Response(PLACES, PLACES[:, None] + 12.5 * NODES, weights, np.full(len(PLACES), 6), affine)
        covariance = np.broadcast_to(self.sigma**2 * np.eye(2), (*shape, 2, 2)).copy()
        none, names = np.zeros(shape), [f"m{i}" for i in range(len(PLACES))]
        marks = Marks(np.arange(self.frames) / 250.0, names, response, none, none, covariance, none + 1.0, none, np.full(shape, OK))
        at = Body(self.camera, body_points(marks, self.camera, self.radius_m), response).project(self.pose) + error_px
        return replace(marks, x_px=at[..., 0], y_px=at[..., 1])

    def fit(self, marks: Marks) -> Fit:
        """The body fitted to them."""
        return fit_platform(marks, self.camera, body_points(marks, self.camera, self.radius_m), PERSPECTIVE)


@pytest.fixture
def drum():
    """The drum."""
    return Drum
