"""A force law that a fit has bent to what is missing, where no loops hold it, or that loops themselves do not meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from identify.criteria import CLOSE, ROUGHLY, TWO_SIDED_95
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.problem import Fit

_STEPS = 8  # of a fit of the releases


def is_bent(fit: Fit) -> bool:
    """Whether some number of the law is farther off than its prior lets one expect."""
    first = fit.problem.first_nuisance
    off = [q / one.spread for q, one in zip(fit.q[:first], fit.problem.parameters[:first], strict=True) if np.isfinite(one.spread)]
    return bool(off) and float(np.max(np.abs(off))) > TWO_SIDED_95


def with_law_as_given(fit: Fit) -> Fit:
    """The law as the model file has it, releases fitted to that."""
    problem = fit.problem
    q = fit.q.copy()
    q[: problem.first_nuisance] = 0.0
    own = solve(problem, q, free=range(problem.first_nuisance, problem.first_effect), most_steps=_STEPS, enough=ROUGHLY).q
    return Fit(problem, own, *problem.jacobian(own), True)


def loops_miss(fit: Fit) -> bool:
    """Whether the loops by themselves are missed: then no tolerance helps, for a shaker knows nothing of the rig."""
    if not fit.problem.films or not fit.problem.loops:
        return False
    alone = replace(fit.problem, films=())
    return solve(alone, laid_out(fit, alone), enough=ROUGHLY, loosely=True).rms > CLOSE
