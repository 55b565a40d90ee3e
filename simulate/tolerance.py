"""The regression turned round: how well the stored forces must agree to keep the platform from turning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from measure.tables import Array

from . import responses
from .designs import Design, Factor
from .model import LEGS, Model, per_leg
from .sweep import Sweep

# Small against what the paper varies, large against rounding: 0.1 % of the mean stored force either way.
_STEP_SHARE = 1e-3
ANGLES_DEG = (5.0, 30.0)
PROBABILITY = 0.95


def gradient_deg_per_N(model: Model) -> Array:
    """(6,) slope of the signed largest theta_z over the stored force of each leg, at the model itself."""
    law = model.actuator
    level = np.abs(per_leg(law.b_l_N))
    even = replace(model, actuator=replace(law, b_l_N=tuple(per_leg(law.b_l_N)), b_u_N=tuple(per_leg(law.b_u_N))))
    step = _STEP_SHARE * (float(level.mean()) or 1.0)
    factors = tuple(Factor(str(leg), f"actuator.b_l_N[{leg}]", b - step, b + step) for leg, b in enumerate(per_leg(law.b_l_N)))
    coded = np.vstack([np.eye(LEGS), -np.eye(LEGS)])
    design = Design("star", 2 * LEGS, LEGS, lambda first, last: coded[first:last])
    answers = np.degrees(Sweep(even, factors, design).responses(0, 2 * LEGS)[:, responses.THETA_Z])
    return (answers[:LEGS] - answers[LEGS:]) / (2 * step)


def spread_N(gradient: Array, angle_deg: float, probability: float) -> float:
    """Standard deviation of independent normal stored forces that keeps abs(theta_z) under the angle.

    s = angle / (z |g|)        z the two-sided normal quantile of the probability

    Linear in the forces; beyond about 0.1 N a leg the response bends.
    """
    from scipy.stats import norm

    size = float(np.linalg.norm(gradient))
    return angle_deg / (float(norm.ppf((1 + probability) / 2)) * size) if size > 0 else np.inf


def tolerance_of(model: Model, angles_deg: Sequence[float] = ANGLES_DEG, probability: float = PROBABILITY) -> Mapping[str, Any]:
    """What the JSON of a sweep says about tolerances: slopes, spreads by angle, and the leg that turns the platform most."""
    gradient = gradient_deg_per_N(model)
    good = bool(np.all(np.isfinite(gradient)))
    return {
        "slope_deg_per_N": gradient,
        "probability": probability,
        "stored_force_spread_N": {f"{angle:g}": spread_N(gradient, angle, probability) if good else None for angle in angles_deg},
        "most_sensitive_leg": int(np.argmax(np.abs(gradient))) + 1 if good else None,
    }
