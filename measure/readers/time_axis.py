"""The time of a record, put in order where that can be done in one way only, and what is reported of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.common.errors import InputError

GAP = 5.0  # median steps, from which on a step is a gap
_UNEVEN = 0.2  # of the median step, the spread of the steps from which on it is mentioned
_LISTED = 3  # gaps that are reported one by one
_LEAST_ROWS = 10  # of a recording
_SHARED = 0.5  # of the shorter one of two runs of rows, from which on seconds that both cover make them two recordings
_ONE_VALUE = 0.1  # of the elongation's range, within which rows of one instant are one sample


def in_order(columns: Mapping[str, Array], where: Callable[[int], str]) -> tuple[dict[str, Array], list[str]]:
    """Rows in the order of their time, those of one instant as one row; and what was done, in sentences.

    Rows are sorted only if that makes the elongation no rougher: the rows of two recordings, or of a clock that was set
    back, would be shuffled into each other.

    Parameters
    ----------
    columns : "time", "elongation" and any others, of one length.
    where : the place of a row in the file, for people.

    Raises
    ------
    InputError
        Two recordings in one file; two elongations at one instant.
    """
    time, u = columns["time"], columns["elongation"]
    if np.all(np.diff(time) > 0.0):
        return dict(columns), []
    said = []
    order = np.argsort(time, kind="stable")
    back = int(np.sum(np.diff(time) < 0.0))
    if back:
        _require_one_recording(time, u, where)
        if _distance(u[order]) > 1.001 * _distance(u):
            _refuse_two_recordings(time, where)
        said.append(f"time goes back at {back} of {len(time)} rows; the rows were sorted by time")
    ordered, more = _merged({name: values[order] for name, values in columns.items()}, order, where)
    return ordered, said + more


def _require_one_recording(time: Array, u: Array, where: Callable[[int], str]) -> None:
    """Refuse a time that starts again: runs of rows over the same seconds with other elongations are recordings of their own."""
    starts = np.flatnonzero(np.diff(time, prepend=time[:1]) < 0.0)
    runs = [run for run in np.split(np.arange(len(time)), starts) if len(run) >= _LEAST_ROWS]
    if len(runs) < 2 or len(starts) >= 2 * len(runs):
        return
    first, second = runs[0], runs[1]
    shared = min(time[first[-1]], time[second[-1]]) - max(time[first[0]], time[second[0]])
    shorter = min(np.ptp(time[first]), np.ptp(time[second]))
    if shared > _SHARED * shorter and not _is_repeated(time, u, first, second):
        i = int(second[0])
        count = "two" if len(runs) == 2 else str(len(runs))
        raise InputError(
            f"{where(i)}: time goes from {time[i - 1]:g} back to {time[i]:g} s and runs over the same seconds again: there are {count} "
            "recordings in the file. Cut the file there, or leave its time out with --sample-period SECONDS."
        )


def _is_repeated(time: Array, u: Array, first: NDArray[np.intp], second: NDArray[np.intp]) -> bool:
    """Whether the second run holds rows of the first one again."""
    rows = {(t, x) for t, x in zip(time[first], u[first], strict=True)}
    return all((t, x) in rows for t, x in zip(time[second], u[second], strict=True))


def _distance(u: Array) -> float:
    return float(np.sum(np.abs(np.diff(u))))


def _refuse_two_recordings(time: Array, where: Callable[[int], str]) -> None:
    i = int(np.argmax(np.diff(time) < 0.0)) + 1
    raise InputError(
        f"{where(i)}: time goes from {time[i - 1]:g} back to {time[i]:g} s, and sorted by time the elongation would leap to and fro: "
        "there are two recordings in the file, or the clock was set back. Cut the file there, or leave its time out with "
        "--sample-period SECONDS."
    )


def _merged(columns: Mapping[str, Array], order: NDArray[np.intp], where: Callable[[int], str]) -> tuple[dict[str, Array], list[str]]:
    """Rows of one instant as one row, their mean."""
    instants, first, count = np.unique(columns["time"], return_index=True, return_counts=True)
    if len(instants) == len(columns["time"]):
        return dict(columns), []
    u = columns["elongation"]
    spread = np.maximum.reduceat(u, first) - np.minimum.reduceat(u, first)
    if np.max(spread) > _ONE_VALUE * np.ptp(u):
        k = int(np.argmax(spread))
        raise InputError(
            f"{where(int(order[first[k]]))}: {count[k]} rows have the time {instants[k]:g} s, "
            f"and their elongations differ by {spread[k]:g} m. "
            "Give each row its own time, or leave the time out with --sample-period SECONDS."
        )
    alike = all(np.array_equal(np.repeat(values[first], count), values, equal_nan=True) for values in columns.values())
    how = "they are the same and count once" if alike else "their mean was taken"
    said = f"{len(u) - len(instants)} of {len(u)} rows have the time of another one; {how}"
    return {name: np.add.reduceat(values, first) / count for name, values in columns.items()}, [said]


def remarks(time_s: Array) -> list[str]:
    """What there is to say about the steps of an increasing time: gaps, and steps that are not alike."""
    step = np.diff(time_s)
    if len(step) < 2:
        return []
    usual = float(np.median(step))
    said = [
        f"no samples for {step[k]:.3g} s after {time_s[k]:.5g} s (a sample every {usual:.3g} s elsewhere)" for k in gaps(time_s)[:_LISTED]
    ]
    if len(gaps(time_s)) > _LISTED:
        said.append(f"and {len(gaps(time_s)) - _LISTED} more gaps")
    low, high = np.quantile(step, [0.05, 0.95])
    if high - low > _UNEVEN * usual:
        said.append(f"steps of {low:.3g} to {high:.3g} s: the clock is uneven, and every time is taken as it is")
    return said


def gaps(time_s: Array) -> list[int]:
    """Indices of the samples behind which some are missing."""
    step = np.diff(time_s)
    return [int(k) for k in np.flatnonzero(step > GAP * np.median(step))]
