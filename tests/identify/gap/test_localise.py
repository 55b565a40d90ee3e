"""Where a gap is and what it goes with, on curves that go with one thing by construction."""

from __future__ import annotations

import numpy as np
import pytest

from identify.gap.localise import smooth_derivative, strongest

TIME = np.linspace(0.0, 1.0, 200)
RAMP, WAVE = TIME - 0.5, np.sin(2.0 * np.pi * 3.0 * TIME)
SIDE = np.sign(np.cos(2.0 * np.pi * 3.0 * TIME))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("name", "driver"), [("elongation", RAMP), ("speed", WAVE), ("direction", SIDE)])
def test_a_force_goes_with_what_it_is_made_of_whatever_its_sign_size_and_level(name, driver, sign):
    drivers = {"elongation": RAMP + 7.0, "speed": WAVE, "direction": SIDE}
    noise = np.random.default_rng(0).normal(0.0, 0.2, 200)
    assert strongest(drivers, 1e-3 * (sign * driver + noise + 0.5)) == name


def test_noise_goes_with_nothing_clear_and_a_constant_force_with_nothing():
    drivers = {"elongation": RAMP, "speed": WAVE}
    noise = np.random.default_rng(1).normal(size=200)
    assert strongest(drivers, noise) == "nothing clear"
    assert strongest(drivers, 10.0 + noise) == "nothing"
    assert strongest(drivers, -10.0 + noise) == "nothing"
    assert strongest(drivers, 3.0 * np.ones(200)) == "nothing clear"


def test_a_driver_that_explains_a_third_of_the_variance_or_less_is_not_clear():
    mixed = WAVE / np.std(WAVE)
    noise = np.random.default_rng(2).normal(size=200)
    noise -= mixed * (noise @ mixed) / (mixed @ mixed)
    noise /= np.std(noise)
    for correlation, said in ((0.55, "nothing clear"), (0.65, "speed")):
        assert strongest({"speed": WAVE}, correlation * mixed + np.sqrt(1.0 - correlation**2) * noise) == said


def test_fewer_than_eight_samples_tell_nothing_and_eight_do():
    assert strongest({"time": TIME[:7]}, RAMP[:7]) == "nothing clear"
    assert strongest({"time": TIME[:8]}, RAMP[:8] - RAMP[:8].mean()) == "time"


def test_a_driver_that_stands_still_explains_nothing():
    assert strongest({"still": np.zeros(200), "speed": WAVE}, WAVE) == "speed"


def test_derivatives_of_a_cubic_are_exact():
    t = np.linspace(0.0, 2.0, 60)
    cubic = 1.0 + 2.0 * t - 3.0 * t**2 + 0.5 * t**3
    assert smooth_derivative(cubic, t[1], 1) == pytest.approx(2.0 - 6.0 * t + 1.5 * t**2, abs=1e-8)
    assert smooth_derivative(cubic, t[1], 2) == pytest.approx(-6.0 + 3.0 * t, abs=1e-6)
