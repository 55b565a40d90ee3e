"""What is left of a fit is followed by the effect that explains it, and noise by none."""

from __future__ import annotations

import numpy as np
import pytest
from calibration import consistent, share
from scipy.optimize import brentq

from identify.actuator.actuator_fit import ActuatorFit, as_good
from identify.actuator.fit_actuator import fit_actuator
from identify.actuator.trials import tried
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import CATALOGUE, HubInertia, ViscousFriction
from simulate.loop import loop_force
from simulate.model.effect import Effect

RATE, FINE = 300.0, 10
PLAIN = ("hub-inertia", "viscous-friction", "curved-asymptotes", "sensor-lag", "sensor-filter", "series-play", "force-offset")
SHAPED = {"stribeck-friction": {"speed_m_per_s": 0.05}, "power-law-friction": {"exponent": 2.0}, "transition-zone": {"length_m": 0.1}}
AMPLITUDES = {"sensor-filter": "time_s", "curved-asymptotes": "quadratic_N_per_m2", "force-offset": "drift_N_per_s"}
SEEN = 10.8  # noncentrality at which a test at one in a thousand finds one number half of the time
TIMES = 5.0  # that size
ALIKE = {"hub-inertia": {"leg-mass"}, "leg-mass": {"hub-inertia"}}


def effect_of(name: str, size: float) -> Effect:
    """An effect of a size, a shape given."""
    kind = CATALOGUE[name]
    if name in SHAPED:
        key = kind.flat_names()[0]
        return kind(**{key: size}, **SHAPED[name])
    key = AMPLITUDES.get(name, kind.flat_names()[0])
    return kind(**{key: (size, 0.0) if name == "sensor-filter" else size})


def moved(frequency: float, amplitude: float, cycles: float = 3.3) -> tuple[np.ndarray, ...]:
    n = int(cycles / frequency * RATE)
    t, w = np.arange(n * FINE) / (RATE * FINE), 2 * np.pi * frequency
    return t, amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)


def force_of(lines: np.ndarray, motion: tuple[np.ndarray, ...], effects: tuple[Effect, ...]) -> np.ndarray:
    t, u, v, a = motion
    force = loop_force(lines, t, 0.25 + u, v, a, 2.8, effects)
    for effect in effects:
        force = effect.observe_force(t, 0.25 + u, force)
    return force[::FINE]


def campaign(lines, chance, effects=(), noise=1e-3):
    """Six loops: three frequencies at two strokes."""
    loops = []
    for frequency in (0.4, 1.0, 3.0):
        for amplitude in (0.05, 0.02):
            motion = moved(frequency, amplitude)
            force = force_of(lines, motion, effects)
            seen = 0.25 + motion[1][::FINE] + 2e-6 * chance.standard_normal(len(force))
            loops.append(
                prepare(Loop(motion[0][::FINE], seen, force + noise * chance.standard_normal(len(force)), f"{frequency}-{amplitude}"))
            )
    return loops


def drawn_lines(chance):
    return np.array([chance.uniform(-0.4, 0.0), 2.79, chance.uniform(-0.4, 0.0), 2.89, np.exp(chance.uniform(np.log(150), np.log(700)))])


def at_times_the_detectable(name: str, lines: np.ndarray, fit: ActuatorFit, noise: float = 1e-3) -> Effect:
    """The effect at five times the size that a test finds half of the time: what law and zeros cannot imitate counts."""
    motions = [moved(f, a) for f in (0.4, 1.0, 3.0) for a in (0.05, 0.02)]
    plain = [force_of(lines, m, ()) for m in motions]

    def shown(size: float) -> float:
        changes = [force_of(lines, m, (effect_of(name, size),)) - p for m, p in zip(motions, plain, strict=True)]
        gaps, table = [], []
        for block, change, data in zip(fit.fit.problem.blocks, changes, fit.loops, strict=True):
            behind_start = (np.arange(len(change)) > data.cycles.reversals[0])[data.used]  # the force at the start is free
            gaps.append(change[data.used][behind_start] / noise)
            table.append(fit.fit.jacobian[block.rows][behind_start])
        seen, known = np.concatenate(gaps), np.concatenate(table)
        return float(np.linalg.norm(seen - known @ np.linalg.lstsq(known, seen, rcond=1e-10)[0]))

    wanted, high = TIMES * np.sqrt(SEEN), 1e-9
    while shown(high) < wanted and high < 1e4:
        high *= 3.0
    return effect_of(name, brentq(lambda size: shown(size) - wanted, high / 3.0, high))  # type: ignore[arg-type]


def first_named(name: str, seed: int) -> str:
    """The effect that is suggested first for loops with this one in them, or this one where it is said to do as well."""
    chance = np.random.default_rng([seed, sorted(CATALOGUE).index(name)])
    lines = drawn_lines(chance)
    effect = at_times_the_detectable(name, lines, fit_actuator(campaign(lines, chance), tare="auto", suggest=False))
    found = fit_actuator(campaign(lines, chance, (effect,)), tare="auto")
    if not found.trials:  # a drift that each zero has of its own is part of the fit
        return "force-offset" if any(fault.word == "drift" for fault in found.faults) else ""
    as_well = {*found.trials[0].alike, *(trial.name for trial in as_good(found.trials))}
    return name if name in as_well else found.trials[0].name


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hub-inertia", "viscous-friction", "sensor-lag"])
def test_an_effect_at_five_times_the_detectable_size_is_named_first(name):
    assert first_named(name, 1) in {name} | ALIKE.get(name, set())


def test_loops_of_the_law_alone_get_no_effect():
    chance = np.random.default_rng(7)
    assert not fit_actuator(campaign(drawn_lines(chance), chance), tare="auto").trials


@pytest.mark.slow
def test_an_effect_that_is_in_the_fit_is_not_suggested_again():
    chance = np.random.default_rng(3)
    loops = campaign(drawn_lines(chance), chance, (HubInertia(0.02), ViscousFriction(0.1)))[::2]
    assert {trial.name for trial in tried(fit_actuator(loops, (HubInertia,), suggest=False).fit)} >= {"viscous-friction"}
    assert not fit_actuator(loops, (HubInertia, ViscousFriction)).trials


def test_friction_is_not_called_viscous_while_an_inertia_is_missing():
    from identify.report.loop_result import result_of

    chance = np.random.default_rng(4)
    loops = campaign(drawn_lines(chance), chance, (HubInertia(0.05),))
    result = result_of(fit_actuator(loops), loops)
    assert result["suggestions"][0]["name"] in ("hub-inertia", "leg-mass")
    assert "while an inertia is missing" in result["friction"]


def test_one_frequency_says_that_it_cannot_tell_a_slope_from_an_inertia():
    from identify.report.loop_result import result_of

    chance = np.random.default_rng(5)
    loops = campaign(drawn_lines(chance), chance)
    assert "slope and inertia look alike" in result_of(fit_actuator(loops[2:4]), loops[2:4])["slopes"]
    assert not result_of(fit_actuator(loops), loops)["slopes"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["backlash", "power-law-friction", pytest.param("stribeck-friction", marks=pytest.mark.calibrate)])
def test_a_model_with_an_effect_more_never_fits_worse(kind):
    chance = np.random.default_rng(6)
    loops = campaign(drawn_lines(chance), chance, (ViscousFriction(0.3),))[::2]
    without, within = fit_actuator(loops, suggest=False), fit_actuator(loops, (CATALOGUE[kind],), suggest=False)
    assert within.fit.cost <= without.fit.cost * (1.0 + 1e-9)


@pytest.mark.calibrate
def test_of_sixty_sets_with_an_effect_it_is_named_first_and_of_sixty_without_none_is(calibration_seed, share_of, validation_table):
    names, number = (*PLAIN, *SHAPED), share_of(60)
    asked = [names[k % len(names)] for k in range(number)]
    found = [first_named(name, 1000 * calibration_seed + k) for k, name in enumerate(asked)]
    right = [got in {name} | ALIKE.get(name, set()) for name, got in zip(asked, found, strict=True)]
    none = []
    for k in range(number):
        chance = np.random.default_rng([calibration_seed, 99, k])
        none.append(not fit_actuator(campaign(drawn_lines(chance), chance), tare="auto").trials)
    wrong = "; ".join(f"{name}: {got or 'none'}" for name, got, ok in zip(asked, found, right, strict=True) if not ok)
    rows = [
        {"sets": f"{number} with one effect", "right": "it is named first", "%": share(sum(right), number), "aim, %": 90, "else": wrong},
        {"sets": f"{number} without", "right": "none is named", "%": share(sum(none), number), "aim, %": 95, "else": ""},
    ]
    validation_table(
        "Effects suggested by fit-actuator",
        rows,
        "The effect at five times the size that a test at one in a thousand finds half of the time; intervals after Clopper and Pearson.",
    )
    assert consistent(sum(right), number, 0.9)
    assert consistent(sum(none), number, 0.95)
