"""The sampled loop a second time, in plain NumPy on the plain NumPy platform: sensors, observer, delay, lag, brakes, failures."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy
from simulate.kernel.reference import Reference, carried, rotation
from simulate.model.model import Release, Simulation
from simulate.model.rig import stroke_of

STEP = 5e-4


def gauss(seed, sample, channel):
    """Noise of a reading: splitmix64 by counting, Box and Muller; whole numbers of any size, cut to 64 bits."""

    def uniform(place):
        z = (place + 1) * 0x9E3779B97F4A7C15 % 2**64
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
        z = (z ^ (z >> 27)) * 0x94D049BB133111EB % 2**64
        return (((z ^ (z >> 31)) >> 11) + 0.5) / 2**53

    place = ((seed * 2**24 + sample) * 8 + channel) * 2
    return math.sqrt(-2.0 * math.log(uniform(place))) * math.cos(2.0 * math.pi * uniform(place + 1))


class Controlled(Reference):
    """The plain platform with a controller that is called at every stage."""

    def __init__(self, model):
        super().__init__(model)
        self.c: Any = model.controller
        self.now = self.begun = 0.0
        self.stroke, self.k = stroke_of(model), 0
        self.pending, self.held, self.level = [], np.zeros(6), np.zeros(6)
        self.x, self.v, self.last = np.zeros(6), np.zeros(6), np.zeros(6)

    def stops(self, u, v):
        return super().stops(u, v) + self.act(v)

    def act(self, v):
        c = self.c
        faded = math.exp(-(self.now - self.begun) / c.lag_s) if c.lag_s else 0.0
        level = self.held + (self.level - self.held) * faded
        if c.actuator == "motor":
            return level
        friction = np.tanh(v / c.brake_speed_m_per_s)
        force = -friction * level
        if c.failed_brake and self.now >= c.failure_s:
            force[c.failed_brake - 1] = -friction[c.failed_brake - 1] * c.stuck_force_N
        return force

    def start_of_step(self, t, state):
        """What an electronic control does between two steps of integration."""
        c = self.c
        faded = math.exp(-(t - self.begun) / c.lag_s) if c.lag_s else 0.0
        self.level = self.held + (self.level - self.held) * faded
        self.begun = t
        self.arrive(t)
        if t > self.k / c.sample_rate_Hz - 1e-9:
            self.observe(t, self.lengths_of(state) - self.stowed, state)
            self.pending.append((t + c.delay_s, self.wanted(t)))
            self.k += 1
            self.arrive(t)

    def arrive(self, t):
        while self.pending and self.pending[0][0] <= t + 1e-9:
            self.held = self.pending.pop(0)[1]

    def observe(self, t, u, state):
        c, period = self.c, 1.0 / self.c.sample_rate_Hz
        if c.sensor == "camera":
            truth, noise, grain = (
                np.array([2 * math.atan2(state.quaternion[3], state.quaternion[0])]),
                c.sensor_noise_rad,
                c.sensor_step_rad,
            )
        else:
            truth, noise, grain = u, c.sensor_noise_m, c.sensor_step_m
        seen = truth + [noise * gauss(c.seed, self.k, i) for i in range(len(truth))]
        seen = np.round(seen / grain) * grain if grain else seen
        if c.failed_sensor and t >= c.failure_s and self.k:
            seen[c.failed_sensor - 1] = self.last[c.failed_sensor - 1]
        if self.k == 0:
            self.x, self.v = seen.copy(), np.zeros(len(seen))
        elif c.observer_Hz:
            z = math.exp(-2 * math.pi * c.observer_Hz * period)
            ahead = self.x + period * self.v
            self.x, self.v = ahead + (1 - z**2) * (seen - ahead), self.v + (1 - z) ** 2 / period * (seen - ahead)
        else:
            self.x, self.v = seen, (seen - self.last) / period
        self.last = seen
        self.arms = self.joints @ rotation(state.quaternion).T
        ways = state.place + self.arms - self.base
        self.levers = np.cross(self.arms, ways / np.linalg.norm(ways, axis=1)[:, None])[:, 2]

    def wanted(self, t):
        c = self.c
        x, v = (self.levers * self.x, self.levers * self.v) if c.sensor == "camera" else (self.x, self.v)
        if isinstance(c, Profile):
            s = min(t / c.duration_s, 1.0)
            way, pace = self.stroke * s**3 * (10 - 15 * s + 6 * s**2), self.stroke * 30 * s**2 * (1 - s) ** 2 / c.duration_s
        else:
            way, pace = x.mean(), v.mean()
        force = -c.stiffness_N_per_m * (x - way) - c.damping_N_s_per_m * (v - pace)
        if c.actuator == "motor":
            return np.clip(force, -c.force_limit_N, c.force_limit_N)
        along = 1.0 if c.sensor == "camera" else np.tanh(v / c.brake_speed_m_per_s)
        return np.clip(-along * force, 0.0, c.force_limit_N)

    def theta_z(self, steps):
        state, legs, seen = self.release(), self.legs_at_release(), []
        for k in range(steps + 1):
            t = self.now = k * STEP
            seen.append(2 * math.atan2(state.quaternion[3], state.quaternion[0]))
            self.start_of_step(t, state)
            first, u, force = self.rate(state, t, legs, max(t - STEP, 0.0))
            legs = carried(legs, u, force, self.strip(u, legs))
            state = self.later(state, first, t, STEP, legs)
        return np.degrees(np.unwrap(seen))

    def rate(self, state, t, before, t0):
        self.now = t
        return super().rate(state, t, before, t0)


REAL: dict[str, Any] = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4, "observer_Hz": 40.0}
BRAKES = Synchronise(stiffness_N_per_m=1500.0, damping_N_s_per_m=30.0, force_limit_N=1.5, **REAL)
CASES = {
    "brakes": BRAKES,
    "motors": replace(BRAKES, actuator="motor", lag_s=0.0),
    "differences and steps": replace(BRAKES, observer_Hz=None, sensor_noise_m=0.0, sensor_step_m=1e-5, delay_s=0.0),
    "a failed brake": replace(BRAKES, failed_brake=2, stuck_force_N=0.8, failure_s=0.05),
    "a failed sensor": replace(BRAKES, failed_sensor=5, failure_s=0.08),
    "a camera": replace(
        BRAKES, sensor="camera", sample_rate_Hz=250.0, delay_s=0.008, stiffness_N_per_m=4000.0, sensor_noise_rad=1e-3, sensor_step_rad=1e-4
    ),
    "a profile": Profile(duration_s=1.0, stiffness_N_per_m=800.0, damping_N_s_per_m=20.0, force_limit_N=5.0, **REAL),
}


def case(prototype, controller, seed, duration):
    rng = np.random.default_rng(seed)
    law = prototype.actuator.shifted(tuple(rng.uniform(-0.28, 0.28, 6)))
    release = Release(tuple(rng.normal(0.0, 1e-3, 3)), tuple(rng.normal(0.0, 2e-3, 3)))
    controller = replace(controller, seed=seed)
    return replace(prototype, actuator=law, release=release, controller=controller, simulation=Simulation(duration, 1000.0, STEP))


def apart(model):
    ours = np.degrees(deploy(model).channels["theta_z_rad"])
    steps = round(model.simulation.duration_s / STEP)
    return np.max(np.abs(ours - Controlled(model).theta_z(steps)[::2][: len(ours)])), np.max(np.abs(ours))


@pytest.mark.parametrize("name", CASES)
def test_the_compiled_loop_agrees_with_a_plain_one_on_the_way_to_the_stops(prototype, name):
    difference, turned = apart(case(prototype, CASES[name], 3, 0.15))
    assert difference < 1e-4
    assert turned > 0.05  # there is something to agree on


@pytest.mark.calibrate
def test_twenty_runs_of_a_second_agree_to_a_hundredth_of_a_degree(prototype):
    names = list(CASES)
    found = [apart(case(prototype, CASES[names[seed % len(names)]], seed, 1.0))[0] for seed in range(20)]
    assert max(found) < 0.01, found
