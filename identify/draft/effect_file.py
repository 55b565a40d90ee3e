"""A drafted force as a Python file that `--effects` takes: formula, units, bounds and what it was made from."""

from __future__ import annotations

import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from itertools import chain, count
from types import ModuleType

from identify.draft.forms import Form
from identify.gap.leg_force import LegTable
from identify.gap.platform_force import ForceTable
from measure.common.arrays import Array
from simulate.model.effect import Effect, effects_among
from simulate.model.measures import Measures, unit_of

FILE = "drafted_effect.py"
_UNITS = {"elongation": "m", "leg speed": "m_per_s", "height": "m", "time": "s", "speed": "m_per_s"}
_PER = {
    "m": ("N", "N_per_m", "N_per_m2", "N_per_m3"),
    "s": ("N", "N_per_s", "N_per_s2", "N_per_s3"),
    "m_per_s": ("N", "N_s_per_m", "N_s2_per_m2", "N_s3_per_m3"),
}
_SYMBOLS = {"elongation": "u", "leg speed": "v", "height": "z", "time": "t", "speed": "v"}
_KINDS, _PLACES = ("vertical force", "lateral force", "moment"), (2, 0, 4)  # of each axis, and where it stands in a wrench
_WIDEST = 100.0  # times the drafted amplitude: its bounds


@dataclass(frozen=True)
class Variable:
    """What a force goes with. in_legs : whether it acts in every leg. axis : on the platform upwards, along x, or as a moment about y.

    has_arm : whether it acts off the centre of mass; its last parameter is the arm then, moment over force.
    """

    name: str
    in_legs: bool
    axis: int = 0
    has_arm: bool = False

    @classmethod
    def of(cls, table: LegTable | ForceTable, axis: int = 0, *, has_arm: bool = False) -> Variable:
        """The variable of a table."""
        if isinstance(table, LegTable):
            return cls("elongation" if table.words == "elongation" else "leg speed", True)
        return cls(table.words, False, axis, has_arm)

    @property
    def unit(self) -> str:
        """Its unit, as a name ends with it."""
        return _UNITS[self.name]

    @property
    def symbol(self) -> str:
        """As it stands in the formula for people."""
        return _SYMBOLS[self.name]

    @property
    def where(self) -> str:
        """In words."""
        if self.in_legs:
            return f"a force in each leg that goes with its {self.name.removeprefix('leg ')}"
        off = ", off its centre of mass," if self.has_arm else ""
        return f"a {_KINDS[self.axis]} on the platform{off} that goes with the {self.name}"

    @property
    def kind(self) -> str:
        """What acts, in words."""
        if self.in_legs:
            return "force along the leg"
        return f"{_KINDS[self.axis]} at an arm" if self.has_arm else _KINDS[self.axis]

    @property
    def quantity(self) -> str:
        """What its parameters are amounts of."""
        return "moment" if self.is_moment else "force"

    @property
    def is_moment(self) -> bool:
        """Whether it is a moment, in N m."""
        return not self.in_legs and self.axis == 2


def formula_text(form: Form, values: Sequence[float] | Array, variable: Variable) -> str:
    """The formula for people, in the variable's own symbol: `-0.4 v / (1 + (v / 0.12)^2) N`."""
    marked = form.text.replace("exp", "\0").replace("x", variable.symbol).replace("\0", "exp")
    arm = f" at an arm of {values[-1]:.3g} m" if variable.has_arm else ""
    return marked.format(*(f"{value:.3g}" for value in values)) + (" m" if variable.is_moment else arm)


@dataclass(frozen=True)
class Origin:
    """What a draft comes from. name : of the effect. about : a sentence. measures : of the rig at hand."""

    name: str
    about: str
    measures: Measures


def free_name(taken: Collection[str]) -> str:
    """A name for a drafted effect that no other one has."""
    return next(name for name in chain(["drafted"], (f"drafted-{i}" for i in count(2))) if name not in taken)


def source_of(form: Form, values: Sequence[float] | Array, variable: Variable, span: tuple[float, float], origin: Origin) -> str:
    """The file; sizes and bounds in it are those for a rig of the prototype's measures, as in every effect.

    Parameters
    ----------
    values : (k,) the parameters as drafted. span : first and last place of the variable.
    """
    rows = [*_amplitudes(form, values, variable, origin.measures), *_shapes(form, values, variable, span, origin.measures)]
    rows += [_arm(values[-1], origin.measures)] if variable.has_arm else []
    kind, formula = _formula(form, variable)
    return _TEMPLATE.format(
        title=f"Drafted: {variable.where}.",
        about=origin.about,
        kind=kind,
        formula=formula_text(form, values, variable),
        name=origin.name,
        parameters="\n".join(rows),
        method=formula,
    )


def effect_from(source: str) -> type[Effect]:
    """The effect that a file of this text defines."""
    module = ModuleType("drafted_effect")
    sys.modules[module.__name__] = module
    exec(compile(source, "<drafted effect>", "exec"), vars(module))
    (kind,) = (one for one in effects_among(vars(module)) if one.__module__ == module.__name__)
    return kind


def _amplitudes(form: Form, values: Sequence[float] | Array, variable: Variable, measures: Measures) -> list[str]:
    rows = []
    for (name, power), value in zip(form.amplitudes, values, strict=False):
        per = _PER[variable.unit][power]
        key = f"{name}_N_m{per[1:]}" if variable.is_moment else f"{name}_{per}"
        size = max(abs(value), 1e-12) / measures.of(unit_of(key))
        rows.append(_row(key, 0.0, -_WIDEST * size, _WIDEST * size, 0.1 * size, f"{name.replace('_', ' ')} of the {variable.quantity}"))
    return rows


def _shapes(form: Form, values: Sequence[float] | Array, variable: Variable, span: tuple[float, float], measures: Measures) -> list[str]:
    rows = []
    for shape, value in zip(form.shapes, values[len(form.amplitudes) : form.parameters], strict=True):
        key = f"{shape.name}_{variable.unit}"
        ratio = measures.of(unit_of(key))
        low, high = shape.bounds(*span)
        typical = 0.1 * (span[1] - span[0] if shape.is_place else abs(value))
        rows.append(_row(key, value, low / ratio, high / ratio, typical / ratio, shape.doc))
    return rows


def _arm(value: float, measures: Measures) -> str:
    size = max(abs(value), 1e-12) / measures.of(unit_of("arm_m"))
    return _row("arm_m", value, -_WIDEST * size, _WIDEST * size, 0.1 * size, "moment about y over force")


def _row(key: str, value: float, low: float, high: float, typical: float, doc: str) -> str:
    return f'    {key}: float = parameter({value:.6g}, low={low:.6g}, high={high:.6g}, typical={typical:.6g}, doc="{doc}")'


def _formula(form: Form, variable: Variable) -> tuple[str, str]:
    """The class that the effect derives from, and its method."""
    if variable.in_legs:
        x = "u" if variable.name == "elongation" else "v"
        return "LegEffect", _LEG.format(x=x, code=form.code)
    x = {"time": "t", "height": "pose[2]", "speed": "twist[2]"}[variable.name]
    unit = "N m" if variable.is_moment else "N"
    moment = _MOMENT.format(arm=form.parameters) if variable.has_arm else ""
    kind, place = variable.kind, _PLACES[variable.axis]
    return "PlatformEffect", _PLATFORM.format(x=x, code=form.code, kind=kind, place=place, unit=unit, moment=moment)


_LEG = '''    @staticmethod
    def leg_force(u: float, v: float, t: float, R: float, travel: float, p: Any) -> float:
        """Force along the leg, N."""
        x = {x}
        return {code}'''
_PLATFORM = '''    @staticmethod
    def platform_wrench(t: float, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        """Adds the {kind}, {unit}."""
        x = {x}
        force = {code}
        wrench[{place}] += force{moment}'''
_MOMENT = """
        wrench[4] += p[{arm}] * force"""
_TEMPLATE = '''"""{title} {about}

It describes what is missing, and is not a cause: rename it once its physics is known.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from simulate.model.effect import {kind}, parameter


@dataclass(frozen=True)
class DraftedEffect({kind}):
    """{title}

        F = {formula}
    """

    name = "{name}"
{parameters}

{method}
'''
