"""An effect in a mirror: the rig of the paper is its own mirror image across y, so what an effect does there is what its image does."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from simulate.deployment.deploy import deploy
from simulate.effects import BaseExcitation, CentreOfMassOffset, GeometryError, HubInertia, LegDisparity, ReleasePose
from simulate.files.model_file import read_model
from simulate.model.mirror import legs_in_mirror, mirrored_effect
from simulate.model.rig import Geometry

PROTOTYPE = read_model(Path(__file__).resolve().parents[3] / "datasets" / "prototype.toml")
GEOMETRY = cast(Geometry, PROTOTYPE.geometry)
TURNED = {"y_m": -1.0, "theta_x_rad": -1.0, "theta_z_rad": -1.0}
WITH_SIDES = [
    LegDisparity((0.3, 0.1, -0.2, 0.0, -0.1, 0.05)),
    ReleasePose((1e-3, -2e-3, 5e-4), (2e-3, 1e-3, -3e-3), (0.01, 0.02, 0.0)),
    CentreOfMassOffset((1e-3, -2e-3, 5e-4)),
    BaseExcitation(0.5, 7.0, 0.3, (0.6, 0.5, 0.62)),
    GeometryError(tuple(np.random.default_rng(4).normal(0.0, 5e-4, 36).tolist())),
]


@pytest.mark.parametrize("effect", WITH_SIDES, ids=lambda effect: effect.name)
def test_an_effect_in_the_mirror_moves_the_rig_as_the_mirror_shows_it(effect):
    quick = replace(PROTOTYPE, simulation=replace(PROTOTYPE.simulation, duration_s=0.3))
    seen, image = (deploy(quick.with_effect(one)).channels for one in (effect, mirrored_effect(effect, 1, GEOMETRY)))
    for name, values in seen.items():
        assert np.allclose(image[name], TURNED.get(name, 1.0) * values, rtol=1e-3, atol=1e-6), name
    assert np.max(np.abs(seen["y_m"])) > 2e-5


@pytest.mark.parametrize("effect", [*WITH_SIDES, HubInertia(0.02)], ids=lambda effect: effect.name)
def test_the_image_of_an_image_is_the_effect_itself(effect):
    for axis in (0, 1):
        image = mirrored_effect(effect, axis, GEOMETRY)
        if axis == 1 or effect.name not in ("leg-disparity", "geometry-error"):  # across x the rig is no image of itself
            assert np.allclose(mirrored_effect(image, axis, GEOMETRY).flat(), effect.flat())


def test_an_effect_without_sides_stays_as_it_is():
    assert mirrored_effect(HubInertia(0.02), 1, GEOMETRY) == HubInertia(0.02)


def test_each_leg_stands_where_the_image_of_another_one_does():
    assert legs_in_mirror(GEOMETRY, 1).tolist() == [5, 4, 3, 2, 1, 0]
