"""A command that is killed at any time leaves the old results as they were and nothing half written; the next run tidies up.

What only SIGKILL may leave is a file under our own key and a lock that nobody holds; what a stopped sweep leaves is its pieces. The
next run goes on from there, takes it away, and gives the bytes of a run that nobody disturbed.
"""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter

import pytest
import tomli_w
from command_server import MAINS
from judging import tree
from odd_inputs import DEMO, ROOT, lay_out
from test_write_faults import COMMANDS as QUICK
from test_write_faults import lay_old

pytestmark = pytest.mark.xdist_group("commands")
COMMANDS = {
    "track-video": ["track-video", "film.avi", "--project", "film.toml", "-o", "out.csv", "--json", "out.json"],
    "fit-actuator": ["fit-actuator", "loop.csv", "-o", "out.toml", "--json", "out.json", "--figure", "out.png"],
    "simulate-deployment": ["simulate-deployment", "model.toml", "-o", "out.csv", "--page", "out.html"],
    "sweep-deployments": ["sweep-deployments", "model.toml", "--resume", "-o", "out", "--json", "out.json"],
    "compare-model": ["compare-model", "model.toml", "test.csv", "-o", "out.png", "--json", "out.json"],
    "explain-gap": ["explain-gap", "model.toml", "test.csv", "--budget", "quick", "-o", "out", "--json", "out.json"],
}
# That many explanations of the demonstration take an hour.
KILLED = {**COMMANDS, "explain-gap": [*("explain-gap", "small/model.toml", "small/test.csv"), *COMMANDS["explain-gap"][3:]]}
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
OURS = (b".unspool-", b".part", b".lock")  # what a killed run may leave for the next one
KILLS = 7  # by each signal, 21 of each command
TITLE = "Kills at any time"
NOTE = (
    "INT, TERM or KILL at a time drawn from the whole duration of a command, over old results. Only a KILL leaves a lock, which nobody "
    "holds, and half files under our own key; a stopped sweep leaves its pieces. After each kill that left something the next run (for a "
    "sweep with `--resume`) was to take it away and to give the bytes of an undisturbed run. `wrong` counts all that may not be."
)


@pytest.fixture
def demonstration(tmp_path):
    """A folder with the demonstration's data, and a run of a tenth of a second."""
    model = tomllib.loads((ROOT / "datasets" / "prototype.toml").read_text(encoding="utf-8"))
    for name, lasts in {"model.toml": 0.1, "rig.toml": 0.7}.items():
        model["simulation"] = {"duration_s": lasts, "sample_rate_Hz": 1000.0}
        (tmp_path / name).write_text(tomli_w.dumps(model))
    for name, source in {"film.avi": "film.avi", "film.toml": "film.toml", "test.csv": "deployment-2.csv"}.items():
        shutil.copy(DEMO / source, tmp_path / name)
    shutil.copy(sorted((DEMO / "loops").glob("*.csv"))[0], tmp_path / "loop.csv")
    return tmp_path


def started(folder, words):
    """The command as a user starts it, imports and all; a shell that runs the tests in the background has switched SIGINT off."""
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    begun = f"{heard}import sys; sys.argv[0] = {words[0]!r}; import measure.commands, os; os.write(1, b'.'); "
    code = f"{begun}from {MAINS[words[0]]} import main; sys.exit(main())"
    command = [sys.executable, "-c", code, *words[1:]]
    (folder / "temporary").mkdir(exist_ok=True)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "TMPDIR": str(folder / "temporary")}
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment)


def ended(folder, words):
    """Status of the command, nobody disturbing it."""
    process = started(folder, words)
    process.communicate()
    return process.returncode


DAMAGED = "results are neither the old nor the new ones"
STATUS = {signal.SIGINT: {0, 1, 130}, signal.SIGTERM: {0, 1, 143, -signal.SIGTERM}, signal.SIGKILL: {0, 1, -signal.SIGKILL}}


def hidden_in(left):
    """What stands there that is no result."""
    return {path for path in left if any(key in path for key in OURS)}


def left_wrong(left, old, whole, ending, status, said):
    """What a kill may not leave or say; one that comes late finds a command that has ended.

    old, whole : the folder before, and with the results of a run that nobody disturbed.
    """
    results = {path: content for path, content in left.items() if path not in hidden_in(left)}
    before = {path: content for path, content in old.items() if path not in hidden_in(old)}
    one_by_one = set(results) == set(whole) and all(results[path] in (before[path], whole[path]) for path in whole)
    wrong = [DAMAGED] * (results not in (before, whole) and not (ending == signal.SIGKILL and one_by_one))
    fresh = sorted(path for path in hidden_in(left) - hidden_in(old) if OURS[1] not in path)
    wrong += [f"left over: {fresh}"] * bool(fresh and ending != signal.SIGKILL)
    wrong += [f"status {status}"] * (status not in STATUS[ending])
    sentences = status == 130 and said.strip().splitlines()
    return wrong + [f"said: {said[-500:]!r}"] * ("Traceback" in said or (bool(sentences) and "stopped" not in sentences[-1]))


class Kills:
    """Kills of one command in one folder, with what was wrong after each."""

    def __init__(self, folder, words):
        self.folder, self.words, self.before = folder, words, tree(folder)
        begun = time.monotonic()
        assert ended(folder, words) in (0, 1)
        self.lasts, self.whole, self.wrong = time.monotonic() - begun, tree(folder), []
        self.results = {
            path: content for path, content in self.whole.items() if path not in self.before and not path.startswith(b"temporary")
        }
        self.counted = Counter()

    def kill(self, after_s, ending):
        """Kill a run over old results; where it leaves something, let the next one end."""
        lay_old(self.folder, self.results)
        old = tree(self.folder)
        begun, process = time.monotonic(), started(self.folder, self.words)
        assert process.stdout is not None
        process.stdout.read(1)  # its first line is reached
        time.sleep(after_s)
        process.send_signal(ending)
        said = process.communicate()[1].decode("utf-8", "replace")
        if process.returncode in (0, 1):
            self.lasts = min(self.lasts, time.monotonic() - begun)  # the first run loads and compiles more
        left = tree(self.folder)
        wrong = left_wrong(left, old, self.whole, ending, process.returncode, said)
        counts = {"kills": 1, "ended before": process.returncode in (0, 1), "old results damaged": DAMAGED in wrong, "wrong": len(wrong)}
        self.counted.update({**counts, "left for the next run": bool(hidden_in(left))})
        self.wrong += [f"{ending.name} after {after_s:.2f} s of {self.lasts:.2f} s: {text}" for text in wrong]
        if hidden_in(left):
            self.go_on(f"after {ending.name}")

    def go_on(self, when):
        """A run that nobody disturbs; it is to leave what the first one has left."""
        status = ended(self.folder, self.words)
        same = status in (0, 1) and tree(self.folder) == self.whole
        self.counted["other bytes by the next run"] += not same
        self.wrong += [f"the next run {when}: status {status}, other bytes or files"] * (not same)

    def row(self, name, ending):
        """For the table of the validation."""
        names = ("kills", "ended before", "old results damaged", "wrong", "left for the next run", "other bytes by the next run")
        return {"command": name, "signal": ending.name, **{key: int(self.counted[key]) for key in names}}


@pytest.mark.calibrate
@pytest.mark.parametrize("name", sorted(KILLED))
@pytest.mark.parametrize("ending", SIGNALS, ids=lambda ending: ending.name)
def test_kills_leave_the_old_results_whole_and_the_next_run_gives_the_same(
    demonstration, name, ending, share_of, calibration_seed, validation_table
):
    chance = random.Random(f"{calibration_seed} {name} {ending.name}")
    (demonstration / "small").mkdir()
    lay_out(demonstration / "small")
    kills = Kills(demonstration, KILLED[name])
    for _ in range(share_of(KILLS)):
        kills.kill(chance.uniform(0.0, 1.05 * kills.lasts), ending)
    kills.go_on("at the end")
    validation_table(TITLE, [kills.row(name, ending)], NOTE)
    assert not kills.wrong, "\n".join(kills.wrong)


@pytest.mark.parametrize(("name", "ending"), [*zip(sorted(set(QUICK) - {"unspool init", "unspool run"}), SIGNALS * 3, strict=False)])
def test_a_kill_leaves_the_old_results_whole_and_the_next_run_gives_the_same(commands, bench, name, ending):
    chance, before = random.Random(name), tree(bench)
    begun = time.monotonic()
    assert commands.run(QUICK[name], bench).status in (0, 1)
    lasts = time.monotonic() - begun
    whole = tree(bench)
    lay_old(bench, {path: content for path, content in whole.items() if path not in before})
    old = tree(bench)
    killed = commands.run(QUICK[name], bench, kill_after_s=chance.uniform(0.0, lasts), signal=int(ending))
    wrong = left_wrong(tree(bench), old, whole, ending, killed.status, killed.error)
    assert commands.run(QUICK[name], bench).status in (0, 1)
    assert not wrong, "\n".join(wrong)
    assert tree(bench) == whole
