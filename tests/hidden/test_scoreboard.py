"""The board: explain-gap asked about cases whose truth is sealed, those of the fast board and those of a fresh seed."""

from __future__ import annotations

import shutil
import time
from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from board import running
from board.further import with_further_run
from board.making import made, sealed_file
from board.page import markdown, printed
from board.running import METHODS, OURS, PATIENCE_S, ask_all, asked, read_answers, run, tokens_answered, version
from board.scoring import Scored, scored
from board.specs import Spec, board
from board.tally import Rate, headline, held_out_gap, strata, tally
from calibration import consistent

from identify.campaign.runs import read_campaign
from identify.loops.prepare import prepare
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import read_model

CASES = 40  # of a fresh board, in a whole calibration
IN_LOOPS = Spec(("viscous-friction",), 3.0, "loops")
PLAIN = Spec(("viscous-friction",), 10.0, "loops")  # so large that whoever names anything names something here


@pytest.mark.calibrate
def test_a_board_of_a_fresh_seed_is_answered_as_well_as_is_promised(tmp_path, calibration_seed, share_of, validation_table):
    specs = board(f"seed-{calibration_seed}")[: share_of(CASES)]
    rows = scored(specs, run(specs, OURS, tmp_path, processes=2), tmp_path)
    validation_table("Rates", [as_row(rate) for rate in headline(rows)], f"{len(rows)} cases; 95 % intervals after Clopper and Pearson.")
    validation_table("By size, run set and engine", [as_row(rate) for rate in strata(rows)])
    validation_table("Cases", [case_row(row) for row in rows])
    found = {rate.name: rate for rate in headline(rows)}
    *_, intervals, failed = found.values()
    assert failed.hits == 0
    assert consistent(intervals.hits, intervals.cases, 0.90)
    for rate in found.values():
        if rate.goal.startswith("at least"):
            assert consistent(rate.hits, rate.cases, percent(rate.goal)), rate
        if rate.goal.startswith("at most"):
            assert consistent(rate.hits, rate.cases, 0.0, percent(rate.goal)), rate
    assert held_out_gap(rows)["median"] is None or held_out_gap(rows)["median"] < 1.15


def percent(goal: str) -> float:
    """The share in `at least 95 %`."""
    return float(goal.split()[-2]) / 100.0


def as_row(rate: Rate) -> dict[str, Any]:
    low, high = rate.interval
    return {
        "rate": rate.name,
        "hits": rate.hits,
        "cases": rate.cases,
        "interval": f"{100 * low:.0f} to {100 * high:.0f} %",
        "aim": rate.goal,
    }


def case_row(row: Scored) -> dict[str, Any]:
    spec, named = row.spec, "; ".join(" or ".join(finding) for finding in row.said)
    right = {"none": not row.names, "unknown": row.verdict == "unknown"}.get(row.expected, row.class_correct)
    return {
        "acts": " and ".join(spec.hidden) or "nothing",
        "size": spec.size,
        "runs": spec.run_set,
        "expected": row.expected,
        "verdict": row.verdict,
        "named": named,
        "right": right,
        "processor time, s": round(row.processor_s),
    }


@pytest.mark.calibrate
@pytest.mark.parametrize("spec", board("fast"), ids=lambda spec: spec.token)
def test_the_answer_to_a_case_of_the_fast_board_is_the_kind_that_is_right(spec: Spec, tmp_path: Path, validation_table):
    (row,) = scored([spec], run([spec], OURS, tmp_path, processes=1), tmp_path)
    validation_table(f"Fast board, case {spec.token}", [case_row(row)])
    assert row.verdict != "failed"
    if row.expected == "none":
        assert row.verdict == "no-gap"
    elif row.expected == "unknown":
        assert row.verdict == "unknown"
    else:
        assert row.class_correct, f"{row.spec.hidden}: {row.verdict} {row.said}"


@pytest.mark.calibrate
def test_an_answer_is_the_same_when_there_is_no_sealed_truth_anywhere(tmp_path: Path):
    case = made(IN_LOOPS, tmp_path / "with")
    alone = shutil.copytree(case, tmp_path / "without" / "case")
    first = asked(OURS, case, PATIENCE_S)
    shutil.rmtree(sealed_file(tmp_path / "with", IN_LOOPS).parent)
    shutil.rmtree(case)
    second = asked(OURS, alone, PATIENCE_S)
    assert first[0] == second[0] == 0
    assert first[2] == second[2]
    assert first[2]["verdict"] in ("named", "class")


def test_an_interrupted_run_goes_on_and_asks_nothing_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(running, "made", lambda spec, folder: folder)
    monkeypatch.setattr(running, "asked", lambda method, case, patience_s: (0, 1.0, {"verdict": "no-gap"}))
    (first,) = run([IN_LOOPS], OURS, tmp_path, processes=1)
    file = tmp_path / f"{OURS}.jsonl"
    file.write_text(file.read_text() + '{"token": "cut o')
    said: list[str] = []
    (again,) = run([IN_LOOPS], OURS, tmp_path, processes=1, say=said.append)
    assert again == first
    assert not said
    assert [answer.version for answer in read_answers(file)] == [version()]
    assert tokens_answered(OURS, tmp_path) == {IN_LOOPS.token}
    file.write_text(file.read_text().replace(version(), "older"))
    assert tokens_answered(OURS, tmp_path) == set()


def test_no_case_is_begun_when_the_time_is_over_and_each_is_asked_as_soon_as_a_place_is_free(tmp_path: Path, monkeypatch):
    begun, slow_may_end = [], Event()

    def ask(method: str, case: Path, patience_s: float) -> tuple[int, float, dict[str, str]]:
        begun.append(case.name)
        if case.name == "slow":
            assert slow_may_end.wait(60.0)
        elif case.name == "last":
            slow_may_end.set()
        return 0, 1.0, {"verdict": "no-gap"}

    monkeypatch.setattr(running, "asked", ask)
    makers = {name: partial(Path, name) for name in ("slow", "first", "last")}
    assert ask_all(makers, OURS, tmp_path / "late.jsonl", until=time.monotonic() - 1.0) == {}
    assert begun == []
    assert set(ask_all(makers, OURS, tmp_path / "answers.jsonl")) == {"slow", "first", "last"}
    assert sorted(begun) == ["first", "last", "slow"]


def test_who_does_not_come_to_an_end_is_ended_by_processor_time_and_has_failed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "endless.py").write_text("def main(arguments):\n    while True:\n        pass\n")
    monkeypatch.setitem(METHODS, "endless", "endless")
    status, spent, said = asked("endless", tmp_path, 1.0)
    assert (status, spent) == (124, 1.0)
    assert "no answer after 1 s of processor time" in said["error"]


def test_the_processor_time_of_an_answer_is_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "asleep.py").write_text("import time\n\ndef main(arguments):\n    time.sleep(1.0)\n    return 2\n")
    monkeypatch.setitem(METHODS, "asleep", "asleep")
    status, spent, _ = asked("asleep", tmp_path, 60.0)
    assert status == 2
    assert 0.0 < spent < 0.9


@pytest.mark.slow
def test_the_recommended_test_is_done_as_it_is_described(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("board.truths.HIDDEN", ("viscous-friction", "hub-inertia"))  # what else it might be does not matter here
    case = made(IN_LOOPS, tmp_path)
    before = read_campaign([case / "campaign.toml"])
    of_loops = {"kind": "loop", "frequency_Hz": 6.0, "amplitude_m": 0.03, "splits": {"a": 0.9}, "model": {}}
    runs = read_campaign([with_further_run(IN_LOOPS, of_loops, tmp_path) / "campaign.toml"])
    assert len(runs) == len(before) + 1
    loop = prepare(runs[-1].table)  # type: ignore[arg-type]
    assert loop.frequency_Hz == pytest.approx(6.0, rel=1e-3)
    assert 0.9 * 0.03 < loop.amplitude_m < 1.01 * 0.03


@pytest.mark.calibrate
def test_a_recommended_deployment_is_let_go_under_its_own_condition(tmp_path: Path):
    spec = Spec(("gravity-imbalance",), 3.0, "single")
    made(spec, tmp_path)
    test = {"kind": "deployment", "model": {"platform": {"mass_kg": 1.5}}, "times_as_long": 2.0, "channels": ["y_m", "z_m"], "splits": {}}
    before, run = read_campaign([with_further_run(spec, test | {"runs": 2}, tmp_path) / "campaign.toml"])[-2:]
    assert run.model(read_model(tmp_path / "further" / spec.token / "model.toml")).platform.mass_kg == 1.5
    assert isinstance(run.table, Trajectory)
    assert isinstance(before.table, Trajectory)
    assert not np.array_equal(before.table.channels["z_m"], run.table.channels["z_m"])
    assert set(run.table.channels) == {"y_m", "z_m"}
    assert len(run.table.time_s) == 300
    assert np.ptp(run.table.channels["z_m"]) > 0.05


@pytest.mark.calibrate
@pytest.mark.parametrize("method", ["lowest-error", "forward-bic", "sparse-regression", "gaussian-process"])
def test_every_rival_answers_in_the_words_of_explain_gap(tmp_path: Path, method: str):
    rows = scored([PLAIN], run([PLAIN], method, tmp_path, processes=1), tmp_path)
    assert rows[0].verdict != "failed"
    assert rows[0].held_out is not None
    assert rows[0].names == (method != "gaussian-process")
    assert method in printed(method, rows)
    assert method in markdown({method: tally(rows)}, "one", version(method))
