"""How long fits will take, from the time of one step of one of them."""

from __future__ import annotations

from identify.estimation.problem import Problem
from measure.common.running.duration import timed

_STEPS = 12  # of a fit, about


def seconds_of(problem: Problem, fits: float) -> float:
    """About how many seconds so many fits like this one take on this machine: a step is one look at all gaps and their slopes.

    Raises
    ------
    InputError
        The model cannot follow the runs at all.
    """
    start = problem.start
    return fits * _STEPS * timed(lambda: problem.jacobian(start))
