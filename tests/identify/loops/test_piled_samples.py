"""A channel that ends before the signal does is found, and a turning point in coarse steps is not taken for one."""

from __future__ import annotations

import numpy as np
import pytest

from identify.loops.piled_samples import at_limits

SEEDS = range(60)
SHAPES = {
    "sine": lambda turn: np.cos(2.0 * np.pi * turn),
    "triangle": lambda turn: 4.0 * np.abs(turn % 1.0 - 0.5) - 1.0,
    "bent": lambda turn: np.cos(2.0 * np.pi * turn) + 0.05 * np.cos(6.0 * np.pi * turn),
}


def recorded(shape: str, chance: np.random.Generator, samples: int, *, clipped: bool) -> tuple[np.ndarray, np.ndarray]:
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
        time, shown = recorded(shape, chance, int(10 ** chance.uniform(1.3, 2.7)), clipped=False)
        assert not np.any(at_limits(time, shown)), seed


@pytest.mark.parametrize("shape", ["sine", "bent"])
def test_a_channel_that_ends_before_the_turning_point_is_found(shape):
    for seed in SEEDS:
        time, shown = recorded(shape, np.random.default_rng(seed), 100, clipped=True)
        cut = at_limits(time, shown)
        assert np.any(cut), seed
        assert np.all(cut[shown == shown.max()]), seed
