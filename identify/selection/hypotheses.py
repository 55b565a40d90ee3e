"""Hypotheses, fitted or only weighed: how likely each is before anything is measured, how many a search may fit, and what it has of them.

Half is given to nothing being missing, for most comparisons are made with a model that is right; a tenth to a model file that is wrong
by no more than its tolerances. Of the rest a wrong drawing or a wrong balance gets more than its number of candidates would give it, and a
force that no catalogue holds gets little: it can follow anything. A second name has a quarter of the probability of a first one, shared
alike. These are conventions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

import numpy as np

from identify.criteria import ANOTHER, CREDIBLE, EQUAL, FARTHEST_SPREADS, NOTHING, UNNAMED, WITHIN, WRONG_DRAWING
from identify.estimation.problem import Fit
from identify.gap.unnamed import Unnamed
from identify.selection.first_look import Promise
from identify.selection.model_errors import MODEL_ERRORS
from identify.selection.stand import Weighed
from identify.selection.verdict import Names, foremost_of, is_unnamed
from simulate.model.effect import Effect

Prior = Callable[[tuple[str, ...]], float]
Say = Callable[[str], None]
_TABLES = 5  # without a name
_NEARLY_ALL = 0.9
_OF_LACK = 0.1  # log evidence that is worth looking from anew, in parts of what a hypothesis is behind the foremost one
_NO_LARGER = 1.01  # times the gap: fits end within a hundredth


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


@dataclass
class Tried:
    """What a search asks with, and what it has by now.

    prior : log prior of a set of names. fitted : hypotheses that were fitted. ahead : those that were only weighed. promised : what each
    name says beside a hypothesis that was looked from. tables : forces without a name beside it.
    """

    catalogue: Mapping[str, type[Effect]]
    prior: Prior
    budget: Budget
    say: Say
    fitted: dict[Names, Hypothesis] = field(default_factory=dict)
    ahead: dict[Names, Ahead] = field(default_factory=dict)
    tables: dict[Names, list[Unnamed]] = field(default_factory=dict)
    promised: dict[Names, list[Promise]] = field(default_factory=dict)

    @property
    def foremost(self) -> Hypothesis:
        """The fitted hypothesis with the largest weight, of those whose names all make the gap smaller; of equal ones that with fewest."""
        found = [self.fitted[names] for names in self._closing()]
        least = max(one.log_weight for one in found) + np.log(EQUAL)
        return min((one for one in found if one.log_weight >= least), key=lambda one: (len(one.names), -one.log_weight))

    def _closing(self) -> list[Names]:
        """Fitted hypotheses that can be meant: no name makes the gap larger, no error is far beyond any drawing's tolerance.

        Without a name the model file may have been moved far beyond its tolerances to the same gap; then what it leaves as it is counts.
        """
        return [
            names
            for names, one in self.fitted.items()
            if not names or (one.is_believable and all(one.fit.rms <= _NO_LARGER * less.largest_rms for less in self._with_one_less(names)))
        ]

    def _rivals(self) -> list[Names]:
        """Fitted hypotheses that are no likelier than the foremost one, and count beside it though their gap is larger.

        They leave noise and are likelier than with any name less: of noise with a memory the likeliest fit need not leave the smallest gap.
        """
        most = self.foremost.log_weight
        return [
            names
            for names, one in self.fitted.items()
            if names and one.is_believable and one.weighed.leaves_noise and one.log_weight <= most
            if all(one.log_weight > less.log_weight for less in self._with_one_less(names))
        ]

    @property
    def _is_explained(self) -> bool:
        """Whether names, fitted or only weighed, are likelier than nothing and than every force without a name."""
        names = foremost_of(self.weights())
        return bool(names) and not any(map(is_unnamed, names))

    @property
    def _base(self) -> Names:
        """The names beside which all others were weighed: the foremost ones, or the foremost of those that were looked from."""
        seen = [names for names in self.promised if names in self.fitted]
        return max(seen, key=lambda names: (names == self.foremost.names, self.fitted[names].log_weight))

    def _with_one_less(self, names: Names) -> list[Hypothesis]:
        """Fitted hypotheses that have one of these names less; nothing where none was fitted."""
        fewer = [tuple(other for other in names if other != name) for name in names]
        return [self.fitted[less] for less in fewer if less in self.fitted] or [self.fitted[()]]

    def shortest(self, names: Names) -> Hypothesis:
        """Of these names the fewest, of those that were fitted, that close nine tenths of what all of them close."""
        whole = self.fitted[()].fit.rms ** 2 - self.fitted[names].fit.rms ** 2
        found = [one for one in self.fitted.values() if set(one.names) <= set(names)]
        enough = [one for one in found if self.fitted[()].fit.rms ** 2 - one.fit.rms**2 >= _NEARLY_ALL * whole]
        return min(enough, key=lambda one: (len(one.names), -one.log_weight))

    def _sure_of(self, names: Names) -> Names:
        """Of several names those that are sure: while fewer of them leave noise and hold more than 0.05, the others may be nothing."""
        weights = self.weights()
        fewer = [less for less, one in self.fitted.items() if less and set(less) < set(names) and one.weighed.leaves_noise]
        likely = [less for less in fewer if weights.get(less, 0.0) > 1.0 - CREDIBLE]
        return self._sure_of(max(likely, key=lambda less: weights[less])) if likely else names

    def weights(self, more: float = 0.0) -> dict[Names, float]:
        """Probability of each hypothesis that was fitted or weighed, the largest first; they add up to one.

        A force without a name counts beside the hypothesis that is foremost in the end, and beside nothing.

        Parameters
        ----------
        more : log evidence that a fit brings beyond what was promised.
        """
        kept = {(), self.foremost.names, self._base}
        left = {names: one for names, one in self.ahead.items() if names not in self.fitted}
        logs = {names: one.log_weight + more for names, one in left.items() if one.promise is not None}
        logs |= {names: one.log_weight for names, one in left.items() if one.promise is None and one.beside.names in kept}
        logs |= {names: self.fitted[names].log_weight for names in (*self._closing(), *self._rivals())}
        whole = np.logaddexp.reduce(list(logs.values()))
        found = {names: float(np.exp(log - whole)) for names, log in logs.items()}
        return dict(sorted(found.items(), key=lambda row: -row[1]))

    def log_z_of(self, names: Names) -> float:
        """Log evidence of a hypothesis that was fitted or weighed."""
        found = self.fitted.get(names) or self.ahead[names]
        return found.log_weight - self.prior(names)

    def beside_foremost(self) -> list[Promise]:
        """What each effect would say beside the foremost hypothesis, the whole films together."""
        return self.promised[self._base]

    def tables_beside(self, names: Names) -> list[Unnamed]:
        """Forces without a name beside a hypothesis that was looked from, the likeliest first; else those beside the foremost."""
        return self.tables.get(names) or self.tables[self._base]

    def _may_compete(self, log_weight: float) -> bool:
        return log_weight > self.foremost.log_weight - self.budget.least

    def _is_much(self, gain: float, one: Hypothesis, least: float) -> bool:
        """Whether a hypothesis has gained enough to weigh anew what stands beside it; one far behind gains a little wherever it is led."""
        return gain > max(least, _OF_LACK * (self.foremost.log_weight - one.log_weight))
