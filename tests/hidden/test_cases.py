"""The board itself: what is detectable, what is one class, and that a case's folder tells nothing."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from board.bench import Bench
from board.campaigns import planned
from board.detectable import Variant, class_of, free_of, needed
from board.making import made, sealed_file
from board.rigs import drawn_rig
from board.shaker import stroke_of
from board.shapes import drawn, rivals
from board.specs import HIDDEN, OUTSIDE, Spec, board, chosen
from board.truths import amount_for
from board.yardstick import Yardstick
from scipy.stats import chi2

from identify.campaign.runs import read_campaign
from simulate.effects import CATALOGUE
from simulate.files.model_file import read_model


def runs_of(spec: Spec) -> Yardstick:
    chance = spec.chance
    rig = drawn_rig(chance)
    return Yardstick(Bench(rig, planned(spec, rig.known, chance)))


def test_an_effect_of_the_detectable_size_is_found_half_of_the_time():
    # the definition, played: noise drawn, law and releases fitted linearly, the gain of the effect's own columns tested
    chance = np.random.default_rng(1)
    free = free_of(chance.normal(size=(300, 7)))
    effect = free.left(chance.normal(size=(300, 2)))
    signal = effect @ [0.6, -0.8]
    signal *= np.sqrt(needed(2)) / np.linalg.norm(signal)
    q, _ = np.linalg.qr(effect)
    gains = np.sum((q.T @ (signal[:, None] + chance.normal(size=(300, 4000)))) ** 2, axis=0)
    assert np.mean(gains > chi2.isf(1e-3, 2)) == pytest.approx(0.5, abs=0.03)


def test_loops_cannot_tell_a_strip_that_moves_from_a_spool_that_turns():
    # along the leg both are a mass times the acceleration; only a deployment shows the strip swinging
    spec = Spec(("leg-mass",), run_set="loops")
    runs = runs_of(spec)
    true = runs.bench.rig.true
    hidden = drawn("leg-mass", true, runs.bench.reach_m, spec.chance)
    variants = runs.variants([lines for name in ("hub-inertia", "viscous-friction") for lines in rivals(CATALOGUE[name], true, 1e-3)])
    assert class_of(100.0 * runs.change(hidden, 1e-2), 1, variants) == ["hub-inertia"]


def test_a_rival_with_fewer_numbers_is_told_apart_only_by_what_they_would_not_gain_by_chance():
    """Fifteen beyond what four numbers say is clear for a truth of five, and what chance often gives one of nine."""
    column = np.eye(50)[:, :1]
    change = np.eye(50)[:, :2] @ np.sqrt([85.0, 15.0])
    rival = Variant("rival", 4, column, np.array([-1e3]), np.array([1e3]))
    assert needed(1) < 15.0 < needed(5)
    assert class_of(change, 5, [rival]) == []
    assert class_of(change, 9, [rival]) == ["rival"]


@pytest.mark.calibrate
def test_a_shaking_base_may_begin_at_any_phase():
    """A wave and its opposite are the same effect half a turn later, so either is told from the other by nothing."""
    runs = runs_of(Spec(("base-excitation",), run_set="single"))
    lines = next(iter(rivals(CATALOGUE["base-excitation"], runs.bench.rig.true, 1e-3)))
    (variant,) = runs.variants([lines])
    for sign in (1.0, -1.0):
        assert class_of(sign * variant.columns[:, 0], 6, [variant]) == ["base-excitation"]


@pytest.mark.calibrate
def test_a_force_on_the_platform_shows_in_no_loop():
    spec = Spec(("gravity-imbalance",), run_set="loops")
    runs = runs_of(spec)
    hidden = drawn("gravity-imbalance", runs.bench.rig.true, runs.bench.reach_m, spec.chance)
    assert amount_for(lambda a: float(np.sum(runs.left(hidden, a) ** 2)), needed(1), hidden.most) is None


def test_the_detectable_amount_is_met_however_it_grows():
    for power in (1.0, 2.0, 4.0):
        amount = amount_for(lambda a, p=power: 3.0 * a**p, needed(1), 1e9)
        assert amount is not None
        assert 3.0 * amount**power == pytest.approx(needed(1), rel=0.03)
    jump = amount_for(lambda a: 0.0 if a < 0.37 else 500.0, needed(1), 1e9)
    assert jump == pytest.approx(0.37, rel=0.05), "a jump is found from above"
    assert amount_for(lambda a: a**2, needed(1), 0.1) is None, "out of its bounds it shows, within them it does not"


def test_loops_beside_a_deployment_lower_the_detectable_hub_inertia():
    alone, both = (runs_of(Spec(("hub-inertia",), run_set=name)).bench for name in ("single", "standard"))
    both = replace(both, rig=alone.rig, campaign=replace(both.campaign, deployments=alone.campaign.deployments))
    sizes = []
    for runs in (Yardstick(alone), Yardstick(both)):
        hidden = drawn("hub-inertia", runs.bench.rig.true, 1e-3, np.random.default_rng(3))
        sizes.append(amount_for(lambda a, r=runs, h=hidden: float(np.sum(r.left(h, a) ** 2)), needed(1), hidden.most))
    assert sizes[1] is not None
    assert sizes[0] is None or sizes[1] < 0.1 * sizes[0]


@pytest.mark.calibrate
def test_what_releases_follow_in_curves_does_not_count_as_seen():
    # six unequal legs turn the platform far behind the stops, and so do releases: a line around the truth falls short of both
    spec = Spec(("leg-disparity",), 3.0, "standard", "coarse", seed=2)
    runs = runs_of(spec)
    true = runs.bench.rig.true
    hidden = drawn("leg-disparity", true, runs.bench.reach_m, spec.chance)
    small, large = (float(np.sum(runs.left(hidden, amount) ** 2)) for amount in (0.05, 0.5))
    assert large == pytest.approx(100.0 * small, rel=0.2), "what is left grows as the square"
    (vector,) = runs.bench.vectors([true.with_effect(hidden.at(0.5))])
    straight = free_of(runs.free.basis[: len(vector)]).left(vector - runs.bench.here)
    assert float(straight @ straight) > 5.0 * large


def test_a_load_cell_that_is_late_by_less_than_the_laser_knows_does_not_show():
    # the laser's noise leaves the phase of a sine uncertain by sqrt(2 / n) sigma / A
    runs = runs_of(Spec(("sensor-lag",), 3.0, "standard", "fine", seed=2))
    late_s = {run: np.sqrt(2.0 / len(run.time_s)) * 1e-5 / run.amplitude_m / (2 * np.pi * run.frequency_Hz) for run in runs.bench.loops}
    known = 1.0 / np.sqrt(sum(1.0 / late**2 for late in late_s.values()))
    hidden = drawn("sensor-lag", runs.bench.rig.true, 1e-3, np.random.default_rng(1))
    amount = amount_for(lambda a: float(np.sum(runs.left(hidden, a) ** 2)), needed(1), hidden.most)
    assert amount is not None
    assert abs(hidden.at(amount).flat()[0]) > np.sqrt(needed(1)) * known


def test_the_path_of_the_shaker_holds_its_turning_points():
    run = replace(runs_of(Spec((), seed=1)).bench.loops[0], drift_m=1e-3, late_s=2e-3)
    stroke = stroke_of(run)
    turns = np.flatnonzero(np.diff(np.sign(stroke.v)))
    assert len(turns) >= 6
    assert np.all(np.minimum(np.abs(stroke.v[turns]), np.abs(stroke.v[turns + 1])) < 1e-9)


@pytest.mark.slow
def test_a_case_made_again_is_the_same_to_the_byte_and_its_folder_tells_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("board.truths.HIDDEN", ("viscous-friction", "hub-inertia"))  # few rivals are as reproducible as all
    spec = Spec(("viscous-friction",), 10.0, run_set="loops")
    first, again = made(spec, tmp_path / "a"), made(spec, tmp_path / "b")
    assert _bytes(first) == _bytes(again)
    sealed = sealed_file(tmp_path / "a", spec)
    assert "viscous-friction" in sealed.read_text()
    assert not sealed.is_relative_to(first)
    words = "|".join((*CATALOGUE, *OUTSIDE, "sealed", "detectable"))
    names = {path.name for path in first.iterdir()}
    assert all(re.fullmatch(r"run-\d+\.csv|model\.toml|campaign\.toml", name) for name in names)
    known = {effect.name for effect in read_model(first / "model.toml").effects}
    for path in first.iterdir():
        assert set(re.findall(words, path.name + path.read_text())) <= known
    assert re.fullmatch(r"[0-9a-f]{12}", first.name)


def test_cases_are_read_by_the_project_and_hold_out_one_run_where_there_are_several(tmp_path: Path):
    folder = made(Spec((), run_set="standard", seed=3), tmp_path)
    runs = read_campaign([folder / "campaign.toml"])
    model = read_model(folder / "model.toml")
    assert [run.is_loop for run in runs] == [False] * 5 + [True] * 6
    assert [run.hold_out for run in runs] == [False] * 4 + [True] + [False] * 6
    heights = {run.model(model).geometry.stowed_height_m for run in runs if not run.is_loop and not run.hold_out}  # type: ignore[union-attr]
    masses = {run.model(model).platform.mass_kg for run in runs if not run.is_loop and not run.hold_out}
    assert len(heights) == len(masses) == 2


def test_the_board_hides_every_effect_of_the_catalogue_at_three_sizes_and_nothing_and_what_nobody_knows():
    specs = board("standard")
    assert len({spec.token for spec in specs}) == len(specs)
    alone = {(spec.hidden[0], spec.size) for spec in specs if len(spec.hidden) == 1 and spec.run_set == "standard"}
    assert {(name, size) for name in HIDDEN for size in (1.0, 3.0, 10.0)} <= alone
    assert {name for name, _ in alone} == {*HIDDEN, *OUTSIDE}
    assert sum(not spec.hidden for spec in specs) >= 15
    assert board("standard")[:20] == specs[:20]


def _bytes(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def test_words_that_all_have_to_fit_choose_one_case_of_each_effect():
    once = chosen(board("full"), ["standard", "3x", "seed-2"], None)
    assert sorted(name for spec in once for name in spec.hidden) == sorted([*HIDDEN, *OUTSIDE])
    assert {(spec.size, spec.run_set, spec.seed) for spec in once} == {(3.0, "standard", 2)}
    assert chosen(board("full"), ["standard", "3x", "seed-2"], 4, skip=3) == once[3:7]
    assert chosen(board("full"), ["2x"], None) == []
    assert [spec.hidden for spec in chosen(board("full"), ["nothing", "standard"], None)] == [()] * 40


def test_another_seed_gives_as_many_cases_on_rigs_of_its_own():
    fresh, known = board("seed-7"), board("full")
    assert len(fresh) == len(board("standard")) == len(board("seed-0"))
    assert not {spec.token for spec in fresh} & {spec.token for spec in known}
    assert set(board("seed-0")) == set(board("standard"))
    assert set(board("seed-7,8")) == {*fresh, *board("seed-8")}
