"""What it means that an effect is missing, in a phrase with its numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from identify.selection.verdict import Finding
from measure.pages.in_use import in_use, unit_in_use
from simulate.model.effect import Effect

PHRASES: Mapping[str, str] = {
    "hub-inertia": "each leg carries {mass_kg} more moving mass than the model",
    "leg-mass": "the strip of each leg, wholly uncoiled, weighs {mass_kg} that the model leaves out",
    "viscous-friction": "each leg brakes with {damping_N_s_per_m} times its speed, which the model leaves out",
    "power-law-friction": "each leg brakes with {coefficient} at 1 m/s, growing with the speed to the power {exponent}",
    "stribeck-friction": "each leg sticks with {force_N} more at rest, which fades at {speed_m_per_s}",
    "eddy-damping": "each leg has a magnetic brake of {damping_N_s_per_m} that is strongest at {speed_m_per_s}",
    "rate-dependent-asymptotes": "the restoring force of each leg depends on how fast it moves",
    "curved-asymptotes": "the restoring force bends with the elongation, by {quadratic_N_per_m2} and {cubic_N_per_m3}",
    "transition-zone": "near the stowed length each leg pushes {force_N} less than the model, fading over {length_m}",
    "force-relaxation": "the stored force of each leg has faded by {fraction} in the end, with a time constant of {time_s}",
    "backlash": "after each reversal a leg moves {gap_m} without force",
    "series-play": "after each reversal the strip follows its leg only beyond a play of {gap_m}",
    "ripple": "the force of each leg waves by {force_N}, once every {period_m}",
    "leg-disparity": "the six legs do not push alike; their stored forces are off by {force_N}",
    "joint-friction": "the joints resist turning, by {damping_N_m_s} and {moment_N_m}",
    "end-stop-dissipation": "the end stops damp by {damping_N_s_per_m} more than the model says",
    "stop-stiffness": "the end stops are stiffer than the model says by {fraction}",
    "gravity-imbalance": "weight and counterweight leave {force_N} over, upwards",
    "counterweight-inertia": "across the cable the platform weighs {lateral_mass_factor} of what it does along it",
    "pulley-inertia": "the pulley adds {mass_kg} to what moves up and down",
    "pulley-friction": "the pulley rubs with {force_N}",
    "cable-pendulum": "the suspension draws the platform back to the middle with {stiffness_N_per_m}",
    "air-drag": "the air brakes the platform with {coefficient_kg_per_m} times its speed squared",
    "handrail-contact": "the platform touches the handrails after {clearance_m} of free way, at {stiffness_N_per_m}",
    "base-excitation": "the base shakes with {acceleration_m_per_s2} at {frequency_Hz}",
    "flexible-base": "the base ring, {mass_kg}, swings at {frequency_Hz} on its support",
    "centre-of-mass-offset": "the platform's centre of mass is off by {offset_m}",
    "release-pose": "the platform is released from elsewhere than the model says, by {position_m}, {theta_rad} and {velocity_m_per_s}",
    "scale-error": "lengths on the film are measured too large by {fraction}",
    "camera-roll": "the camera is rolled by {angle_rad}",
    "lens-distortion": "the lens bends the picture by {per_m2}",
    "time-offset": "the camera's clock is off by {offset_s} and gains {rate_fraction}",
    "sensor-lag": "the load cell is {delay_s} late",
    "sensor-filter": "load cell and camera smooth what they see, with time constants of {time_s}",
    "force-offset": "the load cell shows {force_N} without load and drifts by {drift_N_per_s}",
    "stored-force-per-run": "the stored force differs from run to run, by {fraction}",
    "platform-mass": "the platform weighs {mass_kg} more than the model file says",
    "platform-inertia": "the platform's moments of inertia are off by {fraction}",
    "geometry-error": "the joints sit elsewhere than the model file says, by up to {position_m}",
}
_FEW, _DECIMALS = 3, 7


def with_error(value: float, error: float, *, alone: bool = False) -> str:
    """A number with two digits of its standard error: "399.9 \u00b1 1.2"; alone: with the same decimals, the error left out."""
    if not (np.isfinite(value) and np.isfinite(error) and error > 0.0):
        return f"{value:.4g}" if alone or not np.isfinite(error) else f"{value:.4g} \u00b1 {error:.2g}"
    decimals = 1 - int(np.floor(np.log10(error)))
    if decimals > _DECIMALS or abs(value) >= 1e7:
        return f"{value:.4g}" if alone else f"{value:.4g} \u00b1 {error:.2g}"
    shown = [f"{round(one, decimals):.{max(decimals, 0)}f}" for one in (value, error)]
    return shown[0] if alone else " \u00b1 ".join(shown)


def phrase_of(finding: Finding) -> str:
    """What is missing, in a phrase with values and 95 % intervals; of an effect of the user's own its name and parameters."""
    values = _values(finding)
    if finding.name in PHRASES:
        return PHRASES[finding.name].format_map(values)
    return f"the model lacks {finding.name}: " + ", ".join(f"{name} = {text}" for name, text in values.items())


def sized(effect: Effect, parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """The phrase of an effect that was fitted with loops, by the rows of its parameters."""
    texts = {}
    for item in fields(effect):
        row = parameters.get(f"{effect.name}.{item.name}")
        texts[item.name] = item.name if row is None else in_use(item.name, row["value"], row["ci95"])
    if effect.name in PHRASES:
        return PHRASES[effect.name].format_map(texts)
    return f"with {effect.name}: " + ", ".join(f"{name} = {text}" for name, text in texts.items())


def _values(finding: Finding) -> dict[str, str]:
    """Each parameter in the units that people use, a vector as one text."""
    rows: dict[str, list[tuple[float, Sequence[float]]]] = {}
    for name, value, ci95, stderr in zip(finding.effect.flat_names(), finding.effect.flat(), finding.ci95, finding.stderr, strict=True):
        known = [] if np.isnan(stderr) else ci95.tolist()
        rows.setdefault(name.split("[")[0], []).append((float(value), known))
    return {name: _text(name, entries) for name, entries in rows.items()}


def _text(name: str, entries: Sequence[tuple[float, Sequence[float]]]) -> str:
    if len(entries) == 1:
        ((value, ends),) = entries
        return in_use(name, value, ends)
    values = [value for value, _ in entries]
    unit, factor = unit_in_use(name, values)
    shown = values if len(values) <= 2 * _FEW else [max(values, key=abs)]
    return f"{', '.join(f'{factor * value:.3g}' for value in shown)} {unit}".rstrip()
