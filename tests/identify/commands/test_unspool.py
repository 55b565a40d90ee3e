"""`unspool`: every task is found, and each says what it does."""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest

from identify.commands.subcommands.completion import COMMANDS, script
from identify.commands.subcommands.tasks import TASKS
from identify.commands.unspool import main
from simulate.effects import CATALOGUE
from simulate.report.effect_text import text_of


def test_without_a_task_all_tasks_and_commands_are_listed(capsys):
    assert main([]) == 0
    said = capsys.readouterr().out
    assert all(f"  {name} " in said for name in (*TASKS, *COMMANDS[1:]))


@pytest.mark.parametrize("task", TASKS)
def test_the_help_of_a_task_ends_with_examples_and_exit_status(task, capsys):
    with pytest.raises(SystemExit):
        main([task, "--help"])
    said = capsys.readouterr().out
    assert said.startswith(f"usage: unspool {task} ")
    assert said.split("examples:")[1].count(f"unspool {task}") >= 2
    assert "70 a fault of the program" in said


def test_a_misspelt_task_is_answered_with_the_nearest(capsys):
    assert main(["efects", "--quiet"]) == 2
    assert capsys.readouterr().err == 'unspool: error: unspool has no task "efects"; did you mean "effects"?\n'


@pytest.mark.parametrize("kind", CATALOGUE.values(), ids=CATALOGUE)
def test_every_effect_says_what_it_is_and_how_it_looks(kind):
    text = text_of(kind)
    assert text.opening.endswith(".")
    assert text.in_loop
    assert text.in_deployment
    assert all(row["is"] and row["low"] <= row["noticeable"] <= row["high"] for row in text.parameters)


def test_an_effect_is_written_for_programs_too(tmp_path):
    assert main(["effects", "stribeck-friction", "--quiet", "--json", str(tmp_path / "e.json")]) == 0
    (effect,) = json.loads((tmp_path / "e.json").read_text())["effects"]
    assert effect["formula"].startswith("F = ")
    assert [row["unit"] for row in effect["parameters"]] == ["N", "m/s"]


def test_all_unknown_effects_are_reported_at_once(capsys):
    assert main(["effects", "hub-inertai", "hub-inertia", "air-dragg"]) == 2
    said = capsys.readouterr().err
    assert '"hub-inertia"?' in said
    assert '"air-drag"?' in said


def completed(*words: str) -> list[str]:
    """What bash offers for the last of these words."""
    line = f"COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}; _unspool; echo ${{COMPREPLY[@]}}"
    ran = subprocess.run(["bash", "-c", f"{script('bash')}\n{line}"], capture_output=True, text=True, check=True)
    return ran.stdout.split()


@pytest.mark.skipif(shutil.which("bash") is None or shutil.which("unspool") is None, reason="asks the installed command through bash")
def test_bash_completes_tasks_options_and_effects():
    assert completed("unspool", "ef") == ["effects"]
    assert "--bootstrap" in completed("fit-actuator", "--b")
    assert completed("unspool", "effects", "hub") == ["hub-inertia"]


def test_a_file_of_effects_is_not_written_over(tmp_path, capsys):
    mine = tmp_path / "mine.py"
    mine.write_text("")
    assert main(["effects", "hub-inertia", "--effects", str(mine), "--json", str(mine)]) == 2
    assert "inputs are never written" in capsys.readouterr().err
    assert mine.read_text() == ""
