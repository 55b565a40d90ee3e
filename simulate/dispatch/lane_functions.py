"""What formulas call besides operators, for numbers of runs side by side: exp and tanh as arithmetic, other functions run by run."""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload, register_jitable

from simulate.dispatch.lanes import LanesType, chosen, larger, smaller
from simulate.law import fading, remaining


def _run_by_run(name: str, count: int) -> Any:
    """A function that LLVM takes from the mathematical library, a call a run."""

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context
        number, row = ir.DoubleType(), signature.return_type
        one = cgutils.get_or_insert_function(builder.module, ir.FunctionType(number, [number] * count), f"llvm.{name}.f64")
        result = ir.Constant(ir.VectorType(number, row.n), ir.Undefined)
        for i in range(row.n):
            place = ir.Constant(ir.IntType(32), i)
            parts = [
                builder.extract_element(value, place) if isinstance(kind, LanesType) else value
                for value, kind in zip(given, signature.args, strict=True)
            ]
            result = builder.insert_element(result, builder.call(one, parts), place)
        return result

    def one_argument(typingctx: Any, a: Any) -> Any:
        del typingctx
        return a(a), generate

    def two_arguments(typingctx: Any, a: Any, b: Any) -> Any:
        del typingctx
        return a(a, b if isinstance(b, LanesType) else types.float64), generate

    return intrinsic(one_argument if count == 1 else two_arguments)


_sine, _cosine, _logarithm, _power = (_run_by_run(name, count) for name, count in (("sin", 1), ("cos", 1), ("log", 1), ("pow", 2)))


def _for_lanes(symbol: Any, make: Any) -> None:
    """Define a function of one argument for lanes; other arguments are not its business."""

    def of_lanes(x: Any) -> Any:
        return make if isinstance(x, LanesType) else None

    overload(symbol, strict=False)(of_lanes)


@register_jitable
def _exponential(x: Any) -> Any:
    shrunk = remaining(abs(x))
    return chosen(x > 0.0, 1.0 / shrunk, shrunk)


@register_jitable
def _tangent(x: Any) -> Any:
    lost = fading(2.0 * abs(x))
    size = -lost / (2.0 + lost)
    return chosen(x > 0.0, size, -size)


_for_lanes(math.exp, lambda x: _exponential(x))
_for_lanes(math.tanh, lambda x: _tangent(x))
_for_lanes(math.sin, lambda x: _sine(x))
_for_lanes(math.cos, lambda x: _cosine(x))
_for_lanes(math.log, lambda x: _logarithm(x))


@overload(max, strict=False)
def _max(a: Any, b: Any) -> Any:
    return (lambda a, b: larger(a, b)) if isinstance(a, LanesType) else None


@overload(min, strict=False)
def _min(a: Any, b: Any) -> Any:
    return (lambda a, b: smaller(a, b)) if isinstance(a, LanesType) else None


@overload(operator.pow, strict=False)
def _pow(a: Any, b: Any) -> Any:
    if not isinstance(a, LanesType):
        return None
    if isinstance(b, types.IntegerLiteral) and b.literal_value == 2:
        return lambda a, b: a * a
    return lambda a, b: _power(a, b)
