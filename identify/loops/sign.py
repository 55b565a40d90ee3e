"""Which way round a laboratory counted: an actuator takes energy, so its loops run anticlockwise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.loops.loop_data import LoopData, area, prepare
from measure.tables.loop import Loop


@dataclass(frozen=True)
class Turned:
    """Which quantity was counted the other way round, "elongation" or "force", or "" for none; and the sentence that says so."""

    quantity: str
    sentence: str


def oriented(loops: Sequence[Loop]) -> tuple[list[Loop], Turned]:
    """The loops with force and elongation counted as in the force law, and what was turned for it.

    If every loop with a full cycle runs clockwise one sign is the other way round. Where the force is positive on the whole
    it is the elongation's, else the force's. Loops that disagree are left as they are; the verdict of the fit will say so.
    """
    return _turned_loops(loops, [prepare(loop) for loop in loops])


def prepared(loops: Sequence[Loop]) -> tuple[list[LoopData], Turned]:
    """The same loops made ready for a fit, each smoothed once where no sign is turned; see `oriented`."""
    data = [prepare(loop) for loop in loops]
    counted, turned = _turned_loops(loops, data)
    return [prepare(loop) for loop in counted] if turned.quantity else data, turned


def _turned_loops(loops: Sequence[Loop], data: Sequence[LoopData]) -> tuple[list[Loop], Turned]:
    areas = [area(d, d.force_N) for d in data if d.cycles.spans]
    if not areas or max(areas) >= 0.0:
        return list(loops), Turned("", "")
    if np.mean([loop.force_N.mean() for loop in loops]) > 0.0:
        turned = [replace(loop, elongation_m=-loop.elongation_m) for loop in loops]
        return turned, Turned("elongation", "the loops run clockwise as given, so the elongation was counted the other way round")
    turned = [replace(loop, force_N=-loop.force_N) for loop in loops]
    return turned, Turned("force", "the loops run clockwise and the force is negative as given, so the force's sign was turned")
