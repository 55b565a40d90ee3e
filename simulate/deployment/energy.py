"""Where the energy of a deployment is: kinetic, stored, lost, and brought in from outside."""

from __future__ import annotations

import math

import numpy as np

from measure.common.arrays import Array
from simulate.model.rig import EndStop, Rig, per_leg, stroke_of


def stored_in_strips(model: Rig, elongation: Array) -> Array:
    """(n,) what the strips would still give on their way to full length, J.

        sum over the legs of the integral of h_m from u to full,   h_m = (h_l + h_u) / 2

    The line in the middle is where the law would run without hysteresis; what a run gives less than this is lost.

    Parameters
    ----------
    elongation : (n, 6).
    """
    law = model.actuator
    slope = (per_leg(law.a_l_N_per_m) + per_leg(law.a_u_N_per_m)) / 2
    level = (per_leg(law.b_l_N) + per_leg(law.b_u_N)) / 2
    full = stroke_of(model)
    return np.sum(slope * (full**2 - elongation**2) / 2 + level * (full - elongation), axis=1)


def stored_in_stops(model: Rig, elongation: Array) -> Array:
    """(n,) energy of the springs of the stops, J: the integral of k p erf(p / s) over the penetration p at either end.

    k (p^2 erf(p/s) / 2 + p s exp(-(p/s)^2) / (2 sqrt pi) - s^2 erf(p/s) / 4)
    """
    lowest = np.minimum(elongation[0], 0.0)
    penetration = np.maximum(np.maximum(elongation - stroke_of(model), lowest - elongation), 0.0)
    return np.sum(_spring_energy(model.end_stop, penetration), axis=1)


def _spring_energy(stop: EndStop, p: Array) -> Array:
    from scipy.special import erf

    s = stop.smoothing_m
    eased, x = erf(p / s), np.minimum(p / s, 30.0)
    return stop.stiffness_N_per_m * (p * p * eased / 2 + p * s * np.exp(-(x * x)) / (2 * math.sqrt(math.pi)) - s * s * eased / 4)


def energy_balance(model: Rig, elongation: Array, work: dict[str, Array], effects: dict[str, Array]) -> dict[str, Array]:
    """All entries against time, each (n,), J. What is stored or kinetic is there, what is lost has gone since the release.

        kinetic + stored + lost = what they were at the release + work of weight + work of effects

    lost_in_hysteresis counts against the middle line, so a strip that is released above it gives a little back at first; what an
    effect does by moving the asymptotes is counted there too. Of any other effect the work is listed by its name:
    negative, it has taken energy out.

    Parameters
    ----------
    model : with its effects on base quantities worked in. elongation : (n, 6). work : kinetic energy, and work of legs, stops, weight.
    """
    strips, stops = stored_in_strips(model, elongation), stored_in_stops(model, elongation)
    return {
        "kinetic": work["kinetic"],
        "stored_in_strips": strips,
        "stored_in_stops": stops,
        "lost_in_hysteresis": strips[0] - strips - work["by_legs"],
        "lost_in_stops": stops[0] - stops - work["by_stops"],
        "by_weight": work["by_weight"],
        **{f"by_{name}": values for name, values in effects.items()},
    }
