"""Runs side by side as one number: what compiled code computes with in vector registers, whatever the processor has of them.

`rows_at(pointer, n, fused)` reads memory as rows of n numbers. A row, `w[U]`, is one value with the operators of a number. With
`fused`, a product and a sum that follow each other may be rounded once, where the processor can; without it every width gives
the same digits.
"""

from __future__ import annotations

import math
import operator
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, overload, register_jitable, register_model

typed: Any = infer_global
_CACHE_LINE = 64  # bytes
_REGISTER = 8  # numbers of which the processor estimates the roots at once
_DOUBLE, _WHOLE, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)


class LanesType(types.Type):
    """One number of each of n runs."""

    def __init__(self, n: int, fused: bool) -> None:
        self.n, self.fused = n, fused
        super().__init__(name=f"Lanes({n}, {fused})")

    @property
    def flags(self) -> tuple[str, ...]:
        """How LLVM may change the operations."""
        return ("contract",) if self.fused else ()


class MaskType(types.Type):
    """Yes or no for each of n runs."""

    def __init__(self, row: LanesType) -> None:
        self.row, self.n = row, row.n
        super().__init__(name=f"Mask({row.name})")


class RowsType(types.Type):
    """Memory as rows of one number a run."""

    def __init__(self, row: LanesType) -> None:
        self.row = row
        super().__init__(name=f"Rows({row.name})")


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.VectorType(_DOUBLE, kind.n))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, ir.VectorType(_BIT, kind.n))


@register_model(RowsType)
class _RowsModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _DOUBLE.as_pointer())


def _filled(builder: Any, value: Any, n: int) -> Any:
    """The same scalar in every lane."""
    vector = ir.Constant(ir.VectorType(value.type, n), ir.Undefined)
    place = ir.Constant(ir.IntType(32), 0)
    first = builder.insert_element(vector, value, place)
    return builder.shuffle_vector(first, vector, ir.Constant(ir.VectorType(ir.IntType(32), n), [0] * n))


def _lanes_of(args: Any) -> LanesType | None:
    return next((kind for kind in args if isinstance(kind, LanesType)), None)


def _binary(symbol: Any, emit: Any, *, compares: bool = False) -> None:
    """Define an operator between lanes, and between lanes and a number."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            del kws
            row = _lanes_of(args)
            if row is None or len(args) != 2:
                return None
            wanted = [row if isinstance(kind, LanesType) else types.float64 for kind in args]
            return signature(MaskType(row) if compares else row, *wanted)

    def generate(context: Any, builder: Any, given: Any, values: Any) -> Any:
        del context
        row = _lanes_of(given.args)
        assert row is not None
        wide = [v if isinstance(k, LanesType) else _filled(builder, v, row.n) for v, k in zip(values, given.args, strict=True)]
        return emit(builder, *wide, row.flags)

    typed(symbol)(Template)
    for left, right in ((LanesType, LanesType), (LanesType, types.Float), (types.Float, LanesType)):
        lower_builtin(symbol, left, right)(generate)


for _symbols, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _symbol in _symbols:
        _binary(_symbol, lambda builder, a, b, flags, name=_name: getattr(builder, name)(a, b, flags=flags))
_binary(operator.gt, lambda builder, a, b, flags: builder.fcmp_ordered(">", a, b), compares=True)
_binary(operator.lt, lambda builder, a, b, flags: builder.fcmp_ordered("<", a, b), compares=True)
_binary(operator.ge, lambda builder, a, b, flags: builder.fcmp_ordered(">=", a, b), compares=True)


def _unary(symbol: Any, emit: Any) -> None:
    """Define a function of one argument for lanes."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            del kws
            return signature(args[0], args[0]) if isinstance(args[0], LanesType) else None

    def generate(context: Any, builder: Any, given: Any, values: Any) -> Any:
        del context, given
        return emit(builder, values[0])

    typed(symbol)(Template)
    lower_builtin(symbol, LanesType)(generate)


def _by_llvm(name: str) -> Any:
    def emit(builder: Any, a: Any) -> Any:
        kind = ir.FunctionType(a.type, [a.type])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"{name}.v{a.type.count}f64"), [a])

    return emit


_unary(operator.neg, lambda builder, a: builder.fneg(a))
_unary(abs, _by_llvm("llvm.fabs"))


def _exact_root(a: Any) -> Any:
    """sqrt(a), rounded once."""
    return math.sqrt(a)


_unary(_exact_root, _by_llvm("llvm.sqrt"))


@typed(operator.and_)
class _Both(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        del kws
        return signature(args[0], *args) if all(isinstance(kind, MaskType) for kind in args) else None


@lower_builtin(operator.and_, MaskType, MaskType)
def _both(context: Any, builder: Any, given: Any, values: Any) -> Any:
    del context, given
    return builder.and_(*values)


@typed(operator.getitem)
class _Read(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        del kws
        return signature(args[0].row, args[0], types.intp) if isinstance(args[0], RowsType) else None


@typed(operator.setitem)
class _Write(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        del kws
        if not isinstance(args[0], RowsType):
            return None
        value = args[2] if isinstance(args[2], LanesType) else types.float64
        return signature(types.none, args[0], types.intp, value)


def _row_place(builder: Any, rows: Any, row: Any, kind: LanesType) -> Any:
    first = builder.gep(rows, [builder.mul(row, ir.Constant(_WHOLE, kind.n))])
    return builder.bitcast(first, ir.VectorType(_DOUBLE, kind.n).as_pointer())


@lower_builtin(operator.getitem, RowsType, types.Integer)
def _read(context: Any, builder: Any, given: Any, values: Any) -> Any:
    del context
    return builder.load(_row_place(builder, values[0], values[1], given.args[0].row), align=8)


@lower_builtin(operator.setitem, RowsType, types.Integer, LanesType)
@lower_builtin(operator.setitem, RowsType, types.Integer, types.Float)
def _write(context: Any, builder: Any, given: Any, values: Any) -> Any:
    kind = given.args[0].row
    value = values[2] if isinstance(given.args[2], LanesType) else _filled(builder, values[2], kind.n)
    builder.store(value, _row_place(builder, values[0], values[1], kind), align=8)
    return context.get_dummy_value()


def _align_stack(function: Any) -> None:
    """Let the stack of a function that works rows begin at a cache line, or a register that is put aside there lies across two."""
    function.attributes.alignstack = _CACHE_LINE
    function.attributes.add("nounwind")  # without another attribute llvmlite does not write this one


@intrinsic(prefer_literal=True)
def _rows_at(typingctx: Any, numbers: Any, n: Any, fused: Any) -> Any:
    """Memory from a pointer on, or a contiguous array, as rows of n numbers; n and fused are constants."""
    del typingctx
    rows = RowsType(LanesType(n.literal_value, fused.literal_value))

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        _align_stack(builder.function)
        if isinstance(signature.args[0], types.Array):
            return context.make_array(signature.args[0])(context, builder, given[0]).data
        return given[0]

    return rows(numbers, n, fused), generate


@intrinsic
def _from_row(typingctx: Any, rows: Any, row: Any) -> Any:
    """The rows from a row on, as rows of their own."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context
        return builder.gep(given[0], [builder.mul(given[1], ir.Constant(_WHOLE, signature.args[0].row.n))])

    return rows(rows, types.intp), generate


@intrinsic
def _chosen(typingctx: Any, where: Any, one: Any, other: Any) -> Any:
    """Lane by lane one number or the other; a plain number stands in every lane."""
    del typingctx
    row = where.row
    wanted = [kind if isinstance(kind, LanesType) else types.float64 for kind in (one, other)]

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context
        wide = [v if isinstance(k, LanesType) else _filled(builder, v, row.n) for v, k in zip(given[1:], signature.args[1:], strict=True)]
        return builder.select(given[0], *wide)

    return row(where, *wanted), generate


@intrinsic
def _power_of_two(typingctx: Any, shifted: Any) -> Any:
    """2^k of a whole number k that stands in the lowest bits of 1.5 * 2^52 + k."""
    del typingctx
    n = shifted.n if isinstance(shifted, LanesType) else 0

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context, signature
        whole, number = (ir.VectorType(kind, n) if n else kind for kind in (_WHOLE, _DOUBLE))
        shift, one = (ir.Constant(whole, [value] * n if n else value) for value in (52, 1023 << 52))
        return builder.bitcast(builder.add(builder.shl(builder.bitcast(given[0], whole), shift), one), number)

    return shifted(shifted), generate


@intrinsic
def _exponent_and_rest(typingctx: Any, a: Any) -> Any:
    """k and m of a = m 2^k, 1 <= m < 2, of numbers above zero."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        whole, number = ir.VectorType(_WHOLE, a.n), ir.VectorType(_DOUBLE, a.n)
        shift, bias, one, rest = (ir.Constant(whole, [value] * a.n) for value in (52, 1023, 1023 << 52, (1 << 52) - 1))
        bits = builder.bitcast(given[0], whole)
        exponent = builder.sitofp(builder.sub(builder.lshr(bits, shift), bias), number)
        mantissa = builder.bitcast(builder.or_(builder.and_(bits, rest), one), number)
        return context.make_tuple(builder, signature.return_type, [exponent, mantissa])

    return types.UniTuple(a, 2)(a), generate


def _counted(holds: Any) -> Any:
    """A function that tells from the bits of a mask whether it holds."""

    def typed(typingctx: Any, mask: Any) -> Any:
        del typingctx

        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            del context, signature
            bits = ir.IntType(mask.n)
            return holds(builder, builder.bitcast(given[0], bits), bits)

        return types.boolean(mask), generate

    return intrinsic(typed)


Rows = Lanes = Mask = Any
"""Memory as rows, one number of each run, and yes or no for each, in annotations."""

rows_at: Any = _rows_at
from_row: Any = _from_row
chosen: Any = _chosen
exponent_and_rest: Any = _exponent_and_rest
any_of: Any = _counted(lambda builder, bits, kind: builder.icmp_unsigned("!=", bits, ir.Constant(kind, 0)))
all_of: Any = _counted(lambda builder, bits, kind: builder.icmp_unsigned("==", bits, ir.Constant(kind, -1)))
power_of_two: Any = _power_of_two


def larger(a: Any, b: Any) -> Any:
    """The larger of two, lane by lane; the second one where the first is no number."""
    return a if a > b else b


@overload(larger, strict=False, jit_options={"forceinline": True})
def _larger(a: Any, b: Any) -> Any:
    if _lanes_of((a, b)) is None:
        return lambda a, b: a if a > b else b
    return lambda a, b: chosen(a > b, a, b)


def smaller(a: Any, b: Any) -> Any:
    """The smaller of two, lane by lane; the second one where the first is no number."""
    return a if a < b else b


@overload(smaller, strict=False, jit_options={"forceinline": True})
def _smaller(a: Any, b: Any) -> Any:
    if _lanes_of((a, b)) is None:
        return lambda a, b: a if a < b else b
    return lambda a, b: chosen(a < b, a, b)


def _is_estimated(kind: Any) -> bool:
    """Whether roots of such numbers are refined estimates, which takes a third of the time: of a sweep's runs, on AVX-512."""
    context: Any = cpu_target.target_context
    features = context.codegen().magic_tuple()[2]
    return isinstance(kind, LanesType) and kind.fused and kind.n % _REGISTER == 0 and "+avx512f" in features.split(",")


@intrinsic
def _estimate(typingctx: Any, x: Any) -> Any:
    """r = 1 / sqrt(x) to 14 bits. With e = 1 - x r^2, the root is x r, and its inverse r, times 1 + e/2 + 3/8 e^2 + 5/16 e^3."""
    del typingctx
    part, mask, place = ir.VectorType(_DOUBLE, _REGISTER), ir.IntType(8), ir.IntType(32)

    def places(first: int, count: int) -> Any:
        return ir.Constant(ir.VectorType(place, count), list(range(first, first + count)))

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context, signature
        kind = ir.FunctionType(part, [part, part, mask])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.avx512.rsqrt14.pd.512")
        parts = [builder.shuffle_vector(given[0], given[0], places(first, _REGISTER)) for first in range(0, x.n, _REGISTER)]
        found = [builder.call(function, [one, ir.Constant(part, None), ir.Constant(mask, -1)]) for one in parts]
        while len(found) > 1:
            pairs = zip(found[::2], found[1::2], strict=True)
            found = [builder.shuffle_vector(a, b, places(0, 2 * a.type.count)) for a, b in pairs]
        return found[0]

    return x(x), generate


estimate: Any = _estimate


@register_jitable(forceinline=True)
def _refined(value: Any, e: Any) -> Any:
    return value + value * (e * (0.5 + e * (0.375 + e * 0.3125)))


def inverse_root(x: Any) -> Any:
    """1 / sqrt(x), lane by lane."""
    return 1.0 / math.sqrt(x)


@overload(inverse_root, strict=False, jit_options={"forceinline": True})
def _inverse_root(x: Any) -> Any:
    def by_estimate(x: Any) -> Any:
        r = estimate(x)
        return _refined(r, 1.0 - (x * r) * r)

    return by_estimate if _is_estimated(x) else lambda x: 1.0 / math.sqrt(x)


@overload(math.sqrt, strict=False, jit_options={"forceinline": True})
def _root(x: Any) -> Any:
    def by_estimate(x: Any) -> Any:
        r = estimate(x)
        root = x * r
        return chosen(abs(x) > 0.0, _refined(root, 1.0 - root * r), x)

    if not isinstance(x, LanesType):
        return None
    return by_estimate if _is_estimated(x) else lambda x: _exact_root(x)
