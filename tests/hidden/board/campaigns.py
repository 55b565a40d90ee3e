"""What is measured: which deployments and loops, by what camera and load cell, how each run was let go."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from simulate.model.model import Model

from .specs import Spec

Chance = np.random.Generator

FRAMES, FPS = 150, 250.0
CAMERAS = {"fine": (4e-6, 3e-5), "usual": (2e-5, 1e-4), "coarse": (1e-4, 4e-4), "film": (4e-6, 6e-5)}
CELL_SIGMA_N = {"fine": 1e-3, "usual": 2e-3, "coarse": 4e-3, "film": 2e-3}
LASER_SIGMA_M = 1e-5
FREQUENCIES_HZ, AMPLITUDES_M = (0.2, 1.0, 3.0), (0.01, 0.04)
CYCLES, SAMPLES = 3, 1000


@dataclass(frozen=True)
class Deployment:
    """A filmed deployment. zeroed : counted from the first frame, as a film is; the camera then runs before the release.

    changes : what the list of runs says of it. file_mass_kg : the platform's mass in the model file; what a run has more is ballast.
    tells_sigma : whether the table says how sure it is. position_m, theta_rad, legs_N, instant_s : how this run was let go.
    rendered : whether the table is made by tracking a made film.
    """

    changes: Mapping[str, Any]
    file_mass_kg: float
    channels: tuple[str, ...]
    sigma: Mapping[str, float]
    zeroed: bool
    tells_sigma: bool
    position_m: np.ndarray
    theta_rad: np.ndarray
    legs_N: np.ndarray
    instant_s: float
    hold_out: bool = False
    rendered: bool = False
    frames: int = FRAMES

    @property
    def time_s(self) -> np.ndarray:
        """The camera's clock."""
        return np.arange(self.frames) / FPS


@dataclass(frozen=True)
class Shaking:
    """A loop on the shaker. drift_m : slow walk of the mean elongation over the record, seen by the laser and harmless.

    tare_N, drift_N_per_s : the load cell's own zero in this run; zero but where the case says otherwise.
    laser_step_m, cell_step_N : what both are rounded to. late_s : by how much the shaker's sine begins behind the record.
    """

    frequency_Hz: float
    amplitude_m: float
    mean_m: float
    drift_m: float
    sigma_N: float
    laser_step_m: float
    cell_step_N: float
    start_force_N: float
    tare_N: float = 0.0
    drift_N_per_s: float = 0.0
    late_s: float = 0.0
    hold_out: bool = False

    @property
    def time_s(self) -> np.ndarray:
        """Three cycles."""
        return np.arange(SAMPLES + 1) * (CYCLES / self.frequency_Hz / SAMPLES)


@dataclass(frozen=True)
class Campaign:
    """All runs of a case, in the order in which they are listed."""

    deployments: tuple[Deployment, ...] = ()
    shakings: tuple[Shaking, ...] = field(default=())


def planned(spec: Spec, known: Model, chance: Chance) -> Campaign:
    """The runs of a case; the last one is held out where there are several of a kind."""
    heavy, high = {"platform.mass_kg": round(1.25 * known.platform.mass_kg, 3)}, _higher(known)
    conditions: dict[str, list[dict[str, Any]]] = {
        "standard": [{}, high, heavy, {**high, **heavy}, _between(known)],
        "two-heights": [{}, high, heavy],
        "single": [{}],
        "loops": [],
    }
    chosen = conditions[spec.run_set]
    seen = seen_by(spec, chance)
    deployments = [deployment(spec, known, c, seen, len(chosen) > 1 and i == len(chosen) - 1, chance) for i, c in enumerate(chosen)]
    if spec.noise == "film":
        deployments[0] = _on_film(deployments[0])
    shakings = _shakings(spec, known, chance) if spec.run_set in ("standard", "loops") else ()
    return Campaign(tuple(deployments), shakings)


def _higher(known: Model) -> dict[str, Any]:
    assert known.geometry is not None
    return {"geometry.stowed_height_m": round(known.geometry.stowed_height_m + 0.05, 3)}


def _between(known: Model) -> dict[str, Any]:
    """A condition of its own for the run that is held out."""
    assert known.geometry is not None
    return {
        "geometry.stowed_height_m": round(known.geometry.stowed_height_m + 0.025, 3),
        "platform.mass_kg": round(1.12 * known.platform.mass_kg, 3),
    }


@dataclass(frozen=True)
class Seen:
    """What all tables of a case have in common."""

    channels: tuple[str, ...]
    zeroed: bool
    tells_sigma: bool


def seen_by(spec: Spec, chance: Chance) -> Seen:
    """What the camera's tables hold: mostly all that one camera sees, one time in six the elevation alone."""
    alone, zeroed, silent = chance.random(3)
    return Seen(("z_m",) if alone < 1 / 6 and spec.noise != "film" else ("x_m", "z_m", "theta_y_rad"), zeroed < 0.5, silent > 0.2)


def deployment(spec: Spec, known: Model, changes: Mapping[str, Any], seen: Seen, hold_out: bool, chance: Chance) -> Deployment:
    spread = known.nuisance
    waits = 0.02 if seen.zeroed else 0.0
    return Deployment(
        changes,
        known.platform.mass_kg,
        seen.channels,
        sigma_of(spec, seen.channels),
        seen.zeroed,
        seen.tells_sigma,
        chance.normal(0.0, spread.release_position_m, 3),
        chance.normal(0.0, spread.release_theta_rad, 3),
        chance.normal(0.0, spread.stored_force_N, 6),
        float(max(waits + chance.normal(0.0, spread.release_instant_s), -0.02)),
        hold_out,
    )


def sigma_of(spec: Spec, channels: Sequence[str]) -> dict[str, float]:
    """The camera's noise on each channel, m and rad."""
    length, angle = CAMERAS[spec.noise]
    return {name: angle if name.endswith("rad") else length for name in channels}


def _on_film(run: Deployment) -> Deployment:
    return replace(run, rendered=True, zeroed=True, tells_sigma=True, instant_s=abs(run.instant_s) + 0.01)


def _shakings(spec: Spec, known: Model, chance: Chance) -> tuple[Shaking, ...]:
    """Six loops; of loops alone the fastest ones are held out."""
    drifts, quantised = chance.random(2) < (0.3, 0.4)
    pairs = [(f, a) for f in FREQUENCIES_HZ for a in AMPLITUDES_M]
    if spec.run_set == "loops":
        pairs.append((2.0, 0.025))
    made = [shaking(spec, known, *pair, drifts, quantised, chance) for pair in pairs]
    if spec.run_set == "loops":
        made[-1] = replace(made[-1], hold_out=True)
    return tuple(made)


def shaking(spec: Spec, known: Model, frequency_Hz: float, amplitude_m: float, drifts: bool, quantised: bool, chance: Chance) -> Shaking:
    """A loop at a frequency and somewhat less than an amplitude."""
    tare, drift = chance.normal(0.0, (0.01, 0.001)) if spec.own_tare else (0.0, 0.0)
    return Shaking(
        frequency_Hz,
        amplitude_m * chance.uniform(0.93, 1.0),
        0.1 + chance.uniform(-0.005, 0.005),
        chance.uniform(-0.1, 0.1) * amplitude_m if drifts else 0.0,
        CELL_SIGMA_N[spec.noise],
        1e-5 if quantised else 1e-7,
        1e-3 if quantised else 1e-5,
        float(known.actuator.b_l_N) + chance.uniform(-0.05, 0.15),  # type: ignore[arg-type]
        tare,
        drift,
    )
