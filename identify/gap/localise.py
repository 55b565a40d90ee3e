"""Where a gap is, and what it goes with: run by run, channel by channel, phase by phase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.campaign.prepared import Film, LoopRun
from identify.estimation.fit import Block
from identify.estimation.problem import Fit
from measure.common.arrays import Array

_CLEAR = 0.6
_WINDOW = 15
_REVERSAL_LENGTHS = 3.0


@dataclass(frozen=True)
class Place:
    """A part of the gap: its share of the whole, in percent of the sum of squares, and what it goes with."""

    run: str
    channel: str
    phase: str
    from_s: float
    to_s: float
    share_percent: float
    depends_on: str


def locate(fit: Fit) -> tuple[Place, ...]:
    """All parts of a fit's gap, the largest first."""
    total = float(np.sum(fit.measured_gaps**2))
    films = {film.run.name: film for film in fit.problem.films}
    loops = {loop.run.name: loop for loop in fit.problem.loops}
    places = [
        place
        for block in fit.problem.blocks
        for place in (
            _in_film(films[block.run], block, fit.part(block), total)
            if block.run in films
            else _in_loop(loops[block.run], block, fit.part(block), total)
        )
    ]
    return tuple(sorted(places, key=lambda place: -place.share_percent))


def _in_film(film: Film, block: Block, part: Array, total: float) -> list[Place]:
    time = film.time_s[block.samples]
    drivers = _film_drivers(film, block)
    missing = _second_derivative(part, time)
    shown = time + film.clock_s
    return [_place(block, phase, shown, part, here, drivers, missing, total) for phase, here in _film_phases(film, block) if here.any()]


def _film_phases(film: Film, block: Block) -> list[tuple[str, NDArray[np.bool_]]]:
    """Release: the first twentieth of the stroke; end-stop: from 98 % of it on; stroke: between."""
    time = film.time_s[block.samples]
    geometry = film.model.geometry
    if "z_m" not in film.channels or geometry is None:
        return [("stroke", np.ones(len(time), dtype=bool))]
    risen = film.values[film.channels.index("z_m")] - geometry.stowed_height_m
    stroke = geometry.deployed_height_m - geometry.stowed_height_m
    off, up = (_first_time(film.time_s, risen >= part * stroke) for part in (0.05, 0.98))
    return [("release", time < off), ("stroke", (time >= off) & (time < up)), ("end-stop", time >= up)]


def _first_time(time_s: Array, reached: NDArray[np.bool_]) -> float:
    return float(time_s[np.argmax(reached)]) if reached.any() else np.inf


def _film_drivers(film: Film, block: Block) -> dict[str, Array]:
    time = film.time_s[block.samples]
    drivers = {"time": time}
    if "z_m" in film.channels and len(time) > _WINDOW:
        z = np.interp(time, film.time_s, _filled(film.values[film.channels.index("z_m")], film.time_s))
        step = float(np.median(np.diff(time)))
        speed = smooth_derivative(z, step, 1)
        drivers |= {"elongation": z, "speed": speed, "acceleration": smooth_derivative(z, step, 2), "direction": np.sign(speed)}
    return drivers


def _filled(values: Array, time_s: Array) -> Array:
    good = np.isfinite(values)
    return np.interp(time_s, time_s[good], values[good])


def _second_derivative(part: Array, time: Array) -> Array:
    """What force a gap of position asks for, up to a mass: its smoothed second derivative."""
    if len(part) <= _WINDOW:
        return part
    return smooth_derivative(part, float(np.median(np.diff(time))), 2)


def smooth_derivative(values: Array, step: float, order: int) -> Array:
    """Derivative of evenly spaced values (n,), by cubics through fifteen neighbours."""
    from scipy.signal import savgol_filter  # takes half a second to import, and most verdicts do without

    return np.asarray(savgol_filter(values, _WINDOW, 3, deriv=order, delta=step), dtype=float)


def _in_loop(loop: LoopRun, block: Block, part: Array, total: float) -> list[Place]:
    data, at = loop.data, block.samples
    u, v = data.elongation_m[at], data.speed_m_per_s[at]
    drivers = {
        "elongation": u,
        "speed": v,
        "acceleration": data.acceleration_m_per_s2[at],
        "time": data.time_s[at],
        "direction": np.sign(v),
        "force level": data.force_N[at],
    }
    near = _near_reversal(loop, at)
    phases = [("uncoiling", (v > 0) & ~near), ("coiling", (v <= 0) & ~near), ("reversal", near)]
    return [_place(block, phase, data.time_s[at], part, here, drivers, part, total) for phase, here in phases if here.any()]


def force_in_loops(fit: Fit) -> tuple[str, dict[str, list]]:
    """What the force missing in the loops goes with, all loops together, in a sentence; and its table, sample by sample."""
    rows: dict[str, list] = {name: [] for name in ("run", "time_s", "elongation_m", "speed_m_per_s", "missing_force_N", "sigma_N")}
    for loop, block in ((loop, block) for loop in fit.problem.loops for block in fit.problem.blocks if block.run == loop.run.name):
        data, at = loop.data, block.samples
        rows["run"] += [block.run] * len(at)
        rows["missing_force_N"] += (fit.difference(block) * data.force_sigma_N).tolist()
        rows["sigma_N"] += [data.force_sigma_N] * len(at)
        for name in ("time_s", "elongation_m", "speed_m_per_s"):
            rows[name] += getattr(data, name)[at].tolist()
    force, u, v = (np.array(rows[name]) for name in ("missing_force_N", "elongation_m", "speed_m_per_s"))
    goes_with = strongest({"elongation": u, "speed": v, "direction": np.sign(v)}, force)
    return f"The force missing in the loops is {float(np.std(force)):.3g} N rms and goes with: {goes_with}.", rows


def _near_reversal(loop: LoopRun, at: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Samples within a few relaxation lengths 1/beta behind a reversal, but at most a fifth of the stroke."""
    u, turns = loop.data.elongation_m, np.asarray(loop.data.cycles.reversals, dtype=int)
    if not len(turns):
        return np.zeros(len(at), dtype=bool)
    beta = float(np.mean(loop.model.actuator.beta_per_m))
    reach = min(_REVERSAL_LENGTHS / beta, 0.2 * float(np.ptp(u)))
    last = np.searchsorted(turns, at, side="right") - 1
    return (last >= 0) & (np.abs(u[at] - u[turns[np.maximum(last, 0)]]) < reach)


def _place(
    block: Block,
    phase: str,
    time: Array,
    part: Array,
    here: NDArray[np.bool_],
    drivers: dict[str, Array],
    missing: Array,
    total: float,
) -> Place:
    share = 100.0 * float(np.sum(part[here] ** 2)) / max(total, 1e-300)
    goes_with = strongest({name: values[here] for name, values in drivers.items()}, missing[here])
    return Place(block.run, block.channel, phase, float(time[here][0]), float(time[here][-1]), share, goes_with)


def strongest(drivers: dict[str, Array], force: Array) -> str:
    """The driver that a force goes with most closely, or `nothing clear`, or `nothing` for a constant force."""
    spread = float(np.std(force))
    if len(force) < 8 or spread == 0.0:
        return "nothing clear"
    if abs(float(np.mean(force))) > 5.0 * spread:
        return "nothing"
    found = {name: abs(_correlation(values, force)) for name, values in drivers.items()}
    name = max(found, key=lambda key: found[key])
    return name if found[name] > _CLEAR else "nothing clear"


def _correlation(a: Array, b: Array) -> float:
    a, b = a - a.mean(), b - b.mean()
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0 else 0.0
