"""What comes out of a deployment: its motion, forces and energies sample by sample, and how exact they are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.arrays import Array
from measure.notebook.shown import Shown
from measure.tables.frames import frame_of
from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.deployment.energy import energy_balance
from simulate.deployment.legs_condition import condition_report
from simulate.deployment.rate_range import assumption_of, beyond_the_loops
from simulate.kernel.layout import LEGS, SAMPLE_ELONGATION, SAMPLE_ENERGY, SAMPLE_FORCE, SAMPLE_POSE, SAMPLE_SIZE
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.model.model import Model
from simulate.model.possible import warnings_of
from simulate.model.rig import geometry_of, leg_lengths, stroke_of

if TYPE_CHECKING:
    from pandas import DataFrame

# What films and other engines are compared at: a hundredth of a millimetre, a hundredth of a degree.
FINE_M, FINE_RAD = 1e-5, np.radians(0.01)


@dataclass(frozen=True)
class StepError:
    """Error of each channel over the whole run and up to the first stop: twice the largest difference from the run with half the step.

    Twice is what a method of first order would leave, as the chord of an asymptote that moves with the speed is; RK4 leaves a fifteenth
    of the half while the motion is smooth, and about the half across reversals and stops. Behind the stops errors grow, which is
    why both are told.
    """

    whole: Mapping[str, float]
    to_the_stops: Mapping[str, float]

    @property
    def fine(self) -> bool:
        """Whether no channel is off by more than a hundredth of a millimetre or of a degree."""
        return all(error <= (FINE_M if name.endswith("_m") else FINE_RAD) for name, error in self.whole.items())

    @cached_property
    def report(self) -> dict[str, Any]:
        """As the JSON of a deployment gives it."""
        return {"whole_run": dict(self.whole), "to_the_stops": dict(self.to_the_stops)}


@dataclass(frozen=True)
class Deployment(Shown, by="simulate.report.showing.ShowingDeployment"):
    """What a deployment did, sample by sample.

    time_s : (n,). samples : (n, SAMPLE_SIZE + len(effects_with_power)), six more with a controller, laid out as in `kernel.layout`,
        NaN from where the run diverged on.
    diverged_at_s : when the state went non-finite, or None. effects_with_power : effects whose work stands in the last columns.
    step_error : how exact it is, by a run with half the step; None where that was not computed.
    """

    model: Model
    time_s: Array
    samples: Array
    step_s: float
    diverged_at_s: float | None
    effects_with_power: tuple[str, ...] = ()
    step_error: StepError | None = None

    def __repr__(self) -> str:
        end = "" if self.diverged_at_s is None else f", diverged at {self.diverged_at_s:g} s"
        size = f"{len(self.time_s)} samples over {self.time_s[-1]:g} s, step {1e3 * self.step_s:g} ms"
        return f"Deployment({self.model.name!r:.60}, {size}{end})"

    def to_frame(self) -> DataFrame:
        """The whole run as a pandas frame, one row a sample; units in `frame.attrs["units"]`.

        Returns
        -------
        pandas.DataFrame
            time_s, the six channels, elongation, length and force of each leg, the energy balance; NaN from where it diverged on.
        """
        return frame_of({"time_s": self.time_s, **self.channels, **self.leg_columns, **self.energy_columns}, name=self.model.name)

    @cached_property
    def channels(self) -> dict[str, Array]:
        """The six deviations against time, by channel name, each (n,)."""
        return channels_of(self.samples)

    @property
    def trajectory(self) -> Trajectory:
        """The same as the table everybody exchanges."""
        return Trajectory(self.time_s, self.channels, name=self.model.name)

    @property
    def elongation_m(self) -> Array:
        """(n, 6) elongation of the legs."""
        return self.samples[:, SAMPLE_ELONGATION : SAMPLE_ELONGATION + LEGS]

    @property
    def leg_force_N(self) -> Array:
        """(n, 6) force with which the legs push the platform: law, stops and effects, before their inertia."""
        return self.samples[:, SAMPLE_FORCE : SAMPLE_FORCE + LEGS]

    @property
    def control_force_N(self) -> Array:
        """(n, 6) force of the controller on the legs, part of `leg_force_N`; zero without one."""
        if self.model.controller is None:
            return np.zeros((len(self.time_s), LEGS))
        return self.samples[:, SAMPLE_SIZE + len(self.effects_with_power) :]

    @property
    def work_J(self) -> dict[str, Array]:
        """Kinetic energy, and the work done so far by legs, stops, weight and all effects, each (n,)."""
        names = ("kinetic", "by_legs", "by_stops", "by_weight")
        work = {name: self.samples[:, SAMPLE_ENERGY + i] for i, name in enumerate(names)}
        return {**work, "by_effects": self.samples[:, SAMPLE_SIZE : SAMPLE_SIZE + len(self.effects_with_power)].sum(axis=1)}

    @property
    def effects_J(self) -> dict[str, Array]:
        """The work done so far by each effect with a force of its own, each (n,); negative, it has taken energy out."""
        columns: dict[str, Array] = {}
        for i, name in enumerate(self.effects_with_power):
            columns[name] = columns.get(name, 0.0) + self.samples[:, SAMPLE_SIZE + i]
        return columns

    @property
    def energy_J(self) -> dict[str, Array]:
        """The energy balance: what is kinetic, stored and lost, and the work of weight and effects, each (n,), J."""
        model = with_rate_worked_in(self.model).adjusted()
        return energy_balance(model, self.elongation_m, self.work_J, self.effects_J)

    @property
    def leg_columns(self) -> dict[str, Array]:
        """Time, and elongation, length and force of each leg, as the columns of a table."""
        g = geometry_of(self.model)
        stowed = leg_lengths(np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m), g.stowed_height_m)
        columns = {"time_s": self.time_s}
        for i in range(LEGS):
            columns[f"elongation_{i + 1}_m"] = self.elongation_m[:, i]
            columns[f"length_{i + 1}_m"] = self.elongation_m[:, i] + stowed[i]
            columns[f"force_{i + 1}_N"] = self.leg_force_N[:, i]
            if self.model.controller is not None:
                columns[f"control_{i + 1}_N"] = self.control_force_N[:, i]
        return columns

    @property
    def energy_columns(self) -> dict[str, Array]:
        """Time and the energy balance as the columns of a table, J."""
        return {"time_s": self.time_s, **{f"{name}_J": values for name, values in self.energy_J.items()}}

    @property
    def time_to_full_height_s(self) -> float | None:
        """When the platform's origin is first seen at the deployed height, or None."""
        there = self.channels["z_m"] >= geometry_of(self.model).deployed_height_m
        return float(self.time_s[np.argmax(there)]) if np.any(there) else None

    @property
    def theta_z_before_stop_deg(self) -> float | None:
        """The signed theta_z where its size is largest up to the first stop that a leg reaches, deg; behind it the stops decide."""
        reached = np.any(self.elongation_m > stroke_of(self.model.adjusted()), axis=1) | ~np.isfinite(self.channels["theta_z_rad"])
        before = self.channels["theta_z_rad"][: int(np.argmax(reached)) if reached.any() else len(reached)]
        return float(np.degrees(before[np.argmax(np.abs(before))])) if len(before) else None

    @property
    def summary(self) -> dict[str, Any]:
        """The run in a few numbers: what it reached, whether it can be trusted, and where the energy went."""
        theta_z = np.degrees(self.channels["theta_z_rad"])
        good = np.isfinite(theta_z)
        energies = {**self.work_J, **self.energy_J}
        return {
            "model": self.model.name,
            "duration_s": self.model.simulation.duration_s,
            "step_s": self.step_s,
            "diverged_at_s": self.diverged_at_s,
            "time_to_full_height_s": self.time_to_full_height_s,
            "theta_z_deg": float(theta_z[good][np.argmax(np.abs(theta_z[good]))]) if np.any(good) else None,
            "theta_z_before_stop_deg": self.theta_z_before_stop_deg,
            "legs_condition": condition_report(self.model, self.time_s, self.samples),
            "energy_closure": self.energy_closure,
            "energy_J": {name: float(values[good][-1]) if np.any(good) else None for name, values in energies.items()},
            "step_error": None if self.step_error is None else self.step_error.report,
            "warnings": self.warnings,
        }

    @property
    def warnings(self) -> list[str]:
        """What is odd about the model, and that a run which diverged is not to be trusted."""
        diverged = [] if self.diverged_at_s is None else [f"the run diverged at {self.diverged_at_s:g} s, so nothing of it is exact"]
        return [*warnings_of(self.model), *self.of_rates, *diverged]

    @property
    def of_rates(self) -> list[str]:
        """What was assumed of asymptotes that follow the speed, and whether legs were faster than the loops that told them."""
        good = np.isfinite(self.elongation_m).all(axis=1)
        beyond = beyond_the_loops(self.model, self.time_s[good], self.elongation_m[good]) if good.sum() > 1 else []
        return [*assumption_of(self.model.actuator.rate), *beyond]

    @property
    def energy_closure(self) -> float:
        """Largest gap between kinetic energy gained and work done, as a share of the largest kinetic energy; NaN where nothing moved."""
        good = np.isfinite(self.samples[:, SAMPLE_ENERGY])
        work = {name: values[good] for name, values in self.work_J.items()}
        most = float(np.max(work["kinetic"], initial=0.0))
        if most == 0.0:
            return math.nan
        done = work["by_legs"] + work["by_stops"] + work["by_weight"] + work["by_effects"]
        return float(np.max(np.abs(work["kinetic"] - work["kinetic"][0] - done)) / most)


def channels_of(samples: Array) -> dict[str, Array]:
    """The six channels from samples (..., n, SAMPLE): position and the swing-twist split of the rotation.

    theta_z = 2 atan2(q_z, q_w), unwrapped, is the rotation about the vertical; theta_x, theta_y are the components of the
    swing's rotation vector, so that turning the world or relabelling the legs changes nothing but their axes.
    """
    place = samples[..., SAMPLE_POSE : SAMPLE_POSE + 3]
    w, x, y, z = np.moveaxis(samples[..., SAMPLE_POSE + 3 : SAMPLE_POSE + 7], -1, 0)
    half = np.arctan2(z, w)
    theta_z = np.unwrap(2 * half, axis=-1)
    c, s = np.cos(half), np.sin(half)
    # swing = q conj(twist), its scalar part is never negative by the choice of the twist
    swing_w, swing_x, swing_y = w * c + z * s, x * c - y * s, y * c + x * s
    sine = np.hypot(swing_x, swing_y)
    factor = np.where(sine > 1e-9, 2 * np.arctan2(sine, swing_w) / np.where(sine > 1e-9, sine, 1.0), 2.0)
    return dict(zip(CHANNELS, (place[..., 0], place[..., 1], place[..., 2], factor * swing_x, factor * swing_y, theta_z), strict=True))
