"""A program as the inner functions of a kernel read it."""

from __future__ import annotations

from typing import NamedTuple

from numba import njit

from .compiled import Program
from .intrinsics import pointer, whole_at


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
def calls_of(called: Program) -> Calls:
    """The calls of a program."""
    return Calls(
        (pointer(called.leg_force.reshape(-1), 0), called.leg_force.shape[0]),
        (pointer(called.leg_mass.reshape(-1), 0), called.leg_mass.shape[0]),
        (pointer(called.leg_asymptotes.reshape(-1), 0), called.leg_asymptotes.shape[0]),
        (pointer(called.leg_transverse.reshape(-1), 0), called.leg_transverse.shape[0]),
        (pointer(called.joint_resistance.reshape(-1), 0), called.joint_resistance.shape[0]),
        (pointer(called.platform_wrench.reshape(-1), 0), called.platform_wrench.shape[0]),
        (pointer(called.platform_mass.reshape(-1), 0), called.platform_mass.shape[0]),
    )


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
