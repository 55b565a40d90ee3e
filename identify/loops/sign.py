"""Which way round a laboratory counted: an actuator takes energy, so its loops run anticlockwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from identify.criteria import NO_AREA, SAME_UNIT
from identify.loops.loop_data import Fault, LoopData, area
from identify.loops.prepare import prepare
from measure.common.arrays import Array
from measure.tables.loop import Loop


@dataclass(frozen=True)
class Turned:
    """Which quantity was counted the other way round, "elongation" or "force", or "" for none; and the sentence that says so.

    each : what is said of each loop, "" of one that was not turned.
    """

    quantity: str
    sentence: str
    each: tuple[str, ...] = ()


def oriented(loops: Sequence[Loop]) -> tuple[list[Loop], Turned]:
    """The loops with force and elongation counted as in the force law, and what was turned for it.

    If every loop with a full cycle runs clockwise one sign is the other way round. Where the force is positive on the whole
    it is the elongation's, else the force's. Where only some run clockwise, those are turned.
    """
    return _turned_loops(loops, [prepare(loop) for loop in loops])


def prepared(loops: Sequence[Loop]) -> tuple[list[LoopData], Turned]:
    """The same loops made ready for a fit, each smoothed once where no sign is turned; see `oriented`."""
    data = [prepare(loop) for loop in loops]
    counted, turned = _turned_loops(loops, data)
    return [prepare(loop) for loop in counted] if turned.quantity else data, turned


def _turned_loops(loops: Sequence[Loop], data: Sequence[LoopData]) -> tuple[list[Loop], Turned]:
    areas = [area(d, d.force_N) for d in data if d.cycles.spans]
    if not areas or min(areas) >= 0.0:
        return list(loops), Turned("", "")
    if max(areas) > 0.0:
        return _some_turned(loops, data)
    by_force = bool(np.mean([loop.force_N.mean() for loop in loops]) <= 0.0)
    said = _ALL_BY_FORCE if by_force else _ALL_BY_ELONGATION
    turned = [_turned_one(loop, by_force=by_force) for loop in loops]
    return turned, Turned("force" if by_force else "elongation", said, (said,) * len(loops))


def _some_turned(loops: Sequence[Loop], data: Sequence[LoopData]) -> tuple[list[Loop], Turned]:
    """Where some loops run clockwise and others do not: those turned whose area stands out of the noise, by force or by elongation.

    The force was turned where its mean has the other sign than that of the loops that run the right way round.
    """
    clockwise = [_surely_clockwise(d) for d in data]
    level = float(np.mean([loop.force_N.mean() for loop, odd in zip(loops, clockwise, strict=True) if not odd]))
    if not any(clockwise):
        return list(loops), Turned("", "")
    by_force = [loop.force_N.mean() * level < 0.0 for loop in loops]
    each = tuple((_FORCE if force else _ELONGATION) if odd else "" for odd, force in zip(clockwise, by_force, strict=True))
    made = [_turned_one(loop, by_force=force) if odd else loop for loop, odd, force in zip(loops, clockwise, by_force, strict=True)]
    names = {what: [Path(loop.name).name for loop, said in zip(loops, each, strict=True) if said == what] for what in (_FORCE, _ELONGATION)}
    sentence = "; ".join(f"{', '.join(of)}: {what}" for what, of in names.items() if of)
    return made, Turned("force" if names[_FORCE] else "elongation", sentence, each)


_ALL_BY_FORCE = "the loops run clockwise and the force is negative as given, so the force's sign was turned"
_ALL_BY_ELONGATION = "the loops run clockwise as given, so the elongation was counted the other way round"
_FORCE = "runs clockwise with a force of the other sign than the rest, so the force's sign was turned"
_ELONGATION = "runs clockwise and the rest does not, so the elongation was counted the other way round"


def _turned_one(loop: Loop, *, by_force: bool) -> Loop:
    return replace(loop, force_N=-loop.force_N) if by_force else replace(loop, elongation_m=-loop.elongation_m)


def _surely_clockwise(data: LoopData) -> bool:
    """Whether a loop's area is negative beyond what noise makes of it."""
    if not data.cycles.spans:
        return False
    height = area(data, data.force_N) / (2.0 * data.amplitude_m)
    return height < -NO_AREA[0] * data.force_sigma_N / float(np.sqrt(data.used.sum()))


_CLEANER = 3.0  # times nearer to a sinusoid: a triangle to the force of a rectangular loop 10, the other way round never above 0.4
_NO_DRIVE = 0.03  # of the variance beside the fundamental; a triangle has 0.015


def swapped_channels(loops: Sequence[LoopData]) -> list[Fault]:
    """Loops whose force moves as a drive does, a sinusoid or a triangle, and whose elongation does not: the columns may be swapped."""
    found = []
    for data in loops:
        if not data.cycles.spans:
            continue
        beside_u, beside_f = (_beside_fundamental(data, channel) for channel in (data.elongation_m, data.force_N))
        if beside_u > _NO_DRIVE and beside_u > _CLEANER * beside_f:
            said = (
                "the force moves like a drive and the elongation like the force of a loop: the two columns are swapped (--column "
                "elongation=... --column force=...), or the test was driven by force"
            )
            found.append(Fault("swapped", "elongation", data.name, "named", beside_u, said))
    return found


def _beside_fundamental(data: LoopData, channel: Array) -> float:
    """Share of a channel's variance that is no sinusoid of the loop's frequency, level and drift aside."""
    t, x = data.time_s[data.used], channel[data.used]
    turn = 2.0 * np.pi * data.frequency_Hz * t
    basis = np.column_stack([np.ones(len(t)), t - t.mean(), np.sin(turn), np.cos(turn)])
    left, whole = (x - columns @ np.linalg.lstsq(columns, x, rcond=None)[0] for columns in (basis, basis[:, :2]))
    return float(left @ left / (whole @ whole)) if whole @ whole > 0.0 else 0.0


_READ_AS = {
    "elongation": ("mm read as m? --unit elongation=mm", "m read as mm? --unit elongation=m"),
    "force": ("mN read as N? --unit force=mN", "kN read as N? --unit force=kN"),
}  # a thousand times too large, too small


def units_apart(loops: Sequence[LoopData]) -> list[Fault]:
    """Loops whose stroke or height is a thousand times that of the others, or a thousandth: they were read in another unit.

    Of two files the one with the larger values is named.
    """
    strokes = np.array([float(np.ptp(d.elongation_m[d.used])) for d in loops])
    heights = np.array([abs(area(d, d.force_N)) / (2.0 * d.amplitude_m) if d.cycles.spans else np.nan for d in loops])
    apart = _apart_by_unit(loops, strokes, "elongation", "its elongation spans {:.4g} m")
    return apart or _apart_by_unit(loops, heights, "force", "its loop is {:.4g} N high")


def _apart_by_unit(loops: Sequence[LoopData], sizes: Array, channel: str, what: str) -> list[Fault]:
    found = []
    for k, (data, size) in enumerate(zip(loops, sizes, strict=True)):
        others = np.delete(sizes, k)
        others = others[np.isfinite(others)]
        ratio = float(size) / max(float(np.median(others)), 1e-300) if len(others) and size > 0.0 else 1.0
        large = 1000.0 / SAME_UNIT < ratio < 1000.0 * SAME_UNIT
        if large or (len(others) > 1 and 1000.0 / SAME_UNIT < 1.0 / ratio < 1000.0 * SAME_UNIT):
            times = f"{ratio:.0f} times" if large else f"1/{1.0 / ratio:.0f} of"
            said = f"{what.format(size)}, {times} that of the others: {_READ_AS[channel][not large]}"
            found.append(Fault("unit", channel, data.name, "refused", float(size), said))
    return found
