"""Ctrl-C and SIGTERM end a command in one sentence, whatever is going on when they come."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import tomllib
from pathlib import Path

import pytest

from measure.common.command_line import run
from measure.common.output import all_or_none, write_text
from measure.common.running.interrupts import COMMANDS

ROOT = Path(__file__).parents[4]


def test_every_command_is_known_by_its_name():
    scripts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["scripts"]
    assert set(COMMANDS) == set(scripts)


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_at_work_is_a_sentence_and_a_status(capsys, number, status):
    def work(words):
        signal.raise_signal(number)
        return 0

    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert run("track-video", work, []) == status
    assert "nothing was written" in capsys.readouterr().err
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_what_had_been_written_before_the_signal_is_not_denied(capsys, tmp_path):
    def work(words):
        with all_or_none():
            write_text(tmp_path / "out.txt", "whole")
        raise KeyboardInterrupt

    assert run("track-video", work, []) == 130
    assert "the results had been written" in capsys.readouterr().err


FOREIGN = {  # a module of a library, in which the signal comes
    "turned into another error": """
        import signal
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            raise ImportError("half")
    """,
    "lost in a callback": """
        import signal
        class Gone:
            def __del__(self):
                signal.raise_signal(signal.SIGINT)
        def lose():
            Gone()
    """,
}  # fmt: skip
SCRIPT = """
    import sys, time
    sys.argv[:] = ["fit-actuator"]
    import measure.commands
    from measure.common.command_line import run
    def work(words):
        import foreign
        getattr(foreign, "lose", int)()
        time.sleep(60)
        return 0
    sys.exit(run("fit-actuator", work))
"""


@pytest.mark.parametrize("how", FOREIGN)
def test_a_library_can_neither_lose_nor_turn_the_signal(tmp_path, how):
    (tmp_path / "foreign.py").write_text(textwrap.dedent(FOREIGN[how]))
    ended = started(textwrap.dedent(SCRIPT), tmp_path)
    assert (ended.returncode, ended.stderr) == (130, "fit-actuator: stopped; nothing was written\n")


def test_while_a_command_is_loaded_it_ends_in_a_sentence_too(tmp_path):
    ended = started(
        "import signal, sys\nsys.argv[:] = ['explain-gap']\nimport measure.commands\nsignal.raise_signal(signal.SIGINT)", tmp_path
    )
    assert (ended.returncode, ended.stderr) == (130, "explain-gap: stopped; nothing was written\n")


def test_whoever_imports_a_command_keeps_his_own_answer_to_the_signal(tmp_path):
    code = "import signal\nimport measure.commands, simulate.commands.sweep_deployments\n"
    ended = started(f"{code}assert signal.getsignal(signal.SIGINT) is signal.default_int_handler", tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")


def started(code, folder):
    """A process of its own, as a user starts it."""
    path = os.pathsep.join([str(ROOT), str(folder)])
    environment = {**os.environ, "PYTHONPATH": path}
    return subprocess.run([sys.executable, "-c", code], cwd=folder, env=environment, capture_output=True, text=True, check=False)
