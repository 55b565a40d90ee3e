"""Whatever the design of a test, a number that a fit calls ok is right: else a verdict, or a sentence."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from calibration import consistent

from identify.actuator.actuator_fit import ActuatorFit
from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from measure import InputError, Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.loop import loop_force
from simulate.model.effect import Effect

FINE = 20  # steps of the truth for each sample
SURE, SLIGHT = 6.0, 0.05  # standard errors, and parts of the number's natural size, that are both exceeded by what is wrong


@dataclasses.dataclass(frozen=True)
class Design:
    """A shaker test drawn at random: the truth, how it was moved, and how it was seen."""

    lines: np.ndarray
    effects: tuple[Effect, ...]
    frequencies_Hz: tuple[float, ...]
    amplitude_m: float
    centre_m: float
    sine: bool
    cycles: float
    samples: int  # a cycle
    noise_N: float
    memory: float  # of the noise, from sample to sample
    quantum_m: float


def drawn(chance: np.random.Generator) -> Design:
    height, amplitude, centre = 10 ** chance.uniform(-2, 0.5), 10 ** chance.uniform(-2.5, -0.7), chance.uniform(0, 0.3)
    level, sine = chance.uniform(0, 10), bool(chance.integers(2))
    a_l, a_u = chance.uniform(-1, 1, 2) * height / amplitude * chance.choice([0.1, 1.0])
    lines = np.array([a_l, level - a_l * centre, a_u, level + height - a_u * centre, 10 ** chance.uniform(1, 5.5)])
    mass, damping = min(4.0, height / amplitude / 100 * chance.uniform(0, 2)), min(100.0, height / amplitude / 20 * chance.uniform(0, 2))
    kinds = [(), (HubInertia(mass),), (ViscousFriction(damping),), (HubInertia(mass), ViscousFriction(damping))][chance.integers(4)]
    return Design(
        lines=lines,
        effects=kinds if sine else tuple(effect for effect in kinds if not isinstance(effect, HubInertia)),  # a corner is a blow
        frequencies_Hz=((1.0,), (1.0, 1.0), (0.3, 3.0), (0.2, 1.0, 3.0))[chance.integers(4)],
        amplitude_m=amplitude,
        centre_m=centre,
        sine=sine,
        cycles=chance.uniform(0.6, 4),
        samples=2 * int(10 ** chance.uniform(1.5, 3) / 2),
        noise_N=height * 10 ** chance.uniform(-3, -0.3),
        memory=chance.choice([0.0, 0.8]),
        quantum_m=chance.choice([0.0, 5e-6, 1e-4]),
    )


def seen(design: Design, frequency: float, chance: np.random.Generator) -> Loop:
    """One loop of it; the corners of a triangle lie on fine steps, so that the truth has them too."""
    amplitude, n = design.amplitude_m * chance.choice([1.0, 0.4]), max(int(design.cycles * design.samples), 20)
    step, w = np.arange(n * FINE), 2 * np.pi * frequency
    t = step / (frequency * design.samples * FINE)
    phase = int(chance.integers(design.samples * FINE))
    turn = (step + phase) / (design.samples * FINE)
    if design.sine:
        wave = np.array([np.sin(2 * np.pi * turn), w * np.cos(2 * np.pi * turn), -(w**2) * np.sin(2 * np.pi * turn)])
    else:
        wave = np.array([4 * np.abs(turn % 1 - 0.5) - 1, np.where(turn % 1 < 0.5, -4.0, 4.0) * frequency, 0 * turn])
    u, v, a = amplitude * wave
    u = u + design.centre_m
    middle = float(np.mean([design.lines[1], design.lines[3]]) + design.centre_m * np.mean(design.lines[[0, 2]]))
    force = loop_force(design.lines, t, u, v, a, middle, design.effects)[::FINE]
    noise = chance.standard_normal(n)
    for i in range(1, n if design.memory else 0):
        noise[i] = design.memory * noise[i - 1] + np.sqrt(1 - design.memory**2) * noise[i]
    shown = u[::FINE] + 2e-6 * chance.standard_normal(n)
    shown = np.round(shown / design.quantum_m) * design.quantum_m if design.quantum_m else shown
    return Loop(t[::FINE], shown, force + np.multiply(design.noise_N, noise))


def silently_wrong(design: Design, fit: ActuatorFit) -> list[str]:
    """Names of numbers that are called ok by a fit that is called ok, and are not."""
    if fit.verdict.word != "ok":
        return []
    height = float(design.lines[3] - design.lines[1] + (design.lines[2] - design.lines[0]) * design.centre_m)
    truth = [*design.lines, *np.concatenate([np.empty(0), *(effect.flat() for effect in design.effects)])]
    wrong = []
    for (name, estimate), true in zip(fit.estimates.items(), truth, strict=True):
        slope = height / design.amplitude_m / 2
        natural = slope + abs(true) if name.startswith("a_") else height if name.startswith("b_") else abs(true)
        error, stderr = abs(estimate.value - true), estimate.stderr
        if name == "beta_per_m":
            end = estimate.ci95[int(true > estimate.value)]  # of this side: the interval is not symmetric
            error, stderr = abs(np.log(estimate.value / true)), abs(np.log(end / estimate.value)) / 1.96
            natural = 1.0
        if estimate.verdict == "ok" and error > SURE * stderr and error > SLIGHT * natural:
            wrong.append(f"{name} {estimate.value:.4g} +- {estimate.stderr:.2g} for {true:.4g}")
    return wrong


def drawn_again(seed: int) -> ActuatorFit:
    """The fit of the loops of one design."""
    chance = np.random.default_rng(seed)
    design = drawn(chance)
    return fit_actuator([prepare(seen(design, f, chance)) for f in design.frequencies_Hz], tuple(type(e) for e in design.effects))


def judged(seeds: range) -> tuple[list[str], int]:
    """What was wrong without a word, by seed; and how many fits were called ok."""
    wrong, good = [], 0
    for seed in seeds:
        try:
            fit = drawn_again(seed)
        except InputError:
            continue
        good += fit.verdict.word == "ok"
        wrong += [f"seed {seed}: {text}" for text in silently_wrong(drawn(np.random.default_rng(seed)), fit)]
    return wrong, good


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning:lmfit")
def test_ten_designs_drawn_at_random_give_right_numbers_or_a_verdict():
    wrong, good = judged(range(10, 20))
    assert not wrong, wrong
    assert good > 1


@pytest.mark.calibrate
@pytest.mark.filterwarnings("ignore:invalid value encountered:RuntimeWarning:lmfit")
def test_of_six_hundred_designs_hardly_any_is_wrong_without_a_word(calibration_seed, share_of, validation_table):
    first, number = 1000 * calibration_seed, share_of(600)
    wrong, good = judged(range(first, first + number))
    designs = {text.partition(":")[0] for text in wrong}
    row = {"designs": number, "called ok": good, "of these wrong": len(designs), "which": "; ".join(wrong)}
    validation_table(
        "Fits that are called ok", [row], "Shaker tests drawn at random; a number is wrong if it is far off and said to be sure."
    )
    assert consistent(good, number, 0.25)
    assert consistent(len(designs), number, 0.0, 1 / 600)


T = np.arange(2000) / 400.0
LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])


def made(u, lines=LINES, effects: tuple[Effect, ...] = (), noise=2e-3, v=None, a=None):
    """A loop of this motion under the law, with noise."""
    v, a = (np.gradient(u, T) if v is None else v), (0 * T if a is None else a)
    force = loop_force(lines, T, u, v, a, 2.8, effects)
    return prepare(Loop(T, u, force + noise * np.random.default_rng(1).standard_normal(len(T))))


def wave(frequency=1.0, amplitude=0.05):
    return 0.25 + amplitude * np.sin(2 * np.pi * frequency * T)


def test_a_test_that_only_uncoils_is_refused():
    with pytest.raises(InputError, match="never turns"):
        fit_actuator([made(0.1 + 0.05 * T)])


def test_a_signal_that_does_not_change_is_refused():
    with pytest.raises(InputError, match=r"elongation_m is 0.25 in every row"):
        made(0.25 + 0 * T)


def test_one_reversal_gives_both_branches_and_no_beta_that_is_not_there():
    data = made(0.1 + 0.2 * (1 - np.abs(T - 2.5) / 2.5))
    fit = fit_actuator([data])
    assert np.isnan(data.frequency_Hz)
    for name, true in zip(fit.estimates, LINES, strict=True):
        estimate = fit.estimates[name]
        assert estimate.verdict != "ok" or abs(estimate.value - true) < 5 * estimate.stderr, name
    assert fit.estimates["b_u_N"].value == pytest.approx(2.89, abs=0.02)


def test_a_stroke_shorter_than_the_law_needs_to_come_near_its_asymptotes_does_not_pass_for_known():
    fit = fit_actuator([made(wave(amplitude=2e-4), noise=2e-4)])
    assert fit.verdict.word != "ok" or fit.estimates["b_u_N"].stderr > 5e-3


@pytest.mark.parametrize("beta", [3e4, 1e6])
def test_a_beta_far_beyond_the_samples_is_not_taken_for_known(beta):
    triangle = 0.25 + 0.05 * (4 * np.abs((T * 0.8) % 1 - 0.5) - 1)
    for u in (wave(3.0), triangle):
        fit = fit_actuator([made(u, np.array([*LINES[:4], beta]))])
        estimate = fit.estimates["beta_per_m"]
        assert estimate.verdict != "ok" or estimate.ci95[0] < beta < estimate.ci95[1]


def in_steps(step_m, amplitude, cycles, samples, frequency=1.0, triangle=False, effects: tuple[Effect, ...] = (), beta=400.0):
    """Sine or triangle, as a laser with steps of this size shows it."""
    turn = np.arange(int(cycles * samples) * FINE) / (samples * FINE) + 0.13
    w = 2 * np.pi * frequency
    shapes = np.sin(2 * np.pi * turn), w * np.cos(2 * np.pi * turn), -(w**2) * np.sin(2 * np.pi * turn)
    if triangle:
        shapes = 4 * np.abs(turn % 1 - 0.5) - 1, np.where(turn % 1 < 0.5, -4.0, 4.0) * frequency, 0 * turn
    u, v, a = amplitude * np.array(shapes)
    t = turn / frequency
    force = loop_force(np.array([*LINES[:4], beta]), t, 0.25 + u, v, a, 2.8, effects)[::FINE]
    noise = 1e-3 * np.random.default_rng(5).standard_normal(len(force))
    return prepare(Loop(t[::FINE], np.round((0.25 + u[::FINE]) / step_m) * step_m, force + noise))


def test_a_triangle_in_coarse_steps_is_not_taken_for_a_few_harmonics():
    """Five harmonics explained it down to its steps, rounded its corners off, and beta was four times too large."""
    estimate = fit_actuator([in_steps(1e-4, 0.004, 3.9, 500, triangle=True)]).estimates["beta_per_m"]
    low, high = estimate.ci95
    assert low / 1.1 < LINES[4] < 1.1 * high
    assert high < 1.5 * low


def test_a_sine_of_little_more_than_a_cycle_in_coarse_steps_shows_its_inertia():
    """Its acceleration came from neighbours in steps of a tenth of a millimetre, and an eighth of the inertia was left."""
    fit = drawn_again(3518)
    assert fit.verdict.word == "ok"
    assert fit.estimates["hub-inertia.mass_kg"].value == pytest.approx(0.1375, rel=0.04)


def test_a_viscous_friction_in_triangles_of_one_speed_is_not_told_from_a_height():
    viscous = (ViscousFriction(0.2),)
    slow, fast = (in_steps(1e-6, 0.02, 3.3, 300, f, True, viscous, 2e4) for f in (0.3, 1.0))
    name = "viscous-friction.damping_N_s_per_m"
    assert fit_actuator([fast], (ViscousFriction,)).estimates[name].verdict == "not-identifiable"
    both = fit_actuator([slow, fast], (ViscousFriction,)).estimates[name]
    assert both.verdict == "ok"
    assert both.value == pytest.approx(0.2, abs=0.02)


def test_without_a_full_cycle_there_is_no_loop():
    few = T < 0.9
    fit = fit_actuator([prepare(Loop(T[few], wave()[few], loop_force(LINES, T[few], wave()[few], 0 * T[few], 0 * T[few], 2.8)))])
    assert fit.verdict.word == "model-does-not-apply"
    assert "no closed loop" in fit.verdict.reason


def test_a_slow_plateau_of_the_misfit_makes_beta_unknown():
    """Noise that a loop of a tenth of its height could hide in, a beta that spans the stroke: twenty times larger is as good."""
    fit = drawn_again(2342)
    assert fit.estimates["beta_per_m"].verdict == "not-identifiable"


@pytest.mark.parametrize("cycles", [0.8, 1.1, 2.0, 5.0])
def test_an_inertia_at_one_frequency_is_never_told_from_a_slope(cycles):
    w, few = 2 * np.pi * 1.0, cycles > T
    u, v, a = wave(), 0.05 * w * np.cos(w * T), -0.05 * w**2 * np.sin(w * T)
    force = loop_force(LINES, T, u, v, a, 2.8, (HubInertia(0.03),)) + 2e-3 * np.random.default_rng(3).standard_normal(len(T))
    fit = fit_actuator([prepare(Loop(T[few], u[few], force[few]))], (HubInertia,))
    assert fit.estimates["hub-inertia.mass_kg"].verdict == "not-identifiable"
    assert fit.verdict.word != "ok"


def test_asymptotes_that_cross_are_said_to_cross():
    fit = fit_actuator([made(wave(), np.array([-1.5, 3.2, 1.0, 2.6, 400.0]))])
    assert "cross" in fit.verdict.reason


@pytest.mark.parametrize("samples", [30, 44, 160, 701])
def test_a_triangle_that_turns_between_two_samples_gives_beta_back(samples):
    """A polynomial through both sides of a corner rounds it off, and beta was up to five times too large."""
    step = np.arange(int(3.3 * samples) * FINE)
    turn = (step + 7) / (samples * FINE)
    u = 0.2 + 0.02 * (4 * np.abs(turn % 1 - 0.5) - 1)
    t = turn - turn[0]
    force = loop_force(LINES, t, u, 0 * t, 0 * t, 2.8)[::FINE]
    chance = np.random.default_rng(samples)
    n = len(force)
    loop = Loop(t[::FINE], u[::FINE] + 2e-6 * chance.standard_normal(n), force + 1e-3 * chance.standard_normal(n))
    estimate = fit_actuator([prepare(loop)]).estimates["beta_per_m"]
    assert abs(estimate.value - 400.0) < 4 * estimate.stderr
    assert estimate.stderr < 60.0
