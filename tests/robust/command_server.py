"""Runs commands one after the other, each in a process of its own that begins with everything imported: a try takes a fraction of a second.

The server imports the commands and loads the kernels once, and forks for each try. The child gets a folder, an environment, limits
of processor time and, where asked, a fault: what goes wrong at its n-th act of writing. Nothing that a command does to itself
reaches the next one. Client and server speak in lines of JSON.
"""

from __future__ import annotations

import contextlib
import json
import os
import resource
import select
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
MAINS = {
    "track-video": "measure.commands.track_video",
    "fit-actuator": "identify.commands.fit_actuator",
    "simulate-deployment": "simulate.commands.simulate_deployment",
    "sweep-deployments": "simulate.commands.sweep_deployments",
    "design-control": "simulate.commands.design_control",
    "design-deployment": "simulate.commands.design_deployment",
    "compare-model": "identify.commands.compare_model",
    "explain-gap": "identify.commands.explain_gap",
    "unspool": "identify.commands.unspool",
}
LOADED = ("cv2", "av", "lmfit", "matplotlib.pyplot", "scipy.optimize", "scipy.io", "jinja2", "h5py", "nptdms")
PATIENCE_S = 40  # of processor time
STUCK_S = 60  # in which no process of a command can be run: it waits for something
WRITING = ("os.rename", "os.link", "os.mkdir", "os.chmod", "os.truncate")
REMOVING = ("os.remove", "os.rmdir")


@dataclass(frozen=True)
class Ended:
    """How a command ended: status (its own; 124 no end, negative a signal), what it said, processor time, and memory that it took.

    What is loaded already when it begins is not counted as its memory.
    """

    status: int
    out: str
    error: str
    processor_s: float
    memory_mb: float
    events: list[str] = field(default_factory=list)


class CommandServer:
    """The client's side; start it once for many tries."""

    def __init__(self, prepared: str = "") -> None:
        self.process = subprocess.Popen(
            [sys.executable, __file__, prepared],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={
                **os.environ,
                "PYTHONPATH": os.pathsep.join([str(ROOT), str(Path(__file__).parent)]),
                "NUMBA_NUM_THREADS": "1",
                "NUMBA_THREADING_LAYER": "workqueue",  # the one that stands a fork
                "OPENBLAS_NUM_THREADS": "1",
            },
        )

    def run(self, words: list[Any], folder: Path, **how: Any) -> Ended:
        """Run a command in a folder.

        how : `environment` (replaces variables), `fault` (see `Fault`), `kill_after_s` and `signal`, `patience_s`.
        """
        asked = {"words": [os.fsencode(str(word)).decode("latin-1") for word in words], "folder": str(folder), **how}
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(asked) + "\n")
        self.process.stdin.flush()
        return Ended(**json.loads(self.process.stdout.readline()))

    def close(self) -> None:
        """End the server. It is not waited for: what it has computed is not counted as the time of whichever test came last."""
        assert self.process.stdin is not None
        self.process.stdin.close()


@dataclass
class Fault:
    """What goes wrong when a command in this folder opens a file for writing, renames, links, makes a folder or flushes to the disk.

    at : the how-manieth of these acts goes wrong; none where it is negative, then they are only listed.
    how : "full" (no space left), "denied", "kill".
    """

    folder: str
    at: int
    how: str
    acts: list[str] = field(default_factory=list)

    def install(self) -> None:
        sync = os.fsync

        def flushed(handle: int) -> None:
            self.act("fsync", "")
            sync(handle)

        os.fsync = flushed  # type: ignore[assignment]
        sys.addaudithook(self.seen)

    def seen(self, event: str, given: tuple[Any, ...]) -> None:
        if event == "open":
            path, mode, flags = given
            if isinstance(path, int) or not self.inside(path):
                return
            if (isinstance(mode, str) and set(mode) & set("wax+")) or (flags or 0) & (os.O_WRONLY | os.O_RDWR):
                self.act("open", path)
        elif event in WRITING + REMOVING * (self.how == "kill") and self.inside(given[0]):
            self.act(event, given[0])

    def inside(self, path: Any) -> bool:
        return str(os.path.abspath(os.fsdecode(path))).startswith(self.folder)

    def act(self, kind: str, path: Any) -> None:
        self.acts.append(f"{kind} {os.path.basename(os.fsdecode(path))}")
        if len(self.acts) - 1 != self.at:
            return
        if self.how == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        code, text = (28, "No space left on device") if self.how == "full" else (13, "Permission denied")
        raise OSError(code, text, os.fsdecode(path) or None)


def served() -> None:
    """Answer until nobody asks any more."""
    for line in sys.stdin:
        print(json.dumps(tried(json.loads(line))), flush=True)


def tried(asked: dict[str, Any]) -> dict[str, Any]:
    """Run one command in a child."""
    pipes = [os.pipe() for _ in range(3)]  # standard output, standard error, acts of writing
    measured, begin = os.pipe()  # the child begins when its memory is known; a quick one would have ended before
    child = os.fork()
    if not child:
        with contextlib.suppress(BaseException):
            os.close(begin)
            os.read(measured, 1)
            os.close(measured)
            for k, (reading, writing) in enumerate(pipes[:2]):
                os.close(reading)
                os.dup2(writing, k + 1)
            os.close(pipes[2][0])
            become(asked, pipes[2][1])
        os._exit(70)
    pages = int(Path(f"/proc/{child}/statm").read_text(encoding="utf-8").split()[1])
    asked["at_start_mb"] = pages * resource.getpagesize() / 2**20
    os.close(measured)
    os.close(begin)
    for _, writing in pipes:
        os.close(writing)
    return waited_for(child, [reading for reading, _ in pipes], asked)


def waited_for(child: int, readings: list[int], asked: dict[str, Any]) -> dict[str, Any]:
    """Read what a child says until it has ended or has to be ended."""
    said = dict.fromkeys(readings, b"")
    open_ones, begun, idle, sent, stuck = list(readings), time.monotonic(), 0, "kill_after_s" not in asked, False
    while open_ones:
        left = asked.get("kill_after_s", 0.0) - (time.monotonic() - begun)
        if not sent and left <= 0.0:
            os.kill(child, asked["signal"])
            sent = True
        ready = select.select(open_ones, [], [], 1.0 if sent else max(0.0, min(left, 1.0)))[0]
        idle = 0 if ready or not sent or runnable(child) else idle + 1
        if idle > STUCK_S and not stuck:
            os.killpg(child, signal.SIGKILL)
            stuck = True
        for reading in ready:
            block = os.read(reading, 1 << 16)
            said[reading] += block
            if not block:
                open_ones.remove(reading)
    for reading in readings:
        os.close(reading)
    _, ended, used = os.wait4(child, 0)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    status = os.waitstatus_to_exitcode(ended)
    out, error, acts = (said[reading].decode("utf-8", "backslashreplace") for reading in readings)
    return {
        "status": 124 if stuck or status == -signal.SIGXCPU else status,
        "out": out,
        "error": error,
        "processor_s": used.ru_utime + used.ru_stime,
        "memory_mb": max(0.0, used.ru_maxrss / 1024 - asked["at_start_mb"]),
        "events": acts.splitlines(),
    }


def runnable(session: int) -> bool:
    """Whether some process of a session has work that it could do; a busy machine may keep it from doing it."""
    for file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError, IndexError):
            state, _, _, of_session = file.read_text(encoding="utf-8", errors="replace").rpartition(")")[2].split()[:4]
            if int(of_session) == session and state in "RD":
                return True
    return False


def become(asked: dict[str, Any], acts: int) -> None:
    """In the child: be the command."""
    os.setsid()
    patience = int(asked.get("patience_s", PATIENCE_S))
    resource.setrlimit(resource.RLIMIT_CPU, (patience, patience + 5))
    os.chdir(asked["folder"])
    os.environ.update(asked.get("environment", {}))
    time.tzset()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    words = [os.fsdecode(word.encode("latin-1")) for word in asked["words"]]
    sys.argv = words
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    sys.stdout = sys.__stdout__ = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = sys.__stderr__ = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    fault = Fault(**asked["fault"]) if "fault" in asked else None
    if fault is not None:
        fault.install()
    if "largest_file" in asked:
        resource.setrlimit(resource.RLIMIT_FSIZE, (asked["largest_file"], resource.RLIM_INFINITY))
    try:
        status = import_module(MAINS[words[0]]).main(words[1:])
    except SystemExit as end:
        status = int(end.code or 0)
    except BaseException:
        import traceback

        traceback.print_exc()
        status = 70
    if fault is not None:
        os.write(acts, "\n".join(fault.acts).encode("utf-8", "backslashreplace"))
    with contextlib.suppress(OSError, ValueError):
        sys.stdout.flush()
        sys.stderr.flush()
    os._exit(status)


def prepare(module: str) -> None:
    """Import what commands import, and let a module of the tests load the kernels and lay results ready."""
    for name in (*MAINS.values(), *LOADED):
        with contextlib.suppress(ImportError):
            import_module(name)
    import cv2

    cv2.setNumThreads(1)  # threads do not survive a fork
    if module:
        import_module(module).prepare()


if __name__ == "__main__":
    channel = os.dup(1)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(os.dup(1), "w")
    with tempfile.TemporaryDirectory() as place:
        os.chdir(place)
        prepare(sys.argv[1])
    sys.stdout = os.fdopen(channel, "w")
    served()
