"""Formulas of effects as addresses that a compiled kernel can call.

Each formula is compiled once, by itself, and kept on disk; the kernels reach it through its address. So a new effect
never recompiles a kernel, and an effect from outside the project runs like ours.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import cfunc, types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from measure.kernel_cache import discard_stale
from measure.tables import Array

from .effect import Effect

if TYPE_CHECKING:
    from .model import Model

discard_stale(Path(__file__).parent)

_NUMBER = types.float64
_NUMBERS = types.CPointer(types.float64)

SIGNATURES = {
    "leg_force": _NUMBER(_NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBERS),
    "leg_mass": _NUMBER(_NUMBER, _NUMBERS),
    "leg_asymptotes": types.void(_NUMBER, _NUMBER, _NUMBER, _NUMBERS, _NUMBERS),
    "leg_transverse": types.void(_NUMBER, _NUMBER, _NUMBERS, _NUMBERS),
    "joint_resistance": _NUMBER(_NUMBER, _NUMBERS),
    "platform_wrench": types.void(_NUMBER, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS),
    "platform_mass": types.void(_NUMBERS, _NUMBERS, _NUMBERS),
}


class Program(NamedTuple):
    """Which formulas a kernel calls, by hook: rows of (address, place of the first parameter)."""

    leg_force: NDArray[np.int64]
    leg_mass: NDArray[np.int64]
    leg_asymptotes: NDArray[np.int64]
    leg_transverse: NDArray[np.int64]
    joint_resistance: NDArray[np.int64]
    platform_wrench: NDArray[np.int64]
    platform_mass: NDArray[np.int64]


def program(effects: Sequence[Effect], first_parameter: int) -> Program:
    """The formulas of these effects; parameters stand one after the other from `first_parameter` on."""
    rows: dict[str, list[tuple[int, int]]] = {hook: [] for hook in SIGNATURES}
    place = first_parameter
    for effect in effects:
        for hook, found in rows.items():
            formula = getattr(type(effect), hook)
            if formula is not None:
                found.append((address(formula, hook), place))
        place += len(effect.flat()) + effect.constants
    return Program(**{hook: np.array(found, dtype=np.int64).reshape(-1, 2) for hook, found in rows.items()})


def flat_parameters(effects: Sequence[Effect], model: Model | None = None) -> Array:
    """All parameters of these effects, one after the other, each followed by its constants; without a model these are zero."""
    parts = [np.empty(0)]
    for effect in effects:
        constants = np.zeros(effect.constants) if model is None else np.array(effect.constants_of(model), dtype=float)
        parts += [effect.flat(), constants]
    return np.concatenate(parts)


def address(formula: Any, hook: str) -> int:
    """Where the compiled formula stands in memory."""
    return _compiled(formula, hook).address


@cache
def _compiled(formula: Any, hook: str) -> Any:
    try:
        return cfunc(SIGNATURES[hook], cache=True)(formula)
    except RuntimeError:
        return cfunc(SIGNATURES[hook])(formula)  # defined at a prompt: there is no file to keep it beside


def _caller(hook: str) -> Any:
    """A function for kernels that calls a formula of this hook: call(address, numbers or pointers ...)."""
    signature = SIGNATURES[hook]

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


call_leg_force = _caller("leg_force")
call_leg_mass = _caller("leg_mass")
call_leg_asymptotes = _caller("leg_asymptotes")
call_leg_transverse = _caller("leg_transverse")
call_joint_resistance = _caller("joint_resistance")
call_platform_wrench = _caller("platform_wrench")
call_platform_mass = _caller("platform_mass")


@intrinsic
def _pointer(typingctx: Any, array: Any, place: Any) -> Any:
    """Address of an entry of a contiguous array, as a whole number."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, given[0]).data
        return builder.ptrtoint(builder.gep(data, [given[1]]), context.get_value_type(types.int64))

    return types.int64(array, types.int64), generate


pointer: Any = _pointer
