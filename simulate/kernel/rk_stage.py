"""One stage of a step as an address that kernels call: compiled once for each width of a block, and kept on disk.

Handed to the kernels as a function it would be compiled anew inside every one of them.
"""

from __future__ import annotations

from typing import Any

from numba import cfunc, njit, types
from numba.np.numpy_support import carray

from measure.common.arrays import Array
from simulate.dispatch import effect_calls as hooks
from simulate.dispatch.compiled_code import once
from simulate.dispatch.intrinsics import caller
from simulate.dispatch.programs import Calls, calls_at
from simulate.kernel import runge_kutta as marching
from simulate.kernel.layout import LEGS
from simulate.kernel.linear_systems import kinetic_energy, solve
from simulate.kernel.mechanics import (
    give_leg,
    leg_forces,
    leg_into_system,
    leg_kinematics,
    rotate,
    start_system,
    state_rates,
    take_leg,
)
from simulate.kernel.model_rows import PARAMETERS
from simulate.kernel.transverse import leg_crosswise

_NUMBERS, _WHOLE, _NUMBER = types.CPointer(types.float64), types.int64, types.float64
_SIGNATURE = types.void(_NUMBERS, _WHOLE, _NUMBERS, _NUMBERS, _WHOLE, _WHOLE, _NUMBER, _NUMBER, _NUMBER)

call_stage = caller(_SIGNATURE)


@once
def stage(n: int, ledger: bool) -> Any:
    """The compiled stage for n runs side by side; `.address` is what kernels want. It must outlive their calls, and does."""
    return cfunc(_SIGNATURE, cache=True, error_model="numpy")(_stage(n, ledger))


def _stage(n: int, ledger: bool) -> Any:
    def compute(memory: Any, size: int, rows: Any, every: Any, each: int, table: int, time: float, reach: float, step: float) -> None:
        """The stage of the step at `time` that looks ahead by `reach`; the one that looks ahead by nothing ends the step before.

        memory : `size` numbers, the rows of `layout`. rows : parameters of the runs as rows, read only. every : the same run
        after run, `each` in all, for the formulas of effects. table : address of the calls.
        """
        w, fixed, mine = carray(memory, size), carray(rows, PARAMETERS * n), carray(every, each)
        calls = calls_at(table)
        if reach == 0.0:
            marching.end_step(w, calls, step, n, ledger)
            derivative(w, fixed, mine, calls, max(time - step, 0.0), time, n, ledger)
            marching.carry_legs(w, n)
        else:
            marching.look_ahead(w, reach, n)
            derivative(w, fixed, mine, calls, time, time + reach, n, ledger)
        marching.gather(w, calls, reach, step, n, ledger)

    return compute


@njit(cache=True, error_model="numpy", forceinline=True)
def derivative(w: Array, fixed: Array, mine: Array, calls: Calls, t0: float, t: float, n: int, ledger: bool) -> None:
    """Rates of the trial states, and of the work done where a ledger is kept, into the rows RATE; what the legs do into OUT.

    t0 : time at which the legs stood as the rows ELONGATION and STORED say.
    """
    rotate(w, n)
    start_system(w, fixed, mine, calls, n)
    if ledger:
        w[hooks.worked(0, n) : hooks.worked(hooks.workers(calls), n)] = 0.0
    for leg in range(LEGS):
        take_leg(w, fixed, leg, n)
        leg_kinematics(w, n)
        leg_forces(w, fixed, mine, calls, t0, t, n, ledger)
        leg_into_system(w, calls, n, ledger)
        if calls.leg_transverse[1] + calls.joint_resistance[1] > 0:
            leg_crosswise(w, mine, calls, n, ledger)
        give_leg(w, leg, n)
    hooks.platform_wrenches(w, mine, calls, t, n, ledger)
    if ledger:
        kinetic_energy(w, n)
    solve(w, n)
    state_rates(w, n)
