"""Formulas of effects as addresses that a compiled kernel can call.

Each formula is compiled once, by itself, and kept on disk; the kernels reach it through its address. So a new effect
never recompiles a kernel, and an effect from outside the project runs like ours.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, njit, types
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from measure.common.errors import InputError, clipped
from measure.common.kernel_cache import discard_stale
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.intrinsics import caller, pointer, whole_at

discard_stale(Path(__file__).resolve().parents[1], ".", "dispatch", "kernel", "control")

_NUMBER = types.float64
_NUMBERS = types.CPointer(types.float64)

SIGNATURES = {
    "leg_force": _NUMBER(_NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBER, _NUMBERS),
    "leg_mass": _NUMBER(_NUMBER, _NUMBERS),
    "strip_elongation": _NUMBER(_NUMBER, _NUMBER, _NUMBERS),
    "leg_asymptotes": types.void(_NUMBER, _NUMBER, _NUMBER, _NUMBERS, _NUMBERS),
    "leg_transverse": types.void(_NUMBER, _NUMBER, _NUMBERS, _NUMBERS),
    "joint_resistance": _NUMBER(_NUMBER, _NUMBERS),
    "platform_wrench": types.void(_NUMBER, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS),
    "platform_mass": types.void(_NUMBERS, _NUMBERS, _NUMBERS),
    "base_mass": _NUMBER(_NUMBERS),
    "base_force": _NUMBER(_NUMBER, _NUMBER, _NUMBERS),
}

# A stage of a Runge-Kutta step, which kernels reach through its address too: see kernel.runge_kutta.
STAGE = types.void(_NUMBERS, types.int64, _NUMBERS, _NUMBERS, types.int64, types.int64, _NUMBER)


# A law of control: see control.control_loop.
LAW = types.void(_NUMBER, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS)


class FormulaTable(NamedTuple):
    """The formulas that a kernel calls, by kind: rows of (address, place of the first parameter, address of the form for lanes).

    Of a controller it is its law, one row or none.
    """

    leg_force: NDArray[np.int64]
    leg_mass: NDArray[np.int64]
    strip_elongation: NDArray[np.int64]
    leg_asymptotes: NDArray[np.int64]
    leg_transverse: NDArray[np.int64]
    joint_resistance: NDArray[np.int64]
    platform_wrench: NDArray[np.int64]
    platform_mass: NDArray[np.int64]
    base_mass: NDArray[np.int64]
    base_force: NDArray[np.int64]
    control: NDArray[np.int64]


class FormulaPointers(NamedTuple):
    """The same table as a kernel's inner functions read it: by kind, address of the rows and their number.

    Arrays handed from function to function are counted each time, which took longer than the mechanics. The table must outlive
    its pointers.
    """

    leg_force: tuple[int, int]
    leg_mass: tuple[int, int]
    strip_elongation: tuple[int, int]
    leg_asymptotes: tuple[int, int]
    leg_transverse: tuple[int, int]
    joint_resistance: tuple[int, int]
    platform_wrench: tuple[int, int]
    platform_mass: tuple[int, int]
    base_mass: tuple[int, int]
    base_force: tuple[int, int]
    control: tuple[int, int]


@njit(cache=True)
def pointers_of(table: FormulaTable) -> NDArray[np.int64]:
    """Address and number of the rows of each kind of formula, one after the other in the order of `FormulaPointers`."""
    pointers = np.empty(2 * len(table), dtype=np.int64)
    for i in range(len(table)):
        pointers[2 * i], pointers[2 * i + 1] = pointer(table[i].reshape(-1), 0), table[i].shape[0]
    return pointers


@njit(cache=True, forceinline=True)
def pointers_at(address: int) -> FormulaPointers:
    """The pointers that `pointers_of` wrote, from the address of its array."""
    return FormulaPointers(
        (whole_at(address, 0), whole_at(address, 1)),
        (whole_at(address, 2), whole_at(address, 3)),
        (whole_at(address, 4), whole_at(address, 5)),
        (whole_at(address, 6), whole_at(address, 7)),
        (whole_at(address, 8), whole_at(address, 9)),
        (whole_at(address, 10), whole_at(address, 11)),
        (whole_at(address, 12), whole_at(address, 13)),
        (whole_at(address, 14), whole_at(address, 15)),
        (whole_at(address, 16), whole_at(address, 17)),
        (whole_at(address, 18), whole_at(address, 19)),
        (whole_at(address, 20), whole_at(address, 21)),
    )


@njit(cache=True)
def count_with_power(table: FormulaTable) -> int:
    """Number of formulas that do work: forces along legs, moments in joints, wrenches, forces on the base, control, in this order."""
    of_effects = table.leg_force.shape[0] + table.joint_resistance.shape[0] + table.platform_wrench.shape[0] + table.base_force.shape[0]
    return of_effects + table.control.shape[0]


@njit(cache=True, forceinline=True)
def formula_at(rows: tuple[int, int], row: int) -> int:
    """Address of a formula."""
    return whole_at(rows[0], 3 * row)


@njit(cache=True, forceinline=True)
def parameter_place(rows: tuple[int, int], row: int) -> int:
    """Place of a formula's first parameter."""
    return whole_at(rows[0], 3 * row + 1)


@njit(cache=True, forceinline=True)
def lanes_formula_at(rows: tuple[int, int], row: int) -> int:
    """Address of the form of a formula that serves a block of runs."""
    return whole_at(rows[0], 3 * row + 2)


_SIGNATURES = {**SIGNATURES, "law": LAW}


def address(formula: Any, kind: str) -> int:
    """Where the compiled formula stands in memory; `kind` is one of SIGNATURES, or "law"."""
    return _compiled(formula, kind).address


@compiled_once
def _compiled(formula: Any, kind: str) -> Any:
    try:
        return cfunc(_SIGNATURES[kind], cache=True, error_model="numpy")(formula)
    except NumbaError as error:
        raise InputError(_uncompilable(formula, error)) from error
    except (RuntimeError, ImportError, AttributeError):
        # defined at a prompt: there is no file to keep it beside; or kept for a module that had another name
        return cfunc(_SIGNATURES[kind], error_model="numpy")(formula)


def _uncompilable(formula: Any, error: NumbaError) -> str:
    where = f"{formula.__code__.co_filename}, line {formula.__code__.co_firstlineno}"
    reason = next((line.strip() for line in str(error).splitlines()[1:] if line.strip()), str(error))
    return f"{where}: {formula.__qualname__} cannot be compiled: {clipped(reason, 200)} A formula is made of numbers, p[i] and math."


call_leg_force = caller(SIGNATURES["leg_force"])
call_leg_mass = caller(SIGNATURES["leg_mass"])
call_strip_elongation = caller(SIGNATURES["strip_elongation"])
call_leg_asymptotes = caller(SIGNATURES["leg_asymptotes"])
call_leg_transverse = caller(SIGNATURES["leg_transverse"])
call_joint_resistance = caller(SIGNATURES["joint_resistance"])
call_platform_wrench = caller(SIGNATURES["platform_wrench"])
call_platform_mass = caller(SIGNATURES["platform_mass"])
call_base_mass = caller(SIGNATURES["base_mass"])
call_base_force = caller(SIGNATURES["base_force"])
call_law = caller(LAW)
call_stage = caller(STAGE)
