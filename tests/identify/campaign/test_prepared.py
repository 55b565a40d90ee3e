"""A film made ready: from where its elevation counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from identify.campaign.posing import film_of
from identify.campaign.run import Run
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import read_model
from simulate.model.rig import geometry_of

RIG = Path(__file__).resolve().parents[1] / "rig.toml"
TIME = np.arange(60) / 250.0


def film(start_m, sigma_m=1e-5):
    """A rise from rest, as a tracker gives it whose elevation begins here."""
    z = start_m + 2.0 * np.maximum(TIME - 0.02, 0.0) ** 2
    table = Trajectory(TIME, {"z_m": z, "x_m": 0.0 * TIME}, {"z_m": np.full(60, sigma_m), "x_m": np.full(60, sigma_m)}, name="one.csv")
    return film_of(Run(table), read_model(RIG))


def test_an_elevation_that_counts_from_the_first_frame_is_put_onto_the_stowed_height():
    height = geometry_of(read_model(RIG)).stowed_height_m
    displacement, elevation = film(0.0), film(height)
    assert displacement.values == pytest.approx(elevation.values)
    assert list(displacement.zeroed) == list(elevation.zeroed) == [True, True]


def test_an_elevation_that_begins_elsewhere_is_left_as_it_is():
    assert film(0.3).values[0, 0] == 0.3
    assert film(0.001).values[0, 0] == 0.001
