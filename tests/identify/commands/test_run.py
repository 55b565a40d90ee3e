"""`unspool run` types the other commands in their order, measures a film once, and stops where a file cannot be used.

The commands themselves are tested elsewhere, and together by `make installed`; here they only note what is typed.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from identify.commands import compare_model, explain_gap, fit_actuator
from identify.commands.subcommands.shipped import shipped
from identify.commands.unspool import main
from measure.commands import track_video
from measure.common.output import sha256, temporary_prefix


@pytest.fixture
def rig(tmp_path):
    """The demonstration's raw files with their templates."""
    assert main(["demo", "--raw", str(tmp_path / "rig"), "--quiet"]) == 0
    assert main(["init", str(tmp_path / "rig"), "--like", "demo", "--quiet"]) == 0
    return tmp_path / "rig"


@pytest.fixture
def typed(monkeypatch):
    """What is typed, command by command; the film's trajectory appears as if it had been measured."""
    words: list[list[str]] = []

    def note(name, status=0):
        def command(given):
            words.append([name, *given])
            if name == "track-video":
                measured(Path(given[0]), [Path(given[given.index(option) + 1]) for option in ("--project", "--model")], given[-2])
            return status

        return command

    monkeypatch.setattr(track_video, "main", note("track-video"))
    monkeypatch.setattr(fit_actuator, "main", note("fit-actuator", 1))
    monkeypatch.setattr(compare_model, "main", note("compare-model"))
    monkeypatch.setattr(explain_gap, "main", note("explain-gap", 1))
    return words


def measured(film, others, table):
    shutil.copy(film.parent / "deployment-2.csv", table)
    inputs = [{"file": str(path), "sha256": sha256(path)} for path in (film, *others)]
    Path(f"{table}.provenance.json").write_text(json.dumps({"inputs": inputs}))


def run(rig, *options):
    return main(["run", str(rig / "campaign.toml"), "-o", str(rig / "results"), "--quiet", *options])


def test_the_commands_are_typed_in_their_order_and_the_last_one_decides(rig, typed):
    assert run(rig, "--budget", "quick") == 1
    assert [words[0] for words in typed] == ["track-video", "fit-actuator", "compare-model", "explain-gap"]
    fitted = str(rig / "results" / "model.toml")
    assert typed[1].count("--mapping") == 1
    assert sum("loops" in word for word in typed[1]) == 6
    assert typed[2][1:3] == typed[3][1:3] == [fitted, str(rig / "campaign.toml")]
    assert typed[3][typed[3].index("--budget") + 1] == "quick"


def test_a_film_is_measured_once_and_again_when_it_its_project_or_the_model_changed(rig, typed):
    run(rig)
    run(rig)
    assert [words[0] for words in typed].count("track-video") == 1
    for name in ("film.toml", "model.toml"):
        (rig / name).write_text((rig / name).read_text() + "\n# changed\n")
        run(rig)
    assert [words[0] for words in typed].count("track-video") == 3


def test_loops_of_two_benches_are_left_to_the_common_fit(rig, typed):
    shutil.copy(rig / "bench.toml", rig / "other.toml")
    text = (rig / "campaign.toml").read_text()
    (rig / "campaign.toml").write_text(text.replace('mapping = "bench.toml"', 'mapping = "other.toml"', 1))
    run(rig)
    assert [words[0] for words in typed] == ["track-video", "compare-model", "explain-gap"]
    assert typed[-1][1] == str(rig / "model.toml")


def test_where_the_law_cannot_be_fitted_nothing_is_explained_with_the_old_one(rig, typed, monkeypatch):
    monkeypatch.setattr(fit_actuator, "main", lambda words: 2)
    assert run(rig) == 2
    assert [words[0] for words in typed] == ["track-video"]


@pytest.mark.parametrize("there", [False, True])
@pytest.mark.parametrize("refuses", [compare_model, explain_gap])
def test_a_refusal_half_way_leaves_the_folder_as_it_was(rig, typed, monkeypatch, there, refuses):
    results = rig / "results"
    if there:
        results.mkdir()
        (results / "model.toml").write_text("[actuator]\n[provenance]\n")
        (results / "mine.txt").write_text("the user's")
    before = {path.name: path.read_bytes() for path in results.glob("*")}
    monkeypatch.setattr(fit_actuator, "main", lambda words: (results / "model.toml").write_text("new") * 0)
    monkeypatch.setattr(compare_model, "main", lambda words: (results / "comparison.png").write_text("new") * 0)
    monkeypatch.setattr(refuses, "main", lambda words: 2)
    assert run(rig) == 2
    assert results.exists() == there
    assert {path.name: path.read_bytes() for path in results.glob("*")} == before


def test_what_a_run_changes_is_checked_with_the_model_of_the_option_before_any_work(rig, typed, capsys):
    (rig / "campaign.toml").write_text('[[run]]\nfile = "deployment-2.csv"\nmodel.nuisance.release_position_m = 1e300\n')
    assert run(rig, "--model", str(rig / "model.toml")) == 2
    assert "1e+300 is not between" in capsys.readouterr().err
    assert typed == []
    assert not (rig / "results").exists()


@pytest.mark.parametrize("ending", [".csv", ".csv.provenance.json", ".png", ".project.toml"])
def test_a_film_of_which_a_killed_run_has_left_a_file_without_its_name_is_measured_anew(rig, typed, ending):
    run(rig)
    kept = next((rig / "measured").glob("*.csv"))
    (kept.parent / f"{temporary_prefix(kept.with_suffix(ending))}1234").write_text("half")
    run(rig)
    assert [words[0] for words in typed].count("track-video") == 2


@pytest.mark.parametrize("text", ["", "{", "[]", '{"inputs": 1}', '{"inputs": [{}]}', "[" * 100_000, "\udcff"])
def test_a_film_whose_note_is_damaged_is_measured_anew(rig, typed, text):
    run(rig)
    note = next((rig / "measured").glob("*.provenance.json"))
    note.write_text(text, encoding="utf-8", errors="surrogateescape")
    run(rig)
    assert [words[0] for words in typed].count("track-video") == 2


def test_nothing_is_begun_while_a_file_is_wrong(rig, typed, capsys):
    (rig / "deployment-2.csv").unlink()
    (rig / "bench.toml").write_text("delimitter = 'semicolon'\n")
    assert run(rig) == 2
    said = capsys.readouterr().err
    assert "deployment-2.csv: no such file" in said
    assert 'did you mean "delimiter"?' in said
    assert typed == []
    assert not (rig / "results").exists()


def test_a_list_without_a_model_is_answered_with_the_line_to_add(rig, typed, capsys):
    text = (rig / "campaign.toml").read_text()
    (rig / "campaign.toml").write_text(text.replace('model = "model.toml"\n', ""))
    assert run(rig) == 2
    assert 'Add --model MODEL, or at the top of the list\nmodel = "model.toml"' in capsys.readouterr().err
    assert run(rig, "--model", str(shipped("demo") / "rig.toml")) == 1


def test_json_in_the_place_of_an_input_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "loop.csv").write_bytes((shipped("demo") / "loops" / "loop-1Hz-20mm.csv").read_bytes())
    (tmp_path / "runs.toml").write_text('[[run]]\nfile = "loop.csv"\n')
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    for taken in before:
        words = ["--model", str(shipped("demo") / "rig.toml"), "-o", str(tmp_path / "results"), "--json", str(taken)]
        assert main(["run", str(tmp_path / "runs.toml"), *words]) == 2
    assert capsys.readouterr().err.count("inputs are never written") == len(before)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
