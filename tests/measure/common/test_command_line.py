"""Every command ends in the same manner: done, bad verdict, or one sentence and nothing written."""

from __future__ import annotations

import errno
import os
import subprocess
import sys

import pytest

from measure.common import command_line as command
from measure.common.errors import InputError
from measure.common.inputs import existing_file


@pytest.fixture
def options():
    return command.parser("pull-strip", "Pull a strip.", output="table (CSV)", output_default="strip.csv")


def test_a_misspelt_option_is_answered_with_the_nearest_one(options):
    with pytest.raises(InputError, match=r'unknown option "--qiet"; did you mean "--quiet"\?'):
        options.parse_args(["--qiet"])


def test_an_option_is_never_guessed_from_its_beginning(options):
    with pytest.raises(InputError, match='unknown option "--qui"'):
        options.parse_args(["--qui"])


def test_a_missing_argument_points_to_the_help(options):
    options.add_argument("loops", nargs="+")
    with pytest.raises(InputError, match=r"required: loops\. See pull-strip --help\."):
        options.parse_args([])


def test_output_has_its_default_and_the_rest_is_off(options):
    given = options.parse_args([])
    assert (given.output.name, given.json, given.quiet) == ("strip.csv", None, False)


def test_a_command_without_a_default_output_has_none():
    assert command.parser("pull-strip", "Pull a strip.", output="table").parse_args([]).output is None


@pytest.mark.parametrize("status", [command.DONE, command.VERDICT_BAD])
def test_the_status_of_the_work_is_the_status_of_the_command(status):
    assert command.run("pull-strip", lambda arguments: status, []) == status


def test_arguments_reach_the_work_and_default_to_those_of_the_process(monkeypatch):
    monkeypatch.setattr("sys.argv", ["pull-strip", "a.csv"])
    seen = []
    command.run("pull-strip", lambda arguments: seen.append(list(arguments)) or 0)
    command.run("pull-strip", lambda arguments: seen.append(list(arguments)) or 0, ["b.csv"])
    assert seen == [["a.csv"], ["b.csv"]]


def test_unusable_input_is_one_sentence_on_standard_error_and_status_2(capsys):
    def work(arguments):
        raise InputError("loop.csv: no such file.")

    assert command.run("pull-strip", work, []) == command.UNUSABLE == 2
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "pull-strip: error: loop.csv: no such file.\n")


def test_stopping_by_hand_is_no_traceback(capsys):
    def work(arguments):
        raise KeyboardInterrupt

    assert command.run("pull-strip", work, []) == 130
    assert "Traceback" not in capsys.readouterr().err


def test_a_fault_of_the_program_is_one_sentence_a_file_and_a_status_of_its_own(tmp_path, monkeypatch, capsys):
    def work(arguments):
        return 1 // len(arguments[1:])

    monkeypatch.chdir(tmp_path)
    assert command.run("pull-strip", work, ["a.csv"]) == 70
    (kept,) = tmp_path.iterdir()
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "ZeroDivisionError" in said
    assert f"Please report it with the file {kept.name}." in said
    text = kept.read_text()
    assert "command   pull-strip a.csv" in text
    assert "numpy " in text
    assert "1 // len(arguments[1:])" in text


def test_a_fault_in_a_folder_that_cannot_be_written_leaves_its_file_among_the_temporary_ones(tmp_path, monkeypatch, capsys):
    from measure.common import fault

    (tmp_path / "away").mkdir()
    monkeypatch.chdir(tmp_path / "away")
    (tmp_path / "away").rmdir()
    monkeypatch.setattr(fault.tempfile, "gettempdir", lambda: str(tmp_path))
    assert command.run("pull-strip", lambda arguments: [].index(1), []) == 70
    (kept,) = tmp_path.iterdir()
    assert str(kept) in capsys.readouterr().err


def test_the_version_is_that_of_the_installed_distribution(options, capsys):
    from importlib import metadata

    with pytest.raises(SystemExit) as end:
        options.parse_args(["--version"])
    assert not end.value.code
    assert capsys.readouterr().out == f"pull-strip {metadata.version('unspool')}\n"


def test_what_the_system_refuses_is_a_sentence_too(tmp_path, capsys):
    def work(arguments):
        return len((tmp_path / "away" / "loop.csv").read_text())

    assert command.run("pull-strip", work, []) == command.UNUSABLE
    said = capsys.readouterr().err
    assert said.startswith(f"pull-strip: error: {tmp_path / 'away' / 'loop.csv'}: No such file or directory. Check")


def test_a_full_disk_is_a_sentence_too(capsys):
    def work(arguments):
        raise OSError(errno.ENOSPC, "No space left on device")

    assert command.run("pull-strip", work, []) == command.UNUSABLE
    assert capsys.readouterr().err == "pull-strip: error: No space left on device.\n"


PRINTS = """
from measure.common.command_line import VERDICT_BAD, run

def work(arguments):
    print("line\\n" * {lines})
    return VERDICT_BAD

raise SystemExit(run("pull-strip", work, []))
"""


@pytest.mark.parametrize(("lines", "status"), [(1, command.VERDICT_BAD), (100_000, command.DONE)])
def test_a_reader_who_leaves_early_as_head_does_hears_no_complaint(lines, status):
    words, buffered = [sys.executable, "-c", PRINTS.format(lines=lines)], {**os.environ, "PYTHONUNBUFFERED": ""}
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=buffered)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait() == status


def test_progress_passes_every_item_and_writes_nothing_where_nobody_looks(capsys):
    assert list(command.progress(range(5), what="loops")) == [0, 1, 2, 3, 4]
    assert list(command.progress(iter("ab"), what="loops", total=2, quiet=True)) == ["a", "b"]
    said = capsys.readouterr()
    assert said.out == said.err == ""


def test_a_missing_file_is_answered_with_its_neighbour_of_nearly_the_same_name(tmp_path):
    (tmp_path / "loop_1Hz.csv").write_text("")
    with pytest.raises(InputError, match=r'no such file; a loop was expected\. Did you mean "loop_1Hz\.csv"\?'):
        existing_file(tmp_path / "loop_1hz.csv", what="a loop")


@pytest.mark.parametrize("name", ["banana", "no/such/folder/loop.csv"])
def test_a_missing_file_without_such_a_neighbour_is_answered_all_the_same(tmp_path, name):
    with pytest.raises(InputError, match=r"no such file; a loop was expected\. Check the name\."):
        existing_file(tmp_path / name, what="a loop")


def test_a_folder_is_not_a_file(tmp_path):
    with pytest.raises(InputError, match="is a folder, and a loop was expected"):
        existing_file(tmp_path, what="a loop")


def test_a_file_that_is_there_is_given_back(tmp_path):
    (tmp_path / "a.csv").write_text("")
    assert existing_file(tmp_path / "a.csv", what="a loop") == tmp_path / "a.csv"


@pytest.mark.parametrize("threads", ["0", "-3", "x", "1.5", "", "99999999999999999999", "٣"])
def test_a_number_of_threads_that_is_none_is_a_sentence(monkeypatch, capsys, threads):
    monkeypatch.setenv("NUMBA_NUM_THREADS", threads)
    assert command.run("pull-strip", lambda arguments: 0, []) == command.UNUSABLE
    assert "NUMBA_NUM_THREADS" in capsys.readouterr().err


def test_settings_of_libraries_that_would_end_the_run_are_put_right(monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "nonsense")
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
    assert command.run("pull-strip", lambda arguments: 0, []) == command.DONE
    assert os.environ["MPLBACKEND"] == "Agg"
    assert "NUMBA_DISABLE_JIT" not in os.environ


SAYS = """
import sys
from measure.common.command_line import VERDICT_BAD, run, say

def work(arguments):
    open(sys.argv[1], "w").write("the result")
    say("a line")
    return VERDICT_BAD

raise SystemExit(run("pull-strip", work, []))
"""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("streams", [">&-", ">&- 2>&-", "<&- >&- 2>&-", "> /dev/full", "2> /dev/full", "> /dev/full 2> /dev/full"])
def test_a_closed_or_full_standard_output_changes_no_result_and_no_status(tmp_path, streams):
    (tmp_path / "says.py").write_text(SAYS)
    words = f'"{sys.executable}" "{tmp_path / "says.py"}" "{tmp_path / "result"}" {streams}'
    ended = subprocess.run(["sh", "-c", words], capture_output=True, check=False, env={**os.environ, "PYTHONUNBUFFERED": ""})
    assert ended.returncode == command.VERDICT_BAD
    assert (tmp_path / "result").read_text() == "the result"
    assert b"Traceback" not in ended.stderr
    assert len(ended.stderr.splitlines()) <= 1


def test_what_a_name_holds_for_the_terminal_is_printed_escaped(capsys):
    def work(arguments):
        command.say("written to \x1b[2Jgone.csv", "and \udcff.csv")
        raise InputError("\x1b[31mred.csv: no such file.")

    command.run("pull-strip", work, [])
    shown = capsys.readouterr()
    assert shown.out == "written to \\x1b[2Jgone.csv\nand \\xff.csv\n"
    assert "\x1b" not in shown.err


def test_a_process_that_is_ended_from_outside_tidies_up_and_says_so(tmp_path):
    waits = (
        "import sys, time\nfrom pathlib import Path\nfrom measure.common.command_line import run\n"
        "from measure.common.output import replacing\n\ndef work(arguments):\n    with replacing(Path(sys.argv[1])) as temporary:\n"
        "        print('ready', flush=True)\n        time.sleep(60)\n\nraise SystemExit(run('pull-strip', work, []))\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", waits, str(tmp_path / "a.csv")], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.readline()
        process.terminate()
        assert b"ended from outside; nothing was written" in process.stderr.read()
    assert process.returncode == 143
    assert not list(tmp_path.iterdir())
