"""The leg that runs inside an FMU. What stands here and in `simulate.law.restoring_force` is copied into it as source, so it uses no more.

`simulate.files.leg_fmu` puts it together; it is imported for that only, as it needs pythonfmu3.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from pythonfmu3 import Float64, Fmi3Causality, Fmi3Initial, Fmi3Slave, Fmi3StepResult, Fmi3Variability, Unit

from simulate.law import restoring_force

UNITS = {
    "s": {"s": 1},
    "m": {"m": 1},
    "m/s": {"m": 1, "s": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "1/m": {"m": -1},
}
STATE = ("last_u_m", "last_speed_m_per_s", "last_force_N")


def turning_point(start: float, end: float, start_slope: float, end_slope: float) -> float:
    """The elongation between two others at which a cubic with these slopes (times the step) turns; the end where it does not."""
    if start_slope * end_slope >= 0.0:
        return end
    way = end - start
    a, b, c = 3.0 * (start_slope + end_slope - 2.0 * way), 3.0 * way - 2.0 * start_slope - end_slope, start_slope
    q = -(b + math.copysign(math.sqrt(b * b - a * c), b))
    s = next(root for root in (c / q if q else -1.0, q / a if a else -1.0) if 0.0 <= root <= 1.0)
    return start + s * (start_slope + s * (b + s * a / 3.0))


class Leg(Fmi3Slave):
    """Force of a leg against its elongation: exact along a step, and along both parts of a step in which the speed turns round."""

    a_l_N_per_m: float
    b_l_N: float
    a_u_N_per_m: float
    b_u_N: float
    beta_per_m: float
    initial_force_N: float

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        about = json.loads((Path(self.resources or ".") / "law.json").read_text(encoding="utf-8"))
        self.description, self.version = about["description"], about["version"]
        self.register_units([Unit(name, **base) for name, base in UNITS.items()])
        for name, (value, unit, what) in about["parameters"].items():
            setattr(self, name, value)
            kind = {"causality": Fmi3Causality.parameter, "variability": Fmi3Variability.tunable, "initial": Fmi3Initial.exact}
            self.register_variable(Float64(name, unit=unit, description=what, **kind))
        self.time = 0.0
        self.register_variable(Float64("time", unit="s", causality=Fmi3Causality.independent, variability=Fmi3Variability.continuous))
        self.u_m = self.speed_m_per_s = self.last_u_m = self.last_speed_m_per_s = 0.0
        self.last_force_N = self.initial_force_N
        for name, (unit, what) in about["inputs"].items():
            self.register_variable(Float64(name, unit=unit, description=what, causality=Fmi3Causality.input))
        self.register_variable(
            Float64("force_N", unit="N", description=about["output"], causality=Fmi3Causality.output, getter=lambda: self.last_force_N)
        )

    def exit_initialization_mode(self) -> None:
        """The leg begins at the elongation that is set, with the initial force."""
        self.last_u_m, self.last_speed_m_per_s, self.last_force_N = self.u_m, self.speed_m_per_s, self.initial_force_N

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """The force at the elongation that is set, which is that at the end of the step."""
        slopes = step_size * self.last_speed_m_per_s, step_size * self.speed_m_per_s
        self._move(turning_point(self.last_u_m, self.u_m, *slopes))
        self._move(self.u_m)
        self.last_speed_m_per_s = self.speed_m_per_s
        self.time = current_time + step_size
        return Fmi3StepResult()

    def _move(self, u: float) -> None:
        if u == self.last_u_m:
            return
        side = "l" if u > self.last_u_m else "u"
        line = getattr(self, f"a_{side}_N_per_m"), getattr(self, f"b_{side}_N")
        self.last_force_N = float(restoring_force(u, self.last_u_m, self.last_force_N, *line, self.beta_per_m))
        self.last_u_m = u

    def _get_fmu_state(self) -> dict[str, float]:
        names = [variable.name for variable in self.vars.values() if variable.causality != Fmi3Causality.output]
        return {name: getattr(self, name) for name in (*names, *STATE)}

    def _set_fmu_state(self, state: dict[str, float]) -> None:
        for name, value in state.items():
            setattr(self, name, value)
