"""What compiled code needs and Python cannot say: addresses, calls through them, and numbers read as other numbers."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


@intrinsic
def _shifted(typingctx: Any, numbers: Any, by: Any) -> Any:
    """A pointer that many entries further on."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context, signature
        return builder.gep(given[0], [given[1]])

    return numbers(numbers, by), generate


def caller(signature: Any) -> Any:
    """A function for kernels that calls a formula of this signature: call(address, numbers or pointers ...)."""

    def typed(typingctx: Any, place: Any, arguments: Any) -> Any:
        del typingctx

        def generate(context: Any, builder: Any, outer: Any, given: Any) -> Any:
            values = cgutils.unpack_tuple(builder, given[1])
            wanted = [context.get_value_type(kind) for kind in signature.args]
            passed = [
                builder.inttoptr(value, kind) if isinstance(source, types.Integer) else value
                for value, kind, source in zip(values, wanted, outer.args[1].types, strict=True)
            ]
            returned = ir.VoidType() if signature.return_type == types.void else context.get_value_type(signature.return_type)
            function = builder.inttoptr(given[0], ir.FunctionType(returned, wanted).as_pointer())
            result = builder.call(function, passed)
            return context.get_dummy_value() if signature.return_type == types.void else result

        return signature.return_type(types.int64, arguments), generate

    return intrinsic(typed)


@intrinsic
def _pointer(typingctx: Any, array: Any, place: Any) -> Any:
    """Address of an entry of a contiguous array, as a whole number."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, given[0]).data
        return builder.ptrtoint(builder.gep(data, [given[1]]), context.get_value_type(types.int64))

    return types.int64(array, types.int64), generate


@intrinsic
def _whole_at(typingctx: Any, address: Any, place: Any) -> Any:
    """The whole number that stands `place` numbers behind an address."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del signature
        whole = context.get_value_type(types.int64)
        return builder.load(builder.gep(builder.inttoptr(given[0], whole.as_pointer()), [given[1]]))

    return types.int64(address, place), generate


@intrinsic
def _uncounted(typingctx: Any, array: Any) -> Any:
    """The same array without its owner: handing it from function to function is free, and somebody else must keep it alive."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        view = context.make_array(signature.args[0])(context, builder, given[0])
        view.meminfo = ir.Constant(view.meminfo.type, None)
        view.parent = ir.Constant(view.parent.type, None)
        return view._getvalue()

    return array(array), generate


shifted: Any = _shifted
pointer: Any = _pointer
uncounted: Any = _uncounted
whole_at: Any = _whole_at
