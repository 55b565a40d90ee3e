"""What `track-video` has not been given: without which it cannot begin, and without which it must assume something."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from measure.common.errors import InputError

if TYPE_CHECKING:
    from measure.footage.footage import Footage
    from measure.geometry.film_project import Project


def require_complete(given: argparse.Namespace, project: Project, footage: Footage) -> None:
    """Ask for everything that is missing at once; where something is, also for what would only be assumed.

    Parameters
    ----------
    given : argparse.Namespace
        Parsed options.
    project : Project
    footage : Footage

    Raises
    ------
    InputError
        No capture rate, or no scale where metres are wanted.
    """
    missing = []
    if project.film.fps is None and footage.fps is None:
        missing.append(
            f"{footage.name}: carries no capture rate of the camera (the rate in a container is that of playing). "
            "Give --fps with the rate that the camera was set to."
        )
    metres = given.output is not None or given.marks is None
    if not project.has_scale() and metres:
        missing.append(
            "no scale, so no metres. Give --mm-per-px S, --scale-from X1,Y1,X2,Y2,LENGTH_MM or --rule X1,Y1,X2,Y2,PITCH_MM; "
            "for the marks in pixels alone give --marks FILE and no --output."
        )
    if given.compare and not project.has_scale():
        missing.append("--compare needs a scale, because trajectories are compared in metres; give --mm-per-px S.")
    if missing:
        assumed = assumptions(project) if metres else []
        raise InputError("\n".join([*missing, *(f"Not needed, but better: {one}" for one in assumed)]))


def assumptions(project: Project) -> list[str]:
    """What is taken for granted because nothing gives it, each with the reason to give it and the option.

    Parameters
    ----------
    project : Project

    Returns
    -------
    list of str
        Sentences; none where all is given.
    """
    platform, camera = project.platform, project.camera
    found = []
    if "start_height_m" not in platform.model_fields_set:
        found.append("no start height, so z is counted from the first frame. Give --start-height-m H or --model MODEL.")
    if platform.radius_m is None:
        found.append(
            "no radius, so the marks are taken to lie in one plane, and a rotation theta_z for lateral motion. "
            "Give --radius-m R of the cylinder that carries the marks, or --model MODEL."
        )
    if camera.distance_m is None and camera.focal_px is None:
        found.append(
            "no distance, so no perspective; theta_z needs it, beside the radius. "
            "Give --distance-m D from the camera to the platform's origin."
        )
    return found
