"""One deployment, or many: from a model to what the platform does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.common.arrays import Array
from measure.tables.trajectory import CHANNELS, Trajectory
from simulate.deployment.energy import ledger_of
from simulate.dispatch.programs import workers
from simulate.files.speed_polynomials import with_rate_as_effect
from simulate.kernel import integrator as six_legs
from simulate.kernel.layout import ALONE, FEW, MANY
from simulate.kernel.model_rows import (
    geometry_of,
    leg_lengths,
    program_of,
    row_of,
    without_idle,
    working_effects,
)
from simulate.kernel.rk_stage import stage
from simulate.kernel.step_division import WHOLE, Pace
from simulate.kernel.step_size import grid, step_of
from simulate.model.model import LEGS, Model

if TYPE_CHECKING:
    from simulate.deployment.accuracy import StepError

__all__ = ["Deployment", "channels_of", "deploy", "deploy_many", "grid", "step_of"]


@dataclass(frozen=True)
class Deployment:
    """What a deployment did, sample by sample.

    time_s : (n,). samples : (n, SAMPLE + worked_by) as laid out in `six_legs`, NaN from the sample on at which the run diverged.
    diverged_at_s : when the state went non-finite, or None. worked_by : effects whose work stands in the last columns.
    step_error : how exact it is, by a run with half the step; None where that was not computed.
    """

    model: Model
    time_s: Array
    samples: Array
    step_s: float
    diverged_at_s: float | None
    worked_by: tuple[str, ...] = ()
    step_error: StepError | None = None

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
        return self.samples[:, six_legs.ELONGATION : six_legs.ELONGATION + LEGS]

    @property
    def leg_force_N(self) -> Array:
        """(n, 6) force with which the legs push the platform: law, stops and effects, before their inertia."""
        return self.samples[:, six_legs.FORCE : six_legs.FORCE + LEGS]

    @property
    def work_J(self) -> dict[str, Array]:
        """Kinetic energy, and the work done so far by legs, stops, weight and all effects, each (n,)."""
        names = ("kinetic", "by_legs", "by_stops", "by_weight")
        work = {name: self.samples[:, six_legs.ENERGY + i] for i, name in enumerate(names)}
        return {**work, "by_effects": self.samples[:, six_legs.SAMPLE :].sum(axis=1)}

    @property
    def effects_J(self) -> dict[str, Array]:
        """The work done so far by each effect with a force of its own, each (n,); negative, it has taken energy out."""
        columns: dict[str, Array] = {}
        for i, name in enumerate(self.worked_by):
            columns[name] = columns.get(name, 0.0) + self.samples[:, six_legs.SAMPLE + i]
        return columns

    @property
    def energy_J(self) -> dict[str, Array]:
        """The ledger: what is kinetic, stored and lost, and the work of weight and effects, each (n,)."""
        model = with_rate_as_effect(self.model).adjusted()
        return ledger_of(model, self.elongation_m, self.work_J, self.effects_J)

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
        return columns

    @property
    def energy_columns(self) -> dict[str, Array]:
        """Time and the ledger as the columns of a table."""
        return {"time_s": self.time_s, **{f"{name}_J": values for name, values in self.energy_J.items()}}

    @property
    def time_to_full_height_s(self) -> float | None:
        """When the platform's origin is first seen at the deployed height, or None."""
        there = self.channels["z_m"] >= geometry_of(self.model).deployed_height_m
        return float(self.time_s[np.argmax(there)]) if np.any(there) else None

    @property
    def summary(self) -> dict[str, Any]:
        """The run in a few numbers: what it reached, whether it can be trusted, and where the energy went."""
        theta_z = np.degrees(self.channels["theta_z_rad"])
        good = np.isfinite(theta_z)
        ledger = {**self.work_J, **self.energy_J}
        return {
            "model": self.model.name,
            "duration_s": self.model.simulation.duration_s,
            "step_s": self.step_s,
            "diverged_at_s": self.diverged_at_s,
            "time_to_full_height_s": self.time_to_full_height_s,
            "theta_z_deg": float(theta_z[good][np.argmax(np.abs(theta_z[good]))]) if np.any(good) else None,
            "energy_closure": self.energy_closure,
            "energy_J": {name: float(values[good][-1]) if np.any(good) else None for name, values in ledger.items()},
            "step_error": None if self.step_error is None else self.step_error.report,
        }

    @property
    def energy_closure(self) -> float:
        """Largest gap between kinetic energy gained and work done, as a share of the largest kinetic energy; NaN where nothing moved."""
        good = np.isfinite(self.samples[:, six_legs.ENERGY])
        ledger = {name: values[good] for name, values in self.work_J.items()}
        most = float(np.max(ledger["kinetic"], initial=0.0))
        if most == 0.0:
            return math.nan
        work = ledger["by_legs"] + ledger["by_stops"] + ledger["by_weight"] + ledger["by_effects"]
        return float(np.max(np.abs(ledger["kinetic"] - ledger["kinetic"][0] - work)) / most)


def channels_of(samples: Array) -> dict[str, Array]:
    """The six channels from samples (..., n, SAMPLE): position and the swing-twist split of the rotation.

    theta_z = 2 atan2(q_z, q_w), unwrapped, is the rotation about the vertical; theta_x, theta_y are the components of the
    swing's rotation vector, so that turning the world or relabelling the legs changes nothing but their axes.
    """
    place = samples[..., six_legs.POSE : six_legs.POSE + 3]
    w, x, y, z = np.moveaxis(samples[..., six_legs.POSE + 3 : six_legs.POSE + 7], -1, 0)
    half = np.arctan2(z, w)
    theta_z = np.unwrap(2 * half, axis=-1)
    c, s = np.cos(half), np.sin(half)
    # swing = q conj(twist), its scalar part is never negative by the choice of the twist
    swing_w, swing_x, swing_y = w * c + z * s, x * c - y * s, y * c + x * s
    sine = np.hypot(swing_x, swing_y)
    factor = np.where(sine > 1e-9, 2 * np.arctan2(sine, swing_w) / np.where(sine > 1e-9, sine, 1.0), 2.0)
    return dict(zip(CHANNELS, (place[..., 0], place[..., 1], place[..., 2], factor * swing_x, factor * swing_y, theta_z), strict=True))


def deploy(model: Model) -> Deployment:
    """Simulate one deployment.

    Raises
    ------
    InputError
        The model has no geometry, or would take too many steps.
    """
    return _alone(model, WHOLE, leads=False)


def deploy_ahead(model: Model) -> tuple[Deployment, Pace]:
    """Simulate one deployment whose steps are divided where a leg runs into a stop, and how they are, for others to follow.

    Raises
    ------
    InputError
        As `deploy`.
    """
    _, stride, count = grid(model)
    pace = np.ones(stride * count, dtype=np.int64)
    return _alone(model, pace, leads=True), pace


def _alone(model: Model, pace: Pace, *, leads: bool) -> Deployment:
    step, stride, count = grid(model)
    acting = without_idle([model])[0]
    called = program_of(acting)
    samples, good = np.empty((1, count, six_legs.SAMPLE + workers(called))), np.empty(1, dtype=np.int64)
    compiled = stage(ALONE, True).address
    six_legs.deploy_block(row_of(acting)[None], 0, called, compiled, ALONE, step, stride, pace, leads, samples, good)
    time_s = np.arange(count) / model.simulation.sample_rate_Hz
    return Deployment(model, time_s, samples[0], step, None if good[0] == count else float(time_s[good[0]]), working_effects(acting))


def deploy_many(models: Sequence[Model], pace: Pace | None = None, *, one_core: bool = False) -> list[Deployment]:
    """Simulate deployments that share effects, duration and sampling, on all cores.

    The answer of each is the same to the last digit whatever the number of cores, and as from `deploy` with the same step.

    Parameters
    ----------
    pace : into how many parts each step is divided, from `deploy_ahead`; by default none is.
    one_core : for threads that keep the other cores busy themselves.
    """
    kernel = six_legs.deploy_on_one_core if one_core else six_legs.deploy_kernel
    first = models[0]
    if any(_kinds(model) != _kinds(first) or model.simulation != first.simulation for model in models):
        raise ValueError("deploy_many: models must share the kinds of their effects, and duration, rate and step.")
    step, stride, count = min((grid(model) for model in models), key=lambda g: g[0])
    acting = without_idle(models)
    rows = np.array([row_of(model) for model in acting])
    called = program_of(acting[0])
    samples = np.empty((len(models), count, six_legs.SAMPLE + workers(called)))
    good = np.empty(len(models), dtype=np.int64)
    parts = WHOLE if pace is None else pace
    for width, block in _widths(len(models)):
        kernel(rows[block], called, stage(width, True).address, width, step, stride, parts, samples[block], good[block])
    time_s = np.arange(count) / first.simulation.sample_rate_Hz
    return [
        Deployment(model, time_s, samples[i], step, None if good[i] == count else float(time_s[good[i]]), working_effects(acting[0]))
        for i, model in enumerate(models)
    ]


def _widths(runs: int) -> list[tuple[int, slice]]:
    """How many stand side by side, and which: a block costs nearly the same whether or not all its places are taken."""
    rest = runs % MANY
    many = runs - rest if rest <= MANY // 2 else runs
    few = (runs - many + 1) // FEW * FEW
    ends = [(MANY, 0, many), (FEW, many, min(many + few, runs)), (ALONE, min(many + few, runs), runs)]
    return [(width, slice(first, last)) for width, first, last in ends if last > first]


def _kinds(model: Model) -> list[type]:
    return [type(effect) for effect in with_rate_as_effect(model).effects]
