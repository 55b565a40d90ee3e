"""Hypotheses, fitted or only weighed, and how many of them a search may fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from identify.criteria import FARTHEST_SPREADS, HALF
from identify.estimation.problem import Fit
from identify.selection.promises import Promise
from identify.selection.verdict import Names
from identify.selection.weighing import Weighed

Say = Callable[[str], None]


@dataclass(frozen=True)
class Budget:
    """How much is tried, in fits and not in seconds, so that every machine comes to the same answer.

    fits : hypotheses that may be fitted whole; one that leaves the films far off counts three times. deepest : the most names of one.
    least : log weight below the best one at which a hypothesis that was only weighed is not worth a fit.
    """

    fits: int
    deepest: int
    least: float


BUDGETS = {"quick": Budget(4, 1, 3.0), "normal": Budget(12, 3, 3.0), "thorough": Budget(40, 3, 4.0)}


@dataclass(frozen=True)
class Hypothesis:
    """A set of names that was fitted."""

    names: Names
    weighed: Weighed
    log_prior: float

    @property
    def log_weight(self) -> float:
        """Log evidence and log prior."""
        return self.weighed.log_z + self.log_prior

    @property
    def fit(self) -> Fit:
        """Its fit."""
        return self.weighed.fit

    @property
    def is_believable(self) -> bool:
        """Whether the parameters of its effects are no farther off than their own priors let one expect, where they have one."""
        first = self.fit.problem.first_effect
        known = [(q, one.spread) for q, one in zip(self.fit.q[first:], self.fit.problem.parameters[first:], strict=True)]
        off = np.array([q / spread for q, spread in known if np.isfinite(spread)])
        return not len(off) or float(np.sqrt(np.mean(off**2))) <= FARTHEST_SPREADS


@dataclass(frozen=True)
class Ahead:
    """A set of names that was only weighed: beside which hypothesis, by what promise, and the log weight that it would have.

    promise : None for a force without a name, which is not fitted here.
    """

    names: Names
    beside: Hypothesis
    promise: Promise | None
    log_weight: float


def halves(before: Fit, after: Fit) -> bool:
    """Whether a fit leaves at most half of what another leaves beyond the noise, in squares."""
    return max(after.rms**2 - 1.0, 0.0) <= HALF * max(before.rms**2 - 1.0, 0.0)
