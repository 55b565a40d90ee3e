"""What a controller is worth: failures among fresh draws with an exact bound, margins, and what others would do.

The bound is Clopper and Pearson's (1934): of n draws with k failures, the failure probability is below the quantile of the beta
distribution B(k + 1, n - k) with the stated confidence, whatever it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.control.task import LIMIT, Requirement
from simulate.control.trials import Trials, deployed, turned_deg
from simulate.model import responses
from simulate.model.control import Controller, SampledController
from simulate.model.rig import LEGS

LEAST_DRAWS, MOST_DRAWS = 4096, 200_000
_SPARE = 1.36  # times the draws that certify with no failure


def upper_bound(failures: int, of: int, confidence: float) -> float:
    """Upper bound of a probability that was met so many times, one-sided, exact."""
    from scipy.stats import beta

    return 1.0 if failures >= of else float(beta.ppf(confidence, failures + 1, of - failures))


def draws_for(requirements: Sequence[Requirement], confidence: float) -> int:
    """So many draws that no failure certifies the highest probability, and some to spare."""
    least = max(math.log(1.0 - confidence) / math.log(r.probability) for r in requirements)
    return max(LEAST_DRAWS, math.ceil(_SPARE * least))


def counted(answers: Array, requirements: Sequence[Requirement], confidence: float) -> list[dict[str, Any]]:
    """Of each requirement: failures in all and before the first stop, the upper bound of the failure probability, whether it is kept.

    A run that does not get to the full height has failed too.
    """
    rows, stuck = [], ~deployed(answers)
    for angle, probability in requirements:
        failures = int(np.sum(~(turned_deg(answers) < angle) | stuck))
        before = int(np.sum(~(turned_deg(answers, responses.BEFORE_STOP) < angle)))
        bound = upper_bound(failures, len(answers), confidence)
        rows.append(
            {
                "angle_deg": angle,
                "probability": probability,
                "failures": failures,
                "failures_before_stop": before,
                "failed_percent": 100.0 * failures / len(answers),
                "failed_before_stop_percent": 100.0 * before / len(answers),
                "upper_bound_percent": 100.0 * bound,
                "certified": bound <= 1.0 - probability,
            }
        )
    return rows


def described(answers: Array) -> dict[str, Any]:
    """What happened in trials: rotation, forces, energy, how many reached the full height."""
    turned = turned_deg(answers)
    return {
        "draws": len(answers),
        "diverged": int(np.sum(~np.isnan(answers[:, responses.DIVERGED]))),
        "theta_z_deg": {f"{q:g} %": _finite(np.quantile(turned, q / 100.0, method="higher")) for q in (50.0, 95.0, 99.9, 100.0)},
        "theta_z_before_stop_deg": _finite(np.max(turned_deg(answers, responses.BEFORE_STOP))),
        "control_force_N": _largest(answers, responses.CONTROL_FORCE),
        "control_energy_J": [_finite(np.nanmin(answers[:, responses.CONTROL_ENERGY])), _largest(answers, responses.CONTROL_ENERGY)],
        "stop_force_N": _largest(answers, responses.STOP_FORCE),
        "full_height_percent": 100.0 * float(np.mean(~np.isnan(answers[:, responses.FULL_HEIGHT]))),
        "full_height_s": _largest(answers, responses.FULL_HEIGHT),
    }


def _largest(answers: Array, place: int) -> float | None:
    good = answers[:, place][np.isfinite(answers[:, place])]
    return float(np.max(good)) if len(good) else None


def _finite(value: Any) -> float | None:
    return float(value) if np.isfinite(value) else None


def margins(controller: Controller, trials: Trials, requirements: Sequence[Requirement]) -> list[dict[str, Any]]:
    """What happens where delay, noise, lag or gains are other than they were taken to be, or a brake or a sensor fails."""
    rows = []
    for what, changed in _changes(controller):
        answers = np.vstack([trials.answers(one) for one in changed])
        worst = [{"angle_deg": r.angle_deg, "failed_percent": _failed(answers, r)} for r in requirements]
        rows.append({"change": what, "failed": worst, **described(answers)})
    return rows


def _failed(answers: Array, requirement: Requirement) -> float:
    return 100.0 * float(np.mean(~(turned_deg(answers) < requirement.angle_deg) | ~deployed(answers)))


def _changes(controller: Controller) -> list[tuple[str, list[Controller]]]:
    gains = [name for name in controller.gains() if name.endswith("_per_m")]
    rows = [(f"gains times {f:g}", [_times(controller, gains, f)]) for f in (0.5, 2.0, 4.0)]
    if isinstance(controller, SampledController):
        rows += [(f"{LIMIT} times {f:g}", [_times(controller, [LIMIT], f)]) for f in (0.8,)]
        for name in ("delay_s", "lag_s", "sensor_noise_m", "sensor_noise_rad"):
            if getattr(controller, name) > 0.0:
                rows += [(f"{name} times {f:g}", [_times(controller, [name], f)]) for f in (2.0, 4.0, 8.0)]
        if controller.sample_rate_Hz is not None:
            rows.append(("one sensor fails", [replace(controller, failed_sensor=leg + 1, failure_s=0.1) for leg in range(LEGS)]))
        stuck = controller.force_limit_N
        rows.append(("one brake stuck", [replace(controller, failed_brake=leg + 1, stuck_force_N=stuck) for leg in range(LEGS)]))
    rows.append(("one brake dead", [replace(controller, failed_brake=leg + 1) for leg in range(LEGS)]))
    return rows


def _times(controller: Controller, names: Sequence[str], factor: float) -> Controller:
    changed: Mapping[str, Any] = {name: factor * getattr(controller, name) for name in names}
    return replace(controller, **changed)
