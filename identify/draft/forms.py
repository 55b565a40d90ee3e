"""A small grammar of forces: how a force may go with one variable, in formulas that a mechanic would write.

Each form is written once, as the line of Python that the drafted effect holds: x is the variable, p[0], p[1] ... the parameters,
amplitudes first, in which it is linear, then shapes in the unit of the variable.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from types import CodeType, SimpleNamespace

import numpy as np

from measure.common.arrays import Array

_ARRAYS = SimpleNamespace(exp=np.exp, tanh=np.tanh, sin=np.sin, cos=np.cos, pi=math.pi)


@dataclass(frozen=True)
class Shape:
    """A parameter that shapes a form. doc : what it is. starts : places to start from, in parts of the way from the first to the
    last place of the variable, from the first place on where it is a place itself. is_place : whether it is one, or a width."""

    name: str
    doc: str
    starts: tuple[float, ...]
    is_place: bool = False

    def values(self, first: float, last: float) -> list[float]:
        """The starts for a variable that goes from first to last."""
        width = last - first
        return [(first if self.is_place else 0.0) + part * width for part in self.starts]

    def bounds(self, first: float, last: float) -> tuple[float, float]:
        """Where it may end: a place within the variable's range, a width from half the way between two places of a table to ten ranges."""
        width = last - first
        return (first, last) if self.is_place else (0.02 * width, 10.0 * width)


@dataclass(frozen=True)
class Form:
    """A way in which a force may go with a variable x.

    code : see above. amplitudes : (name, power of x in the denominator of its unit) of each. text : for people, with {0}, {1} ... for
    the parameters. only_speed : whether it makes sense for a speed alone.
    """

    name: str
    code: str
    text: str
    amplitudes: tuple[tuple[str, int], ...]
    shapes: tuple[Shape, ...] = ()
    only_speed: bool = False
    only_platform: bool = False

    @property
    def parameters(self) -> int:
        """How many parameters it has."""
        return len(self.amplitudes) + len(self.shapes)

    def force(self, x: Array, parameters: Sequence[float] | Array) -> Array:
        """The force at places of its variable, (n,), N."""
        with np.errstate(over="ignore"):
            value = eval(_compiled(self.code), {"math": _ARRAYS, "abs": np.abs, "x": x, "p": parameters})
        return np.broadcast_to(value, np.shape(x)).astype(float)

    def basis(self, x: Array, shapes: Sequence[float] | Array) -> Array:
        """The force at places (n,) for an amplitude of one each, (n, k)."""
        units = np.eye(len(self.amplitudes))
        return np.stack([self.force(x, [*unit, *shapes]) for unit in units], axis=1)

    def starts(self, first: float, last: float) -> list[tuple[float, ...]]:
        """Sets of shapes to start from, for a variable that goes from first to last."""
        return list(product(*(shape.values(first, last) for shape in self.shapes)))


@cache
def _compiled(code: str) -> CodeType:
    return compile(code, "<form>", "eval")


def sum_of(one: Form, other: Form) -> Form:
    """Two forms added: the amplitudes of both, then the shapes of both; those of the second are called so."""
    first, more = len(one.amplitudes), len(other.amplitudes)
    of_one = [*range(first), *range(first + more, one.parameters + more)]
    of_other = [*range(first, first + more), *range(one.parameters + more, one.parameters + other.parameters)]
    return Form(
        f"{one.name} and {other.name}",
        f"{_renumbered(one.code, of_one)} + {_renumbered(other.code, of_other)}",
        f"({_terms(one.text, of_one)} + {_terms(other.text, of_other)}) N",
        (*one.amplitudes, *((f"second_{name}", power) for name, power in other.amplitudes)),
        (*one.shapes, *(replace(shape, name=f"second_{shape.name}") for shape in other.shapes)),
        one.only_speed or other.only_speed,
        one.only_platform or other.only_platform,
    )


def _renumbered(code: str, places: Sequence[int]) -> str:
    return re.sub(r"p\[(\d)\]", lambda found: f"p[{places[int(found[1])]}]", code)


def _terms(text: str, places: Sequence[int]) -> str:
    bare = text.removesuffix(" N")
    bare = bare[1:-1] if bare.startswith("(") and bare.endswith(")") else bare
    return re.sub(r"\{(\d)\}", lambda found: f"{{{places[int(found[1])]}}}", bare)


_WIDTHS, _PLACES = (0.03, 0.1, 0.3), tuple(np.linspace(0.05, 0.95, 13).tolist())
_BEGINS, _ENDS = tuple(np.linspace(0.05, 0.75, 8).tolist()), tuple(np.linspace(0.25, 0.95, 8).tolist())
_TURN = Shape("turn", "where it turns", (0.03, 0.1, 0.3))

FORMS: tuple[Form, ...] = (
    Form("constant", "p[0]", "{0} N", (("level", 0),), only_platform=True),
    Form("line", "p[0] * x", "{0} x N", (("slope", 1),)),
    Form("parabola", "p[0] * x + p[1] * x * x", "({0} x + {1} x^2) N", (("slope", 1), ("quadratic", 2))),
    Form(
        "cubic",
        "p[0] * x + p[1] * x * x + p[2] * x * x * x",
        "({0} x + {1} x^2 + {2} x^3) N",
        (("slope", 1), ("quadratic", 2), ("cubic", 3)),
    ),
    Form("square", "p[0] * x * abs(x)", "{0} x |x| N", (("quadratic", 2),), only_speed=True),
    Form("saturating", "p[0] * math.tanh(x / p[1])", "{0} tanh(x / {1}) N", (("level", 0),), (_TURN,), only_speed=True),
    Form(
        "falling",
        "p[0] * x / (1.0 + (x / p[1]) * (x / p[1]))",
        "{0} x / (1 + (x / {1})^2) N",
        (("slope", 1),),
        (_TURN,),
        only_speed=True,
    ),
    Form(
        "step",
        "p[0] / (1.0 + math.exp(-(x - p[1]) / p[2]))",
        "{0} / (1 + exp(-(x - {1}) / {2})) N",
        (("level", 0),),
        (Shape("place", "where it sets in", _PLACES, True), Shape("width", "how gradually", (0.02, 0.06))),
    ),
    Form(
        "bump",
        "p[0] * math.exp(-((x - p[1]) / p[2]) * ((x - p[1]) / p[2]))",
        "{0} exp(-((x - {1}) / {2})^2) N",
        (("level", 0),),
        (Shape("place", "where it is largest", _PLACES, True), Shape("width", "half width", _WIDTHS)),
    ),
    Form(
        "stretch",
        "p[0] / (1.0 + math.exp(-(x - p[1]) / p[3])) / (1.0 + math.exp((x - p[2]) / p[3]))",
        "{0} / (1 + exp(-(x - {1}) / {3})) / (1 + exp((x - {2}) / {3})) N",
        (("level", 0),),
        (
            Shape("begin", "where it sets in", _BEGINS, True),
            Shape("end", "where it ends", _ENDS, True),
            Shape("width", "how gradually", (0.02,)),
        ),
    ),
    Form(
        "decay",
        "p[0] * math.exp(-x / p[1])",
        "{0} exp(-x / {1}) N",
        (("level", 0),),
        (Shape("decay", "after which a third is left", _WIDTHS),),
    ),
    Form(
        "ripple",
        "p[0] * math.sin(2.0 * math.pi * x / p[2]) + p[1] * math.cos(2.0 * math.pi * x / p[2])",
        "({0} sin(2 pi x / {2}) + {1} cos(2 pi x / {2})) N",
        (("sine", 0), ("cosine", 0)),
        (Shape("period", "period", tuple(np.geomspace(0.09, 0.9, 16).tolist())),),
    ),
)
