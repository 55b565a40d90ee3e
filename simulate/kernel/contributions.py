"""What effects contribute to the equations of motion: their formulas, called for every run of a block, by address."""

from __future__ import annotations

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import (
    FormulaPointers,
    call_base_force,
    call_base_mass,
    call_joint_resistance,
    call_leg_asymptotes,
    call_leg_force,
    call_leg_mass,
    call_leg_transverse,
    call_platform_mass,
    call_platform_wrench,
    call_strip_elongation,
    formula_at,
    lanes_formula_at,
    parameter_place,
)
from simulate.dispatch.intrinsics import pointer
from simulate.dispatch.lane_forms import (
    call_base_force_lanes,
    call_base_mass_lanes,
    call_joint_resistance_lanes,
    call_leg_asymptotes_lanes,
    call_leg_force_lanes,
    call_leg_mass_lanes,
    call_leg_transverse_lanes,
    call_platform_mass_lanes,
    call_platform_wrench_lanes,
    call_strip_elongation_lanes,
)
from simulate.dispatch.lanes import Rows, from_row
from simulate.kernel.layout import (
    ADDED,
    AXIAL_MASS,
    AXIS,
    BASE,
    BASE_SYSTEM,
    BIAS,
    CONTROL_AXIS,
    CONTROL_BIAS,
    EACH,
    FULL,
    JOINT_RATE,
    LEG_BEFORE,
    LEG_VALUE,
    LENGTH,
    LEVER,
    MANY,
    MATRIX,
    RESISTANCE,
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
def address_for_all(rows: tuple[int, int], row: int, n: int, with_work: bool) -> int:
    """Address of the form of a formula that a sweep computes with the numbers of all its runs at once; 0 where there is none."""
    return lanes_formula_at(rows, row) if n == MANY and not with_work else 0


@njit(cache=True, error_model="numpy", forceinline=True)
def uncoil_strip(flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """What of the elongation of the leg at hand reaches its strip."""
    size, strip, before = len(by_run) // n, pointer(flat, STRIP_NOW * n), pointer(flat, (LEG_BEFORE + 3) * n)
    for row in range(formulas.strip_elongation[1]):
        first, for_all = parameter_place(formulas.strip_elongation, row), address_for_all(formulas.strip_elongation, row, n, with_work)
        if for_all != 0:
            call_strip_elongation_lanes(for_all, (strip, before, from_row(by_lane, first), strip))
            continue
        formula = formula_at(formulas.strip_elongation, row)
        for i in range(n):
            p = pointer(by_run, i * size + first)
            now = flat[STRIP_NOW * n + i]
            flat[STRIP_NOW * n + i] = call_strip_elongation(formula, (now, flat[(LEG_BEFORE + 3) * n + i], p))


@njit(cache=True, error_model="numpy", forceinline=True)
def move_asymptotes(flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Asymptotes of the leg at hand as effects move them, before and now."""
    for row in range(formulas.leg_asymptotes[1]):
        for_all = address_for_all(formulas.leg_asymptotes, row, n, with_work)
        if for_all != 0:
            p, v = from_row(by_lane, parameter_place(formulas.leg_asymptotes, row)), pointer(flat, V * n)
            before, now = pointer(flat, (LEG_BEFORE + 3) * n), pointer(flat, STRIP_NOW * n)
            call_leg_asymptotes_lanes(for_all, (before, v, pointer(flat, TIME_BEFORE * n), p, pointer(flat, H * n)))
            call_leg_asymptotes_lanes(for_all, (now, v, pointer(flat, TIME_NOW * n), p, pointer(flat, (H + 2) * n)))
        else:
            move_asymptotes_run_by_run(flat, by_run, formulas, row, n)


@njit(cache=True, error_model="numpy", forceinline=True)
def move_asymptotes_run_by_run(w: Array, by_run: Array, formulas: FormulaPointers, row: int, n: int) -> None:
    """The same by one formula, run by run."""
    scratch, size = ROWS * n + SCRATCH_PAIR, len(by_run) // n
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
    size, powers, memory = len(by_run) // n, from_row(w, power_row(0, n) // n), pointer(flat, 0)
    for row in range(formulas.leg_force[1]):
        first, for_all = parameter_place(formulas.leg_force, row), lanes_formula_at(formulas.leg_force, row)
        if n == 1 or for_all == 0:
            push_run_by_run(flat, by_run, formula_at(formulas.leg_force, row), first, n)
        elif n == MANY and not with_work:
            call_leg_force_lanes(for_all, (memory, from_row(by_lane, first), 0, n))
        else:
            call_leg_force_lanes(for_all, (memory, pointer(by_run, first), size, n))
        w[ADDED] += w[EACH]
        if with_work:
            powers[row] += w[EACH] * w[V]
    for row in range(formulas.leg_mass[1]):
        first, for_all = parameter_place(formulas.leg_mass, row), lanes_formula_at(formulas.leg_mass, row)
        if n == 1 or for_all == 0:
            for i in range(n):
                p = pointer(by_run, i * size + first)
                flat[AXIAL_MASS * n + i] += call_leg_mass(formula_at(formulas.leg_mass, row), (flat[U * n + i], p))
        elif n == MANY and not with_work:
            call_leg_mass_lanes(for_all, (memory, from_row(by_lane, first), 0, n))
        else:
            call_leg_mass_lanes(for_all, (memory, pointer(by_run, first), size, n))


@njit(cache=True, error_model="numpy", forceinline=True)
def push_run_by_run(w: Array, by_run: Array, formula: int, first: int, n: int) -> None:
    """The force of one formula along the leg at hand, run by run, into EACH."""
    size = len(by_run) // n
    for i in range(n):
        u, p = w[U * n + i], pointer(by_run, i * size + first)
        known = u, w[V * n + i], w[TIME_NOW * n + i], w[R * n + i], u - w[(LEG_BEFORE + 2) * n + i]
        w[EACH * n + i] = call_leg_force(formula, (*known, p))


@njit(cache=True, error_model="numpy", forceinline=True)
def transverse_inertia(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Inertia across the leg at hand at its platform joint, and its slope over the length."""
    scratch, size = ROWS * n + SCRATCH_PAIR, len(by_run) // n
    w[G], w[SLOPE], w[EACH] = 0.0, 0.0, w[LEG_VALUE + STOWED] + w[LEG_VALUE + FULL]
    for row in range(formulas.leg_transverse[1]):
        first, for_all = parameter_place(formulas.leg_transverse, row), address_for_all(formulas.leg_transverse, row, n, with_work)
        if for_all != 0:
            length, full = pointer(flat, LENGTH * n), pointer(flat, EACH * n)
            call_leg_transverse_lanes(for_all, (length, full, from_row(by_lane, first), pointer(flat, G * n)))
            continue
        formula = formula_at(formulas.leg_transverse, row)
        for i in range(n):
            flat[scratch], flat[scratch + 1] = flat[G * n + i], flat[SLOPE * n + i]
            p = pointer(by_run, i * size + first)
            call_leg_transverse(formula, (flat[LENGTH * n + i], flat[EACH * n + i], p, pointer(flat, scratch)))
            flat[G * n + i], flat[SLOPE * n + i] = flat[scratch], flat[scratch + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def resist_in_joints(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Sum of what effects put into the joints of the leg at hand against their JOINT_RATE, N m s, and the power of each."""
    w[RESISTANCE] = w[RESISTANCE + 1] = 0.0
    for row in range(formulas.joint_resistance[1]):
        first, for_all = parameter_place(formulas.joint_resistance, row), address_for_all(formulas.joint_resistance, row, n, with_work)
        if for_all != 0:
            call_joint_resistance_lanes(for_all, (pointer(flat, JOINT_RATE * n), from_row(by_lane, first), pointer(flat, RESISTANCE * n)))
        else:
            power = power_row(formulas.leg_force[1] + row, n)
            resist_run_by_run(flat, by_run, formula_at(formulas.joint_resistance, row), first, power, n, with_work)


@njit(cache=True, error_model="numpy", forceinline=True)
def resist_run_by_run(w: Array, by_run: Array, formula: int, first: int, power: int, n: int, with_work: bool) -> None:
    """The same by one formula, run by run; its power stands from `power` on."""
    size = len(by_run) // n
    for joint in range(2):
        for i in range(n):
            rate = w[(JOINT_RATE + joint) * n + i]
            resistance = call_joint_resistance(formula, (rate, pointer(by_run, i * size + first)))
            w[(RESISTANCE + joint) * n + i] += resistance
            if with_work:
                w[power + i] -= resistance * rate * rate


@njit(cache=True, error_model="numpy", forceinline=True)
def change_platform_mass(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """The bare platform's mass matrix as effects change it."""
    for row in range(formulas.platform_mass[1]):
        first, for_all = parameter_place(formulas.platform_mass, row), address_for_all(formulas.platform_mass, row, n, with_work)
        for j in range(6):
            for k in range(j + 1):
                w[MATRIX + 6 * j + k] = w[MATRIX + 6 * k + j] = w[SYSTEM + j * (j + 1) // 2 + k]
        if for_all != 0:
            call_platform_mass_lanes(for_all, (pointer(flat, TRIAL * n), from_row(by_lane, first), pointer(flat, MATRIX * n)))
        else:
            change_mass_run_by_run(flat, by_run, formula_at(formulas.platform_mass, row), first, n)
        for j in range(6):
            for k in range(j + 1):
                w[SYSTEM + j * (j + 1) // 2 + k] = w[MATRIX + 6 * j + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def change_mass_run_by_run(w: Array, by_run: Array, formula: int, first: int, n: int) -> None:
    """The rows MATRIX as one formula changes them, run by run."""
    scratch, size = ROWS * n, len(by_run) // n
    for i in range(n):
        for k in range(7):
            w[scratch + SCRATCH_POSE + k] = w[(TRIAL + k) * n + i]
        for k in range(36):
            w[scratch + SCRATCH_MATRIX + k] = w[(MATRIX + k) * n + i]
        pose, matrix = pointer(w, scratch + SCRATCH_POSE), pointer(w, scratch + SCRATCH_MATRIX)
        call_platform_mass(formula, (pose, pointer(by_run, i * size + first), matrix))
        for k in range(36):
            w[(MATRIX + k) * n + i] = w[scratch + SCRATCH_MATRIX + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def add_platform_wrenches(w: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Wrenches of effects into the right side, the power of each into the energy balance."""
    scratch, size = ROWS * n, len(by_run) // n
    for row in range(formulas.platform_wrench[1]):
        for_all = address_for_all(formulas.platform_wrench, row, n, with_work)
        if for_all != 0:
            p, now = from_row(by_lane, parameter_place(formulas.platform_wrench, row)), pointer(w, TIME_NOW * n)
            pose, twist, right = pointer(w, TRIAL * n), pointer(w, (TRIAL + 7) * n), pointer(w, RIGHT * n)
            call_platform_wrench_lanes(for_all, (now, pose, twist, p, right))
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
def weigh_base(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Mass of the base ring, kg, into BASE_SYSTEM; zero where it is rigid."""
    size = len(by_run) // n
    w[BASE_SYSTEM] = 0.0
    for row in range(formulas.base_mass[1]):
        first, for_all = parameter_place(formulas.base_mass, row), address_for_all(formulas.base_mass, row, n, with_work)
        if for_all != 0:
            call_base_mass_lanes(for_all, (from_row(by_lane, first), pointer(flat, BASE_SYSTEM * n)))
            continue
        for i in range(n):
            flat[BASE_SYSTEM * n + i] += call_base_mass(formula_at(formulas.base_mass, row), (pointer(by_run, i * size + first),))


@njit(cache=True, error_model="numpy", forceinline=True)
def hold_base(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Sum of the forces that hold the base ring, N, into EACH, and the power of each."""
    size, first_power = len(by_run) // n, formulas.leg_force[1] + formulas.joint_resistance[1] + formulas.platform_wrench[1]
    place, speed = (TRIAL + BASE) * n, (TRIAL + BASE + 1) * n
    w[EACH] = 0.0
    for row in range(formulas.base_force[1]):
        first, for_all = parameter_place(formulas.base_force, row), address_for_all(formulas.base_force, row, n, with_work)
        if for_all != 0:
            rows = from_row(by_lane, first)
            call_base_force_lanes(for_all, (pointer(flat, place), pointer(flat, speed), rows, pointer(flat, EACH * n)))
            continue
        for i in range(n):
            p = pointer(by_run, i * size + first)
            force = call_base_force(formula_at(formulas.base_force, row), (flat[place + i], flat[speed + i], p))
            flat[EACH * n + i] += force
            if with_work:
                flat[power_row(first_power + row, n) + i] += force * flat[speed + i]
