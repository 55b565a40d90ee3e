"""The search for what is missing: hypotheses weighed along straight lines, the foremost fitted whole, and on from the best.

One object holds what was fitted, what was only weighed (`tried`), and what it cost. A hypothesis is a set of names: effects of the
catalogue, errors of the model file, or a force without a name. The search is best first: everything is weighed beside what was fitted best;
while a hypothesis that was only weighed might hold a share of the probability, it is fitted. Films are weighed up to their first stop as
well, for behind the stops a release has several local minima and straight lines lead nowhere.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from identify.criteria import CLOSE, CREDIBLE, GAP_P, HARDLY, NEAR, ROUGHLY
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import solve, to_the_end
from identify.estimation.multistart import Minima, released_again
from identify.estimation.problem import Fit
from identify.gap.size import halves
from identify.selection.first_look import Promise
from identify.selection.hypotheses import Ahead, Hypothesis, Tried
from identify.selection.model_errors import FORCES
from identify.selection.other_side import on_the_likelier_side
from identify.selection.promises import promises
from identify.selection.stand import Weighed
from identify.selection.unknown_force import unnamed_forces
from identify.selection.verdict import Names, credible_set, foremost_of, is_unnamed, of_the_unnamed
from identify.selection.weighing import errors_without, fitted, led_anew, stands_of, weighed, weighed_within, without

_DEEPER = 10.0  # sum of squares, or log evidence, by which another local minimum is worth looking from anew
_SETTLING, _DEAD_END = 8, 2  # fits of what turns out to hold a share in the end; those that one costs besides which leaves films far off
_UNSETTLED = 1.0  # log evidence that lines promise at the base and the simulation does not keep
_BEYOND = 2.0  # log evidence by which a fit may well exceed its promise: straight lines know no curve


@dataclass
class Search(Tried):
    """A search with what it has tried. seen_from : from where all others were weighed. led : by what promise each was fitted.
    tried_anew : what was led from the model file, too. brought_back : what was looked for in other local minima since it was fitted.
    reached : log weight to which the fit of each led by itself. releases : local minima of each run's release that were found. turned :
    what was looked for on the other side of what no film shows. closely : whether the base is yet to be looked from before the stops."""

    seen_from: set[Names] = field(default_factory=set)
    led: dict[Names, Ahead] = field(default_factory=dict)
    tried_anew: set[Names] = field(default_factory=set)
    brought_back: set[Names] = field(default_factory=set)
    reached: dict[Names, float] = field(default_factory=dict)
    releases: Minima = field(default_factory=dict)
    spent: int = 0
    turned: set[Names] = field(default_factory=set)
    closely: bool = False

    def run(self, base: Fit) -> None:
        """Search on from a fit without any effect, until nothing that was only weighed might hold a share or the budget is spent."""
        self._keep((), weighed(base))
        while True:
            best = max(filter(self._is_worth_a_fit, self.ahead.values()), key=lambda one: one.log_weight, default=None)
            behind = self._left_behind(best.log_weight if best else -np.inf) if self.spent < self.budget.fits else None
            if () not in self.turned and self._doubts_the_base:
                self._turn(())
            elif self.closely and () in self.seen_from and not self._is_explained:
                self._look_closely()
            elif len(self.fitted) > 1 and () not in self.seen_from:  # all was weighed from where the base is no more
                self._look_from(self.fitted[()])
            elif behind is not None:
                self._fit_again(behind)
            elif best is not None and self.spent < self.budget.fits:
                self._fit_or_turn(best)
            elif self.foremost.names not in self.seen_from and self._leads_on(self.foremost):
                self._look_from(self._brought_back(self.foremost))
            elif self._is_on_one_side(self.foremost):
                self._turn(self.foremost.names)
            else:
                return

    @property
    def _doubts_the_base(self) -> bool:
        """Whether the base leaves a gap, or names that were fitted or a force without a name are likelier.

        On the other side of what no film shows none may be needed, and from the wrong side straight lines say little of any.
        """
        unnamed, base = [one.log_weight for one in self.ahead.values() if one.promise is None], self.fitted[()]
        return not base.weighed.leaves_noise or max([self.foremost.log_weight, *unnamed]) > base.log_weight

    def _is_on_one_side(self, one: Hypothesis) -> bool:
        """Whether names that leave noise were not looked for on the other side yet: there they may not be needed."""
        return bool(one.names) and one.names not in self.turned and one.weighed.leaves_noise

    def _fit_or_turn(self, ahead: Ahead) -> None:
        """Fit a hypothesis; before a name is added to the foremost ones, look for these on the other side: there it may not be needed."""
        names = self.foremost.names
        if not names or names in self.turned or not set(names) < set(ahead.names):
            self._fit(ahead)
        else:
            self._turn(names)

    def _turn(self, names: Names) -> None:
        """Look for a hypothesis on the other side of what no film shows, once; from a much likelier place all beside it is weighed anew.

        The search is not thorough where a base is close to the films and leaves a gap, for names may close that; nor for names, which were
        fitted from a base that has been turned already.
        """
        before = self.fitted[names].weighed
        after = on_the_likelier_side(before, thoroughly=not names and (before.leaves_noise or before.stand.misses))
        self._keep(names, after)
        self.turned.add(names)
        self._take_the_base_along(self.fitted[names], after.log_z - before.log_z)
        if after.log_z <= before.log_z + _DEEPER:
            return
        for weighed_there in (self.ahead, self.tables, self.promised):
            for other in [other for other in weighed_there if set(names) <= set(other)]:
                del weighed_there[other]

    def _take_the_base_along(self, one: Hypothesis, gain: float) -> None:
        """Look for the base where names were found to be likelier by some log evidence: there it may be, too, and compete."""
        if one.names and gain > HARDLY and (gain > _DEEPER or self._may_compete(self.fitted[()].log_weight + gain)):
            self._base_again(one.weighed, is_elsewhere=True)

    def _leads_on(self, one: Hypothesis) -> bool:
        """Whether a further name may be looked for: of several names each must have halved the gap that those before it left.

        Beside names none is where nothing may be missing, or where the budget is spent and the films are still far off.
        """
        base = self.fitted[()]
        may_be_nothing = base.weighed.leaves_noise and self._may_compete(base.log_weight)
        if one.names and (may_be_nothing or (self.spent >= self.budget.fits and one.weighed.stand.misses)):
            return False
        return len(one.names) < 2 or halves(min((less.fit for less in self._with_one_less(one.names)), key=lambda fit: fit.rms), one.fit)

    def settled(self) -> Hypothesis:
        """The hypothesis with the largest probability; of one with a force without a name the rest.

        What may stand in its place is fitted, if it was only weighed: a class rests on fits, too, and so does a name alone.
        """
        for _ in range(_SETTLING):
            self._weigh_tables_beside_foremost()
            promised = [self.ahead[names] for names in credible_set(self.weights(_BEYOND)) if names not in self.fitted]
            worth = [one for one in promised if one.promise is not None and not self._adds_to_enough(one)]
            if not worth:
                break
            self._fit(worth[0])
        self._weigh_tables_beside_foremost()
        weights = self.weights()
        names = tuple(name for name in foremost_of(weights) if not is_unnamed(name))
        found = self.fitted.get(self._sure_of(names), self.foremost)
        return found if of_the_unnamed(weights) > CREDIBLE else self._brought_back(found)

    def _weigh_tables_beside_foremost(self) -> None:
        if self._base not in self.tables:
            one = self.fitted[self._base]
            self._weigh_tables(one, one.weighed, self.promised[self._base])

    def _brought_back(self, one: Hypothesis) -> Hypothesis:
        """The same looked for again where films are missed: a fit may end in a wrong local minimum of a release, or of a bent base."""
        if one.names in self.brought_back:
            return self.fitted[one.names]
        before = one.log_weight
        if one.names and one.names not in self.tried_anew:
            self.tried_anew.add(one.names)
            led = led_anew(one.weighed)
            if led is not None:
                self._keep(one.names, led)
                one = self.fitted[one.names]
        again = released_again(one.fit, known=self.releases)
        if again.cost < one.fit.cost - _DEEPER:
            self._keep(one.names, weighed_within(one.weighed.exact.given, again.q, errors_without(one.weighed, ())))
        self.brought_back.add(one.names)
        one = self.fitted[one.names]
        self._take_the_base_along(one, one.log_weight - before)
        return one

    def _is_worth_a_fit(self, one: Ahead) -> bool:
        if one.promise is None or self._has_led(one):
            return False
        if self._adds_to_enough(one):
            return one.log_weight > self.foremost.log_weight - (0.0 if self.foremost.names else _BEYOND)
        return self._may_reach_the_unnamed(one) and self._may_compete(one.log_weight)

    def _has_led(self, one: Ahead) -> bool:
        """Whether its names were fitted, from here or with nearly as much as is promised from here."""
        known = self.fitted.get(one.names)
        return known is not None and (self.led.get(one.names) is one or one.log_weight < known.log_weight + _DEEPER)

    def _left_behind(self, least: float) -> Ahead | None:
        """What was fitted from beside a hypothesis that was found likelier elsewhere since: from there it may be, too, and compete.

        least : log weight that it has to reach there, for what else is to be fitted comes first.
        """
        for names, led in self.led.items():
            one = self.fitted[led.beside.names]
            gain = one.log_weight - led.beside.log_weight
            reached = self.fitted[names].log_weight + gain
            if reached >= least and self._is_much(gain, one, HARDLY) and self._may_compete(reached):
                return led
        return None

    def _fit_again(self, led: Ahead) -> None:
        """Fit a hypothesis from where the one beside which it was promised is now."""
        one, of = self.fitted[led.beside.names], led.promise
        assert of is not None
        self.led[led.names] = replace(led, beside=one)
        alone = {name: kind for name, kind in self.catalogue.items() if name == of.name}
        stands = [(one.weighed, one.weighed.along_lines)] if of.instead else stands_of(one.weighed)
        found = [self._promised(one, new, reached) for at, reached in stands for new in promises(at, alone, of.instead)]
        for ahead in sorted((new for new in found if new.names == led.names), key=lambda new: -new.log_weight)[:1]:
            self.ahead[ahead.names] = ahead  # in place of what was promised from where the base was before
            self._fit(ahead)

    def _may_reach_the_unnamed(self, one: Ahead) -> bool:
        """Whether it comes near the likeliest force without a name, were its fit to bring as much more than promised as one before did.

        What stays behind that changes no verdict. Of the first fit nothing is known yet.
        """
        unnamed = max((other.log_weight for other in self.ahead.values() if other.promise is None), default=-np.inf)
        more = max((self.fitted[names].log_weight - led.log_weight for names, led in self.led.items()), default=np.inf)
        return one.log_weight + max(more, 0.0) > unnamed - self.budget.least

    def _adds_to_enough(self, one: Ahead) -> bool:
        """Whether it adds a name to the foremost ones, which leave noise: promised less, it changes no verdict.

        Beside nothing it may: a law that has bent hides what is missing from straight lines.
        """
        best = self.foremost
        return set(best.names) <= set(one.names) and best.weighed.leaves_noise

    def _keep(self, names: Names, found: Weighed) -> None:
        """Keep a fit, or the better one of two of the same names; only from a much likelier place all else is weighed anew."""
        known = self.fitted.get(names)
        one = Hypothesis(names, found if known is None else known.weighed.better_of(found), self.prior(names))
        if known is None or one.log_weight > known.log_weight:
            self.fitted[names] = one
        if known is None or self._is_much(one.log_weight - known.log_weight, one, _DEEPER):
            self.seen_from.discard(names)
            self.brought_back.discard(names)
            if names:  # of nothing the other side is searched thoroughly, which takes long
                self.turned.discard(names)

    def _look_from(self, one: Hypothesis) -> None:
        """Weigh every hypothesis with one name more, or another name in the place of one."""
        further = len(one.names) < self.budget.deepest
        self.say("weighing " + (f"what else stands beside {', '.join(one.names)}" if one.names else "every effect"))
        self.seen_from.add(one.names)
        improbable = one.weighed.evidence.prior_p < GAP_P
        closely = improbable and bool(one.names)  # from a base only where no name explains it, see `run`
        stands = stands_of(one.weighed, closely=closely) if further else [(one.weighed, one.weighed.along_lines)]
        self._look(one, stands, further)
        if not one.names:
            self.closely = len(stands) == 1 and (improbable or self._doubts_the_base)
        for effect in one.fit.problem.effects:
            if effect.is_linear():  # another one cannot be taken out along straight lines
                self._weigh(one, promises(one.weighed, self.catalogue, effect.name), one.weighed.along_lines)

    def _look_closely(self) -> None:
        """Weigh every hypothesis beside the base before the stops as well: releases may have bent to what shows there."""
        self.closely, base = False, self.fitted[()]
        self._look(base, stands_of(base.weighed, closely=True)[1:], further=True)

    def _look(self, one: Hypothesis, stands: Iterable[tuple[Weighed, float]], further: bool) -> None:
        for at, reached in stands:
            found = list(promises(at, self.catalogue))
            self._weigh(one, found if further else (), reached)
            if at is one.weighed:
                self.promised[one.names] = found
            if at.along_lines == reached and not one.names:
                self._weigh_tables(one, at, found)

    def _weigh(self, one: Hypothesis, found: Iterable[Promise], reached: float) -> None:
        for promise in found:
            self._ahead(self._promised(one, promise, reached))

    def _promised(self, one: Hypothesis, promise: Promise, reached: float) -> Ahead:
        names = tuple(sorted({*one.names, promise.name} - {promise.instead}))
        return Ahead(names, one, promise, one.weighed.log_z + promise.log_z - reached + self.prior(names))

    def _weigh_tables(self, one: Hypothesis, at: Weighed, beside: Iterable[Promise]) -> None:
        """Weigh forces without a name from where names promised something."""
        found = unnamed_forces(at, max([0.0, *(promise.first for promise in beside)]))
        self.tables.setdefault(one.names, found)
        for table in found:
            names = tuple(sorted((*one.names, table.name)))
            self._ahead(Ahead(names, one, None, one.weighed.log_z + table.log_z - at.along_lines + self.prior(names)))

    def _ahead(self, one: Ahead) -> None:
        known = self.ahead.get(one.names)
        if known is None or one.log_weight > known.log_weight:
            self.ahead[one.names] = one

    def _fit(self, ahead: Ahead) -> None:
        """Fit a hypothesis that was only weighed, whole."""
        self.spent += 1
        self.say("fitting " + ", ".join(ahead.names))
        promise = ahead.promise
        assert promise is not None
        self.led[ahead.names] = ahead
        for each in (promise, *promise.others):
            if each is promise or ahead.log_weight + each.log_z - promise.log_z > self.fitted[ahead.names].log_weight:
                self._keep(ahead.names, fitted(ahead.beside.weighed, each))
        found = self.fitted[ahead.names]
        if found.log_weight < ahead.log_weight - _DEEPER and not ahead.beside.weighed.leaves_noise:  # bent too far
            self._keep(ahead.names, weighed(solve_from_afar(found.weighed.exact.given, found.weighed.exact.origin)))
            found = self.fitted[ahead.names]
        self.spent += _DEAD_END if found.weighed.stand.misses else 0
        is_elsewhere = found.log_weight > ahead.log_weight + _DEEPER
        if is_elsewhere or len(ahead.names) == 1:  # several stand beside one that has led the base already
            self._base_again(found.weighed, is_elsewhere)
        self.reached[ahead.names] = found.log_weight
        if found.log_weight == max(self.reached.values()):  # compared as fitted: a rival may have been led on already
            self._brought_back(found)
        likeliest = max(self.fitted.values(), key=lambda one: one.log_weight)
        if ahead.names == likeliest.names:
            self._with_less(likeliest)

    def _with_less(self, one: Hypothesis) -> None:
        """Fit what is left of several names without each of them: the first one may have stood for the second.

        While a gap is left, one that even straight lines from there can hardly do without is needed. Where several names brought far more
        than straight lines predicted, they have led to another local minimum: then what was fitted before is brought there as well.
        """
        led, least = self.led.get(one.names), -np.inf if one.weighed.leaves_noise else one.weighed.along_lines - NEAR
        is_elsewhere = led is not None and one.log_weight > led.log_weight + _DEEPER
        for name in one.names if len(one.names) > 1 else ():
            names = tuple(other for other in one.names if other != name)
            before = self.fitted.get(names)
            if name == FORCES or (before is not None and not is_elsewhere) or one.weighed.doing_without(name).along_lines < least:
                continue
            self.say("fitting " + ", ".join(names))
            self._keep(names, without(one.weighed, name))
            if before is not None and self.fitted[names] is not before:
                self._brought_back(self.fitted[names])

    def _base_again(self, led: Weighed, is_elsewhere: bool = False) -> None:
        """The base from where an effect has led: it may lie in a wrong local minimum of the releases, or have stopped too early.

        is_elsewhere : whether the effect brought far more than straight lines predicted from the base, so that another minimum may have.
        """
        nothing = self.fitted[()]
        of, q = nothing.weighed.exact.given, led.fit.q[: led.fit.problem.first_effect]
        if led.both.is_exact:
            again, before = to_the_end(solve(of, q, enough=ROUGHLY)), nothing.weighed.exact.fit
            if again.cost < before.cost - _DEEPER and (again.rms < CLOSE or halves(before, again)):
                self._keep((), weighed_within(of, again.q, {}))
        elif nothing.weighed.both.within is not None:
            is_settled = nothing.weighed.leaves_noise and nothing.weighed.evidence.unkept < _UNSETTLED
            is_foremost = led.names == set(self.foremost.names)  # before it is said it is compared with nothing from the same place
            if is_elsewhere or is_foremost or not is_settled or halves(nothing.fit, led.fit):
                self._keep((), weighed_within(of, q, errors_without(led, led.names)))
