"""The regression turned round: how well the stored forces must agree to keep the platform from turning, and what to do about it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import permutations
from typing import Any, NamedTuple

import numpy as np

from measure.common.arrays import Array
from simulate.model import responses
from simulate.model.model import Model
from simulate.model.rig import LEGS, per_leg
from simulate.sweeps.sweep import responses_of, wilson

# Small against what the paper varies, large against rounding: 0.1 % of the mean stored force either way.
_STEP_SHARE = 1e-3
ANGLES_DEG = (5.0, 30.0)
PROBABILITY = 0.95
_TRIALS = 256
_CURVE = (0.25, 0.5, 1.0, 2.0, 4.0)


class SpreadTrial(NamedTuple):
    """Trials with normal stored forces: their spread, the angle kept with the stated probability, the share within the angle asked for."""

    spread_N: float
    angle_deg: float
    share: float
    interval: tuple[float, float]


def gradient_deg_per_N(model: Model) -> Array:
    """(6,) slope of the signed largest theta_z over the stored force of each leg, at the model itself."""
    step = _STEP_SHARE * (float(np.abs(per_leg(model.actuator.b_l_N)).mean()) or 1.0)
    shifts = step * np.vstack([np.eye(LEGS), -np.eye(LEGS)])
    answers = theta_z_deg(model, shifts)
    return (answers[:LEGS] - answers[LEGS:]) / (2 * step)


def theta_z_deg(model: Model, shifts: Array) -> Array:
    """(runs,) signed largest theta_z with the stored forces shifted by each row of (runs, 6), N."""
    rigs = [replace(model, actuator=model.actuator.shifted(tuple(row))) for row in shifts]
    return np.degrees(responses_of(rigs)[:, responses.THETA_Z])


def spread_N(gradient: Array, angle_deg: float, probability: float) -> float:
    """Standard deviation of independent normal stored forces that keeps abs(theta_z) under the angle.

    s = angle / (z |g|)        z the two-sided normal quantile of the probability

    Linear in the forces, about a rig that does not turn; `tried_spread` says what comes of it.
    """
    from scipy.stats import norm

    size = float(np.linalg.norm(gradient))
    return angle_deg / (float(norm.ppf((1 + probability) / 2)) * size) if size > 0 else np.inf


def tried_spread(model: Model, spread: float, angle_deg: float, probability: float, seed: int = 0) -> SpreadTrial:
    """Simulated and not extrapolated: how far the platform turns with stored forces of this spread."""
    drawn = np.random.default_rng([seed, 7]).normal(0.0, spread, (_TRIALS, LEGS))
    turned = np.abs(theta_z_deg(model, drawn))
    turned = turned[np.isfinite(turned)]
    within = int(np.sum(turned < angle_deg))
    share = within / len(turned) if len(turned) else np.nan
    return SpreadTrial(spread, float(np.quantile(turned, probability)) if len(turned) else np.nan, share, wilson(within, len(turned)))


def tolerance_of(
    model: Model, angles_deg: Sequence[float] = ANGLES_DEG, probability: float = PROBABILITY, seed: int = 0
) -> Mapping[str, Any]:
    """What the JSON of a sweep says about tolerances.

    Parameters
    ----------
    model : Model
        The rig as it is nominally.
    angles_deg : within which theta_z is to stay.
    probability : with which it is to stay there.
    seed : of the runs that are simulated to check the spreads.

    Returns
    -------
    Mapping
        Slopes; spreads by angle, N, and the share of simulated runs that kept it; the curve of angle over spread; the leg that turns the
        platform most; by how much to adjust it, or how to sort the legs, where the model itself turns.
    """
    gradient = gradient_deg_per_N(model)
    good = bool(np.all(np.isfinite(gradient)) and np.any(gradient))
    spreads = {angle: spread_N(gradient, angle, probability) for angle in angles_deg} if good else {}
    tried = {angle: tried_spread(model, spread, angle, probability, seed) for angle, spread in spreads.items()}
    return {
        "slope_deg_per_N": gradient,
        "probability": probability,
        "stored_force_spread_N": {f"{angle:g}": spreads.get(angle) for angle in angles_deg},
        "simulated": {f"{angle:g}": {"share": k.share, "interval": k.interval, "runs": _TRIALS} for angle, k in tried.items()},
        "curve": _curve(model, spreads, probability, seed),
        "most_sensitive_leg": int(np.argmax(np.abs(gradient))) + 1 if good else None,
        "adjust": _adjusted(model, gradient) if good else None,
        "sort": _sorted_legs(model, gradient) if good else None,
    }


def _curve(model: Model, spreads: Mapping[float, float], probability: float, seed: int) -> list[dict[str, float]]:
    """Angle kept with the probability, over spreads around those asked for."""
    if not spreads:
        return []
    middle = float(np.exp(np.mean(np.log(list(spreads.values())))))
    points = [tried_spread(model, share * middle, np.inf, probability, seed) for share in _CURVE]
    return [{"spread_N": point.spread_N, "angle_deg": point.angle_deg} for point in points]


def _adjusted(model: Model, gradient: Array) -> dict[str, Any]:
    """By how much to change the most sensitive leg's stored force so that the rig itself does not turn, and what is left then."""
    leg = int(np.argmax(np.abs(gradient)))
    before = float(theta_z_deg(model, np.zeros((1, LEGS)))[0])
    by = -before / float(gradient[leg])
    after = float(theta_z_deg(model, by * np.eye(LEGS)[leg : leg + 1])[0])
    return {"leg": leg + 1, "by_N": by, "theta_z_before_deg": before, "theta_z_after_deg": after}


def _sorted_legs(model: Model, gradient: Array) -> dict[str, Any] | None:
    """Which leg to put where, of the six that the model has, for the least rotation; None where all are alike.

    All 720 orders are compared by the slopes, the best is simulated: `order[i]` is the leg that goes to place i + 1.
    """
    force = per_leg(model.actuator.b_l_N)
    if np.ptp(force) == 0.0:
        return None
    orders = np.array(list(permutations(range(LEGS))))
    best = orders[np.argmin(np.abs((force[orders] - force.mean()) @ gradient))]
    after = float(theta_z_deg(model, (force[best] - force)[None])[0])
    return {"order": [int(leg) + 1 for leg in best], "theta_z_after_deg": after}
