"""What was seen: footage and files become tables.

from measure import Loop, Trajectory, read_loop, read_trajectory, track
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from measure.common.front_door import loaded_late

if TYPE_CHECKING:
    from measure.common.errors import InputError as InputError
    from measure.film.dispersion import compare_trajectories as compare_trajectories
    from measure.film.smoothing import smooth as smooth
    from measure.film.track import track as track
    from measure.film.tracked import Tracked as Tracked
    from measure.footage.footage import from_array as from_array
    from measure.footage.formats import open_footage as open_footage
    from measure.geometry.film_project import Project as Project
    from measure.geometry.film_project import read_project as read_project
    from measure.geometry.film_project import write_project as write_project
    from measure.notebook.watching import progress_of as progress_of
    from measure.readers.column_mapping import ColumnMapping as ColumnMapping
    from measure.readers.loop_file import read_loop_file as read_loop_file
    from measure.readers.measurement import read_measurement as read_measurement
    from measure.synthetic.made_film import deployment_scene as deployment_scene
    from measure.synthetic.made_film import project_for as project_for
    from measure.synthetic.made_film import render as render
    from measure.tables.loop import Loop as Loop
    from measure.tables.loop import read_loop as read_loop
    from measure.tables.loop import write_loop as write_loop
    from measure.tables.loop_or_trajectory import read_table as read_table
    from measure.tables.mat_file import write_mat as write_mat
    from measure.tables.trajectory import CHANNELS as CHANNELS
    from measure.tables.trajectory import Trajectory as Trajectory
    from measure.tables.trajectory import read_trajectory as read_trajectory
    from measure.tables.trajectory import write_trajectory as write_trajectory

_HOMES = {
    "InputError": "common.errors",
    "progress_of": "notebook.watching",
    "Loop": "tables.loop",
    "Trajectory": "tables.trajectory",
    "CHANNELS": "tables.trajectory",
    "read_loop": "tables.loop",
    "read_trajectory": "tables.trajectory",
    "read_table": "tables.loop_or_trajectory",
    "write_loop": "tables.loop",
    "write_mat": "tables.mat_file",
    "write_trajectory": "tables.trajectory",
    "ColumnMapping": "readers.column_mapping",
    "read_loop_file": "readers.loop_file",
    "read_measurement": "readers.measurement",
    "open_footage": "footage.formats",
    "from_array": "footage.footage",
    "Project": "geometry.film_project",
    "read_project": "geometry.film_project",
    "write_project": "geometry.film_project",
    "track": "film.track",
    "Tracked": "film.tracked",
    "smooth": "film.smoothing",
    "compare_trajectories": "film.dispersion",
    "deployment_scene": "synthetic.made_film",
    "project_for": "synthetic.made_film",
    "render": "synthetic.made_film",
}

__all__ = [
    "CHANNELS",
    "ColumnMapping",
    "InputError",
    "Loop",
    "Project",
    "Tracked",
    "Trajectory",
    "compare_trajectories",
    "deployment_scene",
    "from_array",
    "open_footage",
    "progress_of",
    "project_for",
    "read_loop",
    "read_loop_file",
    "read_measurement",
    "read_project",
    "read_table",
    "read_trajectory",
    "render",
    "smooth",
    "track",
    "write_loop",
    "write_mat",
    "write_project",
    "write_trajectory",
]

__getattr__ = loaded_late(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(_HOMES)
