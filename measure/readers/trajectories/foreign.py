"""Which files are trajectories of other programs, and the one door to their readers."""

from __future__ import annotations

from pathlib import Path

from measure.readers.column_mapping import ColumnMapping
from measure.readers.trajectories.c3d_markers import read_c3d
from measure.readers.trajectories.markers import trajectory_of_markers
from measure.readers.trajectories.tracker import read_tracker_table, tracker_head
from measure.readers.trajectories.trc import read_trc
from measure.tables.trajectory import Trajectory

_FIRST_BYTES = 4096


def read_foreign_trajectory(path: Path, wanted: ColumnMapping) -> Trajectory | None:
    """The trajectory in a file of markers (.c3d, .trc) or in Tracker's table; None where it is none of these.

    Raises
    ------
    InputError
        It is one of these and cannot be used.
    """
    if not path.is_file():
        return None
    if path.suffix.lower() == ".c3d":
        return trajectory_of_markers(read_c3d(path), wanted)
    with open(path, "rb") as file:
        shown = file.read(_FIRST_BYTES).removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")
    if path.suffix.lower() == ".trc" or shown.startswith("PathFileType"):
        return trajectory_of_markers(read_trc(path, wanted.encoding), wanted)
    return None if wanted.columns or tracker_head(shown) is None else read_tracker_table(path, wanted)
