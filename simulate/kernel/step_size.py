"""The step of the integrator, chosen for the model at hand, and the grid of samples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np

from measure.common.errors import InputError
from simulate.kernel.response_kernel import Pace
from simulate.model.control import Controller, SampledController
from simulate.model.effect import Effect
from simulate.model.model import Model
from simulate.model.rig import LEGS, longest_arm

LONGEST_STEP_S = 5.0e-4
LONGEST_FLIGHT_S = 2.0e-3  # of a sweep's runs, whose steps are their own
_SETTING_IN = 0.35  # of a stop's smoothing length, in one of them
_AT_STOPS = 2.0  # times the step of a single deployment, which has the same for flight and stops
_STEPS_A_RADIAN = 5.0
_STABLE = 0.125  # of the slope of a controller's dry friction at rest: with it the step is at 0.6 of the limit of stability
_SET_IN = 3.0  # times the speed at which dry friction sets in: its slope is a hundredth there
_MOST_STEPS = 5_000_000  # some 20 s on one core; the run is repeated with half the step
_MOST_SAMPLES = 2_000_000  # some 600 MB
_FINER, _ON_A_STEP = 20, 1e-6  # times shorter for a controller's samples; of a step, by which these may miss it
_SLOW = 1e-5  # m/s and m: small against what eases friction in


def unhurried_step() -> float:
    """The step of a model in which nothing is stiff, s."""
    return LONGEST_STEP_S


def longest_flight() -> float:
    """The longest step of a sweep's runs, s."""
    return LONGEST_FLIGHT_S


def step_of(model: Model, longest: float = LONGEST_STEP_S, near_rest: bool = True) -> float:
    """The step for a model: a fraction of its stiffest time constant, at most half a millisecond unless told otherwise.

    The sampling rate is not the step: a step of 1 ms loses most runs of the paper's design at the stops. Stiff are the
    stops, as a spring, w = sqrt(6 k / m), and as a damper, 6 c / m, on the platform's mass and on its smallest inertia seen
    at the joints, and likewise what effects add, dry friction by its slope at rest. The hysteresis is exact in the
    elongation and asks for nothing.

    near_rest : whether the dry friction of a controller is near rest, where alone it is stiff.
    """
    if model.simulation.step_s is not None:
        return model.simulation.step_s
    at = model.adjusted()
    mass = at.gravity.mass_factor * _lightest_mass(at)
    added = [_stiffness(effect, at) for effect in at.effects]
    added += [] if at.controller is None else [_controller_stiffness(at.controller, at, near_rest)]
    spring = LEGS * at.end_stop.stiffness_N_per_m + sum(k for k, _ in added)
    damper = LEGS * at.end_stop.damping_N_s_per_m + sum(c for _, c in added)
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        fastest = float(max(np.sqrt(np.float64(spring) / mass), np.float64(damper) / mass, 1e-9))
    return min(longest, 1.0 / min(_STEPS_A_RADIAN * fastest, 1e300)) if math.isfinite(fastest) else 1e-300


def _lightest_mass(model: Model) -> float:
    """The platform's mass, or its inertia over the squared arm of a joint where that is less, kg."""
    arm = longest_arm(model)
    inertia = min(model.platform.inertia_kg_m2)
    return min(model.platform.mass_kg, inertia / arm**2 if arm > 0 else math.inf)


def _stiffness(effect: Effect, model: Model) -> tuple[float, float]:
    """Spring and damper that an effect adds as the platform feels it at rest, N/m and N s/m, from its own formulas."""
    p = [*effect.flat().tolist(), *effect.constants_of(model)]
    spring, damper = effect.stiffness(model)
    if effect.leg_force is not None:
        rest, fast, away = (effect.leg_force(0.1 + u, v, 0.0, 3.0, 1.0, p) for u, v in ((0.0, 0.0), (0.0, _SLOW), (_SLOW, 0.0)))
        spring, damper = spring + LEGS * abs(away - rest) / _SLOW, damper + LEGS * abs(fast - rest) / _SLOW
    if effect.platform_wrench is not None:
        rest, fast, away = (_force(effect, p, x, v) for x, v in ((0.0, 0.0), (0.0, _SLOW), (_SLOW, 0.0)))
        spring, damper = spring + _size(away - rest) / _SLOW, damper + _size(fast - rest) / _SLOW
    if effect.joint_resistance is not None:
        arm = longest_arm(model)
        damper += LEGS * effect.joint_resistance(0.0, p) * (1.0 / max(arm, 0.02) ** 2 + 1.0 / 0.2**2)
    return spring, damper


def _controller_stiffness(controller: Controller, model: Model, near_rest: bool) -> tuple[float, float]:
    """Spring and damper of a controller on all legs, N/m and N s/m, near rest with its dry friction, which sets in as tanh(v / speed)."""
    spring, damper = controller.stiffness(model)
    force, speed = controller.dry_friction()
    slope = _STABLE * force / speed if near_rest else 0.0
    return LEGS * spring, LEGS * max(damper, slope)


def _force(effect: Effect, p: list[float], x: float, v: float) -> Any:
    wrench = np.zeros(6)
    effect.platform_wrench(0.0, np.array([x, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0]), np.array([v, v, v, 0.0, 0.0, 0.0]), p, wrench)
    return wrench[:3]


def _size(force: Any) -> float:
    return float(np.linalg.norm(force))


def _asks_for_so_many(model: Model, step: float, longest: float) -> str:
    """The key that a run has so many steps by, and which way it is to be changed."""
    if model.simulation.step_s is not None:
        return f"simulation.step_s ({step:.3g} s): give a longer one, or leave it out"
    if step > longest / 10.0:
        return f"simulation.duration_s ({model.simulation.duration_s:g} s) or simulation.sample_rate_Hz: give less"
    at = model.adjusted()
    bare = replace(at, effects=())
    stiff = max(at.effects, key=lambda effect: sum(_stiffness(effect, at)), default=None)
    if stiff is not None and step_of(bare, longest) > 2.0 * step:
        return f"the parameters of {stiff.name}: so stiff an effect needs so small a step"
    soft = replace(bare, end_stop=replace(at.end_stop, stiffness_N_per_m=0.0))
    name = "stiffness_N_per_m" if step_of(soft, longest) > 2.0 * step else "damping_N_s_per_m"
    return f"end_stop.{name} ({getattr(at.end_stop, name):g}), or the platform's mass and inertia: so stiff a stop needs so small a step"


def pace_of(model: Model, longest: float = LONGEST_FLIGHT_S) -> Pace:
    """The steps of a sweep's runs: in flight as long as told where nothing is stiff, at a stop as its stiffness asks.

    All steps are in proportion to `longest`, so that half of it halves them. A model that gives a step gives both. With a controller none
    goes beyond its next sample, or the next command that arrives, so these ask for nothing. Its dry friction is stiff near rest only: a
    step is as short as that asks where a leg is slow, or could have become slow at its end. Brakes turn about where legs rest at a stop,
    so steps there are half as long.

    Raises
    ------
    InputError
        As `grid`.
    """
    _, _, samples = grid(model)
    given, between = model.simulation.step_s, 1.0 / model.simulation.sample_rate_Hz
    fineness = min(1.0, (given or longest) / LONGEST_FLIGHT_S)
    if given:
        return Pace(_beside_samples(given, between), given, _SETTING_IN * fineness, between, samples, given, 0.0, 0.0, 4)
    flying = replace(model, end_stop=replace(model.end_stop, stiffness_N_per_m=0.0, damping_N_s_per_m=0.0))
    frame, near_rest = (fineness * step_of(flying, LONGEST_FLIGHT_S, slow) for slow in (False, True))
    braked = model.controller is not None and not model.controller.passive
    at_stops = (1.0 if braked else _AT_STOPS) * step_of(model, math.inf)
    slow, per_braking = _slow_down(model)
    return Pace(
        frame, fineness * at_stops, _SETTING_IN * fineness, between, samples, near_rest, slow, fineness * per_braking, _stages(model)
    )


def _stages(model: Model) -> int:
    """Stages of a step: three, of third order, where a controller's samples keep it to half of what it could be in flight or less."""
    rate = getattr(model.controller, "sample_rate_Hz", None)
    return 3 if rate is not None and rate * LONGEST_FLIGHT_S >= 2.0 - 1e-9 else 4


def _slow_down(model: Model) -> tuple[float, float]:
    """Speed below which a leg is near rest, m/s, and over the largest deceleration by dry friction, s^2/m."""
    if model.controller is None:
        return 0.0, 0.0
    force, speed = model.controller.dry_friction()
    at = model.adjusted()
    return _SET_IN * speed, at.gravity.mass_factor * _lightest_mass(at) / (LEGS * force) if force > 0.0 else math.inf


def _beside_samples(step: float, between: float) -> float:
    """The longest step, not above the given one, that is a multiple or a fraction of the time between two samples."""
    return between * math.floor(step / between + 1e-9) if step >= between else between / math.ceil(between / step - 1e-9)


def finest(paces: Iterable[Pace]) -> Pace:
    """The finest of the paces of models that share duration and sampling."""
    frames, at_stops, parts, between, samples, near_rest, slow, per_braking, stages = zip(*paces, strict=True)
    return Pace(min(frames), min(at_stops), min(parts), between[0], samples[0], min(near_rest), max(slow), min(per_braking), max(stages))


def _steps_between_samples(stride: int, between: float, controller: Controller | None) -> int:
    """At least so many steps between two samples that a controller's own samples, and the commands that arrive, fall on steps.

    Where that would ask for steps many times shorter they fall within a step, and act from the next one on.
    """
    if not isinstance(controller, SampledController) or controller.sample_rate_Hz is None:
        return stride
    times = np.array([1.0 / controller.sample_rate_Hz, controller.delay_s]) / between
    tried = np.arange(stride, _FINER * stride + 1)
    off = np.abs(np.outer(tried, times) - np.round(np.outer(tried, times)))
    fit = np.flatnonzero(np.all(off < _ON_A_STEP, axis=1))
    return int(tried[fit[0]]) if len(fit) else stride


def grid(model: Model, longest: float = LONGEST_STEP_S) -> tuple[float, int, int]:
    """Step in s, steps between two samples, number of samples.

    Raises
    ------
    InputError
        The run would take more steps than anybody waits for, or more samples than fit into memory.
    """
    with np.errstate(all="ignore"):
        simulation, step = model.simulation, step_of(model, longest)
        between = float(np.float64(1.0) / simulation.sample_rate_Hz)
        wanted = float(np.float64(simulation.duration_s) * simulation.sample_rate_Hz)
        steps = float(np.float64(max(between, simulation.duration_s)) / step)
    if not (steps <= _MOST_STEPS and wanted <= _MOST_STEPS):
        raise InputError(
            f'model "{model.name}": {max(steps, wanted):.3g} steps of {step:.3g} s; at most {_MOST_STEPS:.0e} are run. '
            f"Change {_asks_for_so_many(model, step, longest)}."
        )
    stride = _steps_between_samples(max(1, math.ceil(between / step - 1e-9)), between, model.controller)
    count = math.floor(wanted + 1e-9) + 1
    if count > _MOST_SAMPLES:
        raise InputError(
            f'model "{model.name}": {count:.3g} samples; at most {_MOST_SAMPLES:.0e} are kept. Shorten duration_s, or lower sample_rate_Hz.'
        )
    return between / stride, stride, count
