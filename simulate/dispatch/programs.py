"""A program as the inner functions of a kernel read it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from simulate.dispatch.formulas import Program
from simulate.dispatch.intrinsics import pointer, whole_at


class Calls(NamedTuple):
    """A program as a kernel's inner functions read it: by hook, address of its rows and their number.

    Arrays handed from function to function are counted each time, which took longer than the mechanics. The program must
    outlive its calls.
    """

    leg_force: tuple[int, int]
    leg_mass: tuple[int, int]
    leg_asymptotes: tuple[int, int]
    leg_transverse: tuple[int, int]
    joint_resistance: tuple[int, int]
    platform_wrench: tuple[int, int]
    platform_mass: tuple[int, int]


@njit(cache=True)
def listed(called: Program) -> NDArray[np.int64]:
    """Address of its rows and their number for each hook of a program, one after the other in the order of `Calls`."""
    table = np.empty(2 * len(called), dtype=np.int64)
    for i in range(len(called)):
        table[2 * i], table[2 * i + 1] = pointer(called[i].reshape(-1), 0), called[i].shape[0]
    return table


@njit(cache=True, forceinline=True)
def calls_at(table: int) -> Calls:
    """The calls from the address of such a table."""
    return Calls(
        (whole_at(table, 0), whole_at(table, 1)),
        (whole_at(table, 2), whole_at(table, 3)),
        (whole_at(table, 4), whole_at(table, 5)),
        (whole_at(table, 6), whole_at(table, 7)),
        (whole_at(table, 8), whole_at(table, 9)),
        (whole_at(table, 10), whole_at(table, 11)),
        (whole_at(table, 12), whole_at(table, 13)),
    )


@njit(cache=True)
def workers(called: Program) -> int:
    """How many formulas of a program do work: forces along legs, joints, wrenches, in this order."""
    return called.leg_force.shape[0] + called.joint_resistance.shape[0] + called.platform_wrench.shape[0]


@njit(cache=True, forceinline=True)
def formula(rows: tuple[int, int], row: int) -> int:
    """Address of a formula."""
    return whole_at(rows[0], 3 * row)


@njit(cache=True, forceinline=True)
def place(rows: tuple[int, int], row: int) -> int:
    """Place of a formula's first parameter."""
    return whole_at(rows[0], 3 * row + 1)


@njit(cache=True, forceinline=True)
def formula_of_lanes(rows: tuple[int, int], row: int) -> int:
    """Address of the form of a formula that serves a block."""
    return whole_at(rows[0], 3 * row + 2)
