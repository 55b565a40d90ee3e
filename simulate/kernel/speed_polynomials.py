"""The table [actuator.rate] in a deployment: polynomials of speed or frequency become constants and an effect that follows the speed."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from measure.common.errors import InputError
from simulate.effects.rate_dependent_asymptotes import RateDependentAsymptotes
from simulate.model.model import Model
from simulate.model.rig import Rate

_LINES = {"a_l": "a_l_N_per_m", "b_l": "b_l_N", "a_u": "a_u_N_per_m", "b_u": "b_u_N"}
_HIGHEST_POWER = 2


def with_rate_worked_in(model: Model) -> Model:
    """The same model with the polynomials of its rate table as constants and as the effect `rate-dependent-asymptotes`.

    A polynomial stands for the value of its name at every speed, so its lowest power replaces that value; the rest is added to what the
    model's own effect says. From then on a change of b_l_N, a factor on it or a fit of it moves the force. The table keeps what the
    loops covered, without polynomials.

    Polynomials of the cycling frequency are taken at mid-stroke, where a sinusoidal test reads its asymptotes: v = 2 pi f A.

    Raises
    ------
    InputError
        Polynomials of the frequency whose loops are not known, or polynomials beyond the second order.
    """
    rate = model.actuator.rate
    if rate is None or not any(getattr(rate, line) for line in _LINES):
        return model
    at_speed = speed_form(rate, model.name)
    given = {name: getattr(at_speed, name) for name in _LINES if getattr(at_speed, name)}
    own = model.effect(RateDependentAsymptotes)
    higher = {name: _sum(getattr(own, name), powers[1:]) for name, powers in given.items()}
    constants: dict[str, Any] = {_LINES[name]: powers[0] for name, powers in given.items()}
    kept = replace(rate, a_l=(), b_l=(), a_u=(), b_u=())
    steady = replace(model, actuator=replace(model.actuator, rate=kept, **constants))
    return steady.with_effect(replace(own, **higher))


def speed_form(rate: Rate, name: str) -> Rate:
    """The same polynomials against speed_m_per_s; those of a frequency with f = v / (2 pi A).

    Raises
    ------
    InputError
        No stroke is known by which a frequency becomes a speed; polynomials beyond the second order. `name` is that of the model.
    """
    for line in _LINES:
        size = len(getattr(rate, line))
        if size > _HIGHEST_POWER + 1:
            raise InputError(f'model "{name}": [actuator.rate] {line} has {size} coefficients; at most 3 are simulated.')
    if rate.abscissa == "speed_m_per_s":
        return rate
    per_Hz = rate.speed_per_Hz
    if per_Hz is None:
        raise InputError(
            f'model "{name}": [actuator.rate] follows frequency_Hz, and a deployment has no cycling frequency but a speed; at mid-stroke '
            "v = 2 pi f A, and the table holds no stroke. Add stroke_m = [...], one for each loop, or fit again with fit-actuator."
        )
    scaled = {line: tuple(c / per_Hz**k for k, c in enumerate(getattr(rate, line))) for line in _LINES}
    return replace(rate, abscissa="speed_m_per_s", **scaled)


def _sum(own: tuple[float, ...], powers: tuple[float, ...]) -> tuple[float, ...]:
    padded = (*powers, 0.0, 0.0)[:_HIGHEST_POWER]
    return tuple(a + b for a, b in zip(own, padded, strict=True))
