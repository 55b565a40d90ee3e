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
from simulate.dispatch.lanes import Rows, chosen
from simulate.kernel.contributions import hold_base, weigh_base
from simulate.kernel.layout import BASE, BASE_FORCE, BASE_ROW, BASE_SYSTEM, EACH, KINETIC, RATE, RIGHT, STATES, SYSTEM, TRIAL, WEIGHT

Z, VZ = 2, 9  # places of the height and of its rate in a state


@njit(cache=True, error_model="numpy", forceinline=True)
def place_in_row(k: int) -> int:
    """Where the third row of a symmetric 6 x 6 matrix has its entry k, lower halves row by row."""
    return 3 + k if k <= Z else k * (k + 1) // 2 + Z


@njit(cache=True, error_model="numpy", forceinline=True)
def look_from_base(w: Rows) -> None:
    """Before the legs: the platform as it is seen from the base, and what of the system is not the legs'."""
    for k in range(6):
        w[BASE_ROW + k] = w[SYSTEM + place_in_row(k)]
    w[BASE_FORCE] = w[RIGHT + Z]
    w[TRIAL + Z] -= w[TRIAL + BASE]
    w[TRIAL + VZ] -= w[TRIAL + BASE + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def stand_on_base(w: Rows, flat: Array, by_lane: Rows, by_run: Array, formulas: FormulaPointers, n: int, with_work: bool) -> None:
    """Behind the legs: the base's row of the system, from what the legs have added to the platform's."""
    weigh_base(w, flat, by_lane, by_run, formulas, n, with_work)
    hold_base(w, flat, by_lane, by_run, formulas, n, with_work)
    w[TRIAL + Z] += w[TRIAL + BASE]
    w[TRIAL + VZ] += w[TRIAL + BASE + 1]
    for k in range(6):
        w[BASE_ROW + k] -= w[SYSTEM + place_in_row(k)]
    mass, weight = w[BASE_SYSTEM], by_lane[WEIGHT + Z]
    w[BASE_SYSTEM] = chosen(mass > 0.0, mass - w[BASE_ROW + Z], 0.0)
    w[BASE_FORCE] += w[EACH] - weight - w[RIGHT + Z]
    if with_work:
        w[RATE + STATES + 2] -= weight * w[TRIAL + BASE + 1]


@njit(cache=True, error_model="numpy", forceinline=True)
def base_energy(w: Rows) -> None:
    """Kinetic energy of a moving base, and what the legs have less for standing on it, J."""
    speed = w[TRIAL + BASE + 1]
    along = 0.5 * w[BASE_SYSTEM] * speed
    for k in range(6):
        along += w[BASE_ROW + k] * w[TRIAL + 7 + k]
    w[KINETIC] += along * speed


@njit(cache=True, error_model="numpy", forceinline=True)
def eliminate_base(w: Rows) -> None:
    """The platform's system with the base's acceleration put in."""
    per = chosen(w[BASE_SYSTEM] > 0.0, 1.0 / w[BASE_SYSTEM], 0.0)
    for j in range(6):
        share = w[BASE_ROW + j] * per
        w[RIGHT + j] -= share * w[BASE_FORCE]
        for k in range(j + 1):
            w[SYSTEM + j * (j + 1) // 2 + k] -= share * w[BASE_ROW + k]


@njit(cache=True, error_model="numpy", forceinline=True)
def base_rates(w: Rows) -> None:
    """Rates of the base's place and speed, from the platform's accelerations."""
    per = chosen(w[BASE_SYSTEM] > 0.0, 1.0 / w[BASE_SYSTEM], 0.0)
    force = w[BASE_FORCE]
    for k in range(6):
        force -= w[BASE_ROW + k] * w[RIGHT + k]
    w[RATE + BASE] = w[TRIAL + BASE + 1]
    w[RATE + BASE + 1] = force * per
