"""What formulas call besides operators, for numbers of runs side by side: as arithmetic, and run by run where it fails."""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, overload, register_jitable

from simulate.dispatch.lanes import LanesType, all_of, chosen, exponent_and_rest, larger, smaller
from simulate.law import fading, nearest_whole, remaining


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
    return remaining(larger(-x, -700.0))


@register_jitable
def _wave(x: Any, quarter: float) -> Any:
    """sin(x + quarter pi / 2) from the polynomial of one half wave: x = k pi - quarter pi / 2 + r, |r| <= pi / 2, pi / 2 in three parts."""
    k = nearest_whole(x * 0.3183098861837907 + 0.5 * quarter)
    turns = 2.0 * k - quarter
    r = ((x - turns * 1.5707963267341256) - turns * 6.077100506303966e-11) - turns * 2.0222662487959506e-21
    odd = k - 2.0 * nearest_whole(0.5 * k - 0.25)
    r2 = r * r
    r4 = r2 * r2
    low = (-1.0 / 6.0 + r2 * (1.0 / 120.0)) + r4 * (-1.0 / 5040.0 + r2 * (1.0 / 362880.0))
    middle = (-1.0 / 39916800.0 + r2 * (1.0 / 6227020800.0)) + r4 * (-1.0 / 1307674368000.0 + r2 * (1.0 / 355687428096000.0))
    high = -1.0 / 121645100408832000.0 + r2 * (1.0 / 51090942171709440000.0 - r2 * (1.0 / 25852016738884976640000.0))
    return (1.0 - 2.0 * odd) * (r + r * r2 * (low + r4 * r4 * (middle + r4 * r4 * high)))


@register_jitable
def _few_turns(x: Any) -> Any:
    return abs(x) < 1e5


@register_jitable
def _sin(x: Any) -> Any:
    found = _wave(x, 0.0)
    return found if all_of(_few_turns(x)) else chosen(_few_turns(x), found, _sine(x))


@register_jitable
def _cos(x: Any) -> Any:
    found = _wave(x, 1.0)
    return found if all_of(_few_turns(x)) else chosen(_few_turns(x), found, _cosine(x))


@register_jitable
def _tangent(x: Any) -> Any:
    lost = fading(2.0 * abs(x))
    size = -lost / (2.0 + lost)
    return chosen(x > 0.0, size, -size)


@register_jitable
def _series(x: Any) -> Any:
    """Logarithm of numbers above zero: k ln 2 + 2 artanh((m - 1) / (m + 1)) with x = m 2^k, m about 1."""
    k, m = exponent_and_rest(x)
    large = m > 1.4142135623730951
    k, m = chosen(large, k + 1.0, k), chosen(large, 0.5 * m, m)
    f = (m - 1.0) / (m + 1.0)
    f2 = f * f
    f4 = f2 * f2
    low = (1.0 / 3.0 + f2 * (1.0 / 5.0)) + f4 * (1.0 / 7.0 + f2 * (1.0 / 9.0))
    middle = (1.0 / 11.0 + f2 * (1.0 / 13.0)) + f4 * (1.0 / 15.0 + f2 * (1.0 / 17.0))
    rest = low + f4 * f4 * (middle + f4 * f4 * (1.0 / 19.0))
    return k * 0.6931471803691238 + (2.0 * f + (2.0 * f * f2 * rest + k * 1.9082149292705877e-10))


@register_jitable
def _usual(x: Any) -> Any:
    return (x > 1e-300) & (x < 1e300)


@register_jitable
def _log(x: Any) -> Any:
    found = _series(x)
    return found if all_of(_usual(x)) else chosen(_usual(x), found, _logarithm(x))


@register_jitable
def _raised(a: Any, b: Any) -> Any:
    found = _exponential(b * _series(a))
    return found if all_of(_usual(a)) else chosen(_usual(a), found, _power(a, b))


_for_lanes(math.exp, lambda x: _exponential(x))
_for_lanes(math.tanh, lambda x: _tangent(x))
_for_lanes(math.sin, lambda x: _sin(x))
_for_lanes(math.cos, lambda x: _cos(x))
_for_lanes(math.log, lambda x: _log(x))


@overload(max, strict=False)
def _max(a: Any, b: Any) -> Any:
    return (lambda a, b: larger(a, b)) if isinstance(a, LanesType) or isinstance(b, LanesType) else None


@overload(min, strict=False)
def _min(a: Any, b: Any) -> Any:
    return (lambda a, b: smaller(a, b)) if isinstance(a, LanesType) or isinstance(b, LanesType) else None


@overload(operator.pow, strict=False)
def _pow(a: Any, b: Any) -> Any:
    if not isinstance(a, LanesType):
        return None
    if isinstance(b, types.Integer):
        return lambda a, b: a * a if b == 2 else _raised(a, float(b))
    return lambda a, b: _raised(a, b)
