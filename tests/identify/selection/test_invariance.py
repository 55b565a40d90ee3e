"""The same case told in another way gets the same answer."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identify.commands.explain_gap import main
from measure.tables.loop import Loop, read_loop, write_loop
from measure.tables.trajectory import Trajectory, read_trajectory, write_trajectory
from simulate.effects import HubInertia
from simulate.files.model_file import read_model, write_model

TWO_LOOPS = ((1.0, 0.04), (3.0, 0.04))


def answer(folder: Path, *options: str) -> dict[str, Any]:
    main([str(folder / "model.toml"), str(folder / "campaign.toml"), "-o", str(folder / "out"), "--budget", "quick", "--quiet", *options])
    return json.loads((folder / "out" / "result.json").read_text())


@pytest.fixture
def told(campaign):
    """A case with a hub inertia hidden in it, and what is said of it."""
    folder = campaign(HubInertia(0.746 + 0.005), 71, loops=TWO_LOOPS)
    return folder, answer(folder)


def check_same(result: dict[str, Any], other: dict[str, Any], share: float) -> None:
    """Verdict and names alike, and the size within a share of its standard error."""
    assert other["verdict"] == result["verdict"] == "named"
    (effect,), (again,) = result["effects"], other["effects"]
    assert again["name"] == effect["name"] == "hub-inertia"
    size, same = effect["parameters"]["mass_kg"], again["parameters"]["mass_kg"]
    assert abs(same["value"] - size["value"]) < share * size["stderr"]


@pytest.mark.calibrate
def test_the_order_of_the_runs_changes_nothing(told):
    folder, result = told
    runs = (folder / "campaign.toml").read_text().split("[[run]]")[1:]
    (folder / "campaign.toml").write_text("".join(f"[[run]]{run}\n" for run in reversed(runs)))
    check_same(result, answer(folder), 0.05)


@pytest.mark.calibrate
def test_clocks_that_were_never_set_change_nothing(told):
    """Film and load cell recorded by a clock that was started long before; only the release's own jitter may move a little."""
    folder, result = told
    for path in folder.glob("deployment-*.csv"):
        film = read_trajectory(path)
        write_trajectory(Trajectory(film.time_s + 7.0, film.channels, film.sigma), path)
    for path in folder.glob("loop-*.csv"):
        loop = read_loop(path)
        write_loop(Loop(loop.time_s + 7.0, loop.elongation_m, loop.force_N), path)
    check_same(result, answer(folder), 0.3)


@pytest.mark.calibrate
def test_the_legs_numbered_from_another_one_change_nothing(told):
    folder, result = told
    model = read_model(folder / "model.toml")
    g = model.geometry
    assert g is not None
    turned = replace(
        g,
        base_joints_m=(*g.base_joints_m[2:], *g.base_joints_m[:2]),
        platform_joints_m=(*g.platform_joints_m[2:], *g.platform_joints_m[:2]),
    )
    write_model(replace(model, geometry=turned), folder / "model.toml")
    check_same(result, answer(folder), 0.05)


@pytest.mark.calibrate
def test_loops_in_other_units_change_nothing(told):
    folder, result = told
    for path in folder.glob("loop-*.csv"):
        loop = read_loop(path)
        rows = np.column_stack([1e3 * loop.time_s, 1e3 * loop.elongation_m, 1e-3 * loop.force_N])
        np.savetxt(path, rows, delimiter=";", header="t;travel;load", comments="", fmt="%.17g")
    options = ["--column", "time=t", "--unit", "time=ms", "--column", "elongation=travel", "--unit", "elongation=mm"]
    check_same(result, answer(folder, *options, "--column", "force=load", "--unit", "force=kN"), 0.05)
