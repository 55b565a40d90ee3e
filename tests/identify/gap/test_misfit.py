"""What a fit leaves of loops: what comes again in every cycle is a misfit, what does not is noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_loops import loop_data, triangles

from identify.gap.misfit import height_of, misfit_of, not_repeated

HALF, CYCLES = 48, 8
U = triangles(CYCLES, HALF)
HEIGHT = 0.4
RECTANGLE = np.where(np.arange(len(U)) % (2 * HALF) < HALF, -HEIGHT / 2.0, HEIGHT / 2.0)  # anticlockwise: coiling lies above
WAVE = 0.03 * np.sin(2.0 * np.pi * np.arange(len(U)) / (2 * HALF))


def made(force=RECTANGLE, **more):
    return loop_data(U, force, half=HALF, **more)


def noise(seed, sigma=0.01):
    return np.random.default_rng(seed).normal(0.0, sigma, len(U))


def test_a_rectangle_is_as_high_as_its_branches_are_apart():
    assert height_of(made()) == pytest.approx(HEIGHT, rel=0.03)
    assert height_of(made(-RECTANGLE)) == pytest.approx(HEIGHT, rel=0.03)


def test_without_a_whole_cycle_the_height_is_the_range_of_the_force():
    whole = made()
    none = made(cycles=whole.cycles.__class__((), (), np.nan, np.nan))
    assert height_of(none) == pytest.approx(HEIGHT)


def test_what_comes_again_is_measured_and_noise_beside_it_is_not():
    found = misfit_of([made()], [WAVE + noise(1)])
    assert found.repeated_N[0] == pytest.approx(0.03 / np.sqrt(2.0), rel=0.05)
    assert found.rms_N[0] == pytest.approx(np.hypot(0.03 / np.sqrt(2.0), 0.01), rel=0.05)
    assert found.relative[0] == pytest.approx(0.03 / np.sqrt(2.0) / (HEIGHT / 2.0), rel=0.06)
    assert found.significance > 8.0


def test_the_significance_of_noise_alone_is_a_standard_normal_number():
    found = [misfit_of([made(), made()], [noise(seed), noise(seed + 1000)]).significance for seed in range(40)]
    assert abs(np.mean(found)) < 0.25
    assert np.std(found) == pytest.approx(1.0, abs=0.25)


def test_noise_with_a_memory_is_no_more_significant_than_white_noise():
    def slow(seed):
        drawn = noise(seed)
        for i in range(1, len(drawn)):
            drawn[i] += 0.8 * drawn[i - 1]
        return drawn

    found = [misfit_of([made()], [slow(seed)]).significance for seed in range(40)]
    assert 0.6 < np.std(found) < 1.5


def test_a_level_and_a_misfit_that_changes_from_cycle_to_cycle_do_not_come_again():
    turned = WAVE * np.where(np.arange(len(U)) // (2 * HALF) % 2, 1.0, -1.0)
    assert misfit_of([made()], [np.full(len(U), 0.3) + 1e-6 * noise(2)]).repeated_N[0] < 1e-6
    assert misfit_of([made()], [turned]).repeated_N[0] == 0.0


def test_the_steps_of_a_converter_are_taken_out_of_what_comes_again():
    step = 0.06
    plain = misfit_of([made()], [WAVE]).repeated_N[0]
    assert misfit_of([made(force_step_N=step)], [WAVE]).repeated_N[0] == pytest.approx(np.sqrt(plain**2 - step**2 / 12.0))


def test_samples_that_do_not_count_have_no_say():
    used = np.ones(len(U), bool)
    used[100:110] = False
    found = misfit_of([made(used=used)], [WAVE[used]])
    assert found.repeated_N[0] == pytest.approx(0.03 / np.sqrt(2.0), rel=0.1)


def test_of_one_cycle_what_is_slow_counts_less_the_noise_of_its_means():
    one = loop_data(U[: 2 * HALF + 1], RECTANGLE[: 2 * HALF + 1], half=HALF)
    found = [misfit_of([one], [noise(seed)[: 2 * HALF + 1]]) for seed in range(40)]
    assert all(np.isnan(one.significance) for one in found)
    assert np.sqrt(np.mean([one.repeated_N[0] ** 2 for one in found])) < 0.005
    slow = misfit_of([one], [WAVE[: 2 * HALF + 1]])
    assert slow.repeated_N[0] == pytest.approx(0.03 / np.sqrt(2.0), rel=0.1)


def test_pooled_over_loops_is_the_root_mean_square_of_their_parts():
    found = misfit_of([made(), made()], [WAVE, 0.0 * WAVE])
    assert found.pooled == pytest.approx(found.relative[0] / np.sqrt(2.0))
    assert found.relative[1] == 0.0


def test_a_loop_whose_residual_is_large_counts_less_in_the_significance():
    loud, quiet = noise(3, 1.0), WAVE + noise(4)
    alone = misfit_of([made()], [quiet]).significance
    assert misfit_of([made(), made()], [quiet, loud]).significance > 0.5 * alone


def test_cycles_of_another_stroke_are_compared_with_their_own_kind():
    """Four small cycles and four large ones, each with a misfit of its own."""
    u = np.concatenate([triangles(4, HALF)[:-1], triangles(4, HALF, 0.05)])
    shape = np.where(np.arange(len(u)) < 8 * HALF, 1.0, -1.0) * WAVE
    mixed = loop_data(u, RECTANGLE, half=HALF)
    assert misfit_of([mixed], [shape]).repeated_N[0] == pytest.approx(0.03 / np.sqrt(2.0), rel=0.02)


def test_without_the_other_cycles_what_comes_again_is_gone_and_noise_is_larger_by_theirs():
    one = noise(9)
    left = not_repeated(made(), WAVE + one)
    whole = np.isfinite(left)
    assert np.count_nonzero(whole) > 0.9 * len(U)
    assert left[whole] == pytest.approx(not_repeated(made(), one)[whole], abs=1e-6)
    assert np.std(left[whole]) == pytest.approx(0.01 * np.sqrt(1.0 + 1.0 / (len(made().cycles.spans) - 1.0)), rel=0.06)


def test_a_loop_in_which_no_stroke_is_repeated_is_left_as_it_is():
    whole = made()
    once = made(cycles=replace(whole.cycles, spans=whole.cycles.spans[:1]))
    assert not_repeated(once, WAVE) == pytest.approx(WAVE)
