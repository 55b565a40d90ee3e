"""The table [actuator.rate] in a deployment: polynomials of the speed become an effect, a frequency is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from measure.common.errors import InputError
from simulate.effects.rate_dependent_asymptotes import RateDependentAsymptotes
from simulate.model.model import Model
from simulate.model.rig import Rate

_LINES = {"a_l": "a_l_N_per_m", "b_l": "b_l_N", "a_u": "a_u_N_per_m", "b_u": "b_u_N"}
_HIGHEST_POWER = 2


def with_rate_as_effect(model: Model) -> Model:
    """The same model with its rate table worked in: constants from the lowest power, the rest as an effect.

    A polynomial stands for the value of its name at every speed, so its lowest power replaces that value. What the model's own
    `rate-dependent-asymptotes` adds is kept.

    Raises
    ------
    InputError
        The polynomials follow a cycling frequency, which a deployment does not have, or go beyond the second order.
    """
    rate = model.actuator.rate
    if rate is None:
        return model
    _require_speed(rate, model.name)
    given = {name: getattr(rate, name) for name in _LINES if getattr(rate, name)}
    own = model.effect(RateDependentAsymptotes)
    higher = {name: _sum(getattr(own, name), powers[1:]) for name, powers in given.items()}
    constants: dict[str, Any] = {_LINES[name]: powers[0] for name, powers in given.items()}
    steady = replace(model, actuator=replace(model.actuator, rate=None, **constants))
    return steady.with_effect(replace(own, **higher))


def _require_speed(rate: Rate, name: str) -> None:
    if rate.abscissa != "speed_m_per_s":
        raise InputError(
            f'model "{name}": [actuator.rate] follows {rate.abscissa}, and a deployment has no cycling frequency. '
            "Give the polynomials against speed_m_per_s (at mid-stroke v = 2 pi f A), or remove the table."
        )
    for line in _LINES:
        if len(getattr(rate, line)) > _HIGHEST_POWER + 1:
            raise InputError(
                f'model "{name}": [actuator.rate] {line} has {len(getattr(rate, line))} coefficients; at most 3 are simulated.'
            )


def _sum(own: tuple[float, ...], powers: tuple[float, ...]) -> tuple[float, ...]:
    padded = (*powers, 0.0, 0.0)[:_HIGHEST_POWER]
    return tuple(a + b for a, b in zip(own, padded, strict=True))
