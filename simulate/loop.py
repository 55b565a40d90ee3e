"""The force of an actuator along a given elongation, as on a shaker: the law and every effect on the leg, without any dynamics."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numba import njit

from measure.common.arrays import Array
from simulate.dispatch.formula_table import flat_parameters, formula_table
from simulate.dispatch.formulas import FormulaTable, call_leg_asymptotes, call_leg_force, call_leg_mass, call_strip_elongation
from simulate.dispatch.intrinsics import pointer
from simulate.kernel.layout import NEVER
from simulate.law import advance
from simulate.model.effect import Effect

A_L, B_L, A_U, B_U, BETA, LINE_VALUES = 0, 1, 2, 3, 4, 5


@lru_cache(maxsize=64)
def _parameters(effects: tuple[Effect, ...]) -> Array:
    return flat_parameters(effects)


def loop_force(
    lines: Array,
    time_s: Array,
    elongation_m: Array,
    speed_m_per_s: Array,
    acceleration_m_per_s2: Array,
    start_force_N: float,
    effects: tuple[Effect, ...] = (),
) -> Array:
    """Force of an actuator along a given elongation: the law, sample to sample exact, and every effect on the leg.

        F = R + sum F_effect - (sum m_effect) u''

    Parameters
    ----------
    lines : (5,) a_l, b_l, a_u, b_u, beta.
    time_s, elongation_m, speed_m_per_s, acceleration_m_per_s2 : (n,) each.
    start_force_N : the hysteretic force R at the first sample.
    effects : what else acts on the leg.

    Returns
    -------
    (n,) force in N, before any effect of the load cell (`Effect.observe_force`).
    """
    values = np.concatenate([np.asarray(lines, dtype=float), _parameters(effects)])
    table = formula_table(effects, LINE_VALUES)
    return loop_kernel(values, table, time_s, elongation_m, speed_m_per_s, acceleration_m_per_s2, float(start_force_N))


@njit(cache=True)
def loop_kernel(values: Array, table: FormulaTable, time: Array, u: Array, v: Array, acceleration: Array, start_force: float) -> Array:
    """`loop_force` on bare arrays: `values` holds the five line values and then the parameters of the effects."""
    n = len(u)
    force = np.empty(n)
    before, after = np.empty(2), np.empty(2)
    R, strip, turned_at, direction = start_force, u[0], NEVER, 0.0
    asymptotes(values, 0, table, u[0], v[0], time[0], before, 0)
    for i in range(n):
        if i > 0:
            step = u[i] - u[i - 1]
            if step * direction < 0.0:
                turned_at = u[i - 1]
            if step != 0.0:
                direction = step
            uncoiled = strip_elongation(values, table, u[i], strip) - strip
            strip += uncoiled
            asymptotes(values, 0, table, strip, v[i], time[i], after, 0)
            side = 0 if uncoiled > 0.0 else 1
            R = advance(R, uncoiled, before[side], after[side], values[BETA])
            before[0], before[1] = after[0], after[1]
        force[i] = R + added_force(values, table, u[i], v[i], time[i], R, u[i] - turned_at)
        force[i] -= axial_mass(values, table, u[i]) * acceleration[i]
    return force


@njit(cache=True, forceinline=True)
def strip_elongation(values: Array, table: FormulaTable, u: float, before: float) -> float:
    """What of an actuator's elongation reaches the strip, which stood at `before`, m."""
    for row in range(table.strip_elongation.shape[0]):
        u = call_strip_elongation(table.strip_elongation[row, 0], (u, before, pointer(values, table.strip_elongation[row, 1])))
    return u


@njit(cache=True, forceinline=True)
def asymptotes(values: Array, line: int, table: FormulaTable, u: float, v: float, t: float, h: Array, at: int) -> None:
    """Lower and upper asymptote at an elongation, into h[at] and h[at + 1]; the five line values start at `line`."""
    h[at] = values[line + A_L] * u + values[line + B_L]
    h[at + 1] = values[line + A_U] * u + values[line + B_U]
    for row in range(table.leg_asymptotes.shape[0]):
        p = pointer(values, table.leg_asymptotes[row, 1])
        call_leg_asymptotes(table.leg_asymptotes[row, 0], (u, v, t, p, pointer(h, at)))


@njit(cache=True, forceinline=True)
def added_force(values: Array, table: FormulaTable, u: float, v: float, t: float, R: float, travel: float) -> float:
    """Sum of the forces that effects add to a leg, N."""
    total = 0.0
    for row in range(table.leg_force.shape[0]):
        total += call_leg_force(table.leg_force[row, 0], (u, v, t, R, travel, pointer(values, table.leg_force[row, 1])))
    return total


@njit(cache=True, forceinline=True)
def axial_mass(values: Array, table: FormulaTable, u: float) -> float:
    """Sum of the inertia that effects add along a leg, kg."""
    total = 0.0
    for row in range(table.leg_mass.shape[0]):
        total += call_leg_mass(table.leg_mass[row, 0], (u, pointer(values, table.leg_mass[row, 1])))
    return total
