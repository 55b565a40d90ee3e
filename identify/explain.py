"""Which physical effect is missing between a model and its measurements: the decision.

    is there a gap?  ->  which effects could close it?  ->  can they be told apart?  ->  is anything left?

A gap is tested first, so that nothing is named where there is only noise. Effects join one by one, each fitted together
with base and releases; an effect that others make superfluous leaves again. What the data cannot separate is a class, and
a gap that nothing closes is unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from simulate.effect import Effect
from simulate.effects import CATALOGUE
from simulate.model import Model
from simulate.model_file import add_effects

from .campaign import Run
from .candidates import Candidate, Screened, carried_over, carried_to_the_end, fit_screened, held_out_rms, kinds_to_try, screen
from .evidence import GAP_P, Gain, GapTest, gain, gap_test, likeness
from .fit import Fit, before_the_stops, solve, solve_from_afar
from .missing_force import MissingForce, estimate
from .problem import problem_of

EFFECT_P = 1e-4
STRONG_BIC = 10.0
CLOSED_SHARE, FAIR_SHARE = 2 / 3, 0.05
_MOST_EFFECTS = 3
_MOST_RIVALS = 3
_MOST_LATER = 5
_HOPELESS_RIVAL = 0.5
_NEAR_BIC = 50.0
_WORTH_A_PARAMETER = 4.0

Say = Callable[[str], None]


@dataclass(frozen=True)
class Rival:
    """A row of the ranking. fitted : whether it was fitted jointly, or only screened by its signature."""

    name: str
    delta_bic: float
    held_out_rms: float
    fitted: bool


@dataclass(frozen=True)
class Finding:
    """An effect named, with its evidence. equivalents : effects that these data cannot tell from it."""

    effect: Effect
    stderr: np.ndarray
    equivalents: tuple[str, ...]
    gain: Gain
    share: float

    @property
    def name(self) -> str:
        """The effect's name in the catalogue."""
        return self.effect.name


@dataclass(frozen=True)
class Held:
    """A run that took no part: its gap before and after, only its own release fitted."""

    before: Fit
    after: Fit


@dataclass(frozen=True)
class Explanation:
    """What came out. as_given : the model file itself; before : base refitted; after : with the findings."""

    verdict: str
    findings: tuple[Finding, ...]
    as_given: Fit
    before: Fit
    after: Fit
    gap_before: GapTest
    gap_after: GapTest
    ranking: tuple[Rival, ...]
    rivals: tuple[Candidate, ...]
    held: tuple[Held, ...]
    missing: MissingForce | None

    @property
    def model(self) -> Model:
        """The extended model: base as refitted, the effects found added."""
        return self.after.problem.model_at(self.after.q)

    @property
    def share_closed(self) -> float:
        """Part of the gap's excess over noise that the findings close, 0 to 1."""
        return share_closed(self.before, self.after)


def explain(
    model: Model, runs: Sequence[Run], catalogue: Mapping[str, type[Effect]] = CATALOGUE, say: Say = lambda text: None
) -> Explanation:
    """Find what is missing in `model` to say what was measured.

    Parameters
    ----------
    runs : loops and deployments; those held out take no part in fitting or naming.
    catalogue : effects to try, by name.
    say : told what is being done, for people who wait.

    Raises
    ------
    InputError
        A run cannot be used with this model.
    """
    say("fitting base and releases")
    problem = problem_of(model, [run for run in runs if not run.hold_out])
    as_given = solve(problem, free=range(problem.first_nuisance, problem.first_effect))
    before = solve_from_afar(problem)
    current, steps = before, []
    while len(steps) < _MOST_EFFECTS:
        found = _next_effect(current, catalogue, say, first=not steps)
        if found is None or (steps and not _matters(before, current, found.best.fit)):
            break
        steps.append(found)
        current = found.best.fit
    current, steps = _without_superfluous(current, steps, say)
    missing = None
    if gap_test(current).p_value < GAP_P and problem.films:
        say("estimating the missing force")
        missing = estimate(before)
    verdict = _verdict(before, current, steps, missing)
    after = current if verdict in ("named", "class", "several") else before
    say("looking at the runs held out")
    held = tuple(_held(model, run, before, after) for run in runs if run.hold_out)
    findings = tuple(_finding(after, before, step) for step in steps) if after is current else ()
    rivals = tuple(c for step in steps for c in step.equivalents)
    tests = gap_test(before), gap_test(after)
    missing = missing if verdict == "unknown" else None
    return Explanation(verdict, findings, as_given, before, after, *tests, _ranking(steps), rivals, held, missing)


def _matters(before: Fit, current: Fit, found: Fit) -> bool:
    """Whether a further effect is worth a name: it leaves only noise, or it closes a fair part of the gap that was there at first.

    Measurements of a real machine never quite agree with a model; many small effects could each mend a little of that.
    """
    return gap_test(found).p_value > GAP_P or share_closed(before, found) - share_closed(before, current) > FAIR_SHARE


@dataclass(frozen=True)
class Step:
    """One effect added: the best candidate, those it cannot be told from, those fitted whole, and the other rows of the ranking."""

    before: Fit
    best: Candidate
    equivalents: tuple[Candidate, ...]
    tried: tuple[Candidate, ...]
    others: tuple[Rival, ...]


def _next_effect(current: Fit, catalogue: Mapping[str, type[Effect]], say: Say, *, first: bool) -> Step | None:
    """The effect that closes most of what is left, or None where only noise is left or nothing helps.

    Where the gap shows before the stops already, effects are tried there first: that part is short and steady. The
    foremost are then fitted whole.
    """
    hint = _hint(current)
    screened = screen(hint, kinds_to_try(catalogue, current))[: None if first else _MOST_LATER]
    if gap_test(current).p_value > GAP_P and not (first and _promising(screened)):
        return None
    quick: list[Candidate] = []
    for one in screened:
        if not _hopeless(one, quick):
            say(f"trying {one.effect.name}")
            quick.append(fit_screened(hint, one))
    if not quick:
        return None
    foremost = _foremost(quick)
    say("fitting the foremost to the end: " + ", ".join(c.name for c in foremost))
    tried = _best_first([carried_to_the_end(current, c) for c in foremost])
    best = tried[0]
    if best.gain.p_value > EFFECT_P or best.gain.delta_bic < STRONG_BIC:
        return None
    equivalents = tuple(c for c in tried[1:] if _cannot_be_told(c, best))
    return Step(current, best, equivalents, tuple(tried), _others(hint, quick, foremost, screened))


def _foremost(quick: Sequence[Candidate]) -> list[Candidate]:
    """The candidates worth fitting whole: a few, or, where the best closed what was looked at, those that come near it."""
    ranked = _best_first(quick)[:_MOST_RIVALS]
    best = ranked[0].fit
    if gap_test(best).p_value < GAP_P:
        return ranked
    return [c for c in ranked if _score(c, best) - _score(ranked[0], best) < _NEAR_BIC]


def _hint(current: Fit) -> Fit:
    """The part of a fit in which a gap can be looked at best: up to the stops, if it shows there."""
    early = before_the_stops(current.problem)
    if early is current.problem:
        return current
    fitted = solve(early, current.q)
    return fitted if gap_test(fitted).p_value < GAP_P else current


def _others(hint: Fit, quick: Sequence[Candidate], foremost: Sequence[Candidate], screened: Sequence[Screened]) -> tuple[Rival, ...]:
    """Rows of the ranking for effects that were not fitted whole: what they gained where they were looked at."""
    done = {c.name for c in foremost}
    hurried = {c.name: c for c in quick if c.name not in done}
    best = foremost[0].fit
    rows = []
    for one in screened:
        if one.effect.name in hurried:
            rows.append(Rival(one.effect.name, _delta_bic(hurried[one.effect.name], hint, best), float("nan"), True))
        elif one.effect.name not in done:
            rows.append(Rival(one.effect.name, one.promise, float("nan"), False))
    return tuple(rows)


def _best_first(tried: Sequence[Candidate]) -> list[Candidate]:
    """By the sum of squares left, with its price for parameters, all in the noise that the best one leaves."""
    best = min(tried, key=lambda c: c.fit.cost).fit
    return sorted(tried, key=lambda c: _score(c, best))


def _score(candidate: Candidate, best: Fit) -> float:
    unit = best.dilution * max(1.0, best.rms**2)
    return candidate.fit.cost / unit + len(candidate.fit.q) * float(np.log(max(best.effective_samples, 2.0)))


def _cannot_be_told(rival: Candidate, best: Candidate) -> bool:
    """Whether a rival's score is within chance of the best one's.

    One with more parameters has to close more of the gap for them: said with more, the same is no rival but a detour
    (a power law of exponent one is viscous friction).
    """
    if _score(rival, best.fit) - _score(best, best.fit) >= STRONG_BIC:
        return False
    extra = len(rival.fit.q) - len(best.fit.q)
    unit = best.fit.dilution * max(1.0, best.fit.rms**2)
    return extra <= 0 or (best.fit.cost - rival.fit.cost) / unit > _WORTH_A_PARAMETER * extra


def _promising(screened: Sequence[Screened]) -> bool:
    """Whether a single signature is too strong for chance, all that were looked at counted; it is keener than the gap's own test."""
    if not screened:
        return False
    best = min(stats.chi2.sf(s.promise, max(s.signature.knobs, 1)) for s in screened)
    return bool(best * max(len(screened), 10) < GAP_P)


def _hopeless(one: Screened, tried: Sequence[Candidate]) -> bool:
    """Whether an effect cannot rival one that has already closed the gap: its signature points elsewhere."""
    closed = [c for c in tried if gap_test(c.fit).p_value > GAP_P and c.gain.chi2 > 100 * STRONG_BIC]
    return any(likeness(one.signature, c.signature) ** 2 < _HOPELESS_RIVAL for c in closed)


def _without_superfluous(current: Fit, steps: list[Step], say: Say) -> tuple[Fit, list[Step]]:
    """Take out each effect in turn and see whether the others do without it."""
    if len(steps) < 2:
        return current, steps
    for step in list(steps):
        others = tuple(e for e in current.problem.effects if e.name != step.best.name)
        say(f"doing without {step.best.name}")
        less = _refitted(current, others)
        if gain(less, current).delta_bic < STRONG_BIC:
            return _without_superfluous(less, [s for s in steps if s is not step], say)
    return current, steps


def _refitted(current: Fit, effects: tuple[Effect, ...]) -> Fit:
    problem = current.problem.with_effects(effects)
    kept = {knob.name: value for knob, value in zip(current.problem.knobs, current.q, strict=True)}
    return solve(problem, np.array([kept[knob.name] for knob in problem.knobs]))


def share_closed(before: Fit, after: Fit) -> float:
    """Part of the excess over noise that goes: (S_before - S_after) / (S_before - number of samples)."""
    excess = before.cost - before.problem.measured * min(1.0, after.rms**2)
    return float(np.clip((before.cost - after.cost) / excess, 0.0, 1.0)) if excess > 0 else 0.0


def _held(model: Model, run: Run, before: Fit, after: Fit) -> Held:
    problem = problem_of(model, [run])
    return Held(carried_over(before, problem), carried_over(after, problem.with_effects(after.problem.effects)))


def _verdict(before: Fit, after: Fit, steps: Sequence[Step], missing: MissingForce | None) -> str:
    """What may be said. Effects that leave a gap must close most of it, and better than a force without any physics does."""
    left = gap_test(after).p_value < GAP_P
    if not steps:
        return "unknown" if left else "no-gap"
    if left and (share_closed(before, after) < CLOSED_SHARE or (missing is not None and _bic(missing.fit) < _bic(after))):
        return "unknown"
    if len(steps) > 1:
        return "several"
    return "class" if steps[0].equivalents else "named"


def _bic(fit: Fit) -> float:
    """Sum of squares and the price of the knobs, samples taken as independent: for fits that leave little but noise."""
    return fit.cost + len(fit.q) * float(np.log(fit.problem.measured))


def _finding(after: Fit, before: Fit, step: Step) -> Finding:
    effects = after.problem.effects_at(after.q)
    place = after.problem.first_effect
    for effect in effects:
        size = len(effect.flat())
        if effect.name == step.best.name:
            rows = np.arange(place, place + size)
            stderr = np.sqrt(np.maximum(np.diag(after.covariance)[rows], 0.0)) * after.problem.scales[rows]
            names = tuple(c.name for c in step.equivalents)
            excess = before.cost - after.cost
            share = (step.before.cost - step.best.fit.cost) / excess if excess > 0 else 0.0
            return Finding(effect, stderr, names, step.best.gain, float(np.clip(share, 0.0, 1.0)) * share_closed(before, after))
        place += size
    raise KeyError(step.best.name)


def _ranking(steps: Sequence[Step]) -> tuple[Rival, ...]:
    """All effects of the first step, best first; the foremost also by runs left out of the fit."""
    if not steps:
        return ()
    first = steps[0]
    whole = [Rival(c.name, _delta_bic(c, first.before, first.best.fit), held_out_rms(c.fit), True) for c in first.tried]
    return (*whole, *sorted(first.others, key=lambda rival: -rival.delta_bic))


def _delta_bic(candidate: Candidate, before: Fit, best: Fit) -> float:
    """Against no effect at all, in the noise that the best one leaves, so that the rows can be compared."""
    unit = best.dilution * max(1.0, best.rms**2)
    price = (len(candidate.fit.q) - len(before.q)) * float(np.log(max(best.effective_samples, 2.0)))
    return (before.cost - candidate.fit.cost) / unit - price


def extended(model: Model, explanation: Explanation) -> Model:
    """The user's model with base and effects as found, ready to be written."""
    at = explanation.model
    return replace(add_effects(model, at.effects), actuator=replace(at.actuator, covariance=None))
