"""Which physical effect is missing between a model and its measurements: the answer.

    fit base and releases  ->  weigh every hypothesis  ->  fit those that may hold a share  ->  a verdict from the probabilities

One rule decides (`verdict`): every hypothesis, nothing among them, has a log evidence under the same noise and priors. Runs held out may
then speak against every name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from identify.campaign.load_cell_zeros import Tare, zeros_differ
from identify.campaign.noiseless import with_noise_where_none
from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.criteria import CLEAR_LEAD, LARGER_PART, ROUGHLY
from identify.design.detection_limits import detection_limits
from identify.design.further_test import NextTest
from identify.design.next_test import next_tests
from identify.draft.draft import draft
from identify.draft.drafted import Drafted
from identify.draft.effect_file import Origin, free_name
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.parameters import Change
from identify.estimation.problem import Fit, Problem
from identify.gap.bent_law import with_law_as_given
from identify.gap.comparison import Held
from identify.gap.gap_test import is_noise
from identify.gap.held_out import carried_over, held_out
from identify.gap.leg_force import LegForce
from identify.gap.platform_force import ForceAlongTime, ForceTable, MissingForce
from identify.gap.size import NoiseOfChannel, as_measured, halves, noise_of_channels, share_closed
from identify.gap.unnamed import Unnamed, simulated
from identify.selection.explanation import Explanation, Ranked
from identify.selection.findings import findings_of, moved_of
from identify.selection.hypotheses import BUDGETS, Budget, Hypothesis, Say, log_prior
from identify.selection.model_errors import FORCES, slight_errors
from identify.selection.other_side import all_sides, brought_to
from identify.selection.search import Search
from identify.selection.stand import Stand, Weighed
from identify.selection.verdict import Finding, Names, Verdict, after_a_veto, doing_without, in_a_class, is_unnamed, verdict_of
from simulate.effects import CATALOGUE, GeometryError
from simulate.model.effect import Effect
from simulate.model.model import Model


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
    model : the model file's.
    runs : loops and deployments; those held out take no part in fitting or naming. Tables without noise are given some, see `noiseless`.
    catalogue : effects to try, by name.
    covariate : a further column of the loops (a pressure, a temperature) to which a part of their force is proportional.
    tare : "common", the load cell has one zero in all loops; "each", one of its own in each; "auto", the
        latter where a gap is left otherwise and the zeros differ by more than three standard errors.
    changes : parameters that are held, bounded, or begin elsewhere; of effects too, where they are tried.
    budget : how much is tried.
    say : called with what is being done, for people who wait.

    Returns
    -------
    Explanation

    Raises
    ------
    InputError
        A run cannot be used with this model.
    """
    runs, added = with_noise_where_none(runs)
    problem = problem_of(model, [run for run in runs if not run.hold_out], covariate, own_zeros=tare == "each", changes=changes)
    return replace(_explained(problem, runs, catalogue, budget, say, zeros_may_differ=tare == "auto"), noise_added=added)


def _zeros_help(fit: Fit) -> bool:
    """Whether zeros of the loops' own close half of what is left."""
    problem = replace(fit.problem, own_zeros=True)
    return halves(fit, solve(problem, laid_out(fit, problem), enough=ROUGHLY, loosely=True))


def _explained(
    problem: Problem, runs: Sequence[Run], catalogue: Mapping[str, type[Effect]], budget: Budget, say: Say, *, zeros_may_differ: bool
) -> Explanation:
    say("fitting base and releases")
    search = Search(catalogue, log_prior(catalogue), budget, say)
    base = solve_from_afar(problem)
    search.run(base)
    foremost, nothing, weights = search.settled(), search.fitted[()], search.weights()
    before = _before_any_name(nothing.weighed, base)
    judged = _judged(search, foremost, before, weights)
    foremost, verdict, findings, after = judged.foremost, judged.verdict, judged.findings, judged.foremost.fit
    say("looking at the runs held out")
    held = tuple(held_out(run, before, after, judged.noise) for run in runs if run.hold_out)
    vetoed = after_a_veto(verdict, leaves_noise=judged.leaves_noise)
    may_be_nothing = vetoed.word == "no-gap"
    if verdict.names and held and (may_be_nothing or any(one.grows for one in held)):
        held = tuple(replace(one, lead=_lead(one, nothing.weighed, foremost.weighed)) for one in held)
        is_worse = any(one.contradicts for one in held) or (may_be_nothing and sum(one.lead for one in held) < 0.0)
        verdict = vetoed if is_worse else in_a_class(verdict)
    is_base = verdict.word == "unknown" or (verdict.word == "no-gap" and not set(foremost.names) <= set(judged.slight))
    said = nothing if is_base else foremost
    if said is nothing:
        findings, after = (), before
        held = tuple(replace(one, after=one.before) for one in held)
    is_open = verdict.word in ("unknown", "partly")
    missed = not is_open and any(one.misses and (verdict.names or not _can_be_met(one.after, said.weighed)) for one in held)
    verdict = replace(verdict, word="partly" if verdict.names else "unknown") if missed else verdict
    if zeros_may_differ and is_open and zeros_differ(after) and _zeros_help(after):
        say("giving each loop a zero of its own")
        return _explained(replace(problem, own_zeros=True), runs, catalogue, budget, say, zeros_may_differ=False)
    rivals = _rivals(search, verdict)
    missing, in_legs = _left(search, after, verdict, say) if is_open else (None, None)
    drafted = _drafted(search, said, after, verdict, runs, say) if is_open else None
    slight = [judged.slight[name] for name in said.names if name in judged.slight and name not in verdict.names]
    return Explanation(
        verdict.word,
        verdict.weights,
        findings,
        with_law_as_given(nothing.weighed.exact.fit),
        before,
        after,
        _noise_beside(drafted, judged.noise) if is_open else judged.noise,
        _ranking(search, weights),
        rivals,
        held,
        missing,
        in_legs,
        _along_time(search) if verdict.word != "no-gap" and problem.films else None,
        drafted,
        detection_limits(search.beside_foremost(), search.prior, problem.measures),
        _next_tests(after, rivals, verdict),
        (*moved_of(said.weighed.stand), *slight),
        verdict.vetoed,
        missed,
    )


@dataclass(frozen=True)
class _Judged:
    """What the runs that took part say.

    foremost : the hypothesis behind the verdict, on its likeliest side. noise : by which gaps are measured. leaves_noise : whether what the
    foremost one of all leaves is as fast as noise. slight : fitted errors of the model file that are hardly beyond their tolerances.
    """

    foremost: Hypothesis
    verdict: Verdict
    findings: tuple[Finding, ...]
    noise: tuple[NoiseOfChannel, ...]
    leaves_noise: bool
    slight: Mapping[str, tuple[Effect, float]]


def _judged(search: Search, foremost: Hypothesis, before: Fit, weights: Mapping[Names, float]) -> _Judged:
    found, leaves_noise = foremost.weighed.evidence, foremost.weighed.leaves_noise
    noise = noise_of_channels(foremost.fit.problem.blocks, foremost.fit.problem.stated_noise, found.noise, found.left)
    noise = noise if leaves_noise else as_measured(noise)
    closes_most = share_closed(before, foremost.fit, noise) > LARGER_PART
    verdict = verdict_of(weights, foremost=foremost.names, closes_most=closes_most, leaves_noise=leaves_noise)
    if verdict.word == "partly":
        foremost = search.shortest(foremost.names)
        verdict = replace(verdict, names=foremost.names)
    slight = {effect.name: (effect, size) for effect, size in slight_errors(foremost.fit)}
    verdict = doing_without(verdict, slight)
    sides = all_sides(foremost.weighed) if verdict.names and verdict.word != "unknown" else (foremost.weighed,)
    foremost = foremost if sides[0] is foremost.weighed else replace(foremost, weighed=brought_to(foremost.weighed, sides[0].stand))
    findings = findings_of(foremost, sides, search.fitted[()], verdict, noise) if verdict.names else ()
    return _Judged(foremost, _as_far_as_known(verdict, findings, foremost), findings, noise, leaves_noise, slight)


def _as_far_as_known(verdict: Verdict, findings: Sequence[Finding], foremost: Hypothesis) -> Verdict:
    """A parameter at its bound, and an effect of many parameters that no loop says anything of, are never named alone."""
    alone = verdict.word == "named"
    if alone and any(finding.at_bound for finding in findings):
        return replace(verdict, word="partly")
    return in_a_class(verdict) if alone and any(one.is_never_alone(foremost.fit.problem) for one in findings) else verdict


def _before_any_name(nothing: Weighed, squares: Fit) -> Fit:
    """The fit before anything is named: the likeliest one where it leaves noise; else least squares, if they leave a smaller gap.

    Far from the measurements the likeliest fit takes a part of the gap for noise with a memory. Close to them least squares may drag the
    release, for they take the model file for exact.
    """
    return nothing.fit if nothing.leaves_noise else min(nothing.fit, squares, key=lambda fit: fit.rms)


def _lead(held: Held, nothing: Weighed, foremost: Weighed) -> float:
    """By how much names make a run that took no part more probable, in log probability."""
    return _log_probability(held.after, foremost) - _log_probability(held.before, nothing)


def _log_probability(held: Fit, one: Weighed) -> float:
    """Log probability of a run that took no part, all that a hypothesis leaves open integrated out: of all runs, less that of the rest."""
    return _with_run(held, one).weighed().log_z - one.evidence.log_z


def _can_be_met(held: Fit, one: Weighed) -> bool:
    """Whether a run that took no part leaves noise where all that a hypothesis leaves open bends to it, along straight lines."""
    stand, (first, *_) = _with_run(held, one), held.problem.blocks
    left = zip(stand.given.blocks, stand.weighed().left, strict=True)
    return is_noise([innovations for block, innovations in left if block.run == first.run])


def _with_run(held: Fit, one: Weighed) -> Stand:
    """A hypothesis where it stands, with a run that took no part among the others."""
    stand, of = one.stand, held.problem
    whole = replace(stand.given, films=(*stand.given.films, *of.films), loops=(*stand.given.loops, *of.loops))
    own = [whole.index_of(parameter.name) for parameter in of.parameters[of.first_nuisance : of.first_effect]]
    q = laid_out(stand.fit, whole)
    q[own] = laid_out(held, whole)[own]
    return Stand.placed(whole, q, stand.errors_by_key)


def _noise_beside(drafted: Drafted | None, noise: Sequence[NoiseOfChannel]) -> tuple[NoiseOfChannel, ...]:
    """By what gaps are measured where more than noise is left: what a draft leaves, if that is noise, or what is fast in each channel."""
    return drafted.noise if drafted is not None and drafted.noise else as_measured(noise)


def _left(search: Search, after: Fit, verdict: Verdict, say: Say) -> tuple[MissingForce | None, LegForce | None]:
    """The force that is left beside what is named, on the platform and in the legs, as far as these runs can tell the two apart."""
    tables: list[Unnamed] = search.tables_beside(verdict.names)
    legs = next((one for one in tables if one.in_legs is not None), None)
    on_platform = [(one.table, one) for one in tables if isinstance(one.table, ForceTable)]
    if not on_platform:
        return None, legs and legs.in_legs
    (_, best), *others = on_platform
    leads = {table.words: best.log_z - one.log_z for table, one in others}
    likely = legs is not None and legs.log_z > best.log_z - CLEAR_LEAD
    say("estimating the missing force")
    return simulated(best, after).on_platform(leads), simulated(legs, after).in_legs if legs is not None and likely else None


def _drafted(search: Search, said: Hypothesis, after: Fit, verdict: Verdict, runs: Sequence[Run], say: Say) -> Drafted | None:
    """A formula for the force that is left, as an effect of one's own."""
    say("drafting an effect")
    known: dict[str, list[Fit]] = {run.name: [] for run in runs if run.hold_out}

    def of_runs_held_out(fit: Fit) -> list[Fit]:
        for run in runs:
            if run.hold_out:
                known[run.name].append(carried_over(fit, run, known[run.name]))
        return [fits[-1] for fits in known.values()]

    about = f"Made from {', '.join(run.name for run in runs if not run.hold_out)} and {after.problem.model.name}."
    taken = {*search.catalogue, *(effect.name for effect in after.problem.effects)}
    origin = Origin(free_name(taken), about, after.problem.measures)
    return draft(said.weighed, after, search.tables_beside(verdict.names), of_runs_held_out, origin)


def _along_time(search: Search) -> MissingForce | None:
    """The force that was missing along time before anything was named."""
    found = next((one for one in search.tables_beside(()) if isinstance(one.table, ForceAlongTime)), None)
    return found and found.on_platform({})


def _ranking(search: Search, weights: Mapping[Names, float]) -> tuple[Ranked, ...]:
    nothing = search.fitted[()].weighed.log_z
    rows = [
        Ranked(names, 2.0 * (search.log_z_of(names) - nothing), weight, names in search.fitted)
        for names, weight in weights.items()
        if names and not any(is_unnamed(name) for name in names)
    ]
    return tuple(sorted(rows, key=lambda row: -row.weight))


def _next_tests(after: Fit, rivals: Mapping[str, Fit], verdict: Verdict) -> tuple[NextTest, ...]:
    """Tests that would split a class; none is predicted with joints that are off: their 36 coordinates bend to any deployment."""
    others = {name: fit for name, fit in rivals.items() if name != GeometryError.name}
    return next_tests(after, others) if others and GeometryError.name not in verdict.names else ()


def _rivals(search: Search, verdict: Verdict) -> dict[str, Fit]:
    """Fits of what may stand in the place of a single name; forces of runs have no fit of their own."""
    if verdict.word != "class":
        return {}
    (name,) = verdict.names
    found = {other: search.fitted.get((other,)) for other in verdict.equivalents[name]}
    return {other: one.fit for other, one in found.items() if one is not None and other != FORCES}
