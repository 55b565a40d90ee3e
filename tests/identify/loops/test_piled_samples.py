"""A channel that ends before the signal does is found, and a turning point in coarse steps is not taken for one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from faulty_benches import bench, plain, recorded

from identify.loops.channel_faults import checked
from identify.loops.piled_samples import at_limits

SEEDS = range(60)
SHAPES = {
    "sine": lambda turn: np.cos(2.0 * np.pi * turn),
    "triangle": lambda turn: 4.0 * np.abs(turn % 1.0 - 0.5) - 1.0,
    "bent": lambda turn: np.cos(2.0 * np.pi * turn) + 0.05 * np.cos(6.0 * np.pi * turn),
}


def shown_as(shape: str, chance: np.random.Generator, samples: int, *, clipped: bool) -> tuple[np.ndarray, np.ndarray]:
    """Time and elongation of an amplitude of one; samples of each cycle lie evenly about its turning points, or on them."""
    turn = (np.arange(int(samples * chance.uniform(3.0, 6.0))) + chance.choice([0.0, 0.5]) + int(samples / 3)) / samples
    step = 10 ** chance.uniform(-4.0, -2.0)
    wave = SHAPES[shape](turn) + step * chance.uniform(0.05, 0.3) * chance.standard_normal(len(turn))
    limit = chance.uniform(0.8, 0.95) * wave.max() if clipped else np.inf
    return turn, step * np.round((np.minimum(wave, limit) + chance.uniform(-1.0, 1.0)) / step)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_turning_point_that_shows_the_same_step_twice_is_no_limit(shape):
    """Two samples that lie alike to both sides of it are equal, in every cycle anew where the sampling keeps pace."""
    for seed in SEEDS:
        chance = np.random.default_rng(seed)
        time, shown = shown_as(shape, chance, int(10 ** chance.uniform(1.3, 2.7)), clipped=False)
        assert not np.any(at_limits(time, shown)), seed


@pytest.mark.parametrize("shape", ["sine", "bent"])
def test_a_channel_that_ends_before_the_turning_point_is_found(shape):
    for seed in SEEDS:
        time, shown = shown_as(shape, np.random.default_rng(seed), 100, clipped=True)
        cut = at_limits(time, shown)
        assert np.any(cut), seed
        assert np.all(cut[shown == shown.max()]), seed


def words(seed: int, dwell: float, part: float) -> set[str]:
    """Faults of the elongation of triangles that dwell, in steps of a thousandth, seen up to a part of the amplitude."""
    chance = np.random.default_rng(seed)
    b = bench(chance, dwell=dwell, sine=False)
    b = replace(b, noise_N=0.01 * b.height_N)
    found = set()
    for loop in recorded(b, chance, plain):
        step, seen = 1e-3 * b.amplitude_m, np.minimum(loop.elongation_m, 0.25 + part * b.amplitude_m)
        found |= {fault.word for fault in checked(replace(loop, elongation_m=step * np.round(seen / step))).faults}
    return found


def test_a_dwell_whose_steps_hide_the_noise_is_no_limit_for_the_force_stays_too():
    """But for stays of a few samples, in which the force does not tell."""
    assert sum("saturated" in words(seed, 0.12, 1.1) for seed in SEEDS) < 0.2 * len(SEEDS)


def test_a_triangle_of_many_steps_a_sample_is_seen_to_end_early_and_the_force_goes_on_behind_its_limit():
    assert all("saturated" in words(seed, 0.0, 0.85) for seed in SEEDS)
