"""Shaker tests as benches write them, drawn at random: quantised, late, filtered, clipped, dwelling, drifting, humming, noisy channels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from measure import Loop
from simulate.loop import loop_force

FINE = 10  # steps of the truth for each sample


@dataclass(frozen=True)
class Bench:
    """A shaker test as it really was: law, motion, noise. states : factor on height and beta of each loop."""

    lines: np.ndarray
    frequencies_Hz: tuple[float, ...]
    amplitude_m: float
    cycles: float
    samples: int
    noise_N: float
    memory: float
    sine: bool
    dwell: float = 0.0
    states: tuple[tuple[float, float], ...] = ()

    @property
    def height_N(self) -> float:
        """Between the asymptotes in the middle."""
        return float(self.lines[3] - self.lines[1] + (self.lines[2] - self.lines[0]) * 0.25)


def bench(chance: np.random.Generator, **given) -> Bench:
    """Any bench: loops 20 mN to 2 N high, 5 to 24 reaches 1 / beta a stroke, one to three frequencies, two to six cycles."""
    height, amplitude = 10 ** chance.uniform(-1.7, 0.3), 10 ** chance.uniform(-2.3, -1.0)
    slope = height / amplitude * chance.uniform(-0.2, 0.2, 2)
    beta = chance.uniform(5.0, 24.0) / amplitude
    level = chance.uniform(0.0, 5.0)
    lines = np.array([slope[0], level - slope[0] * 0.25, slope[1], level + height - slope[1] * 0.25, beta])
    made = Bench(
        lines=lines,
        frequencies_Hz=((1.0,), (0.5, 1.0), (0.2, 1.0, 3.0))[chance.integers(3)],
        amplitude_m=amplitude,
        cycles=chance.uniform(2.3, 6.0),
        samples=int(10 ** chance.uniform(2.0, 2.7)),
        noise_N=height * 10 ** chance.uniform(-2.3, -1.3),
        memory=float(chance.choice([0.0, 0.5])),
        sine=bool(chance.integers(2)),
    )
    return replace(made, **given)


def turning(b: Bench, turn: np.ndarray, frequency: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Elongation about the middle, speed and acceleration of a sine, a triangle, or a triangle that dwells at both ends."""
    w = 2 * np.pi * frequency
    if b.dwell:
        ramp = (1 - b.dwell) / 2
        x = turn % 1.0
        knots, values = [0, b.dwell / 2, b.dwell / 2 + ramp, 1 - ramp, 1], [1, 1, -1, -1, 1]
        return b.amplitude_m * np.interp(x, knots, values), 0 * turn, 0 * turn
    if b.sine:
        return (
            b.amplitude_m * np.sin(w * turn / frequency),
            b.amplitude_m * w * np.cos(2 * np.pi * turn),
            -w * w * b.amplitude_m * np.sin(2 * np.pi * turn),
        )
    return b.amplitude_m * (4 * np.abs(turn % 1 - 0.5) - 1), np.where(turn % 1 < 0.5, -4.0, 4.0) * frequency * b.amplitude_m, 0 * turn


def recorded(
    b: Bench, chance: np.random.Generator, spoil: Callable[[Bench, np.ndarray, np.ndarray, np.ndarray, float], tuple]
) -> list[Loop]:
    """The loops of a bench as a channel that `spoil` makes faulty shows them; truth on fine steps."""
    loops = []
    for k, frequency in enumerate(b.frequencies_Hz):
        height, beta = b.states[k] if b.states else (1.0, 1.0)
        lines = b.lines * np.array([1.0, 1.0, 1.0, 1.0, beta])
        lines[[1, 3]] += (height - 1.0) * b.height_N / 2.0 * np.array([-1.0, 1.0])
        n = int(b.cycles * b.samples)
        turn = np.arange(n * FINE) / (b.samples * FINE) + 0.13
        t = turn / frequency
        t = t - t[0]
        u, v, a = turning(b, turn, frequency)
        force = loop_force(lines, t, 0.25 + u, v, a, float(lines[1] + lines[3]) / 2.0 + 0.25 * float(lines[0] + lines[2]) / 2.0)
        noise = chance.standard_normal(n)
        for i in range(1, n if b.memory else 0):
            noise[i] = b.memory * noise[i - 1] + np.sqrt(1 - b.memory**2) * noise[i]
        seen = 0.25 + u[::FINE] + 1e-4 * b.amplitude_m * chance.standard_normal(n)
        time, shown, force_N = spoil(b, t, seen, force, frequency)
        loops.append(Loop(time, shown, force_N[: len(time)] + b.noise_N * noise[: len(time)], f"{frequency:g}Hz-{k}.csv"))
    return loops


def plain(b, t, u, force, frequency):
    return t[::FINE], u, force[::FINE]


def quantised(chance):
    """Steps of a seventh to a half of the loop's height, far above the noise."""
    b = bench(chance)
    b = replace(b, noise_N=b.height_N * 10 ** chance.uniform(-3.0, -2.0))
    step = b.height_N * chance.uniform(0.15, 0.5)
    return b, [replace(loop, force_N=np.round(loop.force_N / step) * step) for loop in recorded(b, chance, plain)]


def late(chance):
    """The force comes later by up to a fiftieth of the fastest period."""
    b = bench(chance)
    delay = chance.uniform(0.002, 0.02) / max(b.frequencies_Hz) * chance.choice([-1, 1])
    return b, recorded(b, chance, lambda _, t, u, force, f: (t[::FINE], u, np.interp(t - delay, t, force)[::FINE]))


def filtered(chance):
    """A low pass of first order in the force, its time up to a fiftieth of the fastest period."""
    from scipy.signal import lfilter

    b = bench(chance)
    time = chance.uniform(0.002, 0.02) / max(b.frequencies_Hz)

    def through(_, t, u, force, frequency):
        share = 1.0 - np.exp(-(t[1] - t[0]) / time)
        return t[::FINE], u, lfilter([share], [1.0, share - 1.0], force, zi=[force[0] * (1.0 - share)])[0][::FINE]

    return b, recorded(b, chance, through)


def clipped_force(chance):
    """The load cell ends a tenth to a third of the height below the top or above the bottom, behind the noise."""
    b = bench(chance)
    loops = recorded(b, chance, plain)
    force = np.concatenate([loop.force_N for loop in loops])
    part, upper = chance.uniform(0.1, 0.33), bool(chance.integers(2))
    limit = force.max() - part * np.ptp(force) if upper else force.min() + part * np.ptp(force)
    return b, [replace(loop, force_N=np.minimum(loop.force_N, limit) if upper else np.maximum(loop.force_N, limit)) for loop in loops]


def clipped_elongation(chance):
    """The gauge ends before the turning point, by up to a fifth of the amplitude."""
    b = bench(chance)
    limit = 0.25 + b.amplitude_m * chance.uniform(0.8, 0.95)
    return b, [replace(loop, elongation_m=np.minimum(loop.elongation_m, limit)) for loop in recorded(b, chance, plain)]


def dwelling(chance):
    """Dwells at both ends, of a tenth to a half of the period."""
    b = bench(chance, dwell=float(chance.uniform(0.1, 0.5)), sine=False)
    return b, recorded(b, chance, plain)


def drifting(chance):
    """The zero drifts by a twentieth to twice the loop's height over a record."""
    b = bench(chance)
    by = b.height_N * 10 ** chance.uniform(-1.3, 0.3)
    return b, recorded(b, chance, lambda _, t, u, force, f: (t[::FINE], u, (force + by * t / t[-1])[::FINE]))


def humming(chance):
    """A hum of 50 or 60 Hz, a twentieth to the whole of the height, sampled fast enough to be seen."""
    b = bench(chance, frequencies_Hz=((0.5,), (0.5, 1.0))[chance.integers(2)], samples=600)
    mains, part, phase = (
        chance.choice([50.0, 60.0]) + chance.uniform(-0.05, 0.05),
        b.height_N * 10 ** chance.uniform(-1.3, 0.0),
        chance.uniform(0, 6),
    )
    return b, recorded(b, chance, lambda _, t, u, force, f: (t[::FINE], u, (force + part * np.sin(2 * np.pi * mains * t + phase))[::FINE]))


def noisy(chance):
    """White or coloured noise of a tenth to a half of the height."""
    b = bench(chance)
    b = replace(b, noise_N=b.height_N * chance.uniform(0.1, 0.5), samples=500)
    return b, recorded(b, chance, plain)


def two_states(chance):
    """One of the loops with another height or another beta, by a tenth to a half."""
    b = bench(chance, frequencies_Hz=(1.0, 1.0) if chance.integers(2) else (0.5, 1.0))
    factor = 1.0 + chance.uniform(0.1, 0.5) * chance.choice([-0.6, 1.0])
    b = replace(b, states=((1.0, 1.0), (factor, 1.0) if chance.integers(2) else (1.0, factor)))
    return b, recorded(b, chance, plain)


def clean(chance):
    """Nothing wrong."""
    b = bench(chance)
    return b, recorded(b, chance, plain)


KINDS = {
    f.__name__: f
    for f in (quantised, late, filtered, clipped_force, clipped_elongation, dwelling, drifting, humming, noisy, two_states, clean)
}
