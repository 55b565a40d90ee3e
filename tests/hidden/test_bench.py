"""The bench board: what its cases are, that a case made twice is the same to the byte, and what counts as right."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from benchtop.asking import ask
from benchtop.cases import ERRORS, KINDS, ONLY_LOOPS, Spec, board
from benchtop.making import drawn_case, drawn_once, made, sealed_file, up_to_the_stops
from benchtop.nuisances import as_built, forces_of_runs, in_tolerances, tolerance_of, with_inertia, with_mass, with_stops
from benchtop.page import calibration, headline, markdown
from benchtop.scoring import Scored, removed, score
from benchtop.sizes import EFFECT_SIZE, SHOWS, LooseYardstick, amount_of, error_shows
from benchtop.tracks import Track, coloured, tracked
from board.bench import Bench, in_run
from board.campaigns import Campaign
from board.detectable import needed
from board.rigs import drawn_rig
from board.running import Answer
from board.shapes import drawn
from calibration import consistent

from measure.tables.trajectory import Trajectory

SHARES = {"nothing: a gap is seen": (0.0, 0.05), "effects: a wrong name": (0.0, 0.04), "model file: physics invented": (0.0, 0.04)}
LEAST = {"model file: named, or in the class": 0.83, "effects: class-correct": 0.9, "outside: unknown, partly, or an honest class": 0.8}


@pytest.mark.calibrate
def test_a_bench_board_of_a_fresh_seed_is_answered_as_well_as_is_promised(tmp_path, calibration_seed, pytestconfig, validation_table):
    specs = board(calibration_seed, pytestconfig.option.share)
    rows = ask(specs, tmp_path)
    rates = {one.name: one for one in headline(rows)}
    note = f"{len(rows)} cases; 95 % intervals after Clopper and Pearson."
    validation_table("Rates", [{"rate": one.name, "hits": one.hits, "cases": one.cases, "aim": one.goal} for one in rates.values()], note)
    validation_table("Weights", [{"stated": words, "hits": one.hits, "cases": one.cases} for words, _, one in calibration(rows)])
    for name, least in LEAST.items():
        assert consistent(rates[name].hits, rates[name].cases, least), rates[name]
    for name, most in SHARES.items():
        assert consistent(rates[name].hits, rates[name].cases, *most), rates[name]
    assert rates["no answer"].hits == 0


def test_a_board_has_its_four_kinds_and_a_share_of_it_a_share_of_each():
    whole, part = board(5), board(5, 0.2)
    assert Counter(spec.kind for spec in whole) == KINDS
    assert Counter(spec.kind for spec in part) == {kind: n // 5 for kind, n in KINDS.items()}
    assert len({spec.token for spec in whole}) == 120
    assert not {spec.token for spec in whole} & {spec.token for spec in board(6)}
    assert Counter(spec.hidden for spec in whole if spec.kind == "errors") == dict.fromkeys(ERRORS, 6)
    assert {spec.runs for seed in range(9) for spec in board(seed) if spec.hidden in ONLY_LOOPS} == {"loops"}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["errors", pytest.param("nothing", marks=pytest.mark.calibrate)])
def test_a_case_made_twice_is_the_same_to_the_byte_and_its_folder_tells_nothing(tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("board.platform_mujoco._STEP_S", 5e-4)  # coarse steps are as reproducible as fine ones
    spec = Spec(kind, "geometry-error" if kind == "errors" else "", "films", 1, 0)
    first, second = made(spec, tmp_path / "a"), made(spec, tmp_path / "b")
    assert {file.name: file.read_bytes() for file in first.iterdir()} == {file.name: file.read_bytes() for file in second.iterdir()}
    text = "".join(file.read_text() for file in first.iterdir())
    assert "geometry-error" not in text
    assert json.loads(sealed_file(tmp_path / "a", spec).read_text())["spec"]["kind"] == kind


@pytest.mark.parametrize(("name", "error"), [("platform-mass", 6.0), ("platform-inertia", 6.9), ("stop-stiffness", 3.05)])
def test_an_error_shows_no_more_than_its_own_tolerance_lets_it_and_nothing_where_it_is_none(name: str, error: float):
    spec = next(spec for spec in board(5) if spec.kind == "nothing" and spec.runs == "films")
    rig, films = drawn_rig(spec.chance), drawn_case(spec).campaign.deployments[:1]
    runs, true = LooseYardstick(Bench(rig, Campaign(films))), rig.true
    built = {
        "platform-mass": with_mass(true, 0.03),
        "platform-inertia": with_inertia(true, np.full(3, -0.2)),
        "stop-stiffness": with_stops(true, np.array([2.5, 1.0])),
    }[name]
    none = np.zeros(len(films))
    own = float(np.linalg.norm(in_tolerances(true, built, none, name)))
    assert own == pytest.approx(error, rel=0.02)
    assert error_shows(name, true, none, runs) == pytest.approx(0.0, abs=1e-9)
    most = own / np.sqrt(needed(1)) + 1e-9
    assert 0.0 < error_shows(name, built, none, runs) <= most
    loud = tuple(replace(film, sigma={channel: 1e6 * s for channel, s in film.sigma.items()}) for film in films)
    assert error_shows(name, built, none, LooseYardstick(Bench(rig, Campaign(loud)))) < 0.1 * most


def test_a_ballast_comes_on_top_of_the_mass_that_the_platform_has():
    """Whatever the file says of it: what the elevations with and without ballast show of a wrong mass is next to nothing."""
    spec = Spec("nothing", "", "elevation", 4, 0)
    rig, films = drawn_rig(spec.chance), drawn_case(spec).campaign.deployments
    bench = Bench(rig, Campaign(films))
    heavy = with_mass(rig.true, 0.03)
    known = rig.known.platform.mass_kg
    ballast = [run.changes.get("platform.mass_kg", known) - known for run in films]
    assert max(ballast) > 0.1 * known
    assert [in_run(heavy, run).platform.mass_kg for run in films] == pytest.approx([1.03 * known + more for more in ballast])
    assert error_shows("platform-mass", heavy, np.zeros(len(films)), LooseYardstick(bench)) < 1.0


@pytest.mark.parametrize("error", [-0.04, 0.04])
def test_films_without_ballast_show_next_to_nothing_of_a_wrong_mass_for_the_law_follows_it(error: float):
    """Behind the stops a fit was lost that looked for how, and of thirty masses drawn the one was taken where it was."""
    rig = drawn_rig(Spec("nothing", "", "films", 0, 0).chance)
    films = drawn_case(Spec("nothing", "", "films", 0, 0)).campaign.deployments[:2]
    assert not any("platform.mass_kg" in run.changes for run in films)
    short = up_to_the_stops(rig.true, films)
    assert all(0.5 * len(run.time_s) < one.frames < len(run.time_s) for one, run in zip(short, films, strict=True))
    runs = LooseYardstick(Bench(rig, Campaign(short)))
    assert error_shows("platform-mass", with_mass(rig.true, error), np.zeros(len(films)), runs) < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed"), [("gravity-imbalance", 8), ("air-drag", 6)])
def test_an_effect_shows_what_is_left_once_all_that_is_free_has_bent_to_it(name: str, seed: int):
    """Of a force that the law can imitate next to nothing; never more than along straight lines."""
    case = drawn_case(Spec("effects", name, "films", seed, 0))
    assert case.amount > 0.0
    assert 0.0 < case.multiple <= 5.0 + 1e-9
    assert (case.multiple < 1.0) == (name == "gravity-imbalance")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "runs", "seed"), [("platform-mass", "loops", 7), ("platform-inertia", "loops", 5), ("stop-stiffness", "films", 10)]
)
def test_an_error_is_drawn_until_the_runs_show_it(name: str, runs: str, seed: int):
    spec = Spec("errors", name, runs, seed, 0)
    assert drawn_once(spec, spec.chance).multiple < SHOWS <= drawn_case(spec).multiple


@pytest.mark.parametrize(("name", "seed"), [("end-stop-dissipation", 5), ("centre-of-mass-offset", 5), ("centre-of-mass-offset", 7)])
def test_an_effect_within_a_tolerance_of_the_model_file_is_not_detectable(name: str, seed: int):
    """However quiet the run is, where an effect shows by far more than its square: as large as its tolerance is, so large it must be."""
    spec = next(spec for spec in board(seed) if spec.kind == "nothing" and spec.runs == "films")
    rig, film = drawn_rig(spec.chance), drawn_case(spec).campaign.deployments[0]
    quiet = replace(film, sigma={channel: 1e-3 * s for channel, s in film.sigma.items()})
    runs = LooseYardstick(Bench(rig, Campaign((quiet,))))
    hidden = drawn(name, rig.true, runs.bench.reach_m, spec.chance)
    larger = replace(hidden, direction=np.abs(hidden.direction))  # a stop can lose no more damping than it has
    amount, multiple = amount_of(larger, runs, outside=False)
    size, wanted = np.linalg.norm(larger.at(amount).flat()) / tolerance_of(name, rig.true), np.sqrt(needed(larger.parameters))
    assert size == pytest.approx(EFFECT_SIZE * wanted)
    assert multiple == pytest.approx(EFFECT_SIZE)


@pytest.mark.parametrize("white", [0.0, 0.4])
def test_noise_has_the_memory_and_the_size_that_it_was_asked_for(white):
    track = Track(0.6, 0.0, 0.0, 0.0, white)
    noise = coloured(100_000, track, np.random.default_rng(1))
    assert np.std(noise) == pytest.approx(1.0, rel=0.02)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx((1.0 - white) * 0.6, abs=0.01)
    assert np.corrcoef(noise[3:], noise[:-3])[0, 1] == pytest.approx((1.0 - white) * 0.6**3, abs=0.02)
    means = noise.reshape(200, 500).mean(axis=1)
    assert np.std(means) == pytest.approx(track.colour / np.sqrt(500.0), rel=0.15)


def test_a_track_counted_from_its_first_frame_begins_where_the_model_has_it():
    time = np.arange(200) / 250.0
    clean = Trajectory(time, {"z_m": 0.26 + time**2})
    seen = tracked(clean, {"z_m": 1e-4}, Track(0.5, 0.01, 0.1, 0.0), True, np.random.default_rng(2))
    assert seen.channels["z_m"][0] == pytest.approx(0.26, abs=1e-8)
    assert 150 < len(seen.time_s) < 200


def test_what_is_hidden_in_the_model_file_is_larger_than_its_tolerance_and_all_else_within_it():
    known = drawn_rig(np.random.default_rng(3)).known
    for draw in range(20):
        chance = np.random.default_rng(draw)
        heavy = as_built(known, "platform-mass", chance)
        assert 0.0199 < abs(heavy.platform.mass_kg / known.platform.mass_kg - 1.0) < 0.0501
        assert heavy.geometry is not None
        assert known.geometry is not None
        assert np.std(np.subtract(heavy.geometry.base_joints_m, known.geometry.base_joints_m)) < 6e-4
        off = np.abs(forces_of_runs("stored-force-per-run", 4, chance))
        assert np.sum((off > 0.0199) & (off < 0.0501)) == 3


def row(spec: Spec, verdict: str, *said: tuple[str, ...], **more: Any) -> Scored:
    findings = [{"name": one[0], "equivalents": list(one[1:]), "parameters": more.get("parameters", {})} for one in said]
    held = more.get("held_out", (2.0, 1.0))
    gap = {"held_out": {"before": {"rms_over_noise": held[0]}, "after": {"rms_over_noise": held[1]}}}
    result = {"verdict": verdict, "effects": findings, "gap": gap, "weights": more.get("weights", {}), "drafted": more.get("drafted")}
    return score(
        spec, Answer(spec.token, "m", "v", 0, 1.0, result), {"values": more.get("values", {}), "multiple": more.get("multiple", 5.0)}
    )


def of(kind: str, hidden: str = "") -> Spec:
    return Spec(kind, hidden, "loops", 1, 0)


def test_any_gap_where_nothing_is_hidden_is_a_false_alarm_and_only_a_name_is_a_wrong_name():
    rates = {one.name: one.hits for one in headline([row(of("nothing"), "unknown"), row(of("nothing"), "named", ("a",))])}
    assert rates["nothing: a gap is seen"] == 2
    assert rates["nothing: a wrong name"] == 1
    assert row(of("nothing"), "no-gap").right


def test_an_error_of_the_model_file_may_stand_in_a_class_and_physics_alone_is_invented():
    wrong = of("errors", "platform-mass")
    assert row(wrong, "class", ("pulley-inertia", "platform-mass")).right
    assert row(wrong, "named", ("pulley-inertia",)).invented
    beside = row(wrong, "several", ("platform-mass",), ("air-drag",))
    assert (beside.found, beside.invented, beside.right) == (True, True, False)
    assert not row(wrong, "named", ("geometry-error",)).invented
    assert not row(wrong, "no-gap").found


def test_a_force_that_nobody_knows_is_unknown_or_a_class_that_runs_held_out_bear_out():
    force = of("outside", "gust")
    assert row(force, "unknown").right
    assert row(force, "partly", ("air-drag",)).right
    assert row(force, "class", ("air-drag", "b"), held_out=(3.0, 1.2)).right
    assert not row(force, "class", ("air-drag", "b"), held_out=(3.0, 2.5)).right
    assert row(force, "named", ("air-drag",), held_out=(3.0, 1.0)).wrong
    assert not row(force, "no-gap").right


def test_an_effect_that_its_runs_cannot_show_counts_as_nothing():
    assert row(of("effects", "air-drag"), "no-gap", multiple=0.0).right


def test_a_draft_is_worth_its_share_of_what_is_more_than_noise():
    assert removed((6.1, 1.05)) == pytest.approx(0.990, abs=1e-3)
    assert removed((2.0, 1.4)) == pytest.approx(0.6)
    assert removed((1.02, 1.02)) == 1.0
    assert row(of("outside", "gust"), "unknown", drafted={"held_out": {"before": 3.0, "after": 1.5}}).draft_worth_having
    assert not row(of("outside", "gust"), "unknown", drafted={"held_out": None}).draft_worth_having


def test_names_that_make_the_held_out_gap_larger_are_counted_and_intervals_are_those_of_the_truth():
    given = {"f": {"ci95": [0.9, 1.1]}, "g": {"ci95": [0.0, 0.1]}}
    found = row(of("effects", "a"), "named", ("a",), held_out=(1.0, 1.4), parameters=given, values={"f": 1.0, "g": 2.0})
    assert found.worse
    assert (found.inside, found.intervals) == (1, 2)
    assert not row(of("effects", "a"), "no-gap", held_out=(1.0, 1.4)).worse


def test_stated_weights_stand_beside_how_often_they_were_right():
    rows = [
        row(of("nothing"), "no-gap", weights={"no-gap": 0.9, "a": 0.1}),
        row(of("effects", "a"), "no-gap", weights={"no-gap": 0.9, "a": 0.1}),
    ]
    table = {words: (one.hits, one.cases) for words, _, one in calibration(rows)}
    assert table == {"0.05 to 0.2": (1, 2), "0.8 to 0.95": (1, 2)}
    assert "| nothing: a wrong name | 0 of 1 |" in markdown(rows, "Two.")
