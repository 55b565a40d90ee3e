"""What the film of a run would show, were the model true: the deployment, seen through clock and camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from measure.tables import CHANNELS, Array, Trajectory
from simulate.deployment import channels_of, deploy_many
from simulate.effect import Effect
from simulate.model import Model, Simulation
from simulate.six_legs import POSE

_MARGIN_S = 0.05
_STEP_S = 1.25e-4  # a film sees micrometres; at the half millisecond of a sweep the stops leave ten of them


@dataclass(frozen=True)
class RunRelease:
    """What one run did of its own: where and when it was released, and by how much its legs differed that day."""

    position_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    theta_rad: tuple[float, ...] = (0.0, 0.0, 0.0)
    instant_s: float = 0.0
    stored_force_N: tuple[float, ...] = (0.0,) * 6


def released(model: Model, release: RunRelease) -> Model:
    """The model with a run's own release worked in (its instant is the clock's business)."""
    at = model.release
    moved = replace(at, position_m=_sum(at.position_m, release.position_m), theta_rad=_sum(at.theta_rad, release.theta_rad))
    changed = replace(model, release=moved)
    return replace(changed, actuator=changed.actuator.shifted(release.stored_force_N)) if any(release.stored_force_N) else changed


def _sum(a: Sequence[float], b: Sequence[float]) -> tuple[float, ...]:
    return tuple(x + y for x, y in zip(a, b, strict=True))


def rig_time(effects: Sequence[Effect], shown_s: Array) -> Array:
    """The rig's time, from the clock of the camera."""
    for effect in reversed(effects):
        shown_s = effect.true_time(shown_s)
    return shown_s


def duration_for(effects: Sequence[Effect], shown_s: Array, release: RunRelease) -> float:
    """How long a simulation has to be to cover these times, s, in steps of a twentieth so that runs can share it."""
    last = float(np.max(rig_time(effects, shown_s))) - release.instant_s
    return max(np.ceil((last + _MARGIN_S) / _MARGIN_S) * _MARGIN_S, _MARGIN_S)


def seen(
    samples: Array, rate_Hz: float, effects: Sequence[Effect], shown_s: Array, release: RunRelease, turned: bool = False
) -> dict[str, Array]:
    """Channels at the times of a film, from the samples of a deployment that starts at the release.

    Before its release the platform stands still where it is held. Between samples a cubic spline runs.

    Parameters
    ----------
    turned : whether rotations count from the first frame, R(t) R(t_0)', as a tracker's do that has no other zero.
    """
    at = np.maximum(rig_time(effects, shown_s) - release.instant_s, 0.0)
    if turned:
        samples = _from_first_frame(samples, int(np.clip(round(float(at[0]) * rate_Hz), 0, len(samples) - 1)))
    curves = np.stack(list(channels_of(samples).values()), axis=-1)
    good = np.isfinite(curves).all(axis=-1)
    times = np.arange(len(curves)) / rate_Hz
    values = np.full((len(at), len(CHANNELS)), np.nan)
    covered = at <= times[good][-1] if good.any() else np.zeros(len(at), dtype=bool)
    if good.sum() > 3:
        values[covered] = CubicSpline(times[good], curves[good])(at[covered])
    channels: Mapping[str, Array] = dict(zip(CHANNELS, values.T, strict=True))
    for effect in effects:
        channels = effect.observe(shown_s, channels)
    return dict(channels)


def _from_first_frame(samples: Array, first: int) -> Array:
    """The samples with every rotation counted from one of them."""
    from scipy.spatial.transform import Rotation

    good, place = np.isfinite(samples[:, POSE]), slice(POSE + 3, POSE + 7)
    turn = Rotation.from_quat(samples[good, place], scalar_first=True)
    changed = samples.copy()
    changed[good, place] = (turn * turn[first].inv()).as_quat(scalar_first=True)
    return changed


def observe_many(
    models: Sequence[Model], shown_s: Sequence[Array], releases: Sequence[RunRelease], turned: Sequence[bool] | None = None
) -> list[dict[str, Array]]:
    """What the films of several runs show, model by model; those that share their effects are simulated together.

    Models that differ only in what happens between rig and film are simulated once.
    """
    rigs = [_rig(*case) for case in zip(models, shown_s, releases, strict=True)]
    samples = _simulate(list(dict.fromkeys(rigs)))
    return [
        seen(samples[rig], rig.simulation.sample_rate_Hz, model.effects, at, release, count)
        for rig, model, at, release, count in zip(rigs, models, shown_s, releases, turned or [False] * len(models), strict=True)
    ]


def _rig(model: Model, shown_s: Array, release: RunRelease) -> Model:
    given = model.simulation
    simulation = Simulation(duration_for(model.effects, shown_s, release), given.sample_rate_Hz, given.step_s or _STEP_S)
    acting = tuple(effect for effect in model.effects if effect.acts_on != "measurement")
    return replace(released(model, release), simulation=simulation, effects=acting, name="", nuisance=type(model.nuisance)())


def _simulate(rigs: Sequence[Model]) -> dict[Model, Array]:
    groups: dict[tuple, list[Model]] = {}
    for rig in rigs:
        groups.setdefault((rig.simulation, *(type(effect) for effect in rig.effects)), []).append(rig)
    return {run.model: run.samples for group in groups.values() for run in deploy_many(group)}


def observe(model: Model, trajectory: Trajectory, release: RunRelease | None = None) -> dict[str, Array]:
    """What the film of one run would show at its own times, every channel (n,)."""
    return observe_many([model], [trajectory.time_s], [release or RunRelease()])[0]
