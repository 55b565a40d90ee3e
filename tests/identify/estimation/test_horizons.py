"""When a film reaches its stops: at the deployed height, or lower down where the platform tilts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation.horizons import first_stop_s, horizons, stretches
from simulate.effects import CentreOfMassOffset
from simulate.files.model_file import read_model

TILTS = CentreOfMassOffset((0.0, 0.1, 0.0))


@pytest.fixture
def problem_with(campaign):
    """One film of a rig with something hidden in it."""

    def made(hidden, seed):
        folder = campaign(hidden, seed, loops=(), deployments=({},), hold_out=False)
        return problem_of(read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"]))

    return made


def height_of(problem):
    """The film, its elevation, and the elevation of the deployed rig."""
    (film,) = problem.films
    return film, film.values[film.channels.index("z_m")], film.model.geometry.deployed_height_m


def with_height(problem, height):
    """The same film with another elevation."""
    film, _, _ = height_of(problem)
    values = film.values.copy()
    values[film.channels.index("z_m")] = height
    return replace(problem, films=(replace(film, values=values),))


def test_a_level_platform_stops_where_it_reaches_the_deployed_height(problem_with):
    problem = problem_with(None, 31)
    film, height, deployed = height_of(problem)
    rise = deployed - film.model.geometry.stowed_height_m
    assert first_stop_s(problem) == film.time_s[np.argmax(height >= deployed - 0.02 * rise)]


def test_a_platform_that_tilts_stops_below_the_deployed_height(problem_with):
    problem = problem_with(TILTS, 32)
    film, height, deployed = height_of(problem)
    stop, rise = first_stop_s(problem), deployed - film.model.geometry.stowed_height_m
    assert height.max() < deployed - 0.02 * rise
    assert height[film.time_s >= stop][0] > film.model.geometry.stowed_height_m + 0.25 * rise
    assert stop < film.time_s[np.argmax(height)]
    after = film.time_s > stop + 0.02
    assert np.gradient(height, film.time_s)[after].max() < np.gradient(height, film.time_s).max()
    assert len(horizons(problem)) == 3


@pytest.mark.parametrize("hidden", [None, TILTS])
def test_single_frames_that_jump_stop_nothing(problem_with, hidden):
    problem = problem_with(hidden, 33)
    film, height, _ = height_of(problem)
    jumps = height.copy()
    jumps[[5, 12, 30]] += (1.0, -1.0, 1.0)
    assert first_stop_s(with_height(problem, jumps)) == pytest.approx(first_stop_s(problem), abs=film.time_s[2])


def test_a_film_that_ends_while_the_platform_rises_has_no_stop(problem_with):
    problem = problem_with(None, 34)
    film, height, _ = height_of(problem)
    rising = film.time_s < 0.5 * first_stop_s(problem)
    cut = replace(film, time_s=film.time_s[rising], values=film.values[:, rising], counts=film.counts[:, rising])
    assert first_stop_s(replace(problem, films=(cut,))) == np.inf
    assert first_stop_s(with_height(problem, np.full_like(height, height[0]))) == np.inf


def test_films_are_met_in_equal_stretches_behind_the_first_stop_and_each_has_a_middle(problem_with):
    problem = problem_with(None, 31)
    last = float(problem.films[0].time_s[-1])
    ends, middles = zip(*stretches(problem), strict=True)
    assert list(ends[:-1]) == horizons(problem)
    assert ends[-1] == problem.until_s == np.inf
    reached = [*ends[:-1], last]
    assert np.diff(reached) == pytest.approx(np.full(3, (last - reached[0]) / 3))
    assert list(middles[1:]) == pytest.approx([0.5 * (a + b) for a, b in pairwise(reached)])


def test_films_that_reach_no_stop_are_one_stretch(problem_with):
    problem = problem_with(None, 31)
    early = problem.until(0.9 * first_stop_s(problem))
    assert [end for end, _ in stretches(early)] == [early.until_s]
