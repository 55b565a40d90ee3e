"""Formulas of effects for runs side by side: one call for a block of runs, with rows where a formula has numbers."""

from __future__ import annotations

import dis
import hashlib
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba import cfunc, types
from numba.core.errors import NumbaError
from numba.extending import register_jitable

from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.intrinsics import caller, shifted
from simulate.dispatch.lanes import rows_at
from simulate.kernel.layout import AXIAL_MASS, EACH, LEG_BEFORE, MANY, TIME_NOW, R, U, V

_NUMBERS = types.CPointer(types.float64)

# The forms for runs side by side: one call for a block, not one for each run; numbers become rows. A sweep computes a formula with the
# numbers of all its runs at once, if it can be (no branch). The two that every leg needs at every stage have a form in other kernels too
# and find their rows themselves, for arguments beyond the fourth go by way of the stack, which takes longer than a short formula. The
# parameters of n runs stand `size` apart; a sweep says `size` zero, and they are rows.
LANE_SIGNATURES = {
    "leg_force": types.void(_NUMBERS, _NUMBERS, types.int64, types.int64),
    "leg_mass": types.void(_NUMBERS, _NUMBERS, types.int64, types.int64),
    "strip_elongation": types.void(*[_NUMBERS] * 4),
    "leg_asymptotes": types.void(*[_NUMBERS] * 5),
    "leg_transverse": types.void(*[_NUMBERS] * 4),
    "joint_resistance": types.void(*[_NUMBERS] * 3),
    "platform_wrench": types.void(*[_NUMBERS] * 5),
    "platform_mass": types.void(*[_NUMBERS] * 3),
    "base_mass": types.void(*[_NUMBERS] * 2),
    "base_force": types.void(*[_NUMBERS] * 4),
    "law": types.void(*[_NUMBERS] * 7),
}


@compiled_once
def form_for_all(formula: Any, kind: str) -> Any:
    """The form for a block of runs, which a sweep computes at once, or None where there is none: a formula with a branch.

    Compiled code is kept by the formula's name and by what stands in its file.
    """
    # numba would give up as well, after a second in every process
    if any("JUMP" in one.opname and "_IF_" in one.opname for one in dis.get_instructions(formula)):
        return None
    register_jitable(formula)
    with suppress(NumbaError):
        return _kept(_TOGETHER[kind], formula, kind)
    return None


def _kept(make: Any, formula: Any, kind: str) -> Any:
    source = Path(formula.__code__.co_filename)
    try:
        return cfunc(LANE_SIGNATURES[kind], cache=True)(make(formula, hashlib.sha256(source.read_bytes()).digest()))
    except (OSError, RuntimeError):
        return cfunc(LANE_SIGNATURES[kind])(make(formula, b""))


@register_jitable
def _leg_force_run_by_run(formula: Any, w: Any, p: Any, size: int, n: int) -> None:
    for i in range(n):
        u, turned = w[U * n + i], w[(LEG_BEFORE + 2) * n + i]
        w[EACH * n + i] = formula(u, w[V * n + i], w[TIME_NOW * n + i], w[R * n + i], u - turned, shifted(p, i * size))


@register_jitable
def _leg_mass_run_by_run(formula: Any, w: Any, p: Any, size: int, n: int) -> None:
    for i in range(n):
        w[AXIAL_MASS * n + i] += formula(w[U * n + i], shifted(p, i * size))


# The forms use `source` only to have it in their closure, by which numba tells kept code apart. What else is in the closure must be the
# same in every process: a function made in another one is not, and the code would be compiled again each time.
def _leg_force_together(formula: Any, source: bytes) -> Any:
    def lanes(memory: Any, p: Any, size: int, n: int) -> None:
        if size == 0 and len(source) >= 0:
            w = rows_at(memory, MANY, True)
            w[EACH] = formula(w[U], w[V], w[TIME_NOW], w[R], w[U] - w[LEG_BEFORE + 2], rows_at(p, MANY, True))
        else:
            _leg_force_run_by_run(formula, memory, p, size, n)

    return lanes


def _leg_mass_together(formula: Any, source: bytes) -> Any:
    def lanes(memory: Any, p: Any, size: int, n: int) -> None:
        if size == 0 and len(source) >= 0:
            w = rows_at(memory, MANY, True)
            w[AXIAL_MASS] += formula(w[U], rows_at(p, MANY, True))
        else:
            _leg_mass_run_by_run(formula, memory, p, size, n)

    return lanes


def _strip_elongation_together(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, before: Any, p: Any, out: Any) -> None:
        if len(source) >= 0:
            rows_at(out, MANY, True)[0] = formula(rows_at(u, MANY, True)[0], rows_at(before, MANY, True)[0], rows_at(p, MANY, True))

    return lanes


def _leg_asymptotes_together(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, v: Any, t: Any, p: Any, h: Any) -> None:
        if len(source) >= 0:
            formula(
                rows_at(u, MANY, True)[0],
                rows_at(v, MANY, True)[0],
                rows_at(t, MANY, True)[0],
                rows_at(p, MANY, True),
                rows_at(h, MANY, True),
            )

    return lanes


def _leg_transverse_together(formula: Any, source: bytes) -> Any:
    def lanes(length: Any, full: Any, p: Any, g: Any) -> None:
        if len(source) >= 0:
            formula(rows_at(length, MANY, True)[0], rows_at(full, MANY, True)[0], rows_at(p, MANY, True), rows_at(g, MANY, True))

    return lanes


def _joint_resistance_together(formula: Any, source: bytes) -> Any:
    def lanes(rate: Any, p: Any, out: Any) -> None:
        if len(source) >= 0:
            for joint in range(2):
                rows_at(out, MANY, True)[joint] += formula(rows_at(rate, MANY, True)[joint], rows_at(p, MANY, True))

    return lanes


def _platform_wrench_together(formula: Any, source: bytes) -> Any:
    def lanes(t: Any, pose: Any, twist: Any, p: Any, wrench: Any) -> None:
        if len(source) >= 0:
            formula(
                rows_at(t, MANY, True)[0],
                rows_at(pose, MANY, True),
                rows_at(twist, MANY, True),
                rows_at(p, MANY, True),
                rows_at(wrench, MANY, True),
            )

    return lanes


def _platform_mass_together(formula: Any, source: bytes) -> Any:
    def lanes(pose: Any, p: Any, mass: Any) -> None:
        if len(source) >= 0:
            formula(rows_at(pose, MANY, True), rows_at(p, MANY, True), rows_at(mass, MANY, True))

    return lanes


def _base_mass_together(formula: Any, source: bytes) -> Any:
    def lanes(p: Any, out: Any) -> None:
        if len(source) >= 0:
            rows_at(out, MANY, True)[0] += formula(rows_at(p, MANY, True))

    return lanes


def _base_force_together(formula: Any, source: bytes) -> Any:
    def lanes(place: Any, speed: Any, p: Any, out: Any) -> None:
        if len(source) >= 0:
            rows_at(out, MANY, True)[0] += formula(rows_at(place, MANY, True)[0], rows_at(speed, MANY, True)[0], rows_at(p, MANY, True))

    return lanes


def _law_together(formula: Any, source: bytes) -> Any:
    def lanes(t: Any, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        if len(source) >= 0:
            formula(
                rows_at(t, MANY, True)[0],
                rows_at(u, MANY, True),
                rows_at(v, MANY, True),
                rows_at(turn, MANY, True),
                rows_at(memory, MANY, True),
                rows_at(p, MANY, True),
                rows_at(out, MANY, True),
            )

    return lanes


_TOGETHER = {
    "leg_force": _leg_force_together,
    "leg_mass": _leg_mass_together,
    "strip_elongation": _strip_elongation_together,
    "leg_asymptotes": _leg_asymptotes_together,
    "leg_transverse": _leg_transverse_together,
    "joint_resistance": _joint_resistance_together,
    "platform_wrench": _platform_wrench_together,
    "platform_mass": _platform_mass_together,
    "base_mass": _base_mass_together,
    "base_force": _base_force_together,
    "law": _law_together,
}


call_leg_force_lanes = caller(LANE_SIGNATURES["leg_force"])
call_leg_mass_lanes = caller(LANE_SIGNATURES["leg_mass"])
call_strip_elongation_lanes = caller(LANE_SIGNATURES["strip_elongation"])
call_leg_asymptotes_lanes = caller(LANE_SIGNATURES["leg_asymptotes"])
call_leg_transverse_lanes = caller(LANE_SIGNATURES["leg_transverse"])
call_joint_resistance_lanes = caller(LANE_SIGNATURES["joint_resistance"])
call_platform_wrench_lanes = caller(LANE_SIGNATURES["platform_wrench"])
call_platform_mass_lanes = caller(LANE_SIGNATURES["platform_mass"])
call_base_mass_lanes = caller(LANE_SIGNATURES["base_mass"])
call_base_force_lanes = caller(LANE_SIGNATURES["base_force"])
call_law_lanes = caller(LANE_SIGNATURES["law"])
