"""What effects contribute to the equations of motion: their formulas, called for every run of a block, by address."""

from __future__ import annotations

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import (
    FormulaPointers,
    call_base_force,
    call_base_mass,
    call_control,
    call_joint_resistance,
    call_leg_asymptotes,
    call_leg_force,
    call_leg_force_lanes,
    call_leg_mass,
    call_leg_mass_lanes,
    call_leg_transverse,
    call_platform_mass,
    call_platform_wrench,
    call_platform_wrench_lanes,
    call_strip_elongation,
    formula_at,
    lanes_formula_at,
    parameter_place,
)
from simulate.dispatch.intrinsics import pointer
from simulate.dispatch.lanes import Rows, from_row
from simulate.kernel.layout import (
    ADDED,
    AXIAL_MASS,
    AXIS,
    BIAS,
    CONTROL_AXIS,
    CONTROL_BIAS,
    EACH,
    FULL,
    LEG_BEFORE,
    LEG_VALUE,
    LENGTH,
    LEVER,
    MANY,
    RIGHT,
    ROWS,
    SCRATCH,
    SCRATCH_MATRIX,
    SCRATCH_PAIR,
    SCRATCH_POSE,
    SCRATCH_TWIST,
    SCRATCH_WRENCH,
    SLOPE,
    STOWED,
    STRIP_NOW,
    SYSTEM,
    TIME_BEFORE,
    TIME_NOW,
    TRIAL,
    G,
    H,
    R,
    U,
    V,
)


@njit(cache=True, error_model="numpy", forceinline=True)
def power_row(row: int, n: int) -> int:
    """Where the power of a formula stands; forces along legs come first, then joints, wrenches, and the base."""
    return ROWS * n + SCRATCH + row * n


@njit(cache=True, error_model="numpy", forceinline=True)
def count_working(formulas: FormulaPointers) -> int:
    """How many formulas do work."""
    of_effects = formulas.leg_force[1] + formulas.joint_resistance[1] + formulas.platform_wrench[1] + formulas.base_force[1]
    return of_effects + formulas.control[1]


@njit(cache=True, error_model="numpy", forceinline=True)
def control_place(formulas: FormulaPointers, n: int, with_work: bool) -> int:
    """Where the memory of a controller begins, behind the work of all formulas."""
    return power_row(3 * count_working(formulas) if with_work else 0, n)


@njit(cache=True, error_model="numpy", forceinline=True)
def keep_leg_for_control(w: Rows, formulas: FormulaPointers, leg: int, n: int, with_work: bool) -> None:
    """Direction, lever and c of the leg at hand, for a controller that acts when all legs are known."""
    kept = from_row(w, control_place(formulas, n, with_work) // n)
    for k in range(3):
        kept[CONTROL_AXIS + 6 * leg + k], kept[CONTROL_AXIS + 6 * leg + 3 + k] = w[AXIS + k], w[LEVER + k]
    kept[CONTROL_BIAS + leg] = w[BIAS]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_control(w: Array, by_run: Array, formulas: FormulaPointers, reach: float, n: int, with_work: bool) -> None:
    """Forces of a controller along the legs, when all legs are known, and their power."""
    at = control_place(formulas, n, with_work)
    power = power_row(count_working(formulas) - 1, n) if with_work else -1
    law, place, loop = formula_at(formulas.control, 0), parameter_place(formulas.control, 0), lanes_formula_at(formulas.control, 0)
    every = len(by_run)
    call_control(loop, (pointer(w, 0), len(w), pointer(by_run, 0), every, place, law, at, power, n, reach))


@njit(cache=True, error_model="numpy", forceinline=True)
def uncoil_strip(w: Array, by_run: Array, formulas: FormulaPointers, n: int) -> None:
    """What of the elongation of the leg at hand reaches its strip."""
    size = len(by_run) // n
    for row in range(formulas.strip_elongation[1]):
        formula, first = formula_at(formulas.strip_elongation, row), parameter_place(formulas.strip_elongation, row)
        for i in range(n):
            p = pointer(by_run, i * size + first)
            w[STRIP_NOW * n + i] = call_strip_elongation(formula, (w[STRIP_NOW * n + i], w[(LEG_BEFORE + 3) * n + i], p))


@njit(cache=True, error_model="numpy", forceinline=True)
def move_asymptotes(w: Array, by_run: Array, formulas: FormulaPointers, n: int) -> None:
    """Asymptotes of the leg at hand as effects move them, before and now."""
    scratch, size = ROWS * n + SCRATCH_PAIR, len(by_run) // n
    for row in range(formulas.leg_asymptotes[1]):
        formula, first = formula_at(formulas.leg_asymptotes, row), parameter_place(formulas.leg_asymptotes, row)
        for i in range(n):
            p = pointer(by_run, i * size + first)
            v = w[V * n + i]
            w[scratch], w[scratch + 1] = w[H * n + i], w[(H + 1) * n + i]
            call_leg_asymptotes(formula, (w[(LEG_BEFORE + 3) * n + i], v, w[TIME_BEFORE * n + i], p, pointer(w, scratch)))
            w[H * n + i], w[(H + 1) * n + i] = w[scratch], w[scratch + 1]
            w[scratch], w[scratch + 1] = w[(H + 2) * n + i], w[(H + 3) * n + i]
            call_leg_asymptotes(formula, (w[STRIP_NOW * n + i], v, w[TIME_NOW * n + i], p, pointer(w, scratch)))
            w[(H + 2) * n + i], w[(H + 3) * n + i] = w[scratch], w[scratch + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_leg_forces(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Forces and axial inertia that effects add to the leg at hand, and the power of each."""
    size, powers = len(by_run) // n, from_row(w, power_row(0, n) // n)
    u, v, stored, turned = pointer(flat, U * n), pointer(flat, V * n), pointer(flat, R * n), pointer(flat, (LEG_BEFORE + 2) * n)
    now, each = pointer(flat, TIME_NOW * n), pointer(flat, EACH * n)
    for row in range(formulas.leg_force[1]):
        p = pointer(by_run, parameter_place(formulas.leg_force, row))
        if n == 1:
            travel = flat[U] - flat[LEG_BEFORE + 2]
            force = call_leg_force(formula_at(formulas.leg_force, row), (flat[U], flat[V], flat[TIME_NOW], flat[R], travel, p))
            flat[EACH] = force
        else:
            rows, together = from_row(by_lane, parameter_place(formulas.leg_force, row)), int(n == MANY and not with_work)
            call_leg_force_lanes(lanes_formula_at(formulas.leg_force, row), (u, v, now, stored, turned, p, size, rows, each, n, together))
        w[ADDED] += w[EACH]
        if with_work:
            powers[row] += w[EACH] * w[V]
    for row in range(formulas.leg_mass[1]):
        p = pointer(by_run, parameter_place(formulas.leg_mass, row))
        if n == 1:
            flat[AXIAL_MASS] += call_leg_mass(formula_at(formulas.leg_mass, row), (flat[U], p))
        else:
            call_leg_mass_lanes(lanes_formula_at(formulas.leg_mass, row), (u, p, size, pointer(flat, AXIAL_MASS * n), n))


@njit(cache=True, error_model="numpy", forceinline=True)
def transverse_inertia(w: Array, by_run: Array, formulas: FormulaPointers, n: int) -> None:
    """Inertia across the leg at hand at its platform joint, and its slope over the length."""
    scratch, size = ROWS * n + SCRATCH_PAIR, len(by_run) // n
    for i in range(n):
        w[scratch], w[scratch + 1] = 0.0, 0.0
        full = w[(LEG_VALUE + STOWED) * n + i] + w[(LEG_VALUE + FULL) * n + i]
        for row in range(formulas.leg_transverse[1]):
            p = pointer(by_run, i * size + parameter_place(formulas.leg_transverse, row))
            call_leg_transverse(formula_at(formulas.leg_transverse, row), (w[LENGTH * n + i], full, p, pointer(w, scratch)))
        w[G * n + i], w[SLOPE * n + i] = w[scratch], w[scratch + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def sum_joint_resistance(w: Array, by_run: Array, formulas: FormulaPointers, lane: int, n: int, rate: float, with_work: bool) -> float:
    """Sum of the resistances that effects put into a joint, N m s, and the power of each."""
    total = 0.0
    for row in range(formulas.joint_resistance[1]):
        p = pointer(by_run, lane * (len(by_run) // n) + parameter_place(formulas.joint_resistance, row))
        resistance = call_joint_resistance(formula_at(formulas.joint_resistance, row), (rate, p))
        total += resistance
        if with_work:
            w[power_row(formulas.leg_force[1] + row, n) + lane] -= resistance * rate * rate
    return total


@njit(cache=True, error_model="numpy", forceinline=True)
def change_platform_mass(w: Array, by_run: Array, formulas: FormulaPointers, n: int) -> None:
    """The bare platform's mass matrix as effects change it."""
    scratch, size = ROWS * n, len(by_run) // n
    for row in range(formulas.platform_mass[1]):
        for i in range(n):
            for k in range(7):
                w[scratch + SCRATCH_POSE + k] = w[(TRIAL + k) * n + i]
            for j in range(6):
                for k in range(j + 1):
                    entry = w[(SYSTEM + j * (j + 1) // 2 + k) * n + i]
                    w[scratch + SCRATCH_MATRIX + 6 * j + k] = w[scratch + SCRATCH_MATRIX + 6 * k + j] = entry
            p = pointer(by_run, i * size + parameter_place(formulas.platform_mass, row))
            call_platform_mass(
                formula_at(formulas.platform_mass, row), (pointer(w, scratch + SCRATCH_POSE), p, pointer(w, scratch + SCRATCH_MATRIX))
            )
            for j in range(6):
                for k in range(j + 1):
                    w[(SYSTEM + j * (j + 1) // 2 + k) * n + i] = w[scratch + SCRATCH_MATRIX + 6 * j + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_platform_wrenches(w: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Wrenches of effects into the right side, the power of each into the energy balance."""
    scratch, size = ROWS * n, len(by_run) // n
    for row in range(formulas.platform_wrench[1]):
        together = lanes_formula_at(formulas.platform_wrench, row)
        if n == MANY and not with_work and together != 0:
            p, now = from_row(by_lane, parameter_place(formulas.platform_wrench, row)), pointer(w, TIME_NOW * n)
            pose, twist, right = pointer(w, TRIAL * n), pointer(w, (TRIAL + 7) * n), pointer(w, RIGHT * n)
            call_platform_wrench_lanes(together, (now, pose, twist, p, right))
            continue
        power = power_row(formulas.leg_force[1] + formulas.joint_resistance[1] + row, n)
        for i in range(n):
            for k in range(13):
                w[scratch + k] = w[(TRIAL + k) * n + i]
            for k in range(6):
                w[scratch + SCRATCH_WRENCH + k] = 0.0
            p = pointer(by_run, i * size + parameter_place(formulas.platform_wrench, row))
            pose, twist, wrench = (
                pointer(w, scratch + SCRATCH_POSE),
                pointer(w, scratch + SCRATCH_TWIST),
                pointer(w, scratch + SCRATCH_WRENCH),
            )
            call_platform_wrench(formula_at(formulas.platform_wrench, row), (w[TIME_NOW * n + i], pose, twist, p, wrench))
            for k in range(6):
                w[(RIGHT + k) * n + i] += w[scratch + SCRATCH_WRENCH + k]
            if with_work:
                for k in range(6):
                    w[power + i] += w[scratch + SCRATCH_WRENCH + k] * w[scratch + SCRATCH_TWIST + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def base_mass(by_run: Array, formulas: FormulaPointers, lane: int, n: int) -> float:
    """Mass of the base ring, kg; zero where it is rigid."""
    total = 0.0
    for row in range(formulas.base_mass[1]):
        p = pointer(by_run, lane * (len(by_run) // n) + parameter_place(formulas.base_mass, row))
        total += call_base_mass(formula_at(formulas.base_mass, row), (p,))
    return total


@njit(cache=True, error_model="numpy", forceinline=True)
def sum_base_forces(
    w: Array, by_run: Array, formulas: FormulaPointers, lane: int, n: int, place: float, speed: float, with_work: bool
) -> float:
    """Sum of the forces that hold the base ring, N, and the power of each."""
    total, first = 0.0, formulas.leg_force[1] + formulas.joint_resistance[1] + formulas.platform_wrench[1]
    for row in range(formulas.base_force[1]):
        p = pointer(by_run, lane * (len(by_run) // n) + parameter_place(formulas.base_force, row))
        force = call_base_force(formula_at(formulas.base_force, row), (place, speed, p))
        total += force
        if with_work:
            w[power_row(first + row, n) + lane] += force * speed
    return total
