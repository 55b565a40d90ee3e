"""What a fit had to move far beyond the model file is said first, with what it looks like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.estimation.parameters import Parameter
from identify.gap.compare import compare
from identify.gap.dragged import _looks_like, dragged, in_words, lost
from simulate.files.model_file import read_model


@pytest.fixture
def two(campaign):
    """Two deployments without loops, the second from 0.28 m."""
    folder = campaign(None, 71, loops=(), deployments=({}, {"geometry.stowed_height_m": 0.28}), hold_out=False, channels=("z_m",))
    return read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])


def test_a_run_whose_stowed_height_was_not_written_is_said_to_have_begun_there(two):
    model, runs = two
    moved = dragged(compare(model, [replace(run, changes={}) for run in runs]).fit)
    first = in_words(moved)[0]
    assert runs[1].label in first
    assert "geometry.stowed_height_m = 0.28" in first
    assert max(moved, key=lambda one: abs(one.shift)).shift == pytest.approx(0.28 - model.geometry.stowed_height_m, abs=0.006)


def test_a_film_whose_scale_was_moved_says_so():
    scale = Parameter("film.length_scale", 1.5e-4, 1.0, -np.inf, np.inf, "film.csv")
    assert "the film's scale looks off by 13.7 %" in _looks_like(scale, 0.137, None)


def test_nothing_is_dragged_where_all_is_as_written(two):
    model, runs = two
    assert dragged(compare(model, runs).fit) == ()


def test_a_law_that_a_fit_knows_worse_than_the_file_is_lost(campaign, fitted):
    fit = fitted(campaign(None, 72, loops=((1.0, 0.04), (3.0, 0.04)), deployments=()))
    assert list(lost(fit)) == []
    unsure = np.diag([1e4 if one.name == "beta_per_m" else 0.0 for one in fit.problem.parameters])
    (sentence,) = lost(replace(fit, widened=unsure))
    assert sentence.startswith("beta_per_m would be")
