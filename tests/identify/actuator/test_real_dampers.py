"""A magnetorheological damper at 0 V, measured by others: the law alone misses a friction that grows with speed."""

from __future__ import annotations

from pathlib import Path

import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.campaign.run import Run
from identify.loops.prepare import prepare
from identify.report.loop_result import model_of
from identify.selection.explain import explain
from measure.readers.column_mapping import ColumnMapping
from measure.readers.loop_file import read_loop_file
from measure.tables.loop import Loop

REAL = Path(__file__).resolve().parents[3].parent / "shared" / "real" / "loops" / "mr-damper-0V"


@pytest.mark.slow
@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.calibrate)])
def test_the_missing_friction_of_a_real_damper_is_viscous_and_mends_a_frequency_it_never_saw(every):
    if not REAL.is_dir():
        pytest.skip(f"real loops are not there: {REAL}")
    files = sorted(REAL.glob("*.csv"))[::every]
    read = [read_loop_file(path, ColumnMapping(units={"elongation": "mm"}))[0] for path in files]
    # the machine counts its travel the other way round, and its cell is off by about 130 N
    loops = [Loop(loop.time_s, -loop.elongation_m, loop.force_N - 130.0, name=path.name) for loop, path in zip(read, files, strict=True)]
    law = model_of(fit_actuator([prepare(loop) for loop in loops]))
    found = explain(law, [Run(loop, hold_out=i == len(loops) // 2) for i, loop in enumerate(loops)])
    assert found.verdict in ("named", "class", "partly")  # a law of five numbers leaves more than the machine's noise
    names = {found.findings[0].name, *found.findings[0].equivalents}
    assert names & {"viscous-friction", "power-law-friction"}
    fitted = found.after.rms / found.before.rms
    held_out = found.held[0].after.rms / found.held[0].before.rms
    assert fitted < 0.6
    assert held_out < 1.15 * fitted
