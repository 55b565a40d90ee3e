"""A base ring that gives way along the vertical: one degree of freedom more, beside the six of the platform. Absent unless an effect asks.

The legs stand on the base, so they see the platform from it. With s its place, M_l the inertia and f the force of all legs in the
platform's coordinates, z their third row, f_0 the platform's weight, which the springs have carried since before the release:

    (M + M_l) a - M_l,z s'' = f + wrench,      (m + M_l,zz) s'' - M_l,z' a = f_0 - f_z + F(s, s')

The base is eliminated first, so the system stays 6 x 6 and positive definite. A base of no mass is rigid.
"""

from __future__ import annotations

from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formulas import FormulaPointers
from simulate.kernel.contributions import base_mass, sum_base_forces
from simulate.kernel.layout import BASE, BASE_FORCE, BASE_ROW, BASE_SYSTEM, KINETIC, RATE, RIGHT, STATES, SYSTEM, TRIAL, WEIGHT

Z, VZ = 2, 9  # places of the height and of its rate in a state


@njit(cache=True, error_model="numpy", forceinline=True)
def place_in_row(k: int) -> int:
    """Where the third row of a symmetric 6 x 6 matrix has its entry k, lower halves row by row."""
    return 3 + k if k <= Z else k * (k + 1) // 2 + Z


@njit(cache=True, error_model="numpy", forceinline=True)
def look_from_base(w: Array, n: int) -> None:
    """Before the legs: the platform as it is seen from the base, and what of the system is not the legs'."""
    for i in range(n):
        for k in range(6):
            w[(BASE_ROW + k) * n + i] = w[(SYSTEM + place_in_row(k)) * n + i]
        w[BASE_FORCE * n + i] = w[(RIGHT + Z) * n + i]
        w[(TRIAL + Z) * n + i] -= w[(TRIAL + BASE) * n + i]
        w[(TRIAL + VZ) * n + i] -= w[(TRIAL + BASE + 1) * n + i]


@njit(cache=True, error_model="numpy", forceinline=True)
def stand_on_base(w: Array, by_lane: Array, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Behind the legs: the base's row of the system, from what the legs have added to the platform's."""
    for i in range(n):
        place, speed, weight = w[(TRIAL + BASE) * n + i], w[(TRIAL + BASE + 1) * n + i], by_lane[(WEIGHT + Z) * n + i]
        w[(TRIAL + Z) * n + i] += place
        w[(TRIAL + VZ) * n + i] += speed
        for k in range(6):
            w[(BASE_ROW + k) * n + i] -= w[(SYSTEM + place_in_row(k)) * n + i]
        mass = base_mass(by_run, formulas, i, n)
        w[BASE_SYSTEM * n + i] = mass - w[(BASE_ROW + Z) * n + i] if mass > 0.0 else 0.0
        force = sum_base_forces(w, by_run, formulas, i, n, place, speed, with_work)
        w[BASE_FORCE * n + i] += force - weight - w[(RIGHT + Z) * n + i]
        if with_work:
            w[(RATE + STATES + 2) * n + i] -= weight * speed


@njit(cache=True, error_model="numpy", forceinline=True)
def base_energy(w: Array, n: int) -> None:
    """Kinetic energy of a moving base, and what the legs have less for standing on it, J."""
    for i in range(n):
        speed = w[(TRIAL + BASE + 1) * n + i]
        along = 0.5 * w[BASE_SYSTEM * n + i] * speed
        for k in range(6):
            along += w[(BASE_ROW + k) * n + i] * w[(TRIAL + 7 + k) * n + i]
        w[KINETIC * n + i] += along * speed


@njit(cache=True, error_model="numpy", forceinline=True)
def eliminate_base(w: Array, n: int) -> None:
    """The platform's system with the base's acceleration put in."""
    for i in range(n):
        per = 1.0 / w[BASE_SYSTEM * n + i] if w[BASE_SYSTEM * n + i] > 0.0 else 0.0
        for j in range(6):
            share = w[(BASE_ROW + j) * n + i] * per
            w[(RIGHT + j) * n + i] -= share * w[BASE_FORCE * n + i]
            for k in range(j + 1):
                w[(SYSTEM + j * (j + 1) // 2 + k) * n + i] -= share * w[(BASE_ROW + k) * n + i]


@njit(cache=True, error_model="numpy", forceinline=True)
def base_rates(w: Array, n: int) -> None:
    """Rates of the base's place and speed, from the platform's accelerations."""
    for i in range(n):
        per = 1.0 / w[BASE_SYSTEM * n + i] if w[BASE_SYSTEM * n + i] > 0.0 else 0.0
        force = w[BASE_FORCE * n + i]
        for k in range(6):
            force -= w[(BASE_ROW + k) * n + i] * w[(RIGHT + k) * n + i]
        w[(RATE + BASE) * n + i] = w[(TRIAL + BASE + 1) * n + i]
        w[(RATE + BASE + 1) * n + i] = force * per
