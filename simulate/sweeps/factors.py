"""What a sweep varies: numbers of a model, each between two levels or with a spread.

Coded levels run from -1 (low) to +1 (high); of a factor with a normal spread they are one standard deviation away.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from measure.common.errors import InputError
from simulate.effects import CATALOGUE
from simulate.model.effect import Catalogue
from simulate.model.model import Model, value_of, with_value
from simulate.model.rig import LEGS
from simulate.sweeps.limits import FARTHEST

LETTERS = "ABCDEFGHJKLMNOPQRSTUVWXYZ"  # no I, as in the paper's Table 1
_SPREAD = re.compile(r"^(?:\+-|\+/-|±)(?P<size>[0-9.eE+-]+)(?P<percent>%?)$")
_NORMAL = re.compile(r"^sigma:(?P<size>[0-9.eE+-]+)(?P<percent>%?)$")
_RANGE = re.compile(r"^(?P<low>[-+0-9.eE]{1,40})\.\.(?P<high>[-+0-9.eE]{1,40})$")


@dataclass(frozen=True)
class Factor:
    """A value of the model that a sweep varies between two levels, or with a normal spread about their middle.

    A key means what it means in `with_value`: it moves alone, but for `actuator.stored_force_N[i]`, which moves b_l, b_u and
    the initial force of a leg by the same amount.
    """

    letter: str
    key: str
    low: float
    high: float
    normal: bool = False

    @property
    def farthest(self) -> float:
        """The coded level that no run goes beyond."""
        return FARTHEST if self.normal else 1.0

    def value(self, coded: float) -> float:
        """The value at a coded level, in the unit of the key."""
        return (self.low + self.high) / 2 + coded * (self.high - self.low) / 2

    def applied(self, model: Model, coded: float) -> Model:
        """The model with this factor at a coded level.

        Raises
        ------
        InputError
            The model cannot have such a value.
        """
        value = self.value(coded)
        try:
            return with_value(model, self.key, value)
        except ValueError as error:  # InputError among them, and the model's own checks
            raise InputError(f"--factor {self.key}: the model cannot have {value:.6g}. Narrow its levels.") from error


def paper_factors(model: Model) -> list[Factor]:
    """The paper's 12 factors: stored force and slope of each leg at +-10 %, letters A to M without I, leg by leg."""
    keys = [f"actuator.{name}[{leg}]" for leg in range(LEGS) for name in ("stored_force_N", "a_l_N_per_m")]
    return [factor_of(model, f"{key}=+-10%", letter) for key, letter in zip(keys, LETTERS, strict=False)]


def factors_of(model: Model, settings: Sequence[str], lettered: int = 0) -> list[Factor]:
    """The factors by their settings, as `actuator.stored_force_N[0]=+-10%`, or the paper's where none is given.

    Parameters
    ----------
    lettered : letters that are taken already.

    Raises
    ------
    InputError
        A key that is no number of the model, a spread that cannot be read, a key named twice, too many factors.
    """
    if not settings:
        return paper_factors(model)
    if lettered + len(settings) > len(LETTERS):
        raise InputError(f"{lettered + len(settings)} factors; at most {len(LETTERS)} have a letter.")
    made = [factor_of(model, setting, letter) for setting, letter in zip(settings, LETTERS[lettered:], strict=False)]
    keys = [factor.key for factor in made]
    if len(set(keys)) < len(keys):
        double = next(key for key in keys if keys.count(key) > 1)
        raise InputError(f"--factor {double} is given twice; keep one.")
    return made


def factor_of(model: Model, setting: str, letter: str) -> Factor:
    """A factor from `KEY=+-10%`, `KEY=+-0.02`, `KEY=2.6..3.0`, or with a normal spread `KEY=sigma:0.001`, `KEY=sigma:1%`."""
    key, _, levels = (part.strip() for part in setting.partition("="))
    try:
        value = value_of(model, key)
    except KeyError as error:
        raise InputError(
            f"--factor {setting}: {error.args[0]} is no number of the model. Name one as in the model file, such as platform.mass_kg."
        ) from error
    normal = _NORMAL.match(levels)
    low, high = _about(value, normal, setting) if normal else _levels(value, levels, setting)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"--factor {setting}: its levels are {low:g} and {high:g}; give two different ones, as +-0.02 or 2.6..3.0.")
    return Factor(letter, key, low, high, normal is not None)


def with_named_effects(model: Model, settings: Sequence[str], catalogue: Catalogue = CATALOGUE) -> Model:
    """The model with the effects that `effect.NAME.PARAMETER=...` names and it has not, switched off."""
    for setting in settings:
        head, _, rest = setting.partition(".")
        name = rest.partition(".")[0]
        if head == "effect" and name in catalogue and name not in [effect.name for effect in model.effects]:
            model = model.with_effect(catalogue[name]())
    return model


def _levels(value: float, levels: str, setting: str) -> tuple[float, float]:
    spread, between = _SPREAD.match(levels), _RANGE.match(levels)
    try:
        if spread:
            return _about(value, spread, setting)
        if between:
            return float(between["low"]), float(between["high"])
    except ValueError:
        pass
    raise InputError(f"--factor {setting}: levels are written +-10%, +-0.02, 2.6..3.0 or sigma:0.001; found {levels!r}.")


def _about(value: float, spread: re.Match[str], setting: str) -> tuple[float, float]:
    try:
        size = float(spread["size"]) * (abs(value) / 100 if spread["percent"] else 1.0)
    except ValueError as error:
        raise InputError(f"--factor {setting}: {spread['size']!r} is no number.") from error
    return value - size, value + size
