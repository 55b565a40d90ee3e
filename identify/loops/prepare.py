"""A loop made ready for comparison with the force law: smoothed, its noise, reversals and faults found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identify.loops.channel_faults import checked, dwell_fault
from identify.loops.corners import Corner, sharpened
from identify.loops.differentiation import Motion, cycles, dead_band, motion, quantum_of
from identify.loops.dwells import dwells_of, with_dwells
from identify.loops.integration_path import path_of
from identify.loops.loop_data import Cycles, Fault, LoopData
from identify.loops.segments import parts, usage
from measure.common.errors import InputError
from measure.tables.checks import require_physical
from measure.tables.loop import LOOP_COLUMNS, Loop

_NOTHING = 1e-12  # m or N: no such motion or force is measured
_FINEST_S = 1e-12  # no load cell is read so often
_ANOTHER = 10.0  # records long, a gap between two recordings


def prepare(loop: Loop) -> LoopData:
    """Smooth a loop's motion, find its noise, its reversals and what of it counts.

    Parameters
    ----------
    loop : Loop
        As it was measured, n samples.

    Returns
    -------
    LoopData
        Each array at the n samples of the loop, in SI.

    Raises
    ------
    InputError
        The elongation or the force does not change, or there are too few samples.
    """
    _require_motion(loop)
    channel = checked(loop)
    smooth = motion(loop.time_s, loop.elongation_m)
    dwells = dwells_of(loop.elongation_m, smooth.noise_m) if not len(smooth.errors) else []
    smooth, corners = with_dwells(loop.time_s, loop.elongation_m, smooth, dwells)
    band = dead_band(smooth, quantum_of(loop.elongation_m))
    found = cycles(loop.time_s, smooth.elongation_m, band)
    smooth, sharp = _sharpened(loop, smooth, found, dwells)
    corners += sharp
    use = usage(loop.time_s, smooth, band, found)
    path, at = path_of(loop.time_s, smooth, found.reversals, sorted(corners, key=lambda corner: corner.time_s))
    return LoopData(
        name=loop.name,
        time_s=loop.time_s,
        elongation_m=smooth.elongation_m,
        speed_m_per_s=smooth.speed_m_per_s,
        acceleration_m_per_s2=smooth.acceleration_m_per_s2,
        force_N=channel.force_N,
        used=use.used & channel.sound,
        force_sigma_N=channel.noise_N,
        elongation_sigma_m=smooth.noise_m,
        turns_sigma_m=smooth.turns_m,
        cycles=replace(found, spans=use.whole(found.spans)),
        path=path,
        at=at,
        motion_errors=smooth.errors,
        other=loop.other,
        parts=tuple(parts(loop.time_s, smooth.elongation_m, use, found.spans)),
        remarks=tuple(loop.remarks),
        faults=(*channel.faults, *_dwell_faults(loop, dwells)),
        force_step_N=channel.step_N,
    )


def _sharpened(loop: Loop, smooth: Motion, found: Cycles, dwells: list[tuple[int, int]]) -> tuple[Motion, list[Corner]]:
    """Sharp reversals made so, but for those in a dwell, whose corners are known."""
    still = [turn for turn in found.reversals if any(a <= turn < b for a, b in dwells)]
    return sharpened(loop.time_s, loop.elongation_m, smooth, tuple(turn for turn in found.reversals if turn not in still))


def _dwell_faults(loop: Loop, dwells: list[tuple[int, int]]) -> list[Fault]:
    lengths = [float(loop.time_s[b - 1] - loop.time_s[a]) for a, b in dwells]
    return [dwell_fault(loop.name, float(np.median(lengths)), len(dwells))] if dwells else []


def _require_motion(loop: Loop) -> None:
    if len(loop.time_s) < 20:
        raise InputError(f"{loop.name}: {len(loop.time_s)} samples; a loop needs at least 20.")
    _require_one_recording(loop)
    for column in LOOP_COLUMNS:
        require_physical(getattr(loop, column), column, loop.name)
    for column in ("elongation_m", "force_N"):
        if np.ptp(getattr(loop, column)) < _NOTHING:
            raise InputError(f"{loop.name}: {column} is {getattr(loop, column)[0]:g} in every row. Check which column was taken for it.")


def _require_one_recording(loop: Loop) -> None:
    steps = np.diff(loop.time_s)
    gap = int(np.argmax(steps))
    if np.min(steps) < _FINEST_S:
        row = int(np.argmin(steps))
        raise InputError(f"{loop.name}: time_s grows by {steps[row]:.3g} s at {loop.time_s[row]:.6g} s. Check its unit, or its digits.")
    sampled = float(np.sum(steps)) - float(steps[gap])
    if steps[gap] > _ANOTHER * max(sampled, len(steps) * float(np.median(steps))):
        raise InputError(
            f"{loop.name}: no samples for {steps[gap]:.4g} s after {loop.time_s[gap]:.6g} s, and {sampled:.3g} s of samples in all; "
            "these are two recordings, or the clock was set anew. Cut the file there."
        )
