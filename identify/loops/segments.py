"""What of a record counts in a fit, what does not, and why: idle seconds, ramps, full cycles, transients, gaps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.loops.differentiation import Motion, moving
from identify.loops.loop_data import Cycles, Kind, Part
from measure.common.arrays import Array
from measure.readers.time_axis import gaps

ENDS = 10  # samples at each end of a record whose acceleration is poorly known
_SHORT = 0.02  # of a period; in a shorter gap a reversal cannot go far
_SPEEDS = 2.0  # factor within which the mean speed over a gap must agree with those at its ends
_STEADY = 0.05  # relative difference of a cycle's stroke from the usual one that makes it a transient
_NEAR = 3  # samples before a gap whose smoothed motion already knows of what is behind it


@dataclass(frozen=True)
class Usage:
    """used : (n,) samples that count. moves : first and last + 1 of the motion. lost : stretches (first, last + 1) behind gaps
    in which the motion may have turned unseen, up to the next reversal."""

    used: NDArray[np.bool_]
    moves: slice
    lost: tuple[tuple[int, int], ...]

    def whole(self, spans: tuple[tuple[int, int], ...]) -> tuple[tuple[int, int], ...]:
        """Those of the full cycles in which nothing is lost."""
        return tuple((a, b) for a, b in spans if not any(first < b and a < last for first, last in self.lost))


def usage(time_s: Array, smooth: Motion, band_m: float, found: Cycles) -> Usage:
    """Which samples count: not those of idle seconds, of a few samples at the ends, and of strokes with an unseen reversal."""
    n = len(time_s)
    moves = _without_strays(moving(smooth.elongation_m, band_m), gaps(time_s))
    lost = tuple(_lost(smooth, found, k) for k in gaps(time_s) if moves.start <= k < moves.stop - 1 and _may_turn(time_s, smooth, found, k))
    used = np.zeros(n, dtype=bool)
    used[moves] = True
    margin = min(ENDS, n // 50)
    used[:margin] = used[n - margin :] = False
    for first, last in lost:
        used[first:last] = False
    return Usage(used, moves, lost)


def _without_strays(moves: slice, behind: Sequence[int]) -> slice:
    """The motion without a handful of samples that a gap parts from the rest of it at either end."""
    start = max([moves.start, *(k + 1 for k in behind if moves.start <= k < moves.start + ENDS)])
    stop = min([moves.stop, *(k + 1 for k in behind if moves.stop - ENDS <= k + 1 < moves.stop)])
    return slice(start, stop)


def _may_turn(time_s: Array, smooth: Motion, found: Cycles, k: int) -> bool:
    """Whether the motion may have turned between sample k and the next: the law depends on the distance, not on the time it took."""
    step, moved = time_s[k + 1] - time_s[k], smooth.elongation_m[k + 1] - smooth.elongation_m[k]
    if step * found.frequency_Hz < _SHORT:
        return False
    speeds = np.array([smooth.speed_m_per_s[max(k - 1, 0)], smooth.speed_m_per_s[min(k + 2, len(time_s) - 1)]]) * np.sign(moved)
    mean = abs(moved) / step
    return bool(speeds.min() <= 0.0 or mean < speeds.min() / _SPEEDS or mean > speeds.max() * _SPEEDS)


def _lost(smooth: Motion, found: Cycles, k: int) -> tuple[int, int]:
    """From just before the gap to the next reversal: from there on the force no longer depends on what was lost."""
    following = [turn for turn in found.reversals if turn > k + 1]
    return max(k - _NEAR + 1, 0), (following[0] if following else len(smooth.elongation_m))


def parts(time_s: Array, elongation_m: Array, use: Usage, all_spans: tuple[tuple[int, int], ...]) -> list[Part]:
    """The record as a sequence of stretches, in the order of time, none left out.

    A cycle whose stroke differs by more than 5 % from the usual one is a transient. Idle is what lies before and after the
    motion, a ramp what leads to the first reversal, a rest what follows the last full cycle.
    """
    n = len(time_s)
    first, last = (all_spans[0][0], all_spans[-1][1] - 1) if all_spans else (use.moves.stop,) * 2
    starts, stops = (use.moves.start if use.moves.start > ENDS else 0), (use.moves.stop if use.moves.stop < n - ENDS else n)
    starts, stops = min(starts, first), max(stops, last)
    edges: list[tuple[Kind, int, int]] = [("idle", 0, starts), ("ramp", starts, first)]
    usual = float(np.median([np.ptp(elongation_m[a:b]) for a, b in all_spans])) if all_spans else 1.0
    for a, b in all_spans:
        steady = abs(np.ptp(elongation_m[a:b]) - usual) <= _STEADY * usual
        edges.append(("cycle" if steady else "transient", a, b - 1))
    edges += [("rest", last, stops), ("idle", stops, n)]
    return [_part(time_s, kind, a, b, use) for kind, a, b in edges if b > a]


def _part(time_s: Array, kind: Kind, a: int, b: int, use: Usage) -> Part:
    kept, behind_gap = int(use.used[a:b].sum()), any(first < b and a < last for first, last in use.lost)
    why = ""
    if kept < b - a:
        ends = "the record ends"
        why = "nothing moves" if kind == "idle" else "the motion may have turned in a gap" if behind_gap else ends
    return Part(kind, float(time_s[a]), float(time_s[min(b, len(time_s) - 1)]), b - a, kept, why)


def sentence(listed: Sequence[Part]) -> str:
    """The stretches of a record in a line, equal neighbours together."""
    groups: list[list[Part]] = []
    for part in listed:
        if groups and (groups[-1][0].kind, groups[-1][0].why) == (part.kind, part.why):
            groups[-1].append(part)
        else:
            groups.append([part])
    return "; ".join(_named(group) for group in groups)


def _named(group: list[Part]) -> str:
    kind, many = group[0].kind, len(group) > 1
    name = {"cycle": "full cycle", "transient": "cycle of another stroke"}.get(kind, kind)
    name = f"{len(group)} {name}s" if many else name
    left_out = sum(part.samples - part.used for part in group)
    tail = f" ({left_out} of {sum(part.samples for part in group)} samples left out: {group[0].why})" if left_out else ""
    return f"{name} {group[0].from_s:.4g} to {group[-1].to_s:.4g} s{tail}"
