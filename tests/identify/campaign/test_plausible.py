"""A deployment that cannot be one of the model as its columns stand is refused, with what to do; every right one is taken."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identify.campaign.plausible import require_plausible
from identify.campaign.posing import film_of
from identify.campaign.run import Run
from identify.campaign.runs import files_of, read_campaign
from identify.loops.prepare import prepare
from measure.common.errors import InputError
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import read_model

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def model():
    return read_model(ROOT / "datasets" / "prototype.toml")


def rise(chance, zeroed=False):
    """A film of a rise to the deployed height with a rest before it."""
    time = np.arange(chance.integers(60, 200)) * chance.choice([0.001, 0.004, 0.01])
    start = 0.0 if zeroed else 0.252
    z = start + 0.4 * np.clip(time / time[-1] * 1.5 - 0.2, 0.0, 1.0) ** 2 + 1e-4 * chance.standard_normal(len(time))
    return time, {"z_m": z, "x_m": 1e-4 * chance.standard_normal(len(time))}


def refused(model, time, channels, sigma=None):
    with pytest.raises(InputError) as refusal:
        require_plausible("test.csv", Trajectory(time, channels, sigma or {}), model)
    return str(refusal.value)


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("zeroed", [False, True])
def test_right_films_are_taken_and_those_of_another_unit_or_sign_refused(model, seed, zeroed):
    time, channels = rise(np.random.default_rng(seed), zeroed)
    require_plausible("test.csv", Trajectory(time, channels), model)
    assert "turn the sign" in refused(model, time, {**channels, "z_m": -channels["z_m"]})
    assert "divide it by 1000" in refused(model, time, {name: 1e3 * values for name, values in channels.items()})
    if time[-1] > 0.4:
        assert "If time_s is in ms" in refused(model, 1e3 * time, channels)


@pytest.mark.parametrize("rows", [2, 3, 4])
def test_a_film_of_a_few_rows_is_refused(model, rows):
    time, channels = rise(np.random.default_rng(0))
    assert f"{rows} rows" in refused(model, time[:rows], {name: values[:rows] for name, values in channels.items()})


@pytest.mark.parametrize("sigma", [1e-300, 5e-324, 1e-17])
def test_a_standard_deviation_below_what_can_be_measured_is_refused(model, sigma):
    time, channels = rise(np.random.default_rng(0))
    assert "nothing is measured better" in refused(model, time, channels, {"z_m": np.full(len(time), sigma)})


def test_a_model_too_stiff_for_the_length_of_a_film_is_named_by_its_key(model):
    time, channels = rise(np.random.default_rng(0))
    stiff = replace(model, end_stop=replace(model.end_stop, stiffness_N_per_m=1e13))
    assert "end_stop.stiffness_N_per_m" in refused(stiff, time, channels)


def test_the_gate_stands_before_every_use_of_a_film(model):
    time, channels = rise(np.random.default_rng(0))
    with pytest.raises(InputError, match="turn the sign"):
        film_of(Run(Trajectory(time, {"z_m": -channels["z_m"]})), model)


@pytest.mark.parametrize("pause_s", [60.0, 1000.0, 1e9])
def test_two_recordings_in_one_loop_file_are_not_taken_for_one(pause_s):
    time = np.arange(600) * 0.005
    u = 0.01 * np.sin(2 * np.pi * time)
    time = time + np.where(np.arange(600) > 300, pause_s, 0.0)
    with pytest.raises(InputError, match="two recordings"):
        prepare(Loop(time, u, 2.8 + u))


@pytest.mark.parametrize("unit", [1e-300, 1e-12])
def test_a_loop_that_is_sampled_faster_than_anything_is_refused(unit):
    time = np.arange(600) * 0.005
    with pytest.raises(InputError, match="Check its unit"):
        prepare(Loop(unit * time, 0.01 * np.sin(2 * np.pi * time), 2.8 + np.sin(time)))


@pytest.mark.parametrize("size", [1e200, 1e20])
def test_a_loop_of_impossible_numbers_is_refused(size):
    time = np.arange(600) * 0.005
    with pytest.raises(InputError, match="it is never beyond"):
        prepare(Loop(time, size * np.sin(time), 2.8 + np.sin(time)))


def test_all_files_that_a_list_of_runs_names_are_inputs(tmp_path):
    (tmp_path / "list.toml").write_text(
        'model = "m.toml"\n[[run]]\nfile = "a.csv"\nmapping = "b.toml"\n[[run]]\nfile = "f.avi"\nproject = "p.toml"\n'
    )
    named = {path.name for path in files_of([tmp_path / "list.toml", tmp_path / "c.csv"])}
    assert named == {"list.toml", "m.toml", "a.csv", "b.toml", "f.avi", "p.toml", "c.csv"}


@pytest.mark.parametrize(
    "text", ["run = [1, 2]", "run = 3", 'run = ["a"]', "[[run]]\nfile = 1", "[[run]]\nfile = []", '[[run]]\nfile = "\\u001b[2J.csv"']
)
def test_runs_that_are_no_tables_are_refused_in_a_sentence(tmp_path, text):
    (tmp_path / "list.toml").write_text(text)
    with pytest.raises(InputError, match=r"run|no such file"):
        read_campaign([tmp_path / "list.toml"])
