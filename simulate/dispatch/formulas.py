"""Formulas of effects as addresses that a compiled kernel can call.

Each formula is compiled once, by itself, and kept on disk; the kernels reach it through its address. So a new effect
never recompiles a kernel, and an effect from outside the project runs like ours.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import cfunc, njit, types
from numba.core.errors import NumbaError
from numba.extending import register_jitable
from numpy.typing import NDArray

from measure.common.errors import InputError, clipped
from measure.common.kernel_cache import discard_stale
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.intrinsics import caller, pointer, shifted, whole_at
from simulate.dispatch.lanes import rows_at
from simulate.kernel.layout import MANY

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

# The two formulas that every leg needs at every stage have a second form, for runs side by side: one call for a block, not one for
# each run. Numbers become rows, and the parameters of a run stand `size` apart; with `together`, which a sweep says, they are rows too,
# and the formula is computed with the numbers of all runs at once, if it can be (no branch).
LANE_SIGNATURES = {
    "leg_force": types.void(*[_NUMBERS] * 6, types.int64, _NUMBERS, _NUMBERS, types.int64, types.int64),
    "leg_mass": types.void(_NUMBERS, _NUMBERS, types.int64, _NUMBERS, types.int64),
    "platform_wrench": types.void(*[_NUMBERS] * 5),
}

# A stage of a Runge-Kutta step, which kernels reach through its address too: see kernel.runge_kutta.
STAGE = types.void(_NUMBERS, types.int64, _NUMBERS, _NUMBERS, types.int64, types.int64, _NUMBER)


# A law of control, and what calls it for every run of a block once all legs are known: see control.control_loop.
LAW = types.void(_NUMBER, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS, _NUMBERS)
CONTROL = types.void(_NUMBERS, types.int64, _NUMBERS, types.int64, types.int64, types.int64, types.int64, types.int64, types.int64, _NUMBER)


class FormulaTable(NamedTuple):
    """The formulas that a kernel calls, by kind: rows of (address, place of the first parameter, address of the form for lanes).

    Of a controller it is (address of the law, place of the first parameter, address of what calls it), one row or none.
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


@compiled_once
def lanes_form(formula: Any, kind: str) -> Any:
    """The form for lanes, or None where there is none: a wrench with a branch is called run by run.

    Compiled code is kept by the formula's name and by what stands in its file.
    """
    register_jitable(formula)
    if kind in _TOGETHER:
        with suppress(NumbaError):
            return _kept(_TOGETHER[kind], formula, kind)
    return _kept(_LANES[kind], formula, kind) if kind in _LANES else None


def _kept(make: Any, formula: Any, kind: str) -> Any:
    source = Path(formula.__code__.co_filename)
    try:
        return cfunc(LANE_SIGNATURES[kind], cache=True)(make(formula, hashlib.sha256(source.read_bytes()).digest()))
    except (OSError, RuntimeError):
        return cfunc(LANE_SIGNATURES[kind])(make(formula, b""))


# The forms use `source` only to have it in their closure, by which numba tells kept code apart.
def _leg_force_lanes(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, v: Any, t: Any, R: Any, turned: Any, p: Any, size: int, rows: Any, out: Any, n: int, together: int) -> None:
        for i in range(n if len(source) >= 0 else 0):
            out[i] = formula(u[i], v[i], t[i], R[i], u[i] - turned[i], shifted(p, i * size))

    return lanes


def _leg_force_together(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, v: Any, t: Any, R: Any, turned: Any, p: Any, size: int, rows: Any, out: Any, n: int, together: int) -> None:
        if together:
            place, speed, time, stored, last = of_all(u), of_all(v), of_all(t), of_all(R), of_all(turned)
            of_all(out)[0] = formula(place[0], speed[0], time[0], stored[0], place[0] - last[0], of_all(rows))
        else:
            for i in range(n if len(source) >= 0 else 0):
                out[i] = formula(u[i], v[i], t[i], R[i], u[i] - turned[i], shifted(p, i * size))

    return lanes


@njit(forceinline=True)
def of_all(numbers: Any) -> Any:
    """Rows of a sweep's block."""
    return rows_at(numbers, MANY, True)


def _leg_mass_lanes(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, p: Any, size: int, out: Any, n: int) -> None:
        for i in range(n if len(source) >= 0 else 0):
            out[i] += formula(u[i], shifted(p, i * size))

    return lanes


def _platform_wrench_together(formula: Any, source: bytes) -> Any:
    def lanes(t: Any, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        if len(source) >= 0:
            formula(of_all(t)[0], of_all(pose), of_all(twist), of_all(p), of_all(wrench))

    return lanes


_LANES = {"leg_force": _leg_force_lanes, "leg_mass": _leg_mass_lanes}
_TOGETHER = {"leg_force": _leg_force_together, "platform_wrench": _platform_wrench_together}


call_leg_force = caller(SIGNATURES["leg_force"])
call_leg_force_lanes = caller(LANE_SIGNATURES["leg_force"])
call_leg_mass_lanes = caller(LANE_SIGNATURES["leg_mass"])
call_platform_wrench_lanes = caller(LANE_SIGNATURES["platform_wrench"])
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
call_control = caller(CONTROL)
call_stage = caller(STAGE)
