"""How large what was measured is: its forces, its stroke and its time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identify.loops.loop_data import LoopData
from simulate.model.measures import PROTOTYPE, Measures, measured
from simulate.model.model import LEGS, Model
from simulate.model.rig import per_leg, stroke_of

_STORED = 10.0  # times the height of a loop: the stored force of a tape spring


def measures_of(model: Model, loops: Sequence[LoopData], *, with_films: bool) -> Measures:
    """The measures of the measurements at hand.

    Parameters
    ----------
    model : its stored force, and its stroke and mass where there are films.
    loops : their largest stroke and largest speed.
    """
    stored = float(np.mean(np.abs(per_leg(model.actuator.initial_force_N))))
    if with_films:
        return _of_rig(model, stored)
    return measures_of_loops(loops, stored) if loops else PROTOTYPE


def measures_of_loops(loops: Sequence[LoopData], stored_N: float = 0.0) -> Measures:
    """The measures of loops, whatever their level of force: heights that are a tenth of the stored force, or this force if it is known."""
    force = stored_N or _STORED * max(float(np.ptp(loop.force_N)) for loop in loops)
    stroke = max(float(np.ptp(loop.elongation_m)) for loop in loops)
    speed = max(float(np.max(np.abs(loop.speed_m_per_s))) for loop in loops)
    return measured(force, stroke, stroke / speed) if min(force, stroke, speed) > 0.0 else PROTOTYPE


def _of_rig(model: Model, stored: float) -> Measures:
    stroke, mass = float(np.max(stroke_of(model))), model.moving_mass_kg
    force = stored or model.platform.mass_kg * 9.81 / LEGS
    return measured(force, stroke, float(np.sqrt(mass * stroke / (LEGS * force))))
