"""What is read off a deployment as a single number: names, units, and their place in the kernel's answer."""

from __future__ import annotations

from typing import NamedTuple

from measure.common.errors import InputError, nearest

THETA_Z, LATERAL, TILT, FULL_HEIGHT, STOP_FORCE, BEFORE_STOP, CONTROL_FORCE, CONTROL_ENERGY, DIVERGED = range(9)
COUNT = 9


class Response(NamedTuple):
    """A number that a deployment ends in: `scale` turns the kernel's SI value into `unit`."""

    place: int
    unit: str
    scale: float
    doc: str


_DEGREE = 57.29577951308232

RESPONSES = {
    "theta_z_deg": Response(THETA_Z, "deg", _DEGREE, "signed theta_z where its size is largest"),
    "theta_z_before_stop_deg": Response(BEFORE_STOP, "deg", _DEGREE, "the same up to the first stop that is reached"),
    "lateral_mm": Response(LATERAL, "mm", 1e3, "largest distance of the platform from the vertical"),
    "tilt_deg": Response(TILT, "deg", _DEGREE, "largest tilt, the size of the swing"),
    "time_to_full_height_s": Response(FULL_HEIGHT, "s", 1.0, "first sample at the deployed height; none where it is not reached"),
    "stop_force_N": Response(STOP_FORCE, "N", 1.0, "largest force of one stop"),
    "control_force_N": Response(CONTROL_FORCE, "N", 1.0, "largest force of one actuator of a controller; zero without one"),
    "control_energy_J": Response(CONTROL_ENERGY, "J", 1.0, "energy that a controller has taken out"),
}


def response_named(name: str) -> Response:
    """A response by its name.

    Raises
    ------
    InputError
        There is none of that name; the nearest known one is named.
    """
    if name not in RESPONSES:
        raise InputError(f'no response is named "{name}"; {nearest(name, RESPONSES)}')
    return RESPONSES[name]
