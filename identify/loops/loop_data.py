"""A loop made ready for comparison with the force law, and what the law says for its motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.loops.channel_faults import checked, dwell_fault
from identify.loops.corners import Corner, sharpened
from identify.loops.differentiation import (
    Cycles,
    Motion,
    cycles,
    dead_band,
    motion,
    quantum_of,
)
from identify.loops.dwells import dwells_of, with_dwells
from identify.loops.faults import Fault
from identify.loops.integration_path import Path, path_of, turns_of, with_motion_error
from identify.loops.segments import Part, parts, usage
from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.tables.checks import require_physical
from measure.tables.loop import LOOP_COLUMNS, Loop
from simulate.loop import loop_force
from simulate.model.effect import Effect

_NOTHING = 1e-12  # m or N: no such motion or force is measured
_FINEST_S = 1e-12  # no load cell is read so often
_ANOTHER = 10.0  # records long, a gap between two recordings


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

    @property
    def force_range_N(self) -> float:
        """Largest minus smallest force of the samples that count; errors are given in parts of it."""
        return float(np.ptp(self.force_N[self.used]))


def prepare(loop: Loop) -> LoopData:
    """Smooth a loop's motion, find its noise, its reversals and what of it counts.

    Returns
    -------
    LoopData
        Each array at the n samples of the loop, in SI.

    Raises
    ------
    InputError
        The elongation or the force does not change, or there are too few samples.
    """
    _require_motion(loop)
    channel = checked(loop)
    smooth = motion(loop.time_s, loop.elongation_m)
    dwells = dwells_of(loop.elongation_m, smooth.noise_m) if not len(smooth.errors) else []
    smooth, corners = with_dwells(loop.time_s, loop.elongation_m, smooth, dwells)
    band = dead_band(smooth, quantum_of(loop.elongation_m))
    found = cycles(loop.time_s, smooth.elongation_m, band)
    smooth, sharp = _sharpened(loop, smooth, found, dwells)
    corners += sharp
    use = usage(loop.time_s, smooth, band, found)
    path, at = path_of(loop.time_s, smooth, found.reversals, sorted(corners, key=lambda corner: corner.time_s))
    return LoopData(
        name=loop.name,
        time_s=loop.time_s,
        elongation_m=smooth.elongation_m,
        speed_m_per_s=smooth.speed_m_per_s,
        acceleration_m_per_s2=smooth.acceleration_m_per_s2,
        force_N=channel.force_N,
        used=use.used & channel.sound,
        force_sigma_N=channel.noise_N,
        elongation_sigma_m=smooth.noise_m,
        turns_sigma_m=smooth.turns_m,
        cycles=replace(found, spans=use.whole(found.spans)),
        path=path,
        at=at,
        motion_errors=smooth.errors,
        other=loop.other,
        parts=tuple(parts(loop.time_s, smooth.elongation_m, use, found.spans)),
        remarks=tuple(loop.remarks),
        faults=(*channel.faults, *_dwell_faults(loop, dwells)),
        force_step_N=channel.step_N,
    )


def _sharpened(loop: Loop, smooth: Motion, found: Cycles, dwells: list[tuple[int, int]]) -> tuple[Motion, list[Corner]]:
    """Sharp reversals made so, but for those in a dwell, whose corners are known."""
    still = [turn for turn in found.reversals if any(a <= turn < b for a, b in dwells)]
    return sharpened(loop.time_s, loop.elongation_m, smooth, tuple(turn for turn in found.reversals if turn not in still))


def _dwell_faults(loop: Loop, dwells: list[tuple[int, int]]) -> list[Fault]:
    lengths = [float(loop.time_s[b - 1] - loop.time_s[a]) for a, b in dwells]
    return [dwell_fault(loop.name, float(np.median(lengths)), len(dwells))] if dwells else []


def _require_motion(loop: Loop) -> None:
    if len(loop.time_s) < 20:
        raise InputError(f"{loop.name}: {len(loop.time_s)} samples; a loop needs at least 20.")
    _require_one_recording(loop)
    for column in LOOP_COLUMNS:
        require_physical(getattr(loop, column), column, loop.name)
    for column in ("elongation_m", "force_N"):
        if np.ptp(getattr(loop, column)) < _NOTHING:
            raise InputError(f"{loop.name}: {column} is {getattr(loop, column)[0]:g} in every row. Check which column was taken for it.")


def _require_one_recording(loop: Loop) -> None:
    steps = np.diff(loop.time_s)
    gap = int(np.argmax(steps))
    if np.min(steps) < _FINEST_S:
        row = int(np.argmin(steps))
        raise InputError(f"{loop.name}: time_s grows by {steps[row]:.3g} s at {loop.time_s[row]:.6g} s. Check its unit, or its digits.")
    sampled = float(np.sum(steps)) - float(steps[gap])
    if steps[gap] > _ANOTHER * max(sampled, len(steps) * float(np.median(steps))):
        raise InputError(
            f"{loop.name}: no samples for {steps[gap]:.4g} s after {loop.time_s[gap]:.6g} s, and {sampled:.3g} s of samples in all; "
            "these are two recordings, or the clock was set anew. Cut the file there."
        )


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
    path = data.path
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
    moved = [predict(lines, replace(data, path=path), guess, effects) for path in data.paths_in_doubt]
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

    Parameters
    ----------
    force_N : (n,) measured or modelled, at the samples.

    Returns
    -------
    float
        The mean over the full cycles; zero where there is none.
    """
    parts = [-np.trapezoid(force_N[a:b], data.elongation_m[a:b]) for a, b in data.cycles.spans]
    closing = [_closing(data.elongation_m, force_N, a, b - 1) for a, b in data.cycles.spans]
    return float(np.mean(np.add(parts, closing))) if parts else 0.0


def _closing(u: Array, force_N: Array, first: int, last: int) -> float:
    """The chord from the last sample of a cycle back to its first."""
    return float(-(u[first] - u[last]) * (force_N[first] + force_N[last]) / 2.0)


def effective_number(residual: Array) -> float:
    """Effective sample size of a residual: n / (1 + 2 sum of its autocorrelations).

    The sum runs while the sum of two neighbouring autocorrelations is positive (Geyer 1992, initial positive sequence), so
    that noise far out does not count. White noise is worth all its samples, a slow drift a handful.
    """
    n = len(residual)
    centred = residual - residual.mean()
    power = float(centred @ centred)
    if n < 4 or power == 0.0:
        return float(n)
    spectrum = np.fft.rfft(centred, 2 * n)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:n] / power
    pairs = correlation[: n - n % 2].reshape(-1, 2).sum(axis=1)
    end = int(np.argmax(pairs <= 0.0)) if np.any(pairs <= 0.0) else len(pairs)
    return float(np.clip(n / (2.0 * pairs[:end].sum() - 1.0), 1.0, n))
