"""What laser and load cell make of an actuator on the shaker."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from measure.tables.loop import Loop
from simulate.loop import loop_force
from simulate.model.effect import Effect
from simulate.model.model import Actuator, Model

from .camera import averaged, values_of
from .campaigns import CYCLES, LASER_SIGMA_M, Shaking

Array = np.ndarray

_FINE = 20  # points between two samples
_PICOSECONDS = 12  # decimals to which two instants are the same
_BEFORE = 0.1  # of a cycle, so that a late load cell has something to show


@dataclass(frozen=True)
class Stroke:
    """A motion imposed by the shaker, fine in time: from a little before the record on."""

    time_s: Array
    u: Array
    v: Array
    a: Array


@lru_cache(16)  # many models are shaken alike
def stroke_of(run: Shaking) -> Stroke:
    """u = mean + drift t / T + A sin(w t), finely from a tenth of a cycle before the record, its turning points among the instants."""
    w, last = 2.0 * np.pi * run.frequency_Hz, run.time_s[-1]
    step = run.time_s[1] / _FINE
    walk = run.drift_m / last
    t = np.arange(-round(_BEFORE / run.frequency_Hz / step), round(last / step) + 1) * step
    t = np.unique(np.round([*t, *_turning_points(walk / (w * run.amplitude_m), w, run.late_s, t[0], t[-1])], _PICOSECONDS))
    sine, cosine = run.amplitude_m * np.sin(w * (t - run.late_s)), run.amplitude_m * np.cos(w * (t - run.late_s))
    return Stroke(t, run.mean_m + walk * t + sine, walk + w * cosine, -(w**2) * sine)


def _turning_points(walk: float, w: float, late_s: float, first_s: float, last_s: float) -> Array:
    """Where cos(w (t - late)) = -walk, within the record."""
    turns = np.arange(-2, CYCLES + 2)[:, None] + np.array([1.0, -1.0]) * np.arccos(-walk) / (2.0 * np.pi)
    t = late_s + turns.ravel() * 2.0 * np.pi / w
    return t[(t > first_s) & (t < last_s)]


def line_values(law: Actuator) -> Array:
    """a_l, b_l, a_u, b_u, beta of the actuator on the shaker."""
    return np.array([np.mean(v) for v in (law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m)])


def kernel_force(model: Model, stroke: Stroke, start_force_N: float) -> Array:
    """The actuator's force by the project's own law, twenty times finer than the record."""
    return loop_force(line_values(model.actuator), stroke.time_s, stroke.u, stroke.v, stroke.a, start_force_N, model.effects)


def cell_shows(force_N: Array, stroke: Stroke, run: Shaking, effects: tuple[Effect, ...]) -> Array:
    """What the load cell shows at the samples: late and smoothed, with a zero of its own."""
    acting = values_of(effects)
    delay = float(acting.get("sensor-lag", (0.0,))[0])
    tare, drift = acting.get("force-offset", (0.0, 0.0))
    slow_s = float(acting.get("sensor-filter", (0.0, 0.0))[0])
    late = averaged(lambda late_s: np.interp(run.time_s - delay - late_s, stroke.time_s, force_N), slow_s)
    return late + run.tare_N + tare + (run.drift_N_per_s + drift) * run.time_s


def loop_of(shown_N: Array, stroke: Stroke, run: Shaking, chance: np.random.Generator) -> Loop:
    """The table as it is written: laser and load cell with their noise, rounded as their electronics do."""
    u = np.interp(run.time_s, stroke.time_s, stroke.u) + chance.normal(0.0, LASER_SIGMA_M, len(run.time_s))
    force = shown_N + chance.normal(0.0, run.sigma_N, len(run.time_s))
    return Loop(np.round(run.time_s, 7), _rounded(u, run.laser_step_m), _rounded(force, run.cell_step_N))


def _rounded(values: Array, step: float) -> Array:
    return np.round(np.round(values / step) * step, 9)
