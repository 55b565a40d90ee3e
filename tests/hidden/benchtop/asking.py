"""Asks about the cases of a bench board for as long as there is time."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import numba
from board.running import OURS, Answer, ask_all, read_answers, version

from .cases import Spec
from .making import made
from .scoring import Scored, scored

PATIENCE_S = 300.0  # of processor time
MINUTES = 60.0


def answered(specs: Sequence[Spec], folder: Path) -> list[Scored]:
    """Those that the present sources have answered, scored."""
    have = _have(folder)
    done = [spec for spec in specs if spec.token in have]
    return scored(done, [have[spec.token] for spec in done], folder)


def ask(
    specs: Sequence[Spec],
    folder: Path,
    *,
    processes: int = 2,
    patience_s: float = PATIENCE_S,
    minutes: float = MINUTES,
    say: Callable[[str], None] = lambda text: None,
) -> list[Scored]:
    """Ask about one case after the other until the time is over, and score those that were answered. Mixed, they are a fair sample."""
    until = time.monotonic() + 60.0 * minutes
    with _processes(processes) as apart:
        makers = {spec.token: partial(_made_apart, apart, spec, folder) for spec in specs}
        ask_all(makers, OURS, _file(folder), processes=processes, patience_s=patience_s, say=say, until=until)
    rows = answered(specs, folder)
    if len(rows) < len(specs):
        say(f"the time is over: {len(rows)} of {len(specs)} cases")
    return rows


def _made_apart(apart: ProcessPoolExecutor, spec: Spec, folder: Path) -> Path:
    return apart.submit(made, spec, folder).result()


def _processes(n: int) -> ProcessPoolExecutor:
    """Where cases are made side by side: new processes, each with a single thread, that share nothing with this one."""
    return ProcessPoolExecutor(n, mp_context=get_context("spawn"), initializer=numba.set_num_threads, initargs=(1,))


def _file(folder: Path) -> Path:
    return folder / f"{OURS}.jsonl"


def _have(folder: Path) -> dict[str, Answer]:
    return {answer.token: answer for answer in read_answers(_file(folder)) if answer.version == version()}
