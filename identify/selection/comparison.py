"""One effect more: which of a catalogue closes most of what is left, and which others might as well.

Effects are screened by their signatures, the foremost fitted together with base and releases: up to the stops first, where
the motion is steady, then whole. What chance alone would do decides who is named and who cannot be told from whom.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from identify.estimation.fit import Fit
from identify.estimation.least_squares import ROUGHLY, before_the_stops, solve, to_the_end
from identify.estimation.multistart import searched_everywhere
from identify.selection.candidate_fits import Candidate, carried_on, carried_to_the_end, fit_screened, held_out_rms
from identify.selection.gap_test import EFFECT_P, GAP_P, Gain, gap_test, similarity
from identify.selection.null_hypothesis import (
    Family,
    chance_of_lead,
    chance_of_likeness,
    family,
    inflation,
    noise_like,
)
from identify.selection.screening import Screened, kinds_to_try, screen
from measure.common.arrays import Array
from simulate.model.effect import Effect

RIVAL_P = 0.01  # a rival that would be led so far less often than this is excluded
LIKENESS_P = 1e-3  # one that would look so much like the best; rarer, for it rests on where its parameters could have pointed
STRONG_BIC, _ROUGH_LEAD = 10.0, 25.0
_HOPELESS, _CLOSED_BY_FAR = 0.5, 1000.0
_FAR_ABOVE = 2.0  # times the sum of squares: a release may lie in a wrong local minimum
_LAST_SHARE = 0.25  # of the excess over noise; a signature is a straight line's guess

Say = Callable[[str], None]


@dataclass(frozen=True)
class Budget:
    """How much is tried, in fits and not in seconds, so that every machine comes to the same answer.

    fitted : effects fitted in a hurry, after screening. whole : of these, how many are fitted whole where none has closed the
    gap; rivals : how many where one has and the others are not excluded. effects : most that are added.
    """

    fitted: int
    whole: int
    rivals: int
    effects: int


BUDGETS = {"quick": Budget(5, 1, 4, 1), "normal": Budget(12, 2, 10, 2), "thorough": Budget(28, 6, 28, 3)}


@dataclass(frozen=True)
class Rival:
    """A row of the ranking. fitted : whether it was fitted jointly, or only screened by its signature.

    chance : how often the foremost would lead it so far if it were the truth; NaN where only signatures were compared.
    """

    name: str
    delta_bic: float
    held_out_rms: float
    fitted: bool
    chance: float = float("nan")


@dataclass(frozen=True)
class Step:
    """One effect added: the fit before, the best candidate, those it cannot be told from, and all rows of the ranking."""

    before: Fit
    best: Candidate
    equivalents: tuple[Candidate, ...]
    ranking: tuple[Rival, ...]

    def rivals_of(self, fit: Fit) -> list[Fit]:
        """A fit with the best effect, and those of the effects that it cannot be told from."""
        return [fit, *(candidate.fit for candidate in self.equivalents)]


@dataclass(frozen=True)
class Look:
    """A fit looked at: the fit, the part of it where, by which signatures, and how many independent tests that was."""

    current: Fit
    hint: Fit
    screened: tuple[Screened, ...]
    tests: Family


def next_effect(
    current: Fit, catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say, *, last: bool = False
) -> tuple[Look, Step | None]:
    """The effect that closes most of what is left, or None where only noise is left or nothing helps; and where it was looked for.

    An effect can show that the fit lay in a wrong local minimum, from where every signature is wrong; then it is looked at again from the
    right one. last : no other may follow, so the effect has to close all that is left, and those whose signature is far from
    that are not tried.
    """
    look = _look(current, catalogue)
    if gap_test(current).p_value > GAP_P and not _promising(look):
        return look, None
    tried = _tried(look, _LAST_SHARE * gap_test(look.hint).excess if last else 0.0, budget, say)
    if not tried.whole:
        return look, None
    moved = _without(current, tried.whole[0].fit)
    if moved is not current:
        say("looking again from another local minimum of the releases")
        return next_effect(moved, catalogue, budget, say, last=last)
    return look, _step(look, tried)


@dataclass(frozen=True)
class Tried:
    """Candidates fitted in a hurry, and the foremost of these fitted whole, best first."""

    quick: Sequence[Candidate]
    whole: Sequence[Candidate]


def _tried(look: Look, least: float, budget: Budget, say: Say) -> Tried:
    """The effects whose signature promises to close `least` of the sum of squares, fitted."""
    quick: list[Candidate] = []
    for one in [s for s in look.screened if s.worth_fitting and s.promise * look.hint.variance_inflation >= least][: budget.fitted]:
        if not _hopeless(one, quick):
            say(f"trying {one.effect.name}")
            quick.append(fit_screened(look.hint, one))
    if not quick:
        return Tried((), ())
    quick = carried_on(look.hint, quick)
    foremost = _foremost(look.hint, quick, budget)
    say("fitting the foremost to the end: " + ", ".join(c.name for c in foremost))
    return Tried(quick, best_first(look.current, carried_to_the_end(look.current, foremost)))


def _look(current: Fit, catalogue: Mapping[str, type[Effect]]) -> Look:
    hint = _hint(current)
    screened = tuple(screen(hint, kinds_to_try(catalogue, current)))
    return Look(current, hint, screened, family([s for one in screened for s in one.looked_at], noise_like(hint)))


def _hint(current: Fit) -> Fit:
    """The part of a fit in which a gap can be looked at best: up to the stops, if it shows there."""
    early = before_the_stops(current.problem)
    if early is current.problem:
        return current
    fitted = solve(early, current.q)
    return fitted if gap_test(fitted).p_value < GAP_P else current


def _promising(look: Look) -> bool:
    """Whether a single signature is too strong for chance, all that were looked at counted; it is keener than the gap's own test."""
    single = min((float(stats.chi2.sf(s.promise, max(s.signature.parameters, 1))) for s in look.screened), default=1.0)
    return look.tests.p_value(single) < GAP_P


def _hopeless(one: Screened, tried: Sequence[Candidate]) -> bool:
    """Whether an effect cannot rival one that has already closed the gap: its signature points elsewhere."""
    closed = [c for c in tried if gap_test(c.fit).p_value > GAP_P and c.gain.chi2 > _CLOSED_BY_FAR]
    return any(similarity(one.signature, c.signature) ** 2 < _HOPELESS for c in closed)


def _foremost(before: Fit, quick: Sequence[Candidate], budget: Budget) -> list[Candidate]:
    """The candidates worth fitting whole: the best ones; where the best closed what was looked at, only those not excluded by it."""
    ranked = best_first(before, quick)
    best = ranked[0]
    if gap_test(best.fit).p_value < GAP_P:
        return ranked[: budget.whole]
    noise = noise_like(best.fit)
    return [best, *(c for c in ranked[1:] if not _excluded(before, c, best, noise, hurried=True))][: budget.rivals]


def _step(look: Look, tried: Tried) -> Step | None:
    current, foremost = look.current, tried.whole[0]
    noise = noise_like(foremost.fit)
    best = replace(foremost, gain=_gain(current, foremost.fit, noise, look.tests))
    if best.gain.p_value > EFFECT_P or best.gain.delta_bic < 0.0:
        return None
    chances = {c.name: chance_of_lead(best.fit, c.fit, noise) for c in tried.whole[1:]}
    equivalents = tuple(c for c in tried.whole[1:] if not _excluded(current, c, best, noise))
    rows = [Rival(c.name, _delta_bic(c, current, best.fit), held_out_rms(c.fit), True, chances.get(c.name, 1.0)) for c in tried.whole]
    return Step(current, best, equivalents, (*rows, *_not_fitted_whole(look, tried)))


def _without(current: Fit, best: Fit) -> Fit:
    """The fit before, or a better one without the effect: then it lay in a wrong local minimum of the releases.

    One far above the best is fitted again from where the effect has led. Where only the effect shows that something is missing, every
    release is looked for anew, for what lies in a shallow wrong local minimum looks like noise and an effect can mend it.
    """
    if current.cost >= _FAR_ABOVE * best.cost:
        found = to_the_end(solve(current.problem, best.q[: len(current.q)]))
        return found if current.cost > _FAR_ABOVE * found.cost else current
    if gap_test(current).p_value < GAP_P:
        return current
    found = searched_everywhere(current)
    return found if found.cost < current.cost - STRONG_BIC else current


def _not_fitted_whole(look: Look, tried: Tried) -> list[Rival]:
    """Rows of the ranking for effects that were not fitted whole: what they gained where they were looked at."""
    whole, hurried = {c.name for c in tried.whole}, {c.name: c for c in tried.quick}
    foremost = hurried[tried.whole[0].name].fit
    rows = []
    for one in look.screened:
        name = one.effect.name
        if name in whole:
            continue
        gained = _delta_bic(hurried[name], look.hint, foremost) if name in hurried else one.promise
        rows.append(Rival(name, gained, float("nan"), name in hurried))
    return sorted(rows, key=lambda row: -row.delta_bic)


def _gain(before: Fit, after: Fit, noise: Array, tests: Family) -> Gain:
    """What an effect gains, in units of what chance gains in the noise that is left, all effects that were looked at counted."""
    parameters = len(after.q) - len(before.q)
    chi2 = max(0.0, before.cost - after.cost) / inflation(after, parameters, noise)
    bic = chi2 - parameters * float(np.log(max(after.effective_samples, 2.0)))
    return Gain(chi2, parameters, tests.p_value(float(stats.chi2.sf(chi2, parameters))), bic)


def _excluded(before: Fit, rival: Candidate, best: Candidate, noise: Array, *, hurried: bool = False) -> bool:
    """Whether a rival is led by more than chance explains, were it the truth; or would hardly ever look so much like the best one.

    A lead of a few units excludes nobody: behind the stops the sum of squares has local minima, and fits end up that far apart; farther
    still where they were hurried. An effect that can bend itself into many others is no rival of the one that it imitates.
    """
    least, slack = (_ROUGH_LEAD, STRONG_BIC) if hurried else (STRONG_BIC, ROUGHLY)
    if len(rival.fit.q) > len(best.fit.q) and chance_of_likeness(before, best.fit, rival.fit, slack) < LIKENESS_P:
        return True
    lead = (rival.fit.cost - best.fit.cost) / max(1.0, best.fit.rms**2)
    return lead > least and chance_of_lead(best.fit, rival.fit, noise) < RIVAL_P


def best_first(before: Fit, tried: Sequence[Candidate]) -> list[Candidate]:
    """By the sum of squares left, with its price for parameters, all in the noise that the best one leaves."""
    best = min(tried, key=lambda c: c.fit.cost).fit
    return sorted(tried, key=lambda c: -_delta_bic(c, before, best))


def _delta_bic(candidate: Candidate, before: Fit, best: Fit) -> float:
    """Against the fit before, in the noise that the best one leaves, so that rows can be compared."""
    return (before.cost - candidate.fit.cost) / best.unit - price_of_words(before, candidate.fit, best)


def price_of_words(before: Fit, fit: Fit, best: Fit) -> float:
    """What the numbers of an effect are charged for: ln n each, or less where that would be a prior much wider than what was found.

    1 + ln(gain per word) is the price under a prior as wide as what was found (Hansen and Yu 2001). Else a faint effect with many
    numbers came behind each plainer one that imitates it.
    """
    gained, words = (before.cost - fit.cost) / best.unit, fit.effective_parameters - before.effective_parameters
    found = 1.0 + float(np.log(max(gained / words, 1.0))) if words > 0.0 else 0.0
    return words * min(float(np.log(max(best.effective_samples, 2.0))), found)
