"""Runs a method over cases, each in a process of its own that is given a copy of the case's folder and nothing else.

Answers are appended as JSON lines, so that a run that was interrupted goes on where it stopped. An answer counts for the sources that
gave it: where these have changed the case is asked again.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from .making import made
from .specs import Spec

HERE = Path(__file__).resolve().parents[1]
ROOT = HERE.parents[1]
OURS = "explain-gap"
PATIENCE_S = 900.0  # of processor time
# A rival is a module beside this folder that takes the same words as the command.
METHODS = {
    OURS: "identify.commands.explain_gap",
    "lowest-error": "rivals.lowest_error",
    "forward-bic": "rivals.forward_bic",
    "sparse-regression": "rivals.sparse_regression",
    "gaussian-process": "rivals.gaussian_process",
}
_KEPT = ("verdict", "weights", "effects", "gap", "drafted", "left", "next_experiment", "next_experiments", "missing_force", "sentence")
# The limit is processor time, so that an answer does not depend on what else the machine does; what was used is left in a file.
_CALL = """
import resource, sys
resource.setrlimit(resource.RLIMIT_CPU, ({limit}, {limit} + 5))
from {module} import main
try:
    raise SystemExit(main(sys.argv[1:]))
finally:
    used = resource.getrusage(resource.RUSAGE_SELF)
    open("processor_s", "w").write(str(used.ru_utime + used.ru_stime))
"""
_CALM = {"OMP_WAIT_POLICY": "passive", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
Say = Callable[[str], None]


@dataclass(frozen=True)
class Answer:
    """What a method said to a case. status : of its process; 0 or 1 with an answer, anything else is a failure."""

    token: str
    method: str
    version: str
    status: int
    processor_s: float
    result: dict[str, Any]

    @property
    def failed(self) -> bool:
        """Whether there is no answer."""
        return self.status not in (0, 1) or "verdict" not in self.result


@cache
def version(method: str = OURS) -> str:
    """A short hash of the sources that answer."""
    rooms = [ROOT / room for room in ("measure", "simulate", "identify")] + ([] if method == OURS else [HERE / "rivals"])
    files = [path for room in rooms for path in sorted(room.rglob("*.py"))]
    digest = hashlib.sha256()
    for path in files:
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def asked(method: str, folder: Path, patience_s: float) -> tuple[int, float, dict[str, Any]]:
    """Ask a method about a case: status, processor time and what it said. patience_s : of processor time, from which it is ended."""
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place) / "case"
        shutil.copytree(folder, copy)
        call = _CALL.format(module=METHODS[method], limit=round(patience_s))
        command = [sys.executable, "-c", call, "model.toml", "campaign.toml", "-o", "out", "--quiet"]
        paths = os.pathsep.join([str(ROOT), str(HERE)])
        ran = subprocess.run(
            command, cwd=copy, env={**os.environ, **_CALM, "PYTHONPATH": paths}, capture_output=True, text=True, check=False
        )
        if ran.returncode == -signal.SIGXCPU:
            return 124, patience_s, {"error": f"no answer after {patience_s:g} s of processor time"}
        used = copy / "processor_s"
        spent = float(used.read_text(encoding="utf-8")) if used.exists() else 0.0
        file = copy / "out" / "result.json"
        if ran.returncode not in (0, 1) or not file.exists():
            return ran.returncode or 2, spent, {"error": ran.stderr[-2000:]}
        result = json.loads(file.read_text(encoding="utf-8"))
        return ran.returncode, spent, {key: result[key] for key in _KEPT if key in result}


def read_answers(file: Path) -> list[Answer]:
    """All answers of a file; a last line that was cut off is left out, and what was written in another form."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    found = [json.loads(line) for line in lines if line.endswith("}")]
    return [Answer(**one) for one in found if "processor_s" in one]


def tokens_answered(method: str, folder: Path) -> set[str]:
    """Of the cases that the present sources have answered."""
    return {answer.token for answer in read_answers(folder / f"{method}.jsonl") if answer.version == version(method)}


def run(specs: Sequence[Spec], method: str, folder: Path, **how: Any) -> list[Answer]:
    """The answers of a method to these cases, made where they are not there yet. how : as for `ask_all`."""
    makers = {spec.token: partial(made, spec, folder) for spec in specs}
    have = ask_all(in_turn(makers), method, folder / f"{method}.jsonl", **how)
    return [have[spec.token] for spec in specs]


def in_turn(makers: Mapping[str, Callable[[], Path]]) -> dict[str, Callable[[], Path]]:
    """Makers of which one works at a time: a simulation of many uses all cores, and only one such can run in a process."""
    lock = threading.Lock()

    def alone(maker: Callable[[], Path]) -> Path:
        with lock:
            return maker()

    return {token: partial(alone, maker) for token, maker in makers.items()}


def ask_all(
    makers: Mapping[str, Callable[[], Path]],
    method: str,
    file: Path,
    *,
    processes: int = 2,
    patience_s: float = PATIENCE_S,
    say: Say = lambda text: None,
    until: float = math.inf,
) -> dict[str, Answer]:
    """Ask about each case that has no answer by the same sources in the file yet.

    makers : give the folder of a case, by its token, several at a time; until : of the monotonic clock, no case is begun later.
    """
    have = {answer.token: answer for answer in read_answers(file) if answer.version == version(method)}
    lock = threading.Lock()

    def one(token: str) -> None:
        if time.monotonic() > until:
            return
        case = makers[token]()
        said = asked(method, case, patience_s)
        if said[0] < 0:  # ended from outside, by a signal; that is no answer, but twice is a crash
            said = asked(method, case, patience_s)
        answer = Answer(token, method, version(method), *said)
        with lock:
            _append(file, answer)
            have[token] = answer
            say(f"{len(have):4d}  {token}  {method}  {answer.processor_s:6.1f} s  {answer.result.get('verdict', 'FAILED')}")

    with ThreadPoolExecutor(processes) as pool:
        for _ in pool.map(one, [token for token in makers if token not in have]):
            pass
    return have


def _append(file: Path, answer: Answer) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("a", encoding="utf-8") as stream:
        stream.write(json.dumps(answer.__dict__) + "\n")
