"""A first look at further columns bounds what the whole evidence says once the noise is estimated anew."""

from __future__ import annotations

import numpy as np
import pytest

from identify.gap.linear_pieces import Channel, Columns, Lines
from identify.noise.noise_model import spacing
from identify.selection.evidence import evidence
from identify.selection.first_look import FirstLook

N = 500
TIME = np.linspace(0.0, 1.0, N)
BASE = 20.0 * np.column_stack([TIME**k for k in range(3)])
WAVES = 5.0 * np.column_stack([np.sin(9.0 * TIME), np.cos(14.0 * TIME)])


def lines(amount, seed):
    gaps = np.random.default_rng(seed).normal(size=N) + WAVES[:, 0] * amount
    channels = (Channel(slice(0, 200), spacing(np.arange(200))), Channel(slice(200, N), spacing(np.arange(300))))
    return Lines(gaps, BASE, np.empty((N, 0)), np.empty(0), np.zeros(3), 0.1 * np.eye(3), channels)


@pytest.mark.parametrize("amount", [0.0, 0.05, 0.1])
def test_a_first_look_bounds_what_the_evidence_gains(amount):
    for seed in range(5):
        at, more = lines(amount, seed), Columns.free(WAVES, 10.0)
        nothing, with_waves = evidence(at), evidence(at, more)
        look = FirstLook(nothing).gain(more)
        gain, deviation = with_waves.log_z - nothing.log_z, float(np.sqrt(with_waves.covariance[-1, -1]))
        assert look.log_z - 1.0 < gain < look.most + 1.0
        assert look.amounts == pytest.approx(with_waves.amounts, abs=4.0 * deviation)
        assert 0.8 * deviation < np.sqrt(look.covariance[-1, -1]) < 3.0 * deviation


def test_what_base_and_releases_can_do_themselves_gains_nothing():
    at = lines(0.0, 7)
    look = FirstLook(evidence(at)).gain(Columns.free(BASE[:, 1:2] - 2.0 * BASE[:, 2:], 10.0))
    assert look.log_z < 1.0


def test_bounds_forbid_a_first_look_the_wrong_sign():
    at = lines(0.15, 8)
    free = FirstLook(evidence(at)).gain(Columns.free(WAVES[:, :1], 10.0))
    spread, none = np.array([10.0]), np.zeros(1)
    wrong = FirstLook(evidence(at)).gain(Columns(WAVES[:, :1], spread, none, none, np.array([np.inf])))
    assert free.log_z > 3.0
    assert wrong.log_z < free.log_z - 3.0


def test_what_is_shown_of_columns_together_holds_what_each_brings_alone():
    look = FirstLook(evidence(lines(0.1, 9)))
    together = look.shown(WAVES)
    for k in range(2):
        alone = Columns.free(WAVES[:, k : k + 1], 10.0)
        assert together.of(k, 1).gain(alone).log_z == pytest.approx(look.gain(alone).log_z, abs=1e-9)
        assert together.of(k, 1).gain(alone).amounts == pytest.approx(look.gain(alone).amounts, rel=1e-9)


def test_a_column_twice_with_half_the_variance_each_brings_what_it_brings_once():
    look = FirstLook(evidence(lines(0.1, 10)))
    one, twice = (look.gain(Columns.free(np.repeat(WAVES[:, :1], n, axis=1), 10.0 / np.sqrt(n))) for n in (1, 2))
    assert twice.log_z == pytest.approx(one.log_z, abs=1e-6)
    assert twice.amounts.sum() == pytest.approx(one.amounts[0], rel=1e-6)
