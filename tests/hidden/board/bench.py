"""The runs of a campaign as one vector of numbers over their noise, and how it changes with everything that is free.

This is the generator's own linear view of a case. It never sees noise; it is laid around the truth with nothing hidden.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from simulate.deployment import deploy_many
from simulate.effect import Effect
from simulate.model import LEGS, Model, Simulation, with_value
from simulate.six_legs import POSE

from .camera import Motion, shown
from .campaigns import Campaign, Deployment, Shaking
from .detectable import Free, Variant, free_of
from .rigs import Rig
from .shaker import cell_shows, kernel_force, stroke_of
from .shapes import Hidden

Array = np.ndarray

LAW = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")
WEAK_FORCE, WEAK_BETA = 0.2, 0.8  # what a model file is trusted with, in parts of the force and of beta
CAMERA_DISTANCE_M = 2.0  # a release nearer by its spread makes a film's lengths longer by spread over distance
DURATION_S, STEP_S = 0.65, 1.25e-4
_NUDGE = 1e-3


def in_run(model: Model, run: Deployment) -> Model:
    """The model as it was in this run: what its conditions change, how it was let go, its legs of that day."""
    for key, value in run.changes.items():
        model = with_value(model, key, value)
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
            made[i] = Motion(run.time_s, run.samples[:, POSE : POSE + 3], run.samples[:, POSE + 3 : POSE + 7])
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

    def vectors(self, models: Sequence[Model]) -> list[Array]:
        """All measured values over their noise, one vector (m,) for each model."""
        cases = [(model, run) for model in models for run in self.films]
        seen = self._seen(cases)
        n = len(self.films)
        return [np.concatenate([*seen[i * n : (i + 1) * n], *(_loop_vector(m, run) for run in self.loops)]) for i, m in enumerate(models)]

    def _seen(self, cases: Sequence[tuple[Model, Deployment]]) -> list[Array]:
        moved = motions([in_run(model, run) for model, run in cases]) if cases else []
        return [_film_vector(motion, run, model.effects) for motion, (model, run) in zip(moved, cases, strict=True)]

    @cached_property
    def here(self) -> Array:
        """The vector with nothing hidden."""
        return self.vectors([self.rig.true])[0]

    @cached_property
    def free(self) -> Free:
        """What law and releases can do, with their priors as further rows."""
        law, law_prior = self._law_columns()
        own, own_prior = self._own_columns()
        columns = np.column_stack([law, own])
        prior = np.concatenate([law_prior, own_prior])
        return free_of(np.vstack([columns, np.diag(prior)]))

    def freed(self, change: Array) -> Array:
        """A change of the measured values (m,), freed of what law and releases can do."""
        return self.free.left(np.concatenate([change, np.zeros(len(self.free.basis) - len(change))]))

    def _law_columns(self) -> tuple[Array, Array]:
        law, model = self.rig.true.actuator, self.rig.true
        level = float(np.mean(law.b_l_N))
        sizes = dict.fromkeys(LAW, WEAK_FORCE * level)
        sizes |= {"a_l_N_per_m": 2 * WEAK_FORCE * level / 0.4, "a_u_N_per_m": 2 * WEAK_FORCE * level / 0.4}
        sizes["beta_per_m"] = WEAK_BETA * float(np.mean(law.beta_per_m))
        moved = [with_value(model, f"actuator.{key}", getattr(law, key) + _NUDGE * size) for key, size in sizes.items()]
        columns = [(vector - self.here) / _NUDGE for vector in self.vectors(moved)]
        return np.stack(columns, axis=1), np.ones(len(columns))

    def _own_columns(self) -> tuple[Array, Array]:
        """Columns of what each run has of its own, and whether each has a prior."""
        rows = [(i, nudged, size) for i, run in enumerate(self.films) for nudged, size in _nudged(run, self.rig.known)]
        seen = self._seen([(self.rig.true, nudged) for _, nudged, _ in rows])
        starts = np.cumsum([0, *(len(run.channels) * len(run.time_s) for run in self.films)])
        columns, priors = [], []
        for (i, _, _), vector in zip(rows, seen, strict=True):
            block = slice(starts[i], starts[i + 1])
            columns.append(self._placed(block.start, (vector - self.here[block]) / _NUDGE))
            priors.append(1.0)
        for i, run in enumerate(self.films):
            if run.zeroed:
                extra = _datum_and_scale(run, self.here[starts[i] : starts[i + 1]], self.rig.known)
                columns += [self._placed(int(starts[i]), column) for column in extra]
                priors += [1.0] * len(extra)
        place = int(starts[-1])
        for run in self.loops:
            column = _loop_vector(self.rig.true, replace(run, start_force_N=run.start_force_N + 1e-3)) - _loop_vector(self.rig.true, run)
            columns.append(self._placed(place, column / 1e-3))
            priors.append(0.0)
            place += len(column)
        if not columns:
            return np.empty((len(self.here), 0)), np.empty(0)
        return np.stack(columns, axis=1), np.array(priors)

    def _placed(self, start: int, values: Array) -> Array:
        column = np.zeros(len(self.here))
        column[start : start + len(values)] = values
        return column

    def change(self, hidden: Hidden, amount: float) -> Array:
        """What an effect of this amount changes, (m,), freed."""
        (vector,) = self.vectors([self.rig.true.with_effect(hidden.at(amount))])
        return self.freed(vector - self.here)

    def variants(self, lines: Sequence[tuple[Hidden, ...]]) -> list[Variant]:
        """Rivals, shape by shape, each amount changed by a thousandth of a noticeable size (a play of the legs by all of it)."""
        flat = [(hidden, _small(hidden)) for group in lines for hidden in group]
        vectors = iter(self.vectors([self.rig.true.with_effect(hidden.at(amount)) for hidden, amount in flat]))
        made = []
        for group in lines:
            columns = [self.freed(next(vectors) - self.here) / _small(hidden) for hidden in group]
            ends = [(-replace(h, direction=-h.direction).most, h.most) for h in group]
            low, high = (np.array([end[side] for end in ends]) for side in (0, 1))
            made.append(Variant(group[0].name, np.stack(columns, axis=1), np.minimum(low, 0.0), np.maximum(high, 0.0)))
        return made


def _small(hidden: Hidden) -> float:
    return 1.0 if hidden.name == "backlash" else _NUDGE


def _film_vector(motion: Motion, run: Deployment, effects: tuple[Effect, ...]) -> Array:
    channels = shown(motion, run, effects)
    start = {name: channels[name][0] if run.zeroed else 0.0 for name in run.channels}
    values = np.concatenate([(channels[name] - start[name]) / run.sigma[name] for name in run.channels])
    return np.nan_to_num(values, nan=1e6)


def _loop_vector(model: Model, run: Shaking) -> Array:
    stroke = stroke_of(run)
    return cell_shows(kernel_force(model, stroke, run.start_force_N), stroke, run, model.effects) / run.sigma_N


def _nudged(run: Deployment, known: Model) -> list[tuple[Deployment, float]]:
    """The run let go a little elsewhere and later, each by a thousandth of its spread."""
    spread = known.nuisance
    rows: list[tuple[str, Any, float]] = []
    rows += [("position_m", axis, spread.release_position_m) for axis in range(3)]
    rows += [("theta_rad", axis, spread.release_theta_rad) for axis in range(3)]
    rows += [("legs_N", leg, spread.stored_force_N) for leg in range(LEGS) if spread.stored_force_N > 0]
    made = []
    for key, axis, size in rows:
        values = getattr(run, key).copy()
        values[axis] += _NUDGE * size
        made.append((replace(run, **{key: values}), size))
    made.append((replace(run, instant_s=run.instant_s + _NUDGE * spread.release_instant_s), spread.release_instant_s))
    return made


def _datum_and_scale(run: Deployment, here: Array, known: Model) -> list[Array]:
    """A film counts from its first frame: that frame's error stands in all others, and its scale is known only so well."""
    n = len(run.time_s)
    made = [np.where(np.arange(len(here)) // n == i, 1.0, 0.0) for i in range(len(run.channels))]
    lengths = np.repeat([name.endswith("_m") for name in run.channels], n)
    made.append(np.where(lengths, here, 0.0) * known.nuisance.release_position_m / CAMERA_DISTANCE_M)
    return made
