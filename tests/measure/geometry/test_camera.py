"""The three angles of a pose: what each turns, and back again."""

from __future__ import annotations

import numpy as np
import pytest

from measure.geometry.camera import angles, rotation

X, Y, Z = np.eye(3)


@pytest.mark.parametrize(("axis", "before", "after"), [(0, Y, Z), (1, Z, X), (2, X, Y)])
def test_an_angle_turns_about_its_own_axis_by_the_right_hand(axis, before, after):
    theta = np.zeros(3)
    theta[axis] = np.pi / 2
    assert rotation(theta) @ before == pytest.approx(after, abs=1e-12)


def test_the_platform_first_turns_about_the_vertical_and_then_tilts():
    assert rotation(np.array([np.pi / 2, 0.0, np.pi / 2])) @ X == pytest.approx(Z, abs=1e-12)


def test_angles_undo_rotation():
    theta = np.random.default_rng(0).normal(0, 0.4, (20, 3))
    assert np.allclose(angles(rotation(theta)), theta, atol=1e-12)
