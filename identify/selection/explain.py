"""Which physical effect is missing between a model and its measurements: the decision.

    is there a gap?  ->  which effects could close it?  ->  can they be told apart?  ->  is anything left?

A gap is tested first, so that nothing is named where there is only noise. Effects join one by one, each fitted together
with base and releases; an effect that others make superfluous leaves again. What the data cannot separate is a class, and
a gap that nothing closes is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.campaign.load_cell_zeros import Tare, zeros_differ
from identify.campaign.noiseless import AddedNoise, with_noise_where_none
from identify.campaign.run import Run
from identify.design.next_test import NextTest, next_tests
from identify.estimation.fit import Fit
from identify.estimation.least_squares import ROUGHLY, laid_out, solve, solve_from_afar
from identify.estimation.multistart import released_again, searched_everywhere
from identify.estimation.parameters import Change
from identify.estimation.problem import Problem, problem_of
from identify.estimation.profile_likelihood import REACH, profile_interval
from identify.gap.platform_force import MissingForce, at_once, estimate
from identify.gap.sparse_force import is_bent
from identify.selection.candidate_fits import Candidate, carried_over
from identify.selection.chaotic_sensitivity import unpredictable
from identify.selection.comparison import BUDGETS, Budget, Rival, Say, Step
from identify.selection.detection_limits import Sight, sight
from identify.selection.equivalent_shapes import LocalMinimum, deepest_shape
from identify.selection.forward_selection import joined, share_closed, without_superfluous
from identify.selection.gap_test import GAP_P, Gain, GapTest, gap_test
from identify.selection.null_hypothesis import noise_like
from identify.selection.screening import kinds_to_try
from identify.selection.verdict import more_than_noise, verdict_of
from simulate.effects import CATALOGUE
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect
from simulate.model.model import Model

_AS_GIVEN_STEPS = 8


@dataclass(frozen=True)
class Finding:
    """An effect named, with its evidence. equivalents : effects that these data cannot tell from it.

    stderr, ci95 : (k,) and (k, 2) of its parameters laid flat; the intervals by profile, cut at the bounds. A parameter of which these
    measurements show nothing has no standard error (NaN), and its bounds for an interval.
    """

    effect: Effect
    stderr: np.ndarray
    ci95: np.ndarray
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
    """What came out. as_given : the model file itself; before : base refitted; after : with the findings.

    missing : the force that no effect explains, where the verdict is unknown. located : the force that was missing before
    anything was named, as a first look along time; both None without deployments or without a gap. unpredictable : deployments that took
    no part because with the findings nobody could predict them, see `chaotic_sensitivity.unpredictable`; then the loops alone decide.
    nearest : of an unknown gap the effect that came nearest, and its share of the gap. noise_added : what tables without noise were given.
    """

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
    located: MissingForce | None
    sights: tuple[Sight, ...]
    next_tests: tuple[NextTest, ...]
    unpredictable: tuple[str, ...] = ()
    nearest: tuple[str, float] | None = None
    noise_added: tuple[AddedNoise, ...] = ()

    @property
    def model(self) -> Model:
        """The extended model: base as refitted, the effects found added."""
        return self.after.problem.model_at(self.after.q)

    @property
    def share_closed(self) -> float:
        """Part of the gap's excess over noise that the findings close, 0 to 1."""
        return share_closed(self.before, self.after)


def explain(
    model: Model,
    runs: Sequence[Run],
    catalogue: Mapping[str, type[Effect]] = CATALOGUE,
    *,
    covariate: str = "",
    tare: Tare = "auto",
    changes: Sequence[Change] = (),
    budget: Budget = BUDGETS["normal"],
    say: Say = lambda text: None,
) -> Explanation:
    """Find what is missing in `model` to say what was measured.

    Parameters
    ----------
    runs : loops and deployments; those held out take no part in fitting or naming. Tables without noise are given some, see `noiseless`.
    catalogue : effects to try, by name.
    covariate : a further column of the loops (a pressure, a temperature) to which a part of their force is proportional.
    tare : "common", the load cell has one zero in all loops; "each", one of its own in each; "auto", the
        latter where a gap is left otherwise and the zeros differ by more than three standard errors.
    changes : parameters that are held, bounded, or begin elsewhere; of effects too, where they are tried.
    budget : how much is tried.
    say : told what is being done, for people who wait.

    Raises
    ------
    InputError
        A run cannot be used with this model.
    """
    runs, added = with_noise_where_none(runs)
    problem = problem_of(model, [run for run in runs if not run.hold_out], covariate, own_zeros=tare == "each", changes=changes)
    return replace(_told(problem, runs, catalogue, tare, budget, say), noise_added=added)


def _told(
    problem: Problem, runs: Sequence[Run], catalogue: Mapping[str, type[Effect]], tare: Tare, budget: Budget, say: Say
) -> Explanation:
    told = _asked_of_loops(problem, catalogue, budget, say)
    if tare == "auto" and told is not None and more_than_noise(told) and zeros_differ(told):
        problem = _with_own_zeros(problem, say)
        told = _asked_of_loops(problem, catalogue, budget, say)
    found = _told_by_loops(told, problem, runs, catalogue, budget, say) or _explained(problem, runs, catalogue, budget, say)
    left = found.verdict == "unknown" or found.gap_after.p_value < GAP_P
    if tare != "auto" or problem.own_zeros or not left or not zeros_differ(found.after):
        return found
    again = _explained(_with_own_zeros(found.before.problem, say), runs, catalogue, budget, say)
    return found if again.verdict == "unknown" else replace(again, unpredictable=found.unpredictable)


def _with_own_zeros(problem: Problem, say: Say) -> Problem:
    say("giving each loop a zero of its own")
    return replace(problem, own_zeros=True)


def _asked_of_loops(problem: Problem, catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say) -> Fit | None:
    """What the loops of a campaign with films say by themselves, where they show a gap; else None."""
    if not problem.films or not problem.loops:
        return None
    before = solve_from_afar(replace(problem, films=()))
    if gap_test(before).p_value > GAP_P:
        return None
    say("asking the loops alone")
    return joined(before, catalogue, budget, say).fit


def _told_by_loops(
    told: Fit | None, problem: Problem, runs: Sequence[Run], catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say
) -> Explanation | None:
    """What the loops name by themselves, where nobody could predict any film with it, so that films say nothing against it; else None."""
    if told is None:
        return None
    films = problem_of(problem.model, [run for run in runs if not run.is_loop]).with_effects(told.problem.effects)
    lost = unpredictable(films, laid_out(told, films))
    if not {film.run.name for film in problem.films} <= set(lost):
        return None
    found = _explained(replace(problem, films=()), runs, catalogue, budget, say)
    return replace(found, unpredictable=lost) if found.findings else None


def _explained(problem: Problem, runs: Sequence[Run], catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say) -> Explanation:
    say("fitting base and releases")
    before = released_again(solve_from_afar(problem))
    added = joined(before, catalogue, budget, say)
    before = added.before
    current, steps = without_superfluous(added.fit, added.steps, say)
    missing, pushed, left = None, False, more_than_noise(current)
    if left and len(steps) > 1:  # several must leave nothing; the foremost alone may stand
        current, steps = added.first[0].best.fit, added.first
    alike = steps[0].rivals_of(current) if len(steps) == 1 else [current]
    if added.pushed is not None and is_bent(before, alike, added.pushed):
        pushed, missing = True, added.pushed.force
    elif left and problem.films:
        say("estimating the missing force")
        missing = estimate(before)
    verdict = "unknown" if pushed else verdict_of(before, current, steps, missing, left=left)
    explained = verdict in ("named", "class", "several")
    after, doubts = _told_best(current, [step.best.name for step in steps], say) if explained else (before, {})
    say("looking at the runs held out")
    held = tuple(_held(run, before, after) for run in runs if run.hold_out)
    findings = _findings(after, before, steps, doubts) if explained else ()
    rivals = tuple(c for step in steps for c in step.equivalents) if findings else ()
    say("looking for what could have been seen")
    sights = sight(after, kinds_to_try(catalogue, after), noise_like(after), added.tests)
    to_split = next_tests(before, after, rivals) if rivals and len(steps) == 1 else ()
    gaps = gap_test(before), gap_test(after)
    missing = missing if verdict == "unknown" else None
    located = at_once(before) if verdict != "no-gap" and problem.films else None
    ranking = steps[0].ranking if steps else ()
    fits = _as_given(before), before, after
    nearest = (steps[0].best.name, share_closed(before, current)) if steps and verdict == "unknown" else None
    return Explanation(verdict, findings, *fits, *gaps, ranking, rivals, held, missing, located, sights, to_split, nearest=nearest)


def _told_best(fit: Fit, names: Sequence[str], say: Say) -> tuple[Fit, dict[str, tuple[LocalMinimum, ...]]]:
    """What is told, from the deepest local minima of releases and shapes; and for each effect the other minima that may as well hold."""
    fit, doubts = _settled(fit, say), {}
    for name in names:
        fit, doubts[name] = deepest_shape(fit, name)
    return _calm(fit), doubts


def _settled(fit: Fit, say: Say) -> Fit:
    """What is told, from the deepest local minimum of every film's release: a shallower one can look like noise and bias an effect."""
    if not fit.problem.films:
        return fit
    say("looking for every release anew")
    return searched_everywhere(fit)


def _calm(fit: Fit) -> Fit:
    """The same fit, parameters that do nothing to these measurements left where the effect has them; a search moves them at random."""
    still = [i for i in range(fit.problem.first_effect, len(fit.q)) if not fit.moves(i)]
    q = fit.q.copy()
    q[still] = 0.0
    return replace(fit, q=q)


def _as_given(before: Fit) -> Fit:
    """The model file itself: base and effects as it has them, only the releases fitted."""
    first, end = before.problem.first_nuisance, before.problem.first_effect
    start = np.zeros(len(before.q))
    start[first:end] = before.q[first:end]
    return solve(before.problem, start, free=range(first, end), most_steps=_AS_GIVEN_STEPS, enough=ROUGHLY)


def _held(run: Run, before: Fit, after: Fit) -> Held:
    of = before.problem
    problem = problem_of(of.model, [run], of.covariate, own_zeros=of.own_zeros)
    return Held(carried_over(before, problem), carried_over(after, problem.with_effects(after.problem.effects)))


def _findings(after: Fit, before: Fit, steps: Sequence[Step], doubts: Mapping[str, Sequence[LocalMinimum]]) -> tuple[Finding, ...]:
    """The effects with their evidence, in order of weight: of what the sum of squares would grow without each."""
    found = [_finding(after, before, step, doubts[step.best.name]) for step in steps]
    return tuple(sorted(found, key=lambda finding: -finding.share))


def _finding(after: Fit, before: Fit, step: Step, doubts: Sequence[LocalMinimum]) -> Finding:
    effect = next(effect for effect in after.problem.effects_at(after.q) if effect.name == step.best.name)
    rows = after.problem.rows_of(step.best.name)
    shown = np.array([after.shows(row) for row in rows.tolist()])
    stderr = np.where(shown, np.sqrt(np.maximum(np.diag(after.covariance)[rows], 0.0)) * after.problem.scales[rows], np.nan)
    ends = np.array([profile_interval(after, row) if seen else (-np.inf, np.inf) for row, seen in zip(rows.tolist(), shown, strict=True)])
    low, high = np.array(list(effect.own_bounds(after.problem.model).values())).T[:, :, None]
    ends = effect.flat()[:, None] + (ends - after.q[rows, None]) * after.problem.scales[rows, None]
    for minimum in doubts:
        way = REACH * minimum.stderr
        ends = np.column_stack([np.minimum(ends[:, 0], minimum.values - way), np.maximum(ends[:, 1], minimum.values + way)])
    ci95 = np.clip(ends, low, high)
    names = tuple(c.name for c in step.equivalents)
    excess = before.cost - after.cost
    share = (step.before.cost - step.best.fit.cost) / excess if excess > 0 else 0.0
    return Finding(effect, stderr, ci95, names, step.best.gain, float(np.clip(share, 0.0, 1.0)) * share_closed(before, after))


def extended(model: Model, explanation: Explanation) -> Model:
    """The user's model with base and effects as found, ready to be written."""
    at = explanation.model
    return replace(add_effects(model, at.effects), actuator=replace(at.actuator, covariance=None))
