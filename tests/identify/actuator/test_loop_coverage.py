"""Intervals that hold the truth as often as they say, over many made sets of loops."""

import numpy as np
import pytest
from calibration import consistent, share

from identify.actuator.fit_actuator import fit_actuator
from identify.loops.prepare import prepare
from measure import Loop
from simulate.effects import HubInertia, ViscousFriction
from simulate.loop import loop_force

RATE, FINE = 300.0, 10


def coloured(rng, n, correlation):
    noise = rng.standard_normal(n)
    for i in range(1, n):
        noise[i] = correlation * noise[i - 1] + np.sqrt(1.0 - correlation**2) * noise[i]
    return noise


def shaken(rng, frequency, amplitude, lines, effects):
    """Two to four cycles from any phase; coloured noise, drift and creep of the force; 5 um steps of the elongation."""
    n = int(rng.uniform(2.3, 3.7) / frequency * RATE)
    t = np.arange(n * FINE) / (RATE * FINE)
    w, phase = 2 * np.pi * frequency, rng.uniform(0, 2 * np.pi)
    wave, slope = np.sin(w * t + phase), w * np.cos(w * t + phase)
    force = loop_force(lines, t, 0.25 + amplitude * wave, amplitude * slope, -amplitude * w**2 * wave, 2.85, effects)[::FINE]
    force = force + 2e-3 * coloured(rng, n, rng.uniform(0.0, 0.8))
    force += rng.uniform(0.0, 2e-3) * rng.standard_normal() * np.linspace(-1, 1, n)
    force += rng.uniform(0.0, 1e-3) * np.cumsum(rng.standard_normal(n)) / np.sqrt(n)
    u = np.round((0.25 + amplitude * wave[::FINE] + 2e-6 * rng.standard_normal(n)) / 5e-6) * 5e-6
    return prepare(Loop(t[::FINE], u, force))


def drawn(seed, number):
    """A law, and how each of its numbers and the effects' are found from six loops: the fit and the truth, by name."""
    rng = np.random.default_rng([seed, number])
    lines = np.array([rng.uniform(-0.4, -0.1), 2.79, rng.uniform(-0.4, -0.1), 2.89, np.exp(rng.uniform(np.log(150), np.log(900)))])
    effects = (HubInertia(0.03), ViscousFriction(0.08))
    loops = [shaken(rng, f, a, lines, effects) for f in (0.4, 1.0, 3.0) for a in (0.05, 0.02)]
    fit = fit_actuator(loops, (HubInertia, ViscousFriction))
    return fit, dict(zip(fit.estimates, [*lines, 0.03, 0.08], strict=True))


def test_a_creep_that_a_relaxation_imitates_is_not_called_one():
    """A random walk of less than a millinewton was taken for a relaxation of 0.05 %: many samples, but hardly any independent."""
    fit, _ = drawn(7310042, 10)
    assert not fit.trials
    assert fit.verdict.word == "ok"


NOTE = (
    "Clean loops with coloured noise, drift and creep; aim 90 to 99 % of the intervals of fits called ok. Of the sets at least 85 % are to "
    "be called ok: in some a drift is surely there that moves a number by more than its standard error, and is named."
)
CALLED_OK = 0.85


@pytest.mark.calibrate
def test_95_percent_intervals_hold_the_truth_in_90_to_99_percent_of_200_sets_of_loops(calibration_seed, share_of, validation_table):
    held: dict[str, list[bool]] = {}
    off: dict[str, list[float]] = {}
    words = []
    for number in range(share_of(200)):
        fit, truths = drawn(calibration_seed, number)
        words.append(fit.verdict.word)
        for (name, estimate), truth in zip(fit.estimates.items(), truths.values(), strict=True) if words[-1] == "ok" else ():
            held.setdefault(name, []).append(estimate.ci95[0] <= truth <= estimate.ci95[1])
            off.setdefault(name, []).append(abs(estimate.value - truth) / estimate.stderr)
    good, verdicts = words.count("ok"), ", ".join(f"{word} {words.count(word)}" for word in sorted(set(words)))
    rows = [
        {"parameter": name, "sets called ok": len(of), "held, %": 100 * np.mean(of), "farthest, standard errors": max(off[name])}
        for name, of in held.items()
    ]
    validation_table("95 % intervals that hold the truth", rows, NOTE)
    validation_table("Verdicts", [{"sets of loops": len(words), "verdicts": verdicts, "called ok, %": share(good, len(words))}])
    assert consistent(good, len(words), CALLED_OK), verdicts
    assert all(consistent(sum(of), len(of), 0.90, 0.99) for of in held.values()), rows
    assert max(map(max, off.values()), default=0.0) < 5.0
