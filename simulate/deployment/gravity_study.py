"""The paper's gravity study (Aridon 2009, Fig. 16): what weight, counterweight and a stronger strip do to the elevation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from simulate.deployment.deploy import deploy_checked
from simulate.deployment.result import Deployment
from simulate.model.model import Gravity, Model

EARTH_M_PER_S2 = 9.81
FORCES = (1, 4)  # the real force cannot lift the weight, four times it can


@dataclass(frozen=True)
class Case:
    """One run of the study: gravity, mass and force, and what came of it."""

    gravity: Gravity
    times_the_force: int
    run: Deployment

    @property
    def label(self) -> str:
        """As a person names it: g, mass that moves, force."""
        mass = self.run.model.platform.mass_kg * self.gravity.mass_factor
        return f"g = {self.gravity.acceleration_m_per_s2:g} m/s2, {mass:.3g} kg, {self.times_the_force} x force"

    @property
    def column(self) -> str:
        """Name of its elevation in a table."""
        return self.label.replace("g = ", "z_g").replace(" m/s2, ", "_").replace(" kg, ", "kg_").replace(" x force", "x_m")

    @property
    def report(self) -> dict[str, Any]:
        """As the JSON of a deployment gives it."""
        return {
            "case": self.label,
            "acceleration_m_per_s2": self.gravity.acceleration_m_per_s2,
            "mass_factor": self.gravity.mass_factor,
            "times_the_force": self.times_the_force,
            "highest_m": float(np.nanmax(self.run.channels["z_m"])),
            **{key: self.run.summary[key] for key in ("time_to_full_height_s", "diverged_at_s", "energy_closure", "step_error")},
        }


def gravity_study(model: Model) -> list[Case]:
    """Six runs: under the platform's weight, with the counterweight's doubled mass, free of both; with the force and four times it."""
    gravities = (Gravity(EARTH_M_PER_S2, 1.0), Gravity(0.0, 2.0), Gravity(0.0, 1.0))
    return [Case(g, times, deploy_checked(_case(model, g, times))) for times in FORCES for g in gravities]


def elevation_columns(cases: Sequence[Case]) -> dict[str, Array]:
    """Time, and the elevation of each case, as the columns of a table."""
    return {"time_s": cases[0].run.time_s, **{case.column: case.run.channels["z_m"] for case in cases}}


def _case(model: Model, gravity: Gravity, times: int) -> Model:
    law = model.actuator
    scaled = {name: _times(getattr(law, name), times) for name in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "initial_force_N")}
    rate = law.rate
    if rate is not None:
        rate = replace(rate, **{name: _times(getattr(rate, name), times) for name in ("a_l", "b_l", "a_u", "b_u")})
    return replace(model, gravity=gravity, actuator=replace(law, **scaled, rate=rate, covariance=None))


def _times(value: Any, times: int) -> Any:
    return tuple(times * v for v in value) if isinstance(value, tuple) else times * value
