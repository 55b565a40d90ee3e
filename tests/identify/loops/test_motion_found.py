"""Reversals, cycles, noise and steps of motions that are known exactly."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_loops import loop_data, triangles

from identify.loops.differentiation import (
    Motion,
    cycles,
    dead_band,
    local_polynomial,
    moving,
    noise_of,
    one_way,
    quantum_of,
    reversals,
)
from identify.loops.interference import jumps, spikes_of
from identify.loops.loop_data import acceleration_apart, area, centre_of, first_cycles, turns_of, with_turns_moved
from identify.loops.piled_samples import steps_of
from identify.loops.residual_dependence import depends_on

TIME = np.linspace(0.0, 4.0, 801)
SINE = 0.2 + 0.05 * np.sin(2.0 * np.pi * TIME)


@pytest.mark.parametrize("half", [3, 8, 400])
def test_a_cubic_and_its_derivatives_are_exact_also_at_the_ends_and_at_uneven_instants(half):
    t = np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, 60)) / 60.0
    at = np.array([0, 1, 20, 58, 59])
    fitted, gain = local_polynomial(t, 1.0 + t - 2.0 * t**2 + t**3, half, at)
    x = t[at]
    assert fitted == pytest.approx(np.stack([1.0 + x - 2.0 * x**2 + x**3, 1.0 - 4.0 * x + 3.0 * x**2, -4.0 + 6.0 * x]), abs=1e-6)
    assert np.all((gain > 0.0) & (gain < 1.0 + 1e-9))


def test_the_noise_of_a_smoothed_value_is_what_its_weights_make_of_it():
    """A cubic through seven even neighbours: 1/3 + 2/21 in the middle, a value from Savitzky and Golay's tables, 7/21."""
    gain = local_polynomial(np.arange(20.0), np.zeros(20), 3, np.array([10]))[1][0]
    assert gain**2 == pytest.approx(7.0 / 21.0)


@pytest.mark.parametrize("sigma", [1e-4, 1e-3])
def test_noise_is_found_on_a_smooth_signal_and_jumps_do_not_count(sigma):
    noisy = SINE + np.where(TIME > 2.0, 0.3, 0.0) + np.random.default_rng(1).normal(0.0, sigma, len(TIME))
    assert noise_of(TIME, noisy) == pytest.approx(sigma, rel=0.1)


def test_a_coarse_converter_makes_noise_of_its_step_over_the_root_of_twelve():
    held = 0.01 * np.round(SINE / 0.01)
    assert quantum_of(held) == pytest.approx(0.01)
    assert noise_of(TIME, held) >= 0.01 / np.sqrt(12.0) - 1e-12
    assert quantum_of(SINE) == 0.0
    assert steps_of(held) == pytest.approx(0.01)
    assert steps_of(SINE) == 0.0


def test_values_that_stand_still_without_being_multiples_of_a_step_have_none():
    held = np.repeat(np.random.default_rng(2).normal(size=80), 5)
    assert steps_of(held) == 0.0


def test_reversals_are_at_the_extremes_whichever_way_the_motion_begins():
    at = [50, 150, 250, 350, 450, 550, 650, 750]
    assert reversals(SINE, 0.01) == tuple(at)
    assert reversals(-SINE, 0.01) == tuple(at)


def test_a_step_back_counts_as_a_reversal_beyond_the_band_only():
    u = np.concatenate([np.arange(0.0, 10.0), np.arange(8.0, 6.0, -1.0), np.arange(8.0, 20.0), [0.0]])
    assert reversals(u, 3.5) == (23,)
    assert reversals(u, 1.5) == (9, 11, 23)


def test_cycles_have_the_frequency_and_amplitude_of_the_sine():
    found = cycles(TIME, SINE, 0.01)
    assert found.spans == ((50, 251), (250, 451), (450, 651))
    assert found.frequency_Hz == pytest.approx(1.0)
    assert found.amplitude_m == pytest.approx(0.05)


def test_the_period_is_measured_between_vertices_and_not_between_samples():
    t = np.arange(0.0, 6.0, 0.09)
    assert cycles(t, np.sin(2.0 * np.pi * 1.03 * t), 0.1).frequency_Hz == pytest.approx(1.03, rel=2e-3)


def test_without_a_full_cycle_there_is_neither_frequency_nor_amplitude():
    half = cycles(TIME[:120], SINE[:120], 0.01)
    assert half.spans == ()
    assert np.isnan(half.frequency_Hz)
    assert np.isnan(half.amplitude_m)


def test_a_glitch_between_two_reversals_is_straightened_and_a_monotone_stroke_stays():
    u = np.concatenate([np.arange(0.0, 21.0), np.arange(19.0, -1.0, -1.0)])
    assert np.array_equal(one_way(u, (0, 20, 40)), u)
    glitch = u.copy()
    glitch[10], glitch[30] = 4.0, 15.0
    straight = one_way(glitch, (0, 20, 40))
    assert np.all(np.diff(straight[:21]) >= 0.0)
    assert np.all(np.diff(straight[20:]) <= 0.0)
    assert straight[[0, 20, 40]].tolist() == [0.0, 20.0, 0.0]


def test_idle_seconds_at_both_ends_are_left_out():
    u = np.concatenate([np.zeros(30), np.arange(1.0, 11.0), np.full(20, 10.0)])
    assert moving(u, 0.5) == slice(29, 40)
    assert moving(np.zeros(10), 0.5) == slice(0, 10)


def test_the_dead_band_is_five_noises_two_quanta_or_a_thousandth_of_the_range():
    still = np.zeros(len(TIME))
    motion = Motion(SINE, still, still, 1e-3, 1e-3, np.empty((0, 3, len(TIME))))
    assert dead_band(motion, 1e-3) == pytest.approx(5e-3)
    assert dead_band(motion, 4e-3) == pytest.approx(8e-3)
    assert dead_band(replace(motion, noise_m=0.0), 0.0) == pytest.approx(1e-4)


HALF = 40
U = triangles(6, HALF)
UP = np.arange(len(U)) % (2 * HALF) < HALF
FORCE = np.where(UP, 1.0, 2.0)


def test_the_area_of_a_rectangle_is_stroke_times_height_and_its_sign_is_the_way_round():
    data = loop_data(U, FORCE, half=HALF)
    assert area(data, FORCE) == pytest.approx(0.1, rel=0.03)
    assert area(data, -FORCE) == pytest.approx(-0.1, rel=0.03)
    assert area(data, 5.0 + 0.0 * U) == pytest.approx(0.0, abs=1e-12)
    assert area(data, 3.0 * U) == pytest.approx(0.0, abs=1e-12)


def test_a_cycle_that_drifts_is_closed_evenly_over_its_time():
    """A triangle: along the axis, up, and back by what it drifted at its mean force."""
    data = loop_data(np.array([0.0, 1.0, 1.0]), np.zeros(3), half=1)
    data = replace(data, cycles=replace(data.cycles, spans=((0, 3),)))
    assert area(data, np.array([0.0, 0.0, 1.0])) == pytest.approx(0.25)


@pytest.mark.parametrize("samples", [20.5, 50.3, 333.3])  # a cycle
@pytest.mark.parametrize("drift", [0.0, 0.02, -0.02])  # of the stroke, a cycle
def test_what_an_inertia_forces_at_the_turns_and_a_drift_are_no_area(samples, drift):
    """A spool with 130 times the force of the loop; the mean drifts. A chord from end to end was wrong by up to the whole area."""
    for begun in np.linspace(0.0, 0.5, 9):
        turns = np.arange(begun, begun + 3.4, 1.0 / samples)
        wave, height = 2.0 * np.pi * turns, 0.07
        smooth = 0.04 * np.sin(wave) + 0.08 * drift * turns
        reversals = np.flatnonzero(np.diff(np.sign(np.diff(smooth)))) + 1
        data = loop_data(smooth, turns, half=1)
        data = replace(data, time_s=turns * samples, cycles=replace(data.cycles, spans=((int(reversals[0]), int(reversals[2]) + 1),)))
        force = 3.0 - 130.0 * height * np.sin(wave) - height * np.cos(wave)
        assert area(data, force) == pytest.approx(np.pi * 0.04 * height, rel=0.1)


def test_turns_are_where_a_path_leaves_a_dwell():
    assert turns_of(np.array([0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0, 1.0])).tolist() == [4, 6]


def test_turning_points_are_moved_outward_on_both_sides():
    moved = with_turns_moved(loop_data(U, FORCE, half=HALF), 0.01).path.elongation_m
    assert moved[HALF] == pytest.approx(0.11)
    assert moved[2 * HALF] == pytest.approx(-0.01)
    assert np.count_nonzero(moved != U) == 11


def test_the_first_cycles_are_two_at_least_and_thinned_to_about_so_many_samples():
    data = loop_data(U, FORCE, half=HALF)
    two = first_cycles(data, 50)
    assert len(two.cycles.spans) == 2
    assert len(two.time_s) == len(two.force_N) == len(two.used) == 4 * HALF + 1
    assert 50 <= two.used.sum() <= 60
    assert two.cycles.reversals == (40, 80, 120, 160)[: len(two.cycles.reversals)]
    assert len(two.path.time_s) == 4 * HALF + 1
    three = first_cycles(data, 6 * HALF + 1)
    assert len(three.cycles.spans) == 3
    assert three.used.all()


def test_accelerations_of_one_frequency_follow_the_elongation_and_of_two_do_not():
    def sine(w):
        data = loop_data(U, FORCE, half=HALF)
        t = 2.0 * np.pi * np.arange(len(U)) / (2 * HALF)
        return replace(data, elongation_m=np.sin(t), acceleration_m_per_s2=3.0 - w**2 * np.sin(t))

    assert acceleration_apart([sine(1.0)]) == pytest.approx(0.0, abs=1e-6)
    assert acceleration_apart([sine(1.0), sine(2.0)]) == pytest.approx(np.sqrt(1.0 - 5.0**2 / (2.0 * 17.0)), rel=1e-6)
    assert centre_of([sine(1.0)]) == pytest.approx(0.0, abs=1e-9)
    assert centre_of([loop_data(U, FORCE, half=HALF)]) == pytest.approx(0.05)


@pytest.mark.parametrize("name", ["speed", "elongation"])
def test_a_residual_is_traced_to_the_quantity_that_it_follows(name):
    data = loop_data(U, FORCE, half=HALF, sigma_N=0.5)
    source = {"speed": data.speed_m_per_s, "elongation": data.elongation_m}[name]
    residual = source - source.mean()
    residual = residual / np.std(residual) + np.random.default_rng(3).normal(0.0, 0.3, len(U))
    residual /= np.sqrt(np.mean(residual**2))
    found = depends_on([data], [residual])
    assert found.strongest == name
    assert found.shares[name] == pytest.approx(1.0 / 1.09, abs=0.06)
    assert f"{name}: explains" in found.sentence
    assert "2.0 times the noise" in found.sentence


def test_noise_follows_nothing_and_its_size_is_told_by_half_as_much_again():
    data, noise = loop_data(U, FORCE, half=HALF, sigma_N=1.0), np.random.default_rng(4).normal(size=len(U))
    noise /= np.sqrt(np.mean(noise**2))
    assert "looks like noise" in depends_on([data], [1.4 * noise]).sentence
    assert "1.6 times the noise" in depends_on([data], [1.6 * noise]).sentence
    assert max(depends_on([data], [noise]).shares.values()) < 0.15


def test_only_a_single_sample_off_both_neighbours_jumps():
    flat = np.zeros(20)
    flat[5], flat[9:11], flat[15:] = 3.0, 2.0, 1.0
    flat[12] = -2.0
    height = jumps(flat)
    assert height[5] == 3.0
    assert height[12] == 2.0
    assert np.count_nonzero(height) == 2


def test_a_spike_is_six_standard_deviations_off_and_steeper_motion_is_none():
    signal = np.sin(np.linspace(0.0, 20.0, 2000)) + np.random.default_rng(5).normal(0.0, 0.002, 2000)
    signal[700] += 1.0
    assert np.flatnonzero(spikes_of(signal, 0.002)).tolist() == [700]
    signal[700] -= 1.0
    assert not spikes_of(signal, 0.002).any()
