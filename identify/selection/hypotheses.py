"""Hypotheses, fitted or only weighed: how likely each is before anything is measured, and how many of them a search may fit.

Half is given to nothing being missing, for most comparisons are made with a model that is right; a tenth to a model file that is wrong
by no more than its tolerances. Of the rest a wrong drawing or a wrong balance gets more than its number of candidates would give it, and a
force that no catalogue holds gets little: it can follow anything. A second name has a quarter of the probability of a first one, shared
alike. These are conventions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from identify.criteria import ANOTHER, FARTHEST_SPREADS, NOTHING, UNNAMED, WITHIN, WRONG_DRAWING
from identify.estimation.problem import Fit
from identify.selection.first_look import Promise
from identify.selection.model_errors import MODEL_ERRORS
from identify.selection.stand import Weighed
from identify.selection.verdict import Names, is_unnamed

Prior = Callable[[tuple[str, ...]], float]
Say = Callable[[str], None]
_TABLES = 5  # without a name


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
    def largest_rms(self) -> float:
        """The gap that it leaves, over the noise: with the model file as it is, or off within its tolerances where that leaves more."""
        return max(self.fit.rms, self.weighed.exact.fit.rms)

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


def log_prior(catalogue: Collection[str]) -> Prior:
    """Log prior of a set of names, for a catalogue."""
    effects = max(len([name for name in catalogue if name not in MODEL_ERRORS]), 1)
    rest = 1.0 - NOTHING - WITHIN - WRONG_DRAWING - UNNAMED
    shares = {True: WRONG_DRAWING / len(MODEL_ERRORS), False: rest / effects}

    def of(names: tuple[str, ...]) -> float:
        if not names:
            return float(np.log(NOTHING + WITHIN))
        each = [UNNAMED / _TABLES if is_unnamed(name) else shares[name in MODEL_ERRORS] for name in names]
        return float(np.sum(np.log(each)) + (len(names) - 1) * np.log(ANOTHER / (1.0 - NOTHING - WITHIN)))

    return of
