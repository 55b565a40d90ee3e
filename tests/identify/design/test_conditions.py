"""Further tests are predicted with instruments like those there were."""

from __future__ import annotations

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.design.conditions import blank_film
from identify.design.further_test import Condition
from simulate.files.model_file import read_model

FROM_THE_SIDE = Condition("from the side", channels=("y_m", "z_m", "theta_x_rad"))


def predicted(folder):
    problem = problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))
    return problem, blank_film(problem, FROM_THE_SIDE)


def test_a_rotation_that_no_film_has_measured_is_as_sure_as_marks_on_the_platform_allow(campaign):
    problem, film = predicted(campaign(None, 650, deployments=({},), loops=(), channels=("z_m",), hold_out=False))
    assert problem.model.geometry is not None
    arm_m = np.linalg.norm(problem.model.geometry.platform_joints_m[0])
    length_m, rotation_rad = np.median(problem.films[0].sigma[0]), film.sigma[2]
    assert rotation_rad == pytest.approx(np.full(len(film.time_s), length_m / arm_m), rel=1e-4)
    assert film.sigma[:2] == pytest.approx(np.full((2, len(film.time_s)), length_m))


def test_a_rotation_is_as_sure_as_the_rotations_that_films_have_measured(campaign):
    problem, film = predicted(campaign(None, 651, deployments=({},), loops=(), hold_out=False))
    seen = problem.films[0]
    measured = np.median(seen.sigma[[name.endswith("_rad") for name in seen.channels]])
    assert film.sigma[2] == pytest.approx(np.full(len(film.time_s), measured))
