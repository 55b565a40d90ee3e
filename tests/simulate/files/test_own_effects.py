"""Effects defined outside the project work like ours, in a loop and in a deployment, through one formula each."""

import importlib
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.deployment.deploy import deploy
from simulate.dispatch.formulas import address
from simulate.files.own_effects import catalogue_with
from simulate.loop import loop_force
from simulate.model.effect import LegEffect, PlatformEffect, parameter
from simulate.model.model import Geometry, Simulation

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class ReturnSpring(LegEffect):
    name = "return-spring"
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=100.0, typical=1.0, doc="pulls the strip back")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return -p[0] * u


@dataclass(frozen=True)
class Softening(LegEffect):
    name = "softening"
    slope_N_per_m: float = parameter(0.0, low=-10.0, high=10.0, typical=1.0, doc="added to the slope of both asymptotes")

    @staticmethod
    def leg_asymptotes(u, v, t, p, h):
        h[0] += p[0] * u
        h[1] += p[0] * u


@dataclass(frozen=True)
class Syrup(PlatformEffect):
    name = "syrup"
    damping_N_s_per_m: float = parameter(0.0, low=0.0, high=100.0, typical=1.0, doc="drag on the platform")

    @staticmethod
    def platform_wrench(t, pose, twist, p, wrench):
        for k in range(3):
            wrench[k] -= p[0] * twist[k]


LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
U = 0.05 * np.sin(np.linspace(0.0, 12.0, 2001))
ZERO = np.zeros_like(U)
MASS, FORCE = 1.6, 0.5


@pytest.fixture
def lift(prototype):
    """A platform on six vertical legs of constant force: elongation is height, and the motion has a closed form."""
    ring: Any = tuple((float(np.cos(a)), float(np.sin(a)), 0.0) for a in np.arange(6) * np.pi / 3)
    law = replace(prototype.actuator, a_l_N_per_m=0.0, b_l_N=FORCE, a_u_N_per_m=0.0, b_u_N=FORCE, initial_force_N=FORCE)
    return replace(prototype, geometry=Geometry(ring, ring), actuator=law, effects=(), simulation=Simulation(0.3, 100.0))


def height(run):
    return run.channels["z_m"] - 0.252


def test_a_spring_from_outside_adds_its_force_to_a_loop():
    added = loop_force(LINES, np.arange(2001.0), U, ZERO, ZERO, 2.9, (ReturnSpring(3.0),)) - loop_force(
        LINES, np.arange(2001.0), U, ZERO, ZERO, 2.9
    )
    assert np.max(np.abs(added + 3.0 * U)) < 1e-12


def test_a_spring_from_outside_makes_the_platform_an_oscillator(lift):
    run = deploy(lift.with_effect(ReturnSpring(8.0)))
    frequency = np.sqrt(6 * 8.0 / MASS)
    assert np.max(np.abs(height(run) - FORCE / 8.0 * (1 - np.cos(frequency * run.time_s)))) < 1e-9


def test_asymptotes_from_outside_are_the_same_as_the_models_own_slope():
    steeper = LINES + np.array([1.5, 0.0, 1.5, 0.0, 0.0])
    outside = loop_force(LINES, np.arange(2001.0), U, ZERO, ZERO, 2.9, (Softening(1.5),))
    assert np.max(np.abs(outside - loop_force(steeper, np.arange(2001.0), U, ZERO, ZERO, 2.9))) < 1e-12


def test_asymptotes_from_outside_are_the_models_own_slope_in_a_deployment(lopsided):
    law = lopsided.actuator
    steeper = replace(law, a_l_N_per_m=tuple(a + 1.5 for a in law.a_l_N_per_m), a_u_N_per_m=tuple(a + 1.5 for a in law.a_u_N_per_m))
    brief = replace(lopsided, simulation=Simulation(0.4, 100.0))
    outside, inside = deploy(brief.with_effect(Softening(1.5))), deploy(replace(brief, actuator=steeper))
    assert np.max(np.abs(outside.samples - inside.samples)) < 1e-9


def test_drag_from_outside_brings_the_platform_to_a_steady_speed(lift):
    run = deploy(lift.with_effect(Syrup(20.0)))
    decay = 20.0 / MASS
    speed = 6 * FORCE / 20.0
    assert np.max(np.abs(height(run) - speed * (run.time_s - (1 - np.exp(-decay * run.time_s)) / decay))) < 1e-9
    assert run.energy_closure < 1e-9


TWICE = '''
from dataclasses import dataclass
from simulate.model.effect import LegEffect, parameter

@dataclass(frozen=True)
class Twice(LegEffect):
    """A spring that is used under two names."""

    name = "twice"
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=100.0, typical=1.0, doc="pulls the strip back")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return -p[0] * u
'''


COMPILE = """
import sys
from pathlib import Path
from simulate.dispatch.formulas import address
from simulate.dispatch.formulas import address
from simulate.files.own_effects import catalogue_with
if sys.argv[1] == "command":
    kind = catalogue_with([Path("springs_of_mine.py")])["twice"]
else:
    sys.path.insert(0, "")
    from springs_of_mine import Twice as kind
address(kind.leg_force, "leg_force")
"""


@pytest.mark.parametrize("first", ["python", "command"])
def test_a_file_of_effects_works_from_python_first_and_then_from_a_command_or_the_other_way_round(tmp_path, monkeypatch, first):
    """What is compiled is kept beside the file, for the module's name of then."""
    file = tmp_path / "springs_of_mine.py"
    file.write_text(TWICE)
    subprocess.run([sys.executable, "-c", COMPILE, first], cwd=tmp_path, check=True, env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert list((tmp_path / "__pycache__").glob("*.nbc"))
    if first == "command":
        monkeypatch.syspath_prepend(tmp_path)
        kind = importlib.import_module("springs_of_mine").Twice
    else:
        kind = catalogue_with([file])["twice"]
    assert address(kind.leg_force, "leg_force")
    sys.modules.pop("springs_of_mine", None)


def test_a_formula_that_cannot_be_compiled_is_a_sentence_with_its_line(tmp_path, prototype):
    file = tmp_path / "wordy.py"
    file.write_text(TWICE.replace("return -p[0] * u", "return -p[0] * u * len(dir())").replace("twice", "wordy"))
    made: Any = catalogue_with([file])["wordy"]
    with pytest.raises(InputError, match=r"wordy\.py, line 1\d: .*cannot be compiled"):
        deploy(prototype.with_effect(made(20.0)))
