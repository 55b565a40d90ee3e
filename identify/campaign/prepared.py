"""Measurements that are ready for a problem, as plain data, and the parameters that are their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.campaign.run import Run
from identify.criteria import ANYWHERE, CAMERA_DISTANCE_M, FARTHEST_OFF_ZERO, FORCES_DIFFER
from identify.estimation.parameters import POSE, STORED_FORCE, Parameter
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from simulate.model.model import LEGS, Model


@dataclass(frozen=True)
class Film:
    """A deployment made ready: the channels that were seen, their noise, and when they count.

    values, sigma : (channels, n). counts : (channels, n), where there is a measurement. nominal : (channels,) where the
    platform should stand before the release. zeroed : (channels,), counted from the first frame and not from the rig's
    own zero; a tracker does that, so such a channel says nothing about where the platform stood, only how far it went.
    time_s : (n,) on the clock that the release sets, as far as it is known; clock_s more is the table's own clock.
    expected_s : when the release is expected on that clock; a film that counts from its first frame began before it.
    by_onset : whether the onset of the motion says so and nothing else does; then a clock that is late says nothing.
    """

    run: Run
    model: Model
    time_s: Array
    channels: tuple[str, ...]
    values: Array
    sigma: Array
    counts: NDArray[np.bool_]
    nominal: Array
    zeroed: NDArray[np.bool_]
    expected_s: float
    clock_s: float = 0.0
    by_onset: bool = False

    @property
    def turned(self) -> bool:
        """Whether rotations count from the first frame."""
        return any(zeroed and name.startswith("theta") for name, zeroed in zip(self.channels, self.zeroed, strict=True))


@dataclass(frozen=True)
class LoopRun:
    """A loop made ready."""

    run: Run
    model: Model
    data: LoopData


def lengths_of(film: Film) -> list[int]:
    """Rows of the zeroed channels that are lengths."""
    names = [channel for channel, zeroed in zip(film.channels, film.zeroed, strict=True) if zeroed]
    return [row for row, channel in enumerate(names) if channel.endswith("_m")]


def release_parameters(film: Film, forces_differ: bool = False) -> list[Parameter]:
    """What a film's own release, its first frame and its scale may be off by.

    forces_differ : whether the stored force may differ from run to run by more than the model file says.
    """
    spread = film.model.nuisance
    rows = list(zip(POSE, 3 * [spread.release_position_m] + 3 * [spread.release_theta_rad], strict=True))
    rows += [("instant_s", spread.release_instant_s)]
    rows += [(f"stored_force_N[{leg}]", spread.stored_force_N) for leg in range(LEGS)]
    rows += [(STORED_FORCE, 0.01 * spread.stored_force_percent or 0.005 * forces_differ)]
    rows = [(f"release.{key}", sd) for key, sd in rows]
    rows += [(f"first_frame_{film.channels[i]}", float(np.nanmedian(film.sigma[i]))) for i in np.flatnonzero(film.zeroed)]
    if film.zeroed.any():
        rows += [("length_scale", spread.release_position_m / CAMERA_DISTANCE_M)]
    wide = {f"release.{STORED_FORCE}": FORCES_DIFFER} if forces_differ else {}
    return [Parameter(f"{film.run.label}.{n}", sd, wide.get(n, 1.0), -np.inf, np.inf, film.run.name) for n, sd in rows if sd > 0]


TURNED_BY_MIRROR = ({"position_x_m", "theta_y_rad", "theta_z_rad"}, {"position_y_m", "theta_x_rad", "theta_z_rad"})
"""What of a release changes its sign in a mirror across x, and across y."""


def across_of(film: Film) -> set[str]:
    """What of a release is across all that a film shows: its mirror image would have looked the same."""
    seen = {"position_z_m"}
    for moved, turned in (("x", "y"), ("y", "x")):
        if f"{moved}_m" in film.channels or f"theta_{turned}_rad" in film.channels:
            seen |= {f"position_{moved}_m", f"theta_{turned}_rad"}
    return set(POSE) - seen


def zero_parameters(loops: Sequence[LoopRun], *, at_will: bool = False) -> list[Parameter]:
    """What a load cell that was set to zero anew may be off by in each loop; behind that, by how much it may drift over the record.

    at_will : zeros may be anywhere, for no level of force is known beforehand; scales then follow the loop and not its level.
    """
    forces = [loop.data.force_N[loop.data.used] for loop in loops]
    off = [float(np.ptp(force)) / 2.0 if at_will else FARTHEST_OFF_ZERO * float(np.max(np.abs(force))) for force in forces]
    drifts = [sd / float(np.ptp(loop.data.time_s)) for loop, sd in zip(loops, off, strict=True)]
    kinds = ("zero_N", off, ANYWHERE if at_will else 1.0), ("drift_N_per_s", drifts, 1.0)
    rows = [(loop, key, sd, spread) for key, sds, spread in kinds for loop, sd in zip(loops, sds, strict=True)]
    return [Parameter(f"{loop.run.label}.{key}", sd, spread, -np.inf, np.inf, loop.run.name) for loop, key, sd, spread in rows]


def beta_bounds(loops: Sequence[LoopData]) -> tuple[float, float]:
    """Between which betas loops can tell anything, 1/m.

    Below, the force would not come near an asymptote within the longest stroke; above, it would be there before the
    elongation's noise, or a fiftieth of a sample's way, has passed.
    """
    stroke = max(float(np.ptp(d.elongation_m[d.used])) for d in loops)
    finest = min(max(d.elongation_sigma_m, float(np.median(np.abs(np.diff(d.elongation_m[d.used])))) / 50.0) for d in loops)
    return 0.3 / stroke, max(3.0 / max(finest, 1e-9 * stroke), 100.0 / stroke)
