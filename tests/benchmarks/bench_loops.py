"""Loops, short and long.

Six loops of 2000 samples: read, fitted and reported; and the same fit with a general ODE solver, as one would write it.
The aims: under 2 s after start-up, and at least a hundred times faster than the plain fit in the same run.

One loop of a million samples: `numpy.loadtxt`, reading it as text in two dialects and as MATLAB and HDF5, and the whole command.
The aims: reading at most 5 times loadtxt and 6 times the file in memory, the command at most 60 times loadtxt.

OPENBLAS_NUM_THREADS=1 .venv/bin/python tests/benchmarks/bench_loops.py [six | long]
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.integrate import solve_ivp
from scipy.io import savemat
from scipy.optimize import least_squares

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.fit_actuator import fit_actuator
from identify.commands.fit_actuator import main as fit_command
from identify.loops.loop_data import LoopData
from identify.loops.prepare import prepare
from identify.report.loop_result import result_of, summary
from measure import Loop, read_loop, write_loop
from measure.readers.loop_file import read_loop_file
from simulate.law import force_rate
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
START = [-0.2, 2.7, -0.2, 3.0, 250.0]


def made(folder: Path) -> list[Path]:
    """Three frequencies, two strokes, three cycles each."""
    rng = np.random.default_rng(0)
    paths = []
    for frequency in (0.2, 1.0, 3.0):
        for amplitude in (0.05, 0.02):
            t = np.linspace(0.0, 3.0 / frequency, 20_000)
            u = 0.25 + amplitude * np.sin(2 * np.pi * frequency * t)
            force = loop_force(LINES, t, u, 0 * t, 0 * t, 2.8)[::10] + 2e-3 * rng.standard_normal(2000)
            paths.append(folder / f"{frequency}_{amplitude}.csv")
            write_loop(Loop(t[::10], u[::10], force), paths[-1])
    return paths


def whole(paths: Sequence[Path]) -> tuple[list[LoopData], ActuatorFit]:
    """From files to the lines that are printed."""
    loops = [prepare(read_loop_file(path)[0]) for path in paths]
    fit = fit_actuator(loops)
    summary(result_of(fit, loops))
    return loops, fit


def plain_fit(loops: Sequence[LoopData]) -> Any:
    """`solve_ivp` for every loop in every evaluation, start forces free, differences wide enough for the solver's tolerance."""

    def residual(p: np.ndarray) -> np.ndarray:
        parts = []
        for data, start in zip(loops, p[5:], strict=True):

            def rate(t: float, r: np.ndarray, data: LoopData = data) -> np.ndarray:
                u = np.interp(t, data.time_s, data.elongation_m)
                v = np.interp(t, data.time_s, data.speed_m_per_s)
                return force_rate(v, r, p[0] * u + p[1], p[2] * u + p[3], p[4])

            ends = (data.time_s[0], data.time_s[-1])
            solved = solve_ivp(rate, ends, [start], t_eval=data.time_s, rtol=1e-8, atol=1e-10, max_step=float(np.ptp(ends)) / 60)
            parts.append(data.force_N - solved.y[0])
        return np.concatenate(parts)

    first = np.array([*START, *(data.force_N[0] for data in loops)])
    return least_squares(residual, first, x_scale=np.abs(first), diff_step=1e-4, ftol=1e-6, max_nfev=30)


def timed(work: Callable[[], Any], repeats: int = 1) -> tuple[Any, float]:
    """The result and the shortest time, s."""
    taken, result = [], None
    for _ in range(repeats):
        begin = time.perf_counter()
        result = work()
        taken.append(time.perf_counter() - begin)
    return result, min(taken)


def six_loops() -> None:
    """Print the times, the ratio and both answers."""
    with tempfile.TemporaryDirectory() as folder:
        paths = made(Path(folder))
        whole(paths)
        (loops, fit), all_s = timed(lambda: whole(paths), 5)
    _, fit_s = timed(lambda: fit_actuator(loops), 5)
    plain, plain_s = timed(lambda: plain_fit(loops))
    print(f"read, fit and report six loops  {all_s:8.2f} s")
    print(f"the fit alone                   {fit_s:8.3f} s   {np.array2string(fit.lines, precision=4)}")
    print(f"the fit with solve_ivp          {plain_s:8.1f} s   {np.array2string(plain.x[:5], precision=4)}   {plain.nfev} steps")
    print(f"ratio                           {plain_s / fit_s:8.0f}")


def written_long(folder: Path, rows: int = 1_000_000) -> dict[str, Path]:
    """One loop of 1 Hz, a sample each millisecond, in five formats; and 3000 rows of it, on which the kernels are compiled."""
    rng = np.random.default_rng(0)
    t = np.arange(rows) * 1e-3
    u = 0.25 + 0.05 * np.sin(2 * np.pi * t)
    force = loop_force(LINES, t, u, 0 * t, 0 * t, 2.8) + 2e-3 * rng.standard_normal(rows)
    loop = Loop(t, u + 5e-6 * rng.standard_normal(rows), force)
    names = ("short.csv", "long.csv", "commas.csv", "long.mat", "long.h5")
    paths = {name: folder / name for name in names}
    write_loop(Loop(t[:3000], loop.elongation_m[:3000], force[:3000]), paths["short.csv"])
    write_loop(loop, paths["long.csv"])
    paths["commas.csv"].write_text(paths["long.csv"].read_text().replace(",", ";").replace(".", ","))
    columns = {"time_s": t, "elongation_m": loop.elongation_m, "force_N": force}
    savemat(paths["long.mat"], columns)
    with h5py.File(paths["long.h5"], "w") as file:
        for name, values in columns.items():
            file[name] = values
    return paths


def in_its_own_process(what: str, path: Path, short: Path) -> tuple[float, float]:
    """Processor time in s, and memory taken in MB, of one piece of work; see `piece`."""
    words = [sys.executable, __file__, "piece", what, str(path), str(short)]
    found = json.loads(subprocess.run(words, capture_output=True, text=True, check=True).stdout.splitlines()[-1])
    return found["s"], found["MB"]


def piece(what: str, path: Path, short: Path) -> None:
    """Do one piece of work, after the same on a short file, and print what it took; processes it started count."""
    work = {
        "loadtxt": lambda path: np.loadtxt(path, delimiter=",", skiprows=1),
        "read_loop": read_loop,
        "read_loop_file": read_loop_file,
        "fit-actuator": lambda path: fit_command([str(path), "--quiet"]),
    }[what]
    work(short)
    before, began = _most_memory_MB(), _processor_s()
    work(path)
    taken = _processor_s() - began
    print(json.dumps({"s": taken, "MB": _most_memory_MB() - before}))


def _most_memory_MB() -> float:
    """Most memory that this process has had; what getrusage gives begins with that of the process it came from."""
    line = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    return int(line.split()[1]) / 1024


def _processor_s() -> float:
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def long_loop() -> None:
    """Print what each piece of work takes, and how many times loadtxt and the file that is."""
    with tempfile.TemporaryDirectory() as folder:
        paths = written_long(Path(folder))
        base = min(in_its_own_process("loadtxt", paths["long.csv"], paths["short.csv"])[0] for _ in range(3))
        print(f"loadtxt          long.csv   {base:7.2f} s")
        for what, name in (
            *(("read_loop", "long.csv"), ("read_loop_file", "long.csv"), ("read_loop_file", "commas.csv")),
            *(("read_loop_file", "long.mat"), ("read_loop_file", "long.h5"), ("fit-actuator", "long.csv")),
        ):
            seconds, megabytes = in_its_own_process(what, paths[name], paths["short.csv"])
            size = paths[name].stat().st_size / 2**20
            print(f"{what:<16} {name:<10} {seconds:7.2f} s  {seconds / base:5.1f} times loadtxt   {megabytes / size:5.1f} times the file")


if __name__ == "__main__":
    asked = sys.argv[1] if len(sys.argv) > 1 else ""
    if asked == "piece":
        piece(sys.argv[2], Path(sys.argv[3]), Path(sys.argv[4]))
    else:
        if asked != "long":
            six_loops()
        if asked != "six":
            long_loop()
