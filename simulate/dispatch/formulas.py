"""Formulas of effects as addresses that a compiled kernel can call.

Each formula is compiled once, by itself, and kept on disk; the kernels reach it through its address. So a new effect
never recompiles a kernel, and an effect from outside the project runs like ours.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numba import cfunc, types
from numba.extending import register_jitable
from numpy.typing import NDArray

from measure.common.arrays import Array
from measure.common.kernel_cache import discard_stale
from simulate.dispatch.compiled_code import once
from simulate.dispatch.intrinsics import caller, shifted
from simulate.model.effect import Effect

if TYPE_CHECKING:
    from simulate.model.model import Model

discard_stale(Path(__file__).resolve().parents[1], ".", "dispatch", "kernel")

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

WORKING = ("leg_force", "joint_resistance", "platform_wrench")  # the hooks that do work, in the order of the kernel's ledger

# The two hooks that every leg asks for at every stage have a second form, for runs side by side: a call a block, not a call
# a run. Numbers become rows, and the parameters of a run stand `size` apart.
LANE_SIGNATURES = {
    "leg_force": types.void(_NUMBERS, _NUMBERS, _NUMBER, _NUMBERS, _NUMBERS, _NUMBERS, types.int64, _NUMBERS, types.int64),
    "leg_mass": types.void(_NUMBERS, _NUMBERS, types.int64, _NUMBERS, types.int64),
}


class Program(NamedTuple):
    """Which formulas a kernel calls, by hook: rows of (address, place of the first parameter, address of the form for lanes)."""

    leg_force: NDArray[np.int64]
    leg_mass: NDArray[np.int64]
    leg_asymptotes: NDArray[np.int64]
    leg_transverse: NDArray[np.int64]
    joint_resistance: NDArray[np.int64]
    platform_wrench: NDArray[np.int64]
    platform_mass: NDArray[np.int64]


def program(effects: Sequence[Effect], first_parameter: int) -> Program:
    """The formulas of these effects; parameters stand one after the other from `first_parameter` on."""
    return _program(tuple(type(effect) for effect in effects), first_parameter)


@once
def _program(kinds: tuple[type[Effect], ...], first_parameter: int) -> Program:
    rows: dict[str, list[tuple[int, int, int]]] = {hook: [] for hook in SIGNATURES}
    place = first_parameter
    for kind in kinds:
        for hook, found in rows.items():
            formula = getattr(kind, hook)
            if formula is not None:
                lanes = _lanes(formula, hook).address if hook in LANE_SIGNATURES else 0
                found.append((address(formula, hook), place, lanes))
        place += len(kind.flat_names()) + kind.constants
    return Program(**{hook: np.array(found, dtype=np.int64).reshape(-1, 3) for hook, found in rows.items()})


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


@once
def _compiled(formula: Any, hook: str) -> Any:
    try:
        return cfunc(SIGNATURES[hook], cache=True, error_model="numpy")(formula)
    except RuntimeError:
        return cfunc(SIGNATURES[hook], error_model="numpy")(formula)  # defined at a prompt: there is no file to keep it beside


@once
def _lanes(formula: Any, hook: str) -> Any:
    """The form for lanes. Compiled code is kept by the formula's name and by what stands in its file."""
    register_jitable(formula)
    source = Path(formula.__code__.co_filename)
    try:
        return cfunc(LANE_SIGNATURES[hook], cache=True)(_LANES[hook](formula, hashlib.sha256(source.read_bytes()).digest()))
    except (OSError, RuntimeError):
        return cfunc(LANE_SIGNATURES[hook])(_LANES[hook](formula, b""))


# The forms use `source` only to have it in their closure, by which numba tells kept code apart.
def _leg_force_lanes(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, v: Any, t: float, R: Any, turned: Any, p: Any, size: int, out: Any, n: int) -> None:
        for i in range(n if len(source) >= 0 else 0):
            out[i] += formula(u[i], v[i], t, R[i], u[i] - turned[i], shifted(p, i * size))

    return lanes


def _leg_mass_lanes(formula: Any, source: bytes) -> Any:
    def lanes(u: Any, p: Any, size: int, out: Any, n: int) -> None:
        for i in range(n if len(source) >= 0 else 0):
            out[i] += formula(u[i], shifted(p, i * size))

    return lanes


_LANES = {"leg_force": _leg_force_lanes, "leg_mass": _leg_mass_lanes}


call_leg_force = caller(SIGNATURES["leg_force"])
call_leg_force_lanes = caller(LANE_SIGNATURES["leg_force"])
call_leg_mass_lanes = caller(LANE_SIGNATURES["leg_mass"])
call_leg_mass = caller(SIGNATURES["leg_mass"])
call_leg_asymptotes = caller(SIGNATURES["leg_asymptotes"])
call_leg_transverse = caller(SIGNATURES["leg_transverse"])
call_joint_resistance = caller(SIGNATURES["joint_resistance"])
call_platform_wrench = caller(SIGNATURES["platform_wrench"])
call_platform_mass = caller(SIGNATURES["platform_mass"])
