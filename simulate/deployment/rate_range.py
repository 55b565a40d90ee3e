"""What is assumed where asymptotes follow the speed, and where a deployment is faster than the loops they were fitted to."""

from __future__ import annotations

import numpy as np

from measure.common.arrays import Array
from simulate.effects.rate_dependent_asymptotes import RateDependentAsymptotes
from simulate.model.model import Model
from simulate.model.rig import Rate

_APART = 0.02  # of the mean stroke, by which strokes may differ and yet be one


def assumption_of(rate: Rate | None) -> list[str]:
    """The sentence on how polynomials of the frequency were taken against speed; none where they follow the speed itself."""
    if rate is None or rate.abscissa == "speed_m_per_s" or rate.speed_per_Hz is None:
        return []
    assumed = 1e3 * rate.speed_per_Hz / np.pi
    said = f"the asymptotes follow the cycling frequency; taken against speed at mid-stroke, v = 2 pi f A, with 2 A = {assumed:.3g} mm"
    strokes = 1e3 * np.array(rate.stroke_m)
    if not len(strokes) or np.ptp(strokes) <= _APART * strokes.mean():
        return [said]
    tail = "one frequency then has several speeds, so --rate speed is the safer fit"
    return [f"{said}, though the loops have strokes from {strokes.min():.3g} to {strokes.max():.3g} mm: {tail}"]


def beyond_the_loops(model: Model, time_s: Array, elongation_m: Array) -> list[str]:
    """The sentence on speeds that no loop had, with when the first leg reaches them; none where all stay within.

    Parameters
    ----------
    time_s, elongation_m : (n,) and (n, 6), of the deployment.
    """
    rate = model.actuator.rate
    follows = any(getattr(rate, line) for line in ("a_l", "b_l", "a_u", "b_u")) if rate else False
    if rate is None or not rate.mid_stroke_speed_m_per_s or not (follows or model.effect(RateDependentAsymptotes).flat().any()):
        return []
    fastest = max(rate.mid_stroke_speed_m_per_s)
    speed = np.max(np.abs(np.gradient(elongation_m, time_s, axis=0)), axis=1)
    beyond = np.flatnonzero(speed > fastest)
    if not len(beyond):
        return []
    return [
        f"the asymptotes were measured at speeds from {min(rate.mid_stroke_speed_m_per_s):.3g} to {fastest:.3g} m/s; from "
        f"{time_s[beyond[0]]:.3g} s on legs are faster, up to {np.nanmax(speed):.3g} m/s, and their polynomials are extrapolated. "
        "Record loops that are as fast, or, where the loop turns with the square of the frequency, fit hub-inertia instead"
    ]
