"""What the film of a run would show, were the model true: the deployment, seen through clock and camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.deployment.deploy import channels_of, deploy_with_division, poses_beside
from simulate.dispatch.formulas import SIGNATURES
from simulate.dispatch.threads import others_busy
from simulate.kernel.layout import POSE_SIZE
from simulate.kernel.model_rows import without_idle
from simulate.kernel.speed_polynomials import with_rate_worked_in
from simulate.kernel.step_division import StepDivision
from simulate.kernel.step_size import step_of
from simulate.model.effect import Effect
from simulate.model.model import Model, Nuisance, per_leg
from simulate.model.rig import altered

_MARGIN_S = 0.05
_NEAREST = 6
_MOST_SAMPLES_A_SECOND = 2e4  # between which poses are interpolated; more cost memory and show nothing
_EXACT = Nuisance()
_LONGEST_FLIGHT_S = 1e-3  # where nothing is stiff: exact to half a micrometre
_SHORTEST_STEP_S = 1.25e-4  # however stiff an effect is; steps are divided at the stops, for a film sees micrometres


@dataclass(frozen=True)
class RunRelease:
    """What one run did of its own: where and when it was released, and by how much its legs differed that day."""

    position_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    theta_rad: tuple[float, ...] = (0.0, 0.0, 0.0)
    instant_s: float = 0.0
    stored_force_N: tuple[float, ...] = (0.0,) * 6
    stored_force_fraction: float = 0.0


def released(model: Model, release: RunRelease) -> Model:
    """The model with a run's own release worked in (its instant is the clock's business)."""
    at = model.release
    moved = altered(at, position_m=_sum(at.position_m, release.position_m), theta_rad=_sum(at.theta_rad, release.theta_rad))
    changed = altered(model, release=moved)
    stored = release.stored_force_fraction * per_leg(changed.actuator.b_l_N) + np.asarray(release.stored_force_N)
    return altered(changed, actuator=changed.actuator.shifted(tuple(stored.tolist()))) if np.any(stored) else changed


def _sum(a: Sequence[float], b: Sequence[float]) -> tuple[float, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))


def rig_time(effects: Sequence[Effect], shown_s: Array, onset_s: float | None = None) -> Array:
    """The rig's time, from the clock of the camera.

    Parameters
    ----------
    onset_s : when the motion began on a clock that was set by that, whatever it showed before; such a clock is right there.
    """
    times = np.asarray(shown_s if onset_s is None else np.append(shown_s, onset_s))
    for effect in reversed(effects):
        times = effect.true_time(times)
    return times if onset_s is None else times[:-1] - times[-1] + onset_s


def duration_for(times_s: Array, release: RunRelease) -> float:
    """How long a simulation has to be to cover these times of the rig, s, in steps of a twentieth so that runs can share it."""
    last = float(np.max(times_s)) - release.instant_s
    return max(np.ceil((last + _MARGIN_S) / _MARGIN_S) * _MARGIN_S, _MARGIN_S)


def poses_at(samples: Array, places: Array) -> Array:
    """Poses (m, 7) at places (m,) between the poses (n, 7) of a deployment; behind one that is not finite nothing is seen."""
    finite = np.isfinite(samples)
    good = len(samples) if finite.all() else int(np.argmin(finite.all(axis=1)))
    if good == len(samples) and places.max(initial=0.0) <= good - 1:
        return between(samples, places)
    poses = np.full((len(places), POSE_SIZE), np.nan)
    covered = places <= good - 1
    if good > 1:
        poses[covered] = between(samples[:good], places[covered])
    return poses


def between(rows: Array, at: Array) -> Array:
    """Rows (n, k) that are evenly spaced, seen at places (m,) between them: the polynomial through the six nearest, or all of fewer."""
    near, weights = _nearest(np.ascontiguousarray(at, dtype=float).tobytes(), len(rows))
    return np.einsum("mj,mjk->mk", weights, rows[near])


@lru_cache(maxsize=256)
def _nearest(places: bytes, rows: int) -> tuple[NDArray[np.intp], Array]:
    """The rows nearest to places (m,), given as bytes, and their weights, both (m, 6); remembered, for films mostly ask for the same."""
    at, count = np.frombuffer(places), min(_NEAREST, rows)
    first = np.clip(np.floor(at).astype(int) - (count // 2 - 1), 0, rows - count)
    away = (at - first)[:, None] - np.arange(count)
    before, behind = np.ones_like(away), np.ones_like(away)
    np.cumprod(away[:, :-1], axis=1, out=before[:, 1:])
    np.cumprod(away[:, :0:-1], axis=1, out=behind[:, -2::-1])
    return first[:, None] + np.arange(count), before * behind / _spacings(count)


@cache
def _spacings(count: int) -> Array:
    """Product of the distances of each of `count` places from all others, (count,)."""
    return np.array([np.prod([j - k for k in range(count) if k != j]) for j in range(count)], dtype=float)


def _from_first_frame(poses: Array) -> Array:
    """Poses (..., n, 7) with every rotation counted from the first: q q_0*, scalar first."""
    w, x, y, z = np.moveaxis(poses[..., 3:], -1, 0)
    a, b, c, d = np.moveaxis(poses[..., :1, 3:], -1, 0)
    turned = (w * a + x * b + y * c + z * d, x * a - w * b + z * c - y * d, y * a - w * c + x * d - z * b, z * a - w * d + y * b - x * c)
    return np.concatenate([poses[..., :3], np.stack(turned, axis=-1)], axis=-1)


@dataclass(frozen=True)
class View:
    """A model, the times of a film of it (n,), and how this run was released.

    turned : whether rotations count from the first frame, R(t) R(t_0)', as a tracker's do that has no other zero.
    onset_s : where the onset of the motion sets the clock, when that is.
    """

    model: Model
    shown_s: Array
    release: RunRelease
    turned: bool = False
    onset_s: float | None = None

    @cached_property
    def frames(self) -> NDArray[np.intp]:
        """Where the frames stand among the instants at which the camera looks, (n,).

        Where an effect remembers it looks between the frames, about as often as the simulation has samples.
        """
        if len(self.shown_s) < 2 or not any(effect.remembers for effect in self.model.effects):
            return np.arange(len(self.shown_s))
        steps = np.maximum(np.round(np.diff(self.shown_s) * _sample_rate(self.model)), 1.0)
        return np.concatenate([[0], np.cumsum(steps.astype(np.intp))])

    @cached_property
    def looked_s(self) -> Array:
        """On the clock of the camera the instants at which it looks, (k,)."""
        if len(self.frames) == 0 or self.frames[-1] + 1 == len(self.frames):
            return self.shown_s
        return np.interp(np.arange(self.frames[-1] + 1), self.frames, self.shown_s)

    @cached_property
    def times_s(self) -> Array:
        """The rig's time of each instant, (k,)."""
        return rig_time(self.model.effects, self.looked_s, self.onset_s)

    @cached_property
    def rig(self) -> Model:
        """What moves: the model without its camera and clock, released as it was, for as long as the film lasts."""
        duration = duration_for(self.times_s, self.release)
        simulation = altered(self.model.simulation, duration_s=duration, sample_rate_Hz=_sample_rate(self.model))
        moved = released(with_rate_worked_in(self.model), self.release)
        acting = [effect for effect in moved.effects if effect.acts_on != "measurement" and not _only_adjusts(type(effect))]
        for effect in moved.effects:
            moved = effect.adjust(moved) if _only_adjusts(type(effect)) else moved
        return altered(moved, simulation=simulation, effects=tuple(acting), name="", nuisance=_EXACT)

    @cached_property
    def places(self) -> Array:
        """Where these stand between the samples of a deployment that starts at the release, (k,); it stands still before."""
        return np.maximum(self.times_s - self.release.instant_s, 0.0) * self.rig.simulation.sample_rate_Hz

    @property
    def is_plain(self) -> bool:
        """Whether nothing stands between rig and camera."""
        return all(type(effect).observe is Effect.observe for effect in self.model.effects)

    def of(self, poses: Array) -> dict[str, Array]:
        """Every channel that the film shows, (..., n), of the poses (..., k, 7) when it looks; of several only where it is plain."""
        channels: Mapping[str, Array] = channels_of(_from_first_frame(poses) if self.turned else poses)
        for effect in self.model.effects:
            channels = effect.observe(self.looked_s, channels)
        return {name: values[..., self.frames] for name, values in channels.items()}


def _sample_rate(model: Model) -> float:
    return min(model.simulation.sample_rate_Hz, _MOST_SAMPLES_A_SECOND)


@cache
def _only_adjusts(kind: type[Effect]) -> bool:
    """Whether an effect does nothing but change the base model, which is done before a run."""
    return kind.acts_on == "model" and all(getattr(kind, formula, None) is None for formula in SIGNATURES)


def observe(view: View) -> dict[str, Array]:
    """What a film shows, every channel (n,)."""
    return view.of(poses_at(_ahead(without_idle([view.rig])[0]).poses, view.places))


def observe_beside(first: View, views: Sequence[View], *, longer: bool = False) -> dict[str, Array]:
    """What films (v, n) show of models that hardly differ from a first one, its steps taken by all, so that differences are smooth.

    Models that differ only in what happens between rig and film are simulated once. All films have the same frames. What is compared to the
    last digit is asked for together: one seen alone is rounded otherwise.

    longer : whether all take steps twice as long, where nothing is too stiff for that. Differences are then exact to a millionth in
    flight and to some hundredths behind the stops, for a leg meets its stop within a step.
    """
    ahead = _ahead(without_idle([first.rig])[0])
    pace = ahead.longer if longer else ahead.pace
    samples: dict[Model, Array] = {}
    groups: dict[tuple, list[Model]] = {}
    for rig in dict.fromkeys(view.rig for view in views):
        groups.setdefault((rig.simulation, type(rig.controller), *(type(effect) for effect in rig.effects)), []).append(rig)
    for group in groups.values():
        samples |= zip(group, poses_beside([pace.of(rig) for rig in group], pace.division, one_core=others_busy()), strict=True)
    poses = np.stack([poses_at(samples[view.rig], view.places / pace.fewer) for view in views])
    if all(view.is_plain for view in views):
        return views[0].of(poses)
    seen = [view.of(own) for view, own in zip(views, poses, strict=True)]
    return {channel: np.stack([one[channel] for one in seen]) for channel in seen[0]}


@dataclass(frozen=True)
class _Pace:
    """The steps that several runs take: their length, s, how they are divided, and how many times fewer samples are kept than asked for."""

    step_s: float
    division: StepDivision
    fewer: int = 1

    def longer(self, stride: int) -> _Pace:
        """Steps twice as long, each divided as that of its two which is divided more; the same where an odd number is between two samples.

        stride : how many steps are between two samples.
        """
        if stride % 2 and stride > 1:
            return self
        pairs = np.pad(self.division, (0, len(self.division) % 2), constant_values=1).reshape(-1, 2)
        return _Pace(2.0 * self.step_s, pairs.max(axis=1), 2 if stride == 1 else 1)

    def of(self, rig: Model) -> Model:
        """A rig that is simulated at this pace."""
        rate = rig.simulation.sample_rate_Hz / self.fewer
        return altered(rig, simulation=altered(rig.simulation, step_s=self.step_s, sample_rate_Hz=rate))


@dataclass(frozen=True)
class _Ahead:
    """A run that chose its own steps: its poses (n, 7), its pace, and one with longer steps where these may be longer."""

    poses: Array
    pace: _Pace
    longer: _Pace


@lru_cache(maxsize=64)
def _ahead(rig: Model) -> _Ahead:
    given = rig.simulation.step_s is not None
    if given:
        run, division = deploy_with_division(rig)
    else:
        free = altered(rig.end_stop, stiffness_N_per_m=0.0, damping_N_s_per_m=0.0)
        in_flight = max(step_of(altered(rig, end_stop=free), _LONGEST_FLIGHT_S), _SHORTEST_STEP_S)
        at_speed = altered(rig, simulation=altered(rig.simulation, step_s=in_flight))
        run, division = deploy_with_division(at_speed, max(step_of(rig), _SHORTEST_STEP_S))
    pace, stride = _Pace(run.step_s, division), round(1.0 / (run.step_s * rig.simulation.sample_rate_Hz))
    may_be_longer = not given and rig.controller is None and step_of(rig) >= _SHORTEST_STEP_S
    return _Ahead(run.samples[:, :POSE_SIZE], pace, pace.longer(stride) if may_be_longer else pace)
