"""The fast board: explain-gap asked about cases whose truth is sealed."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from board.further import with_further_run
from board.making import made, sealed_file
from board.page import markdown, printed
from board.running import OURS, asked, read_answers, run, tokens_answered, version
from board.scoring import Scored, scored
from board.specs import Spec, board
from board.tally import tally

from identify.campaign.runs import read_campaign
from identify.loops.loop_data import prepare
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import read_model

pytestmark = pytest.mark.slow
PATIENCE_S = 900.0
IN_LOOPS = Spec(("viscous-friction",), 3.0, "loops")
PLAIN = Spec(("viscous-friction",), 10.0, "loops")  # so large that whoever names anything names something here


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("board")


@pytest.fixture(scope="module", params=board("fast"), ids=lambda spec: spec.token)
def row(request: pytest.FixtureRequest, folder: Path) -> Scored:
    """One case of the fast board, asked and scored; its truth is read when the answer is there."""
    answers = run([request.param], OURS, folder, processes=1, patience_s=PATIENCE_S)
    (found,) = scored([request.param], answers, folder)
    return found


def test_the_answer_to_a_sealed_case_is_the_kind_that_is_right(row: Scored):
    assert row.verdict != "failed"
    if row.expected == "none":
        assert row.verdict == "no-gap"
    elif row.expected == "unknown":
        assert row.verdict == "unknown"
    else:
        assert row.class_correct, f"{row.spec.hidden}: {row.verdict} {row.said}"


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


def test_an_interrupted_run_goes_on_and_asks_nothing_twice(tmp_path: Path):
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


def test_the_recommended_test_is_done_as_it_is_described(tmp_path: Path):
    case = made(IN_LOOPS, tmp_path)
    before = read_campaign([case / "campaign.toml"])
    of_loops = {"kind": "loop", "frequency_Hz": 6.0, "amplitude_m": 0.03, "splits": {"a": 0.9}, "model": {}}
    runs = read_campaign([with_further_run(IN_LOOPS, of_loops, tmp_path) / "campaign.toml"])
    assert len(runs) == len(before) + 1
    loop = prepare(runs[-1].table)  # type: ignore[arg-type]
    assert loop.frequency_Hz == pytest.approx(6.0, rel=1e-3)
    assert 0.9 * 0.03 < loop.amplitude_m < 1.01 * 0.03


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


@pytest.mark.parametrize("method", ["lowest-error", "forward-bic", "sparse-regression", "gaussian-process"])
def test_every_rival_answers_in_the_words_of_explain_gap(tmp_path: Path, method: str):
    rows = scored([PLAIN], run([PLAIN], method, tmp_path, processes=1), tmp_path)
    assert rows[0].verdict != "failed"
    assert rows[0].held_out is not None
    assert rows[0].names == (method != "gaussian-process")
    assert method in printed(method, rows)
    assert method in markdown({method: tally(rows)}, "one", version(method))
