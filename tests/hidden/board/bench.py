"""The runs of a campaign as one vector of numbers over their noise. It never sees noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from simulate.deployment.deploy import deploy_many
from simulate.kernel.layout import SAMPLE_POSE
from simulate.model.effect import Effect
from simulate.model.model import Model, Simulation, with_value

from .camera import Motion, shown
from .campaigns import Campaign, Deployment, Shaking
from .rigs import Rig
from .shaker import cell_shows, kernel_force, stroke_of

Array = np.ndarray

DURATION_S, STEP_S = 0.65, 1.25e-4


def in_run(model: Model, run: Deployment) -> Model:
    """The model as it was in this run: what its conditions change, how it was let go, its legs of that day.

    A ballast is added to the platform that there is, whatever the file says of its mass.
    """
    beyond_file_kg = model.platform.mass_kg - run.file_mass_kg
    for key, value in run.changes.items():
        model = with_value(model, key, value + beyond_file_kg if key == "platform.mass_kg" else value)
    at = model.release
    release = replace(at, position_m=_plus(at.position_m, run.position_m), theta_rad=_plus(at.theta_rad, run.theta_rad))
    law = model.actuator.shifted(tuple(run.legs_N.tolist())) if np.any(run.legs_N) else model.actuator
    return replace(model, release=release, actuator=law)


def _plus(a: Sequence[float], b: Array) -> tuple[float, float, float]:
    x, y, z = (float(p + q) for p, q in zip(a, b, strict=True))
    return x, y, z


def motions(models: Sequence[Model], step_s: float = STEP_S, duration_s: float = DURATION_S) -> list[Motion]:
    """Deployments by the project's kernel, those of the same effects side by side."""
    rigs = [replace(m, simulation=Simulation(duration_s, 1000.0, step_s), effects=_inside(m.effects)) for m in models]
    groups: dict[tuple, list[int]] = {}
    for i, rig in enumerate(rigs):
        groups.setdefault(tuple(type(effect) for effect in rig.effects), []).append(i)
    made: dict[int, Motion] = {}
    for rows in groups.values():
        for i, run in zip(rows, deploy_many([rigs[i] for i in rows]), strict=True):
            made[i] = Motion(run.time_s, run.samples[:, SAMPLE_POSE : SAMPLE_POSE + 3], run.samples[:, SAMPLE_POSE + 3 : SAMPLE_POSE + 7])
    return [made[i] for i in range(len(rigs))]


def _inside(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """The effects that move the platform, not those of camera and load cell."""
    return tuple(effect for effect in effects if effect.acts_on != "measurement")


@dataclass(frozen=True)
class Bench:
    """A rig and the runs that take part in fitting."""

    rig: Rig
    campaign: Campaign

    @cached_property
    def films(self) -> tuple[Deployment, ...]:
        """Deployments that are not held out."""
        return tuple(run for run in self.campaign.deployments if not run.hold_out)

    @cached_property
    def loops(self) -> tuple[Shaking, ...]:
        """Loops that are not held out."""
        return tuple(run for run in self.campaign.shakings if not run.hold_out)

    @cached_property
    def reach_m(self) -> float:
        """How far the platform strays sideways at most, the median over the runs; a millimetre where nothing was filmed."""
        radii = [np.max(np.hypot(m.place_m[:, 0], m.place_m[:, 1])) for m in motions([in_run(self.rig.true, run) for run in self.films])]
        return float(np.median(radii)) if radii else 1e-3

    @cached_property
    def runs(self) -> tuple[Deployment | Shaking, ...]:
        """Both, films first."""
        return (*self.films, *self.loops)

    @cached_property
    def here(self) -> Array:
        """All measured values over their noise, (m,)."""
        return np.concatenate(seen([(self.rig.true, run) for run in self.runs]))

    @cached_property
    def rows(self) -> list[slice]:
        """Where each run's values stand among all."""
        lengths = [len(run.channels) * len(run.time_s) if isinstance(run, Deployment) else len(run.time_s) for run in self.runs]
        ends = np.cumsum([0, *lengths]).tolist()
        return [slice(*pair) for pair in pairwise(ends)]

    def vectors(self, models: Sequence[Model]) -> list[Array]:
        """All measured values over their noise for each model, (m,) each."""
        values, n = seen([(model, run) for model in models for run in self.runs]), len(self.runs)
        return [np.concatenate(values[i * n : (i + 1) * n]) for i in range(len(models))]

    def with_model(self, model: Model) -> Bench:
        """The same runs of another truth."""
        return replace(self, rig=replace(self.rig, true=model))


def seen(shots: Sequence[tuple[Model, Deployment | Shaking]]) -> list[Array]:
    """What every run of every model shows over its noise; films are simulated side by side."""
    films = [(model, run) for model, run in shots if isinstance(run, Deployment)]
    moved = iter(motions([in_run(model, run) for model, run in films]) if films else [])
    return [
        _film_vector(next(moved), run, model.effects) if isinstance(run, Deployment) else _loop_vector(model, run) for model, run in shots
    ]


def _film_vector(motion: Motion, run: Deployment, effects: tuple[Effect, ...]) -> Array:
    channels = shown(motion, run, effects)
    start = {name: channels[name][0] if run.zeroed else 0.0 for name in run.channels}
    values = np.concatenate([(channels[name] - start[name]) / run.sigma[name] for name in run.channels])
    return np.nan_to_num(values, nan=1e6)


def _loop_vector(model: Model, run: Shaking) -> Array:
    stroke = stroke_of(run)
    return cell_shows(kernel_force(model, stroke, run.start_force_N), stroke, run, model.effects) / run.sigma_N
