"""All that a command writes is checked together before any work, and appears together or not at all."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from measure.common import output
from measure.common.errors import InputError
from measure.common.output import replacing, write_text
from measure.common.output_gate import Outputs


def tree(folder):
    """Every file of a folder with its content."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def refused(outputs, words):
    with pytest.raises(InputError, match=words), outputs.held():
        raise AssertionError("let through")


@pytest.fixture
def loop(tmp_path):
    path = tmp_path / "loop.csv"
    path.write_text("a measurement")
    return path


def alias_of(path, how):
    """Another name of the same file."""
    other = path.with_name("alias.csv")
    if how == "hard link":
        os.link(path, other)
    elif how == "link":
        other.symlink_to(path.name)
    elif how == "link to a link":
        path.with_name("between.csv").symlink_to(path)
        other.symlink_to("between.csv")
    elif how == "link to its folder":
        path.with_name("there").symlink_to(path.parent)
        return path.with_name("there") / path.name
    elif how == "roundabout":
        path.with_name("sub").mkdir()
        return path.parent / "sub" / ".." / path.name
    else:
        return Path(os.path.relpath(path))
    return other


@pytest.mark.parametrize("how", ["hard link", "link", "link to a link", "link to its folder", "roundabout", "relative"])
@pytest.mark.parametrize("turned", [False, True])
def test_an_input_is_never_written_whatever_it_is_called(loop, how, turned):
    other = alias_of(loop, how)
    written, read = (loop, other) if turned else (other, loop)
    refused(Outputs({"--output": written}, {}, [read]), "is an input")
    assert loop.read_text() == "a measurement"


def test_an_input_inside_a_folder_that_is_written_is_found_too(loop):
    refused(Outputs({}, {"--output": (loop.parent, ["result.json", "loop.csv"])}, [loop]), "is an input")


@pytest.mark.parametrize("name", ["mine.csv", "deeper/mine.csv", "."])
def test_nothing_is_written_into_a_folder_that_is_an_input(tmp_path, name):
    (tmp_path / "frames" / "deeper").mkdir(parents=True)
    where = tmp_path / "frames" / name
    outputs = (
        Outputs({}, {"--output": (where, [])}, [tmp_path / "frames"]) if name == "." else Outputs({"-o": where}, {}, [tmp_path / "frames"])
    )
    refused(outputs, "a folder that is an input")


def test_writing_through_a_link_that_leads_elsewhere_is_allowed(tmp_path, loop):
    (tmp_path / "real.csv").write_text("old")
    (tmp_path / "latest.csv").symlink_to("real.csv")
    outputs = Outputs({"--output": tmp_path / "latest.csv"}, {}, [loop])
    with outputs.held(), outputs.together():
        write_text(tmp_path / "latest.csv", "new")
    assert (tmp_path / "real.csv").read_text() == "new"


def test_everything_that_is_wrong_is_said_at_once(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("")
    (tmp_path / "round").symlink_to("round")
    files = {
        "-o": tmp_path / "folder",
        "--json": tmp_path / "no" / "r.json",
        "--figure": tmp_path / "round",
        "--legs": tmp_path / ("x" * 300),
    }
    with pytest.raises(InputError) as refusal, Outputs(files, {"--pictures": (tmp_path / "file", ["a.png"])}).held():
        pass
    said = str(refusal.value).splitlines()
    assert len(said) >= 5
    for words in ("is a folder", "no does not exist", "circle", "too long", "is a file, and a folder"):
        assert any(words in line for line in said), words


@pytest.mark.parametrize(("first", "second"), [("a.csv", "a.csv"), ("a.csv", "sub/../a.csv"), ("a.csv", "alias/a.csv")])
def test_two_outputs_have_two_names(tmp_path, first, second):
    (tmp_path / "sub").mkdir()
    (tmp_path / "alias").symlink_to(tmp_path)
    refused(Outputs({"--output": tmp_path / first, "--json": tmp_path / second}), "what both --output and --json write")


def test_a_file_may_not_take_the_name_of_one_in_a_folder_that_is_written(tmp_path):
    refused(Outputs({"--json": tmp_path / "out" / "result.json"}, {"--output": (tmp_path / "out", ["result.json"])}), "what both")


def test_a_file_may_stand_in_a_folder_that_is_made_for_the_others(tmp_path):
    outputs = Outputs({"--json": tmp_path / "out" / "mine.json"}, {"--output": (tmp_path / "out", ["result.json"])})
    with outputs.held(), outputs.together():
        write_text(tmp_path / "out" / "mine.json", "{}")
    assert tree(tmp_path) == {"out/mine.json": b"{}"}


def test_a_folder_of_the_system_that_takes_nothing_is_found_before_the_work(tmp_path):
    if not Path("/proc/self").exists():
        pytest.skip("no such folder on this system")
    refused(Outputs({"--output": Path("/proc/self/x.csv")}), "device|nothing can be written")


def write_all(outputs, paths, error=None):
    """What a command does: write everything in one go, and perhaps break down at the end of it."""
    with outputs.held(), outputs.together():
        for path in paths:
            write_text(path, "new")
        if error:
            raise error


def fail_at(monkeypatch, which):
    """Let the n-th renaming fail as on a full disk; those that put back old content work."""
    real, count = os.replace, iter(range(1000))

    def replace(source, target):
        if next(count) == which:
            raise OSError(28, "No space left on device", str(source), None, str(target))
        real(source, target)

    monkeypatch.setattr(output.os, "replace", replace)


@pytest.mark.parametrize("which", [0, 1, 2, 3])
def test_where_one_of_several_files_cannot_take_its_place_all_is_as_before(tmp_path, monkeypatch, which):
    (tmp_path / "a.csv").write_text("old a")
    (tmp_path / "c.csv").write_text("old c")
    before = tree(tmp_path)
    outputs = Outputs({f"--{name}": tmp_path / f"{name}.csv" for name in "abc"}, {"--folder": (tmp_path / "made", ["d.csv"])})
    fail_at(monkeypatch, which)
    with pytest.raises(InputError, match="No space left"):
        write_all(outputs, [*(tmp_path / f"{name}.csv" for name in "abc"), tmp_path / "made" / "d.csv"])
    assert tree(tmp_path) == before
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt, InputError])
def test_where_the_work_ends_badly_nothing_has_been_written(tmp_path, error):
    (tmp_path / "a.csv").write_text("old")
    outputs = Outputs({"--output": tmp_path / "a.csv"}, {"--folder": (tmp_path / "made", ["d.csv"])})
    with pytest.raises(error):
        write_all(outputs, [tmp_path / "a.csv", tmp_path / "made" / "d.csv"], error)
    assert tree(tmp_path) == {"a.csv": b"old"}
    assert sorted(tmp_path.iterdir()) == [tmp_path / "a.csv"]


def test_a_full_disk_while_writing_is_a_sentence_that_names_the_file(tmp_path):
    with pytest.raises(InputError, match=r"a\.csv: cannot be written \(No space left on device\)"), replacing(tmp_path / "a.csv"):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())


def test_two_runs_to_one_output_are_kept_apart(tmp_path):
    (tmp_path / "alias").symlink_to(tmp_path)
    with Outputs({"--output": tmp_path / "a.csv"}).held():
        refused(Outputs({"--json": tmp_path / "alias" / "a.csv"}), "another run is writing it")
        with Outputs({"--output": tmp_path / "b.csv"}).held():
            pass
    with Outputs({"--output": tmp_path / "a.csv"}).held():
        pass


KILLED = """
import os, sys
from pathlib import Path
from measure.common.output import replacing
from measure.common.output_gate import Outputs

outputs = Outputs({"--output": Path(sys.argv[1])})
with outputs.held(), outputs.together(), replacing(Path(sys.argv[1])) as temporary:
    temporary.write_text("half")
    os.kill(os.getpid(), 9)
"""


def test_what_a_killed_run_left_is_removed_by_the_next_one_and_nothing_else(tmp_path):
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path / "a.csv")], check=False)
    assert [path.name[:9] for path in tmp_path.iterdir()] == [".unspool-"]
    for name in (".unspool", ".a-1234.csv", "a.csv.part", ".unspool-notes.csv"):
        (tmp_path / name).write_text("the user's")
    outputs = Outputs({"--output": tmp_path / "a.csv"})
    with outputs.held(), outputs.together():
        write_text(tmp_path / "a.csv", "whole")
    assert sorted(tree(tmp_path)) == [".a-1234.csv", ".unspool", ".unspool-notes.csv", "a.csv", "a.csv.part"]


def odd_path(chance, folder):
    """A path as somebody may name it: a file, a folder, a link of some kind, a name that is too long or has odd letters."""
    name = chance.choice(
        ["in.csv", "free", "sub", "loop", "hard.csv", "soft.csv", "a\x1b[2Jb", "é" * 80, "x" * 300, "", "..", "pipe", "no/way"]
    )
    return folder / chance.choice(["", "sub", "link", "sub/.."]) / name


@pytest.mark.parametrize("seed", range(60))
def test_drawn_paths_end_in_a_sentence_or_in_whole_files_and_never_in_a_lost_input(tmp_path, seed):
    chance = random.Random(seed)
    (tmp_path / "sub").mkdir()
    (tmp_path / "in.csv").write_text("the measurement")
    os.link(tmp_path / "in.csv", tmp_path / "sub" / "hard.csv")
    (tmp_path / "soft.csv").symlink_to("in.csv")
    (tmp_path / "loop").symlink_to("loop")
    (tmp_path / "link").symlink_to("sub")
    os.mkfifo(tmp_path / "sub" / "pipe")
    before = {**tree(tmp_path)}
    files = {"-o": odd_path(chance, tmp_path), "--json": odd_path(chance, tmp_path)}
    folders = {"--pictures": (odd_path(chance, tmp_path), ["in.csv", "b.png"])}
    outputs = Outputs(files, folders, [tmp_path / "in.csv"])
    try:
        with outputs.held(), outputs.together():
            for path in (*files.values(), folders["--pictures"][0] / "in.csv", folders["--pictures"][0] / "b.png"):
                write_text(path, "a result")
    except InputError:
        assert tree(tmp_path) == before
    assert (tmp_path / "in.csv").read_text() == "the measurement"


def test_a_write_protected_file_is_said_to_be(tmp_path, monkeypatch):
    (tmp_path / "a.csv").write_text("old")
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK)  # the superuser may write everything
    refused(Outputs({"--output": tmp_path / "a.csv"}), "is write-protected")


def test_a_folder_that_takes_nothing_is_found_before_the_work(tmp_path, monkeypatch):
    def denied(**given):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("tempfile.TemporaryFile", denied)
    refused(Outputs({"--output": tmp_path / "a.csv"}), r"nothing can be written there \(Read-only file system\)")


def test_a_signal_while_results_take_their_names_waits_until_all_have_theirs(tmp_path, monkeypatch):
    real = os.replace

    def replace(source, target):
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.005)  # until some thread has taken it
        real(source, target)

    monkeypatch.setattr(output.os, "replace", replace)
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    with pytest.raises(KeyboardInterrupt):
        write_all(Outputs({"--output": paths[0], "--json": paths[1]}), paths)
    assert tree(tmp_path) == {"a.csv": b"new", "b.csv": b"new"}


def test_it_waits_likewise_where_other_threads_take_the_signal(tmp_path, monkeypatch):
    """Kernels and test processes have further threads; a signal to the process comes to any of them."""
    ended = threading.Event()
    others = [threading.Thread(target=ended.wait) for _ in range(4)]
    for other in others:
        other.start()
    try:
        for number in range(20):
            (tmp_path / str(number)).mkdir()
            with monkeypatch.context() as patched:
                test_a_signal_while_results_take_their_names_waits_until_all_have_theirs(tmp_path / str(number), patched)
    finally:
        ended.set()
        for other in others:
            other.join()


def test_results_are_written_from_a_thread_of_a_user_too(tmp_path):
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    own = threading.Thread(target=lambda: write_all(Outputs({"--output": paths[0], "--json": paths[1]}), paths))
    own.start()
    own.join()
    assert tree(tmp_path) == {"a.csv": b"new", "b.csv": b"new"}
