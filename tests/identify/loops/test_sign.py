"""An actuator takes energy: its loops run anticlockwise, however a laboratory counted."""

from dataclasses import replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign, remarks
from identify.loops.loop_data import area
from identify.loops.prepare import prepare
from identify.loops.sign import oriented, swapped_channels
from measure import Loop, write_loop
from simulate.loop import loop_force


def loop():
    t = np.arange(1500) / 300.0
    w = 2 * np.pi
    u = 0.05 * np.sin(w * t)
    force = loop_force(np.array([-0.25, 2.79, -0.3, 2.89, 400.0]), t, u, 0 * t, 0 * t, 2.8)
    return Loop(t, u, force)


def enclosed(given):
    data = prepare(given)
    return area(data, data.force_N)


@pytest.mark.parametrize(("elongation", "force", "word"), [(-1, 1, "elongation"), (1, -1, "force"), (1, 1, ""), (-1, -1, "")])
def test_a_sign_that_was_counted_the_other_way_is_turned_and_said(elongation, force, word):
    given = replace(loop(), elongation_m=elongation * loop().elongation_m, force_N=force * loop().force_N)
    loops, turned = oriented([given])
    assert enclosed(loops[0]) > 0.0
    assert turned.quantity == word
    assert f"{word}" in turned.sentence


@pytest.mark.parametrize("quantity", ["elongation_m", "force_N"])
def test_of_loops_that_disagree_the_one_that_runs_clockwise_is_turned_and_named(quantity):
    other = replace(loop(), **{quantity: -getattr(loop(), quantity)}, name="other.csv")
    loops, turned = oriented([loop(), other])
    assert "other.csv" in turned.sentence
    assert turned.quantity == quantity.partition("_")[0]
    assert enclosed(loops[1]) == pytest.approx(enclosed(loops[0]))


def test_a_campaign_turns_its_loops_too_and_says_so(tmp_path):
    write_loop(replace(loop(), elongation_m=-loop().elongation_m), tmp_path / "loop.csv")
    (run,) = read_campaign([tmp_path / "loop.csv"])
    assert isinstance(run.table, Loop)
    assert run.table.elongation_m == pytest.approx(loop().elongation_m, abs=1e-9)
    assert remarks([run]) == ["loop.csv: the loops run clockwise as given, so the elongation was counted the other way round"]


def test_in_a_campaign_only_the_loop_that_was_turned_has_a_remark(tmp_path):
    write_loop(loop(), tmp_path / "right.csv")
    write_loop(replace(loop(), elongation_m=-loop().elongation_m, force_N=1.001 * loop().force_N), tmp_path / "wrong.csv")
    runs = read_campaign([tmp_path / "right.csv", tmp_path / "wrong.csv"])
    assert remarks(runs) == ["wrong.csv: runs clockwise and the rest does not, so the elongation was counted the other way round"]


@pytest.mark.parametrize("seed", range(6))
def test_no_loop_with_a_heavy_spool_and_a_drift_is_turned(seed):
    """A spool forced by a hundred times the height of the loop, at 3 Hz; the mean elongation drifts by 2 mm a cycle."""
    chance, t, w = np.random.default_rng([901, seed]), np.arange(1000) / 1000.0, 6.0 * np.pi
    wave = 0.04 * np.sin(w * t + chance.uniform(0.0, 2.0 * np.pi))
    u = 0.1 + wave + chance.choice([-2e-3, 2e-3]) * 3.0 * t
    force = loop_force(np.array([-0.25, 3.07, -0.25, 3.2, 400.0]), t, u, 0 * t, 0 * t, 3.1) + 0.7 * w**2 * wave
    measured = Loop(t, u + chance.normal(0.0, 1e-5, len(t)), force + chance.normal(0.0, 2e-3, len(t)))
    assert oriented([loop(), measured])[1].quantity == ""


@pytest.mark.parametrize("beta", [40.0, 400.0])
@pytest.mark.parametrize("triangle", [False, True])
def test_swapped_channels_are_said_and_right_ones_are_not(beta, triangle):
    chance, t = np.random.default_rng(7), np.arange(1060) / 200.0
    turn = np.sin(2 * np.pi * t)
    u = 0.25 + 0.04 * (2 / np.pi * np.arcsin(turn) if triangle else turn)
    force = loop_force(np.array([-0.25, 2.79, -0.3, 2.89, beta]), t, u, 0 * t, 0 * t, 2.8) + 2e-3 * chance.standard_normal(len(t))
    u = u + 1e-5 * chance.standard_normal(len(t))
    assert swapped_channels([prepare(Loop(t, u, force))]) == []
    said = swapped_channels([prepare(Loop(t, force, u))])
    # where the loop is an ellipse nearly, nothing shows it
    assert [fault.word for fault in said] == (["swapped"] if beta > 100.0 or triangle else [])
