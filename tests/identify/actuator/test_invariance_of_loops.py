"""What is answered does not depend on the load cell's zero, on the order of the files, or on their units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from faulty_benches import KINDS

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.fit_actuator import fit_actuator
from identify.loops.sign import prepared
from measure import Loop
from measure.readers.column_mapping import ColumnMapping
from measure.readers.loop_file import read_loop_file
from measure.tables.csv_cells import write_columns

SAME = 1e-9
Loops = list[Loop]


def other_zeros(loops: Loops, chance: np.random.Generator, folder: Path) -> Loops:
    """A constant of its own, up to a hundred heights, on the force of each file."""
    size = 100.0 * max(np.ptp(loop.force_N) for loop in loops)
    return [replace(loop, force_N=loop.force_N + chance.uniform(-size, size)) for loop in loops]


def other_order(loops: Loops, chance: np.random.Generator, folder: Path) -> Loops:
    """The last file first."""
    return loops[::-1]


def other_units(loops: Loops, chance: np.random.Generator, folder: Path) -> Loops:
    """Written in milliseconds, micrometres and kilonewtons, and read."""
    read = []
    for loop in loops:
        path = folder / loop.name
        write_columns({"time_ms": 1e3 * loop.time_s, "elongation_um": 1e6 * loop.elongation_m, "force_kN": 1e-3 * loop.force_N}, path)
        read.append(replace(read_loop_file(path, ColumnMapping())[0], name=loop.name))
    return read


CHANGES: dict[str, Callable[[Loops, np.random.Generator, Path], Loops]] = {
    change.__name__: change for change in (other_zeros, other_order, other_units)
}


def answered(loops: Sequence[Loop]) -> ActuatorFit:
    return fit_actuator(prepared(loops)[0], tare="auto")


def numbers(fit: ActuatorFit) -> dict[str, float]:
    """All that is said in numbers, by name; the levels about their mean, because the zero of a load cell is nobody's."""
    levels = [name for name in fit.estimates if name.startswith("b_")]
    zero = float(np.mean([fit.estimates[name].value for name in levels]))
    found = {"half height": fit.half_height_N, "misfit": fit.misfit.pooled}
    for name, e in fit.estimates.items():
        off = zero if name in levels else 0.0
        found |= {
            f"{name} value": e.value - off,
            f"{name} low": e.ci95[0] - off,
            f"{name} high": e.ci95[1] - off,
            f"{name} error": e.stderr,
        }
    for trial in fit.trials:
        found |= {f"{trial.name}.{key}": float(v) for key, v in zip(trial.effect.flat_names(), trial.effect.flat(), strict=True)}
    return found


def farthest(one: ActuatorFit, other: ActuatorFit) -> float:
    """The largest difference of the numbers, relative, of levels and slopes in those of the loop; infinite where the words differ."""
    if words(one) != words(other):
        return float("inf")
    first, second = numbers(one), numbers(other)
    height = 2.0 * abs(one.half_height_N)
    natural = {"a_": height / max(data.amplitude_m for data in one.loops), "b_": height}
    of_law = {name: natural[name[:2]] for name in first if name[:2] in natural and name.endswith(("value", "low", "high"))}
    scales = {"misfit": 1.0, **of_law}
    return max(
        abs(first[name] - second[name]) / scales.get(name, max(abs(first[name]), 1e-300)) for name in first if np.isfinite(first[name])
    )


def words(fit: ActuatorFit) -> tuple[object, ...]:
    """Verdict, faults, effects and the words of the parameters."""
    faults = sorted((fault.word, Path(fault.loop).name if fault.loop.endswith(".csv") else "") for fault in fit.faults)
    return fit.verdict.word, tuple(faults), tuple(t.name for t in fit.trials), tuple(e.verdict for e in fit.estimates.values())


def drawn(kind: str, seed: int) -> Loops:
    """A design of a kind with several files."""
    for k in range(100):
        loops = KINDS[kind](np.random.default_rng([seed, k, sorted(KINDS).index(kind)]))[1]
        if len(loops) > 1:
            return [replace(loop, name=f"{place}.csv") for place, loop in enumerate(loops)]
    raise AssertionError(kind)


def compared(kind: str, seed: int, folder: Path) -> dict[str, float]:
    """How far the numbers of a design move under each change."""
    loops, chance = drawn(kind, seed), np.random.default_rng(seed)
    before = answered(loops)
    return {name: farthest(before, answered(change(loops, chance, folder))) for name, change in CHANGES.items()}


@pytest.mark.parametrize("kind", ["clean", "drifting"])
def test_zeros_order_and_units_change_nothing(kind, tmp_path):
    assert max(compared(kind, 1, tmp_path).values()) < SAME


@pytest.mark.calibrate
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning:lmfit")
def test_in_twenty_sets_zeros_order_and_units_change_nothing(calibration_seed, share_of, validation_table, tmp_path):
    kinds = [kind for kind in KINDS if kind != "two_states"] + ["clean"] * 10
    rows = []
    for k in range(share_of(20)):
        moved = compared(kinds[k % len(kinds)], 1000 * calibration_seed + k, tmp_path)
        rows.append({"set": k + 1, "kind": kinds[k % len(kinds)], **moved})
    note = "Largest relative difference of any number of the answer; a level counts in loop heights, inf where a word differs. Aim 1e-9."
    validation_table("What changes nothing", rows, note)
    assert max(max(row[name] for name in CHANGES) for row in rows) < SAME
