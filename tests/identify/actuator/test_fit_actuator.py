"""The fit of loops against loops whose parameters are known."""

import numpy as np
import pytest

from identify.actuator.fit_actuator import fit_actuator
from identify.actuator.loops_alone import problem_of_loops
from identify.actuator.rate_order import choose_order
from identify.loops.loop_data import gap
from identify.loops.prepare import prepare
from measure import InputError, Loop
from simulate.effects import GravityImbalance, HubInertia, ViscousFriction
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
NAMES = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m")


def shaken(frequency, amplitude=0.05, noise=2e-3, effects=(), seed=0, lines=LINES, level=0.0, cycles=3.3, rate=300.0):
    """A loop as a shaker gives it: centre at 0.25 m, ten fine steps a sample, noise on the force and 10 um on the elongation."""
    rng = np.random.default_rng(seed)
    n = int(cycles / frequency * rate)
    t = np.arange(n * 10) / (rate * 10)
    w = 2 * np.pi * frequency
    u, v, a = 0.25 + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)
    force = loop_force(lines, t, u, v, a, 2.75, effects)[::10] + level + noise * rng.standard_normal(n)
    return prepare(Loop(t[::10], u[::10] + 1e-5 * rng.standard_normal(n), force, f"{frequency:g} Hz"))


def six_loops(seed=0, **options):
    return [
        shaken(f, a, seed=100 * seed + 10 * i + j, **options) for i, f in enumerate((0.4, 1.0, 3.0)) for j, a in enumerate((0.05, 0.02))
    ]


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.calibrate) for seed in (1, 2))])
def test_loops_give_back_the_truth_within_four_standard_errors(seed):
    fit = fit_actuator(six_loops(seed), suggest=False)
    assert fit.verdict.word == "ok"
    for name, truth in zip(NAMES, LINES, strict=True):
        estimate = fit.estimates[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.stderr
        assert estimate.verdict == "ok"
    assert fit.estimates["beta_per_m"].stderr < 15.0
    assert fit.estimates["b_l_N"].stderr < 2e-3


def test_effects_are_found_jointly_with_the_law():
    fit = fit_actuator(six_loops(effects=(HubInertia(0.04), ViscousFriction(0.1))), (HubInertia, ViscousFriction), suggest=False)
    assert fit.estimates["hub-inertia.mass_kg"].value == pytest.approx(0.04, abs=1e-3)
    assert fit.estimates["viscous-friction.damping_N_s_per_m"].value == pytest.approx(0.1, abs=2e-3)
    assert fit.estimates["a_l_N_per_m"].value == pytest.approx(-0.25, abs=0.02)


def test_hub_inertia_at_one_frequency_is_said_to_be_undetermined():
    loops = [shaken(1.0, a, effects=(HubInertia(0.04),), seed=i) for i, a in enumerate((0.05, 0.02))]
    fit = fit_actuator(loops, (HubInertia,), suggest=False)
    assert fit.estimates["hub-inertia.mass_kg"].verdict == "not-identifiable"
    assert fit.verdict.word in ("not-identifiable", "model-does-not-apply")


def test_an_inertia_that_is_not_there_ends_at_its_bound_and_not_below():
    fit = fit_actuator(six_loops(effects=()), (HubInertia,), suggest=False)
    mass = fit.estimates["hub-inertia.mass_kg"]
    assert mass.value >= 0.0
    assert mass.verdict == "at-bound" or mass.ci95[0] < 0.0 < mass.ci95[1]


def test_slow_drift_of_the_load_cell_makes_the_intervals_wider():
    still = fit_actuator([shaken(1.0, cycles=10.3)], suggest=False)
    rng = np.random.default_rng(4)
    data = shaken(1.0, cycles=10.3)
    drift = np.cumsum(rng.standard_normal(len(data.force_N))) * 2e-4
    moved = fit_actuator([prepare(Loop(data.time_s, data.elongation_m, data.force_N + drift))], suggest=False)
    assert moved.estimates["b_l_N"].stderr > 3.0 * still.estimates["b_l_N"].stderr


def test_a_polynomial_in_frequency_gives_each_loop_its_asymptotes():
    def lines(f):
        return LINES + np.array([0.0, 0.02 * f, 0.0, 0.03 * f, 0.0])

    loops = [shaken(f, seed=i, lines=lines(f)) for i, f in enumerate((0.5, 1.0, 2.0, 3.0))]
    fit = fit_actuator(loops, abscissa="frequency_Hz", order=1, suggest=False)
    polynomials = fit.polynomials()
    assert polynomials["b_l"] == pytest.approx((2.79, 0.02), abs=3e-3)
    assert polynomials["b_u"] == pytest.approx((2.89, 0.03), abs=3e-3)


def test_frequencies_left_out_choose_the_order_that_the_loops_have():
    frequencies = (0.5, 1.0, 1.6, 2.3, 3.0)
    flat = [shaken(f, seed=i) for i, f in enumerate(frequencies)]
    assert choose_order(flat, (), "frequency_Hz").chosen == 0
    bent = [shaken(f, seed=i, lines=LINES + np.array([0, 0.02 * f, 0, 0.02 * f, 0])) for i, f in enumerate(frequencies)]
    choice = choose_order(bent, (), "frequency_Hz")
    assert choice.chosen == 1
    assert set(choice.left_out) == {0, 1, 2}
    assert choice.left_out[0] > 2.0 * choice.left_out[1]
    assert choice.papers is not None
    assert choice.papers["b_l"][:2] == pytest.approx((2.79, 0.02), abs=6e-3)


def test_frequencies_are_left_out_as_by_fits_from_scratch():
    loops = [shaken(f, seed=i, lines=LINES + np.array([0, 0.02 * f, 0, 0.03 * f, 0])) for i, f in enumerate((0.5, 1.0, 1.6, 3.0))]
    quick = choose_order(loops, (), "frequency_Hz").left_out
    for order in (0, 1, 2):
        parts = []
        for data in loops:
            others = [other for other in loops if other is not data]
            fit = fit_actuator(others, abscissa="frequency_Hz", order=order, suggest=False)
            problem = fit.fit.problem
            parts.append(gap(problem.lines_at(fit.fit.q, problem.rate.z_of(data)), data) / data.force_range_N)
        assert quick[order] == pytest.approx(np.sqrt(np.mean(np.concatenate(parts) ** 2)), rel=1e-3)


@pytest.mark.parametrize("own_zeros", [False, True])
def test_slopes_of_the_gaps_are_those_of_differences(own_zeros):
    loops = [shaken(f, seed=i, level=0.01 * i) for i, f in enumerate((0.5, 1.0, 3.0))]
    problem = problem_of_loops(loops, (HubInertia,), "frequency_Hz", 2, own_zeros=own_zeros).with_exact_motion()
    q = 0.3 * np.random.default_rng(3).normal(size=len(problem.parameters))
    q[-1] = 0.5  # a mass is not negative
    _, slopes = problem.jacobian(q)
    steps = 1e-5 * np.eye(len(q))
    differences = np.stack([(problem.gaps(q + step) - problem.gaps(q - step)) / 2e-5 for step in steps], axis=1)
    assert np.allclose(slopes, differences, rtol=0.0, atol=1e-4 * np.linalg.norm(differences, axis=0).max() / np.sqrt(len(differences)))


def test_loops_of_two_frequencies_are_no_ground_for_the_papers_polynomials():
    choice = choose_order([shaken(1.0), shaken(2.0)], (), "frequency_Hz")
    assert choice.papers is None
    assert "three frequencies" in choice.sentences(0)[1]


def test_a_tare_that_differs_from_loop_to_loop_is_noticed_and_taken_out():
    levels = (0.0, 0.2, -0.1)
    loops = [shaken(1.0, seed=i, level=level) for i, level in enumerate(levels)]
    fit = fit_actuator(loops, tare="auto", suggest=False)
    assert np.array(fit.tares_N) == pytest.approx(np.array(levels) - np.mean(levels), abs=2e-3)
    assert fit.half_height_N == pytest.approx(0.05 - 0.05 * 0.25 / 2, abs=1e-3)
    same = fit_actuator([shaken(1.0, seed=i) for i in range(3)], tare="auto", suggest=False)
    assert same.tares_N == (0.0, 0.0, 0.0)


def test_the_papers_recipe_finds_the_lines_but_hardly_beta():
    fit = fit_actuator(six_loops(), suggest=False)
    assert fit.recipe is not None
    assert fit.recipe.lines[:4] == pytest.approx(LINES[:4], abs=0.02)
    assert 50.0 < fit.recipe.beta_per_m < 4000.0


def test_an_area_no_beta_can_enclose_is_said_instead_of_solved():
    loops = [shaken(1.0, 0.05, effects=(ViscousFriction(0.5),), noise=0.0)]
    recipe = fit_actuator(loops, suggest=False).recipe
    assert recipe is not None
    if not np.isfinite(recipe.beta_per_m):
        assert recipe.statement.startswith("no beta gives the measured area")


def test_a_clockwise_loop_is_not_an_actuator():
    data = shaken(1.0)
    fit = fit_actuator([prepare(Loop(data.time_s, data.elongation_m, -data.force_N))])
    assert fit.verdict.word == "model-does-not-apply"
    assert "clockwise" in fit.verdict.reason


def test_beta_of_a_rectangular_loop_is_not_taken_for_known():
    sharp = np.array([-0.25, 2.79, -0.3, 2.89, 4e6])
    fit = fit_actuator([shaken(1.0, lines=sharp)], suggest=False)
    assert fit.estimates["beta_per_m"].verdict in ("at-bound", "not-identifiable")
    assert fit.verdict.word == fit.estimates["beta_per_m"].verdict


def test_a_ramp_that_never_turns_is_refused():
    t = np.linspace(0.0, 1.0, 200)
    with pytest.raises(InputError, match="never turns"):
        fit_actuator([prepare(Loop(t, t, 2.0 + 0.1 * t))])


def test_too_few_frequencies_for_the_polynomials_are_refused():
    with pytest.raises(InputError, match="needs 3"):
        fit_actuator([shaken(1.0), shaken(2.0)], abscissa="frequency_Hz", order=2)


def test_an_effect_that_no_loop_can_show_is_refused():
    with pytest.raises(InputError, match="gravity-imbalance"):
        fit_actuator([shaken(1.0)], (GravityImbalance,))


def test_a_pressure_that_pushes_along_is_found_and_taken_out():
    rng = np.random.default_rng(2)
    plain = shaken(1.0)
    pressure = 5.0 + 0.02 * np.sign(-plain.speed_m_per_s) + 0.01 * rng.standard_normal(len(plain.force_N))
    force = plain.force_N + 2.0 * (pressure - 5.0)
    loop = Loop(plain.time_s, plain.elongation_m, force, other={"pressure_bar": pressure, "force_V": force / 50.0})
    blind = fit_actuator([prepare(loop)], suggest=False)
    assert set(blind.covariate_shares) == {"pressure_bar"}
    assert blind.covariate_shares["pressure_bar"] > 0.5
    fit = fit_actuator([prepare(loop)], covariate="pressure_bar", suggest=False)
    assert fit.estimates["covariate.pressure_bar"].value == pytest.approx(2.0, abs=0.05)
    assert fit.half_height_N == pytest.approx(0.04375, abs=2e-3)


def test_spikes_do_not_move_a_robust_fit():
    data = shaken(1.0, cycles=5.3)
    rng = np.random.default_rng(8)
    spikes = np.where(rng.random(len(data.force_N)) < 0.03, 1.0, 0.0) * rng.uniform(0.5, 2.0, len(data.force_N))
    spiky = prepare(Loop(data.time_s, data.elongation_m, data.force_N + spikes))
    off = {robust: abs(fit_actuator([spiky], robust=robust, suggest=False).estimates["b_u_N"].value - 2.89) for robust in (True, False)}
    assert off[True] < 0.012
    assert off[True] < off[False] / 3.0
