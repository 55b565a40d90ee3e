"""A loop ready for comparison with the force law, as plain data, and what the law says for its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from measure.common.arrays import Array
from simulate.dispatch.formula_table import flat_parameters, formula_table
from simulate.loop import axial_mass, loop_force
from simulate.model.effect import Effect

FaultWord = Literal["saturated", "quantised", "hum", "spikes", "dwells", "drift", "lag", "filter", "sign", "unit", "swapped"]
Consequence = Literal["left out", "widened", "modelled", "refused", "named"]


@dataclass(frozen=True)
class Fault:
    """One fault of one channel.

    channel : "force", "elongation" or "time". loop : name of the file. size : in the unit of the channel, N, m or s.
    consequence : "left out", the samples do not count; "widened", the intervals are wider; "modelled", it was taken out or is part of
    the fit; "refused", nothing that is fitted to it can be trusted; "named", nothing was done.
    """

    word: FaultWord
    channel: str
    loop: str
    consequence: Consequence
    size: float
    sentence: str


@dataclass(frozen=True)
class Cycles:
    """The strokes of a record: where the motion turns, and the full cycles between.

    reversals : indices of the extreme samples. spans : (first, last + 1) of each full cycle, from a reversal to the
    next but one. frequency_Hz, amplitude_m : medians over the full cycles, NaN where there is none.
    """

    reversals: tuple[int, ...]
    spans: tuple[tuple[int, int], ...]
    frequency_Hz: float
    amplitude_m: float


Kind = Literal["idle", "ramp", "cycle", "transient", "rest"]


@dataclass(frozen=True)
class Part:
    """A stretch of a record: what it is, from when to when, how many of its samples count, and why the others do not."""

    kind: Kind
    from_s: float
    to_s: float
    samples: int
    used: int
    why: str


@dataclass(frozen=True)
class Path:
    """The motion along which the force law is integrated: the samples and, between them, the exact turning points, each (m,) in SI."""

    time_s: Array
    elongation_m: Array
    speed_m_per_s: Array
    acceleration_m_per_s2: Array


def with_motion_error(path: Path, time_s: Array, error: Array) -> Path:
    """The path with its motion off by an error; no turning point is added.

    Parameters
    ----------
    time_s : (n,) of the samples. error : (3, n) of elongation, speed and acceleration there, in SI.
    """
    off = [np.interp(path.time_s, time_s, row) for row in error]
    return Path(path.time_s, path.elongation_m + off[0], path.speed_m_per_s + off[1], path.acceleration_m_per_s2 + off[2])


def turns_of(u: Array) -> NDArray[np.intp]:
    """Indices at which a path turns; of a dwell, where the motion leaves it."""
    moves = np.flatnonzero(np.diff(u))
    direction = np.sign(np.diff(u)[moves])
    return moves[1:][direction[:-1] * direction[1:] < 0.0]


@dataclass(frozen=True)
class LoopData:
    """One loop, its motion smoothed, its noise estimated, its cycles found.

    time_s, elongation_m, speed_m_per_s, acceleration_m_per_s2, force_N : (n,) at the samples; the force as measured, without hum.
    used : (n,) samples that count; idle seconds before and after the motion do not, nor do a few samples at the ends of
    the record, where the acceleration is poorly known, nor strokes that may have turned in a gap of the record, nor forces cut off.
    parts : the whole record as stretches, with what of them counts and why. remarks : what was done to it on reading.
    force_sigma_N, elongation_sigma_m : one standard deviation of the sample noise, from the high frequencies.
    turns_sigma_m : how well the turning points are known, one standard deviation. motion_errors : (k, 3, n), see `Motion`.
    path, at : where the law is integrated, and the index of each sample in it. other : further columns, (n,), by name.
    faults : what is wrong with the channels. force_step_N : step of the load cell's converter that its noise does not cover, else zero.
    """

    name: str
    time_s: Array
    elongation_m: Array
    speed_m_per_s: Array
    acceleration_m_per_s2: Array
    force_N: Array
    used: NDArray[np.bool_]
    force_sigma_N: float
    elongation_sigma_m: float
    turns_sigma_m: float
    cycles: Cycles
    path: Path
    at: NDArray[np.intp]
    motion_errors: Array
    other: Mapping[str, Array] = field(default_factory=dict)
    parts: tuple[Part, ...] = ()
    remarks: tuple[str, ...] = ()
    faults: tuple[Fault, ...] = ()
    force_step_N: float = 0.0

    @property
    def frequency_Hz(self) -> float:
        """Cycling frequency, NaN without a full cycle."""
        return self.cycles.frequency_Hz

    @property
    def amplitude_m(self) -> float:
        """Half the stroke, NaN without a full cycle."""
        return self.cycles.amplitude_m

    @property
    def mid_stroke_speed_m_per_s(self) -> float:
        """Speed in the middle of the stroke, where a sinusoidal test reads its asymptotes: 2 pi f A."""
        return 2.0 * np.pi * self.frequency_Hz * self.amplitude_m

    @property
    def finest_way_m(self) -> float:
        """Way from a turning point to the second sample behind it, median over the turns: what is over sooner hardly shows."""
        u = self.path.elongation_m
        turns = turns_of(u)
        behind = np.searchsorted(self.at, turns, side="right") + 1
        known = behind < len(self.at)
        return float(np.median(np.abs(u[self.at[behind[known]]] - u[turns[known]]))) if np.any(known) else float(np.ptp(u))

    @cached_property
    def paths_in_doubt(self) -> tuple[Path, ...]:
        """The path with each of the errors that the motion may have."""
        return tuple(with_motion_error(self.path, self.time_s, error) for error in self.motion_errors)

    @cached_property
    def force_range_N(self) -> float:
        """Largest minus smallest force of the samples that count; errors are given in parts of it."""
        return float(np.ptp(self.force_N[self.used]))


def with_turns_moved(data: LoopData, outward_m: float) -> LoopData:
    """The loop with every turning point further out, as the law would have it if they were wrong by so much."""
    u = data.path.elongation_m.copy()
    turns = turns_of(u)
    u[turns] += outward_m * np.sign(u[turns] - u[turns - 1])
    return replace(data, path=replace(data.path, elongation_m=u))


def first_cycles(data: LoopData, samples: int) -> LoopData:
    """The first full cycles of a loop, about so many samples; of a cycle that is longer, fewer of its samples count.

    At least two cycles stay where there are two, so that what comes again in every cycle can be told from noise.
    """
    ends = [b for k, (_, b) in enumerate(data.cycles.spans) if k == 1 or b <= samples]
    stop = max(ends, default=len(data.time_s))
    used = data.used[:stop].copy()
    used[np.flatnonzero(used)[np.arange(int(used.sum())) % max(int(used.sum()) // samples, 1) > 0]] = False
    last = int(data.at[stop - 1]) + 1
    path = Path(*(getattr(data.path, key)[:last] for key in ("time_s", "elongation_m", "speed_m_per_s", "acceleration_m_per_s2")))
    arrays = {
        key: getattr(data, key)[:stop] for key in ("time_s", "elongation_m", "speed_m_per_s", "acceleration_m_per_s2", "force_N", "at")
    }
    turns = tuple(turn for turn in data.cycles.reversals if turn < stop)
    spans = tuple(span for span in data.cycles.spans if span[1] <= stop)
    return replace(
        data,
        **arrays,
        used=used,
        path=path,
        cycles=replace(data.cycles, reversals=turns, spans=spans),
        motion_errors=data.motion_errors[:, :, :stop],
        other={name: values[:stop] for name, values in data.other.items()},
    )


def predict(lines: Array, data: LoopData, start_force_N: float, effects: tuple[Effect, ...] = ()) -> Array:
    """Force that the law and these effects give for the motion of a loop, as a load cell shows it.

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta.
    start_force_N : the hysteretic force at the first sample; no loop tells it beforehand, see `free_start`.

    Returns
    -------
    (n,) force at the samples, N. Effects that do not act on a leg or a load cell change nothing.
    """
    return _along(data.path, lines, data, start_force_N, effects)


def _along(path: Path, lines: Array, data: LoopData, start_force_N: float, effects: tuple[Effect, ...]) -> Array:
    force = loop_force(lines, path.time_s, path.elongation_m, path.speed_m_per_s, path.acceleration_m_per_s2, start_force_N, effects)
    for effect in effects:
        force = effect.observe_force(path.time_s, path.elongation_m, force)
    return force[data.at]


def free_start(lines: Array, data: LoopData, effects: tuple[Effect, ...] = ()) -> tuple[float, Array]:
    """The start force that suits the measured loop best, and the force predicted with it.

    The law is linear in its start force, which fades as exp(-beta times the distance travelled), so two predictions give the
    least-squares value. In a steady loop it concerns only the first samples; it is a nuisance, one for each loop. It is held
    to within the loop's force range: where it has faded before the first sample that counts, it would else follow the noise there.
    """
    guess, force, change = _start_guess(lines, data, effects)
    shift = _share(change[data.used], (data.force_N - force)[data.used], data)
    return guess + shift, force + shift * change


def gap(lines: Array, data: LoopData, effects: tuple[Effect, ...] = ()) -> Array:
    """Measured minus modelled force, with the loop's own start force taken out.

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta.

    Returns
    -------
    (used,) N, at the samples that count.
    """
    return (data.force_N - free_start(lines, data, effects)[1])[data.used]


def gap_and_motion_errors(
    lines: Array, data: LoopData, effects: tuple[Effect, ...] = (), zero_N: Array | float = 0.0
) -> tuple[Array, Array]:
    """The gap, and what each of the errors that the loop's motion may have does to it; the start force is free in all.

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta.
    zero_N : (n,) or one number, what the load cell shows without force.

    Returns
    -------
    (used,) and (used, k) N, at the samples that count.
    """
    guess, force, change = _start_guess(lines, data, effects)
    seen = change[data.used]
    moved = [_along(path, lines, data, guess, effects) for path in data.paths_in_doubt]
    columns = [(data.force_N - zero_N - force)[data.used], *((force - other)[data.used] for other in moved)]
    freed = [column - _share(seen, column, data) * seen for column in columns]
    return freed[0], np.stack(freed[1:], axis=1) if moved else np.empty((len(seen), 0))


def _start_guess(lines: Array, data: LoopData, effects: tuple[Effect, ...]) -> tuple[float, Array, Array]:
    """A start force, the force predicted with it, and the change of that force with it."""
    guess = float(data.force_N[np.argmax(data.used)])
    force = predict(lines, data, guess, effects)
    return guess, force, predict(lines, data, guess + 1.0, effects) - force


def _share(signature: Array, left: Array, data: LoopData) -> float:
    """How much of a signature is in what is left, drawn to zero as if one force range were its standard deviation beforehand."""
    return float(signature @ left / (float(signature @ signature) + (data.force_sigma_N / data.force_range_N) ** 2 + 1e-12))


def area(data: LoopData, force_N: Array) -> float:
    """Energy that a loop dissipates in one cycle, J: the area it encloses, positive when it runs anticlockwise.

    A cycle whose elongation drifts does not close: what it drifts is spread evenly over its time.

    Parameters
    ----------
    force_N : (n,) measured or modelled, at the samples.

    Returns
    -------
    float
        The mean over the full cycles; zero where there is none.
    """
    areas = [_enclosed(data, force_N, first, last) for first, last in data.cycles.spans]
    return float(np.mean(areas)) if areas else 0.0


def _enclosed(data: LoopData, force_N: Array, a: int, b: int) -> float:
    """The same of the cycle of samples a to b - 1, from turn to turn: the ends are moved to the turns, at the force that they have."""
    u, force, time = data.elongation_m, force_N[a:b], data.time_s[a:b]
    first, last = _turn(u, a), _turn(u, b - 1)
    mean = np.trapezoid(force, time) / (time[-1] - time[0])
    ends = force[0] * (u[a] - first) + force[-1] * (last - u[b - 1])
    return float((last - first) * mean - np.trapezoid(force, u[a:b]) - ends)


def _turn(u: Array, at: int) -> float:
    """Elongation where it turns near a sample: the top of the parabola through this and its neighbours."""
    before, here, behind = u[max(at - 1, 0)], u[at], u[min(at + 1, len(u) - 1)]
    is_top = (here - before) * (here - behind) > 0.0
    return float(here - (behind - before) ** 2 / (8.0 * (before - 2.0 * here + behind))) if is_top else float(here)


def centre_of(loops: Sequence[LoopData]) -> float:
    """The middle of the elongations of all loops, m."""
    everywhere = np.concatenate([data.elongation_m[data.used] for data in loops])
    return float((everywhere.min() + everywhere.max()) / 2.0)


def acceleration_apart(loops: Sequence[LoopData]) -> float:
    """Share of the acceleration of all loops that is no multiple of the elongation, 0 to 1, each loop centred.

    Zero for sinusoids of one frequency; the larger, the more frequencies differ.
    """
    seen = [np.stack([d.elongation_m, d.acceleration_m_per_s2])[:, d.used] for d in loops]
    u, a = np.concatenate([pair - pair.mean(axis=1, keepdims=True) for pair in seen], axis=1)
    power = float(u @ u) * float(a @ a)
    return float(np.sqrt(max(1.0 - float(u @ a) ** 2 / power, 0.0))) if power > 0.0 else 0.0


def inertia(data: LoopData, effects: tuple[Effect, ...]) -> Array:
    """Mass times acceleration of the effects with inertia along the leg, N, at every sample."""
    values, table = flat_parameters(effects), formula_table(effects, 0)
    if not len(table.leg_mass):
        return np.zeros(len(data.time_s))
    mass = np.array([axial_mass(values, table, float(u)) for u in data.elongation_m])
    return mass * data.acceleration_m_per_s2
