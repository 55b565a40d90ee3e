"""The formulas of effects, called for every run of a block; a hook that no effect uses is passed over."""

from __future__ import annotations

from numba import njit

from measure.tables import Array

from .compiled import (
    Program,
    call_joint_resistance,
    call_leg_asymptotes,
    call_leg_force,
    call_leg_mass,
    call_leg_transverse,
    call_platform_mass,
    call_platform_wrench,
    pointer,
)
from .layout import ADDED, LEG_BEFORE, LEG_VALUE, LENGTH, MASS, RATE, RIGHT, ROWS, SLOPE, STATES, SYSTEM, TRIAL, G, H, R, U, V
from .packing import FULL, STOWED

# Behind the rows: room for what a formula wants to see as plain vectors.
POSE, TWIST, WRENCH, MATRIX, PAIR = 0, 7, 13, 19, 55
SCRATCH = 57


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_asymptotes(w: Array, mine: Array, called: Program, t0: float, t: float, n: int) -> None:
    """Asymptotes of the leg at hand as effects move them, before and now."""
    room, size = ROWS * n + PAIR, len(mine) // n
    for row in range(called.leg_asymptotes.shape[0]):
        formula, place = called.leg_asymptotes[row, 0], called.leg_asymptotes[row, 1]
        for i in range(n):
            p = pointer(mine, i * size + place)
            v = w[V * n + i]
            w[room], w[room + 1] = w[H * n + i], w[(H + 1) * n + i]
            call_leg_asymptotes(formula, (w[LEG_BEFORE * n + i], v, t0, p, pointer(w, room)))
            w[H * n + i], w[(H + 1) * n + i] = w[room], w[room + 1]
            w[room], w[room + 1] = w[(H + 2) * n + i], w[(H + 3) * n + i]
            call_leg_asymptotes(formula, (w[U * n + i], v, t, p, pointer(w, room)))
            w[(H + 2) * n + i], w[(H + 3) * n + i] = w[room], w[room + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def leg_forces(w: Array, mine: Array, called: Program, t: float, n: int) -> None:
    """Forces and axial inertia that effects add to the leg at hand."""
    size = len(mine) // n
    for row in range(called.leg_force.shape[0]):
        formula, place = called.leg_force[row, 0], called.leg_force[row, 1]
        for i in range(n):
            u, v, stored = w[U * n + i], w[V * n + i], w[R * n + i]
            travel = u - w[(LEG_BEFORE + 2) * n + i]
            w[ADDED * n + i] += call_leg_force(formula, (u, v, t, stored, travel, pointer(mine, i * size + place)))
    for row in range(called.leg_mass.shape[0]):
        formula, place = called.leg_mass[row, 0], called.leg_mass[row, 1]
        for i in range(n):
            w[MASS * n + i] += call_leg_mass(formula, (w[U * n + i], pointer(mine, i * size + place)))


@njit(cache=True, error_model="numpy", forceinline=True)
def transverse_masses(w: Array, mine: Array, called: Program, n: int) -> None:
    """Inertia across the leg at hand at its platform joint, and its slope over the length."""
    room, size = ROWS * n + PAIR, len(mine) // n
    for i in range(n):
        w[room], w[room + 1] = 0.0, 0.0
        full = w[(LEG_VALUE + STOWED) * n + i] + w[(LEG_VALUE + FULL) * n + i]
        for row in range(called.leg_transverse.shape[0]):
            p = pointer(mine, i * size + called.leg_transverse[row, 1])
            call_leg_transverse(called.leg_transverse[row, 0], (w[LENGTH * n + i], full, p, pointer(w, room)))
        w[G * n + i], w[SLOPE * n + i] = w[room], w[room + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def joint_resistance(mine: Array, called: Program, lane: int, n: int, rate: float) -> float:
    """Sum of the resistances that effects put into a joint, N m s."""
    total = 0.0
    for row in range(called.joint_resistance.shape[0]):
        p = pointer(mine, lane * (len(mine) // n) + called.joint_resistance[row, 1])
        total += call_joint_resistance(called.joint_resistance[row, 0], (rate, p))
    return total


@njit(cache=True, error_model="numpy", forceinline=True)
def platform_masses(w: Array, mine: Array, called: Program, n: int) -> None:
    """The bare platform's mass matrix as effects change it."""
    room, size = ROWS * n, len(mine) // n
    for row in range(called.platform_mass.shape[0]):
        for i in range(n):
            for k in range(7):
                w[room + POSE + k] = w[(TRIAL + k) * n + i]
            for j in range(6):
                for k in range(j + 1):
                    entry = w[(SYSTEM + j * (j + 1) // 2 + k) * n + i]
                    w[room + MATRIX + 6 * j + k] = w[room + MATRIX + 6 * k + j] = entry
            p = pointer(mine, i * size + called.platform_mass[row, 1])
            call_platform_mass(called.platform_mass[row, 0], (pointer(w, room + POSE), p, pointer(w, room + MATRIX)))
            for j in range(6):
                for k in range(j + 1):
                    w[(SYSTEM + j * (j + 1) // 2 + k) * n + i] = w[room + MATRIX + 6 * j + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def platform_wrenches(w: Array, mine: Array, called: Program, t: float, n: int) -> None:
    """Wrenches of effects into the right side, their power into the ledger."""
    room, size = ROWS * n, len(mine) // n
    for row in range(called.platform_wrench.shape[0]):
        for i in range(n):
            for k in range(13):
                w[room + k] = w[(TRIAL + k) * n + i]
            for k in range(6):
                w[room + WRENCH + k] = 0.0
            p = pointer(mine, i * size + called.platform_wrench[row, 1])
            pose, twist, wrench = pointer(w, room + POSE), pointer(w, room + TWIST), pointer(w, room + WRENCH)
            call_platform_wrench(called.platform_wrench[row, 0], (t, pose, twist, p, wrench))
            for k in range(6):
                w[(RIGHT + k) * n + i] += w[room + WRENCH + k]
                w[(RATE + STATES + 3) * n + i] += w[room + WRENCH + k] * w[room + TWIST + k]
