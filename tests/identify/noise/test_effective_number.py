"""How many independent samples a residual is worth."""

import numpy as np
import pytest

from identify.noise.effective_number import effective_number


def test_a_correlated_residual_is_worth_few_samples():
    rng = np.random.default_rng(0)
    white = rng.standard_normal(20_000)
    coloured = np.zeros_like(white)
    for i in range(1, len(white)):
        coloured[i] = 0.9 * coloured[i - 1] + white[i]
    assert effective_number(white) > 0.85 * len(white)
    assert effective_number(coloured) == pytest.approx(len(white) * 0.1 / 1.9, rel=0.25)


def test_the_effective_number_of_alternating_or_few_samples_is_their_number():
    assert effective_number(np.tile([1.0, -1.0], 50)) == 100.0
    assert effective_number(np.array([1.0, 2.0, 4.0])) == 3.0
    assert effective_number(np.ones(50)) == 50.0
