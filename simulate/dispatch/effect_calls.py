"""The formulas of effects, called for every run of a block; a hook that no effect uses is passed over."""

from __future__ import annotations

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import (
    call_joint_resistance,
    call_leg_asymptotes,
    call_leg_force,
    call_leg_force_lanes,
    call_leg_mass,
    call_leg_mass_lanes,
    call_leg_transverse,
    call_platform_mass,
    call_platform_wrench,
)
from simulate.dispatch.intrinsics import pointer
from simulate.dispatch.programs import Calls, formula, formula_of_lanes, place
from simulate.kernel.layout import (
    ADDED,
    EACH,
    LEG_BEFORE,
    LEG_VALUE,
    LENGTH,
    MASS,
    MATRIX,
    PAIR,
    POSE,
    RIGHT,
    ROWS,
    SCRATCH,
    SLOPE,
    SYSTEM,
    TRIAL,
    TWIST,
    WRENCH,
    G,
    H,
    R,
    U,
    V,
)
from simulate.kernel.model_rows import FULL, STOWED


@njit(cache=True, error_model="numpy", forceinline=True)
def worked(row: int, n: int) -> int:
    """Where the power of a formula stands; forces along legs come first, then joints, then wrenches."""
    return ROWS * n + SCRATCH + row * n


@njit(cache=True, error_model="numpy", forceinline=True)
def workers(calls: Calls) -> int:
    """How many formulas do work."""
    return calls.leg_force[1] + calls.joint_resistance[1] + calls.platform_wrench[1]


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_asymptotes(w: Array, mine: Array, calls: Calls, t0: float, t: float, n: int) -> None:
    """Asymptotes of the leg at hand as effects move them, before and now."""
    room, size = ROWS * n + PAIR, len(mine) // n
    for row in range(calls.leg_asymptotes[1]):
        called, first = formula(calls.leg_asymptotes, row), place(calls.leg_asymptotes, row)
        for i in range(n):
            p = pointer(mine, i * size + first)
            v = w[V * n + i]
            w[room], w[room + 1] = w[H * n + i], w[(H + 1) * n + i]
            call_leg_asymptotes(called, (w[LEG_BEFORE * n + i], v, t0, p, pointer(w, room)))
            w[H * n + i], w[(H + 1) * n + i] = w[room], w[room + 1]
            w[room], w[room + 1] = w[(H + 2) * n + i], w[(H + 3) * n + i]
            call_leg_asymptotes(called, (w[U * n + i], v, t, p, pointer(w, room)))
            w[(H + 2) * n + i], w[(H + 3) * n + i] = w[room], w[room + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_forces(w: Array, mine: Array, calls: Calls, t: float, n: int, ledger: bool) -> None:
    """Forces and axial inertia that effects add to the leg at hand, and the power of each."""
    size = len(mine) // n
    u, v, stored, turned = pointer(w, U * n), pointer(w, V * n), pointer(w, R * n), pointer(w, (LEG_BEFORE + 2) * n)
    for row in range(calls.leg_force[1]):
        p = pointer(mine, place(calls.leg_force, row))
        w[EACH * n : (EACH + 1) * n] = 0.0
        if n == 1:
            travel = w[U] - w[LEG_BEFORE + 2]
            w[EACH] = call_leg_force(formula(calls.leg_force, row), (w[U], w[V], t, w[R], travel, p))
        else:
            call_leg_force_lanes(formula_of_lanes(calls.leg_force, row), (u, v, t, stored, turned, p, size, pointer(w, EACH * n), n))
        for i in range(n):
            w[ADDED * n + i] += w[EACH * n + i]
        if ledger:
            for i in range(n):
                w[worked(row, n) + i] += w[EACH * n + i] * w[V * n + i]
    for row in range(calls.leg_mass[1]):
        p = pointer(mine, place(calls.leg_mass, row))
        if n == 1:
            w[MASS] += call_leg_mass(formula(calls.leg_mass, row), (w[U], p))
        else:
            call_leg_mass_lanes(formula_of_lanes(calls.leg_mass, row), (u, p, size, pointer(w, MASS * n), n))


@njit(cache=True, error_model="numpy", forceinline=True)
def transverse_masses(w: Array, mine: Array, calls: Calls, n: int) -> None:
    """Inertia across the leg at hand at its platform joint, and its slope over the length."""
    room, size = ROWS * n + PAIR, len(mine) // n
    for i in range(n):
        w[room], w[room + 1] = 0.0, 0.0
        full = w[(LEG_VALUE + STOWED) * n + i] + w[(LEG_VALUE + FULL) * n + i]
        for row in range(calls.leg_transverse[1]):
            p = pointer(mine, i * size + place(calls.leg_transverse, row))
            call_leg_transverse(formula(calls.leg_transverse, row), (w[LENGTH * n + i], full, p, pointer(w, room)))
        w[G * n + i], w[SLOPE * n + i] = w[room], w[room + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_resistance(w: Array, mine: Array, calls: Calls, lane: int, n: int, rate: float, ledger: bool) -> float:
    """Sum of the resistances that effects put into a joint, N m s, and the power of each."""
    total = 0.0
    for row in range(calls.joint_resistance[1]):
        p = pointer(mine, lane * (len(mine) // n) + place(calls.joint_resistance, row))
        resistance = call_joint_resistance(formula(calls.joint_resistance, row), (rate, p))
        total += resistance
        if ledger:
            w[worked(calls.leg_force[1] + row, n) + lane] -= resistance * rate * rate
    return total


@njit(cache=True, error_model="numpy", forceinline=True)
def platform_masses(w: Array, mine: Array, calls: Calls, n: int) -> None:
    """The bare platform's mass matrix as effects change it."""
    room, size = ROWS * n, len(mine) // n
    for row in range(calls.platform_mass[1]):
        for i in range(n):
            for k in range(7):
                w[room + POSE + k] = w[(TRIAL + k) * n + i]
            for j in range(6):
                for k in range(j + 1):
                    entry = w[(SYSTEM + j * (j + 1) // 2 + k) * n + i]
                    w[room + MATRIX + 6 * j + k] = w[room + MATRIX + 6 * k + j] = entry
            p = pointer(mine, i * size + place(calls.platform_mass, row))
            call_platform_mass(formula(calls.platform_mass, row), (pointer(w, room + POSE), p, pointer(w, room + MATRIX)))
            for j in range(6):
                for k in range(j + 1):
                    w[(SYSTEM + j * (j + 1) // 2 + k) * n + i] = w[room + MATRIX + 6 * j + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def platform_wrenches(w: Array, mine: Array, calls: Calls, t: float, n: int, ledger: bool) -> None:
    """Wrenches of effects into the right side, the power of each into the ledger."""
    room, size = ROWS * n, len(mine) // n
    for row in range(calls.platform_wrench[1]):
        power = worked(calls.leg_force[1] + calls.joint_resistance[1] + row, n)
        for i in range(n):
            for k in range(13):
                w[room + k] = w[(TRIAL + k) * n + i]
            for k in range(6):
                w[room + WRENCH + k] = 0.0
            p = pointer(mine, i * size + place(calls.platform_wrench, row))
            pose, twist, wrench = pointer(w, room + POSE), pointer(w, room + TWIST), pointer(w, room + WRENCH)
            call_platform_wrench(formula(calls.platform_wrench, row), (t, pose, twist, p, wrench))
            for k in range(6):
                w[(RIGHT + k) * n + i] += w[room + WRENCH + k]
            if ledger:
                for k in range(6):
                    w[power + i] += w[room + WRENCH + k] * w[room + TWIST + k]
