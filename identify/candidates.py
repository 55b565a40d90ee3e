"""Every effect of a catalogue tried on a gap: screened by its signature, then fitted together with everything else."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import lsq_linear

from measure.tables import Array
from simulate.effect import Effect

from .evidence import Gain, Signature, gain, signature
from .fit import Fit, solve, solve_from_afar
from .problem import Problem

_WORTH_FITTING = 6.0
_MOST_FITTED = 8
_SHORT_OF_PROMISE = 0.5
_FIRST_STEPS, _LAST_STEPS = 12, 20


@dataclass(frozen=True)
class Screened:
    """An effect and what its signature promises: sum of squares gained, within bounds, on independent samples."""

    effect: Effect
    signature: Signature
    promise: float
    start: Array


@dataclass(frozen=True)
class Candidate:
    """An effect fitted jointly with base and releases.

    held_out_rms : gap over noise of runs left out of the fit, NaN where none could be left out.
    """

    effect: Effect
    fit: Fit
    gain: Gain
    signature: Signature
    held_out_rms: float = float("nan")

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name


def kinds_to_try(catalogue: Mapping[str, type[Effect]], fit: Fit) -> list[Effect]:
    """One effect of each kind that is not among the unknown yet: as the model has it, or switched off."""
    taken = {effect.name for effect in fit.problem.effects}
    return [fit.problem.model.effect(kind) for name, kind in catalogue.items() if name not in taken]


def screen(fit: Fit, effects: Iterable[Effect]) -> list[Screened]:
    """The effects that promise anything, best first."""
    found = [_screened(fit, effect) for effect in effects]
    worth = [s for s in found if s is not None and s.promise > _WORTH_FITTING]
    return sorted(worth, key=lambda s: -s.promise)[:_MOST_FITTED]


def _screened(fit: Fit, effect: Effect) -> Screened | None:
    problem = fit.problem.with_effects((*fit.problem.effects, effect))
    q = np.concatenate([fit.q, np.zeros(len(effect.flat()))])
    new = range(len(fit.q), len(q))
    _, columns = problem.jacobian(q, new)
    found = signature(fit, columns)
    if not found.knobs:
        return _tried_at_typical_size(fit, problem, effect)
    start, chi2 = _bounded(fit, problem, columns, new)
    return Screened(effect, found, chi2 / fit.dilution, start)


def _bounded(fit: Fit, problem: Problem, columns: Array, new: Sequence[int]) -> tuple[Array, float]:
    """Sizes within their bounds that linearly close most of the gap together with the other knobs, and the gain."""
    base, _ = np.linalg.qr(fit.jacobian / np.maximum(np.linalg.norm(fit.jacobian, axis=0), 1e-300))
    free = columns - base @ (base.T @ columns)
    norms = np.linalg.norm(free, axis=0)
    used = np.flatnonzero(norms > 1e-9)
    low, high = (np.array([getattr(problem.knobs[i], side) for i in new])[used] * norms[used] for side in ("low", "high"))
    low, high = np.minimum(low, -0.0), np.maximum(high, 0.0)
    r, triangle = np.linalg.qr(free[:, used] / norms[used])
    found = lsq_linear(triangle, -(r.T @ fit.gaps), bounds=(low, np.maximum(high, low + 1e-9)))
    start = np.zeros(len(new))
    start[used] = found.x / norms[used]
    left = fit.gaps + free @ start
    return start, max(0.0, fit.cost - float(left @ left))


def _tried_at_typical_size(fit: Fit, problem: Problem, effect: Effect) -> Screened | None:
    """An effect whose rate of change is zero where it is switched off (a clearance, a backlash) is looked at full size."""
    start = np.ones(len(effect.flat()))
    at = problem.gaps(np.concatenate([fit.q, start]))
    column = (at - fit.gaps)[:, None]
    found = signature(fit, column)
    return Screened(effect, found, found.chi2 / fit.dilution, start) if found.knobs else None


def fit_screened(before: Fit, screened: Screened) -> Candidate:
    """Fit an effect jointly; where the fit falls short of what the signature promised, start again at its typical size."""
    problem = before.problem.with_effects((*before.problem.effects, screened.effect))
    found = _fitted(problem, before, screened.start)
    if before.cost - found.cost < _SHORT_OF_PROMISE * screened.promise * before.dilution:
        others = [_fitted(problem, before, sign * np.ones(len(screened.start))) for sign in _signs(problem, len(before.q))]
        found = min([found, *others], key=lambda f: f.cost)
    return Candidate(screened.effect, found, gain(before, found), screened.signature)


def carried_to_the_end(before: Fit, candidate: Candidate) -> Candidate:
    """A candidate that was fitted up to the stops, or in a hurry, fitted whole."""
    problem = before.problem.with_effects(candidate.fit.problem.effects)
    best = solve_from_afar(problem, candidate.fit.q, most_steps=_LAST_STEPS)
    return replace(candidate, fit=best, gain=gain(before, best))


def _signs(problem: Problem, first: int) -> tuple[float, ...]:
    return (1.0, -1.0) if all(knob.low < -1.0 for knob in problem.knobs[first:]) else (1.0,)


def _fitted(problem: Problem, before: Fit, start: Array) -> Fit:
    return solve(problem, np.concatenate([before.q, start]), most_steps=_FIRST_STEPS)


def held_out_rms(fit: Fit) -> float:
    """Gap over noise of measurements that took no part: each group of runs is left out in turn, the rest fitted.

    Films are left out one by one while the loops stay; without films, the loops of one frequency together. Of a film left
    out only its own release is fitted.
    """
    folds = _folds(fit.problem)
    squares = [_left_out(fit, fold) for fold in folds]
    parts = np.concatenate(squares) if squares else np.empty(0)
    return float(np.sqrt(np.mean(parts**2))) if len(parts) else float("nan")


def _folds(problem: Problem) -> list[set[str]]:
    films = [film.run.name for film in problem.films]
    if len(films) > 1 or (films and problem.loops):
        return [{name} for name in films] if len(films) > 1 else []
    by_frequency: dict[float, set[str]] = {}
    for loop in problem.loops:
        by_frequency.setdefault(round(loop.data.frequency_Hz, 2), set()).add(loop.run.name)
    return list(by_frequency.values()) if len(by_frequency) > 1 else []


def _left_out(fit: Fit, fold: set[str]) -> Array:
    problem = fit.problem
    rest = replace(
        problem,
        films=tuple(f for f in problem.films if f.run.name not in fold),
        loops=tuple(x for x in problem.loops if x.run.name not in fold),
    )
    refitted = solve(rest, _moved(fit, problem, rest), most_steps=8)
    out = replace(
        problem,
        films=tuple(f for f in problem.films if f.run.name in fold),
        loops=tuple(x for x in problem.loops if x.run.name in fold),
    )
    return carried_over(refitted, out, fit).measured_gaps


def carried_over(fit: Fit, other: Problem, start: Fit | None = None) -> Fit:
    """Other runs seen with the base and effects of a fit; only their own releases are fitted."""
    q = _moved(fit, fit.problem, other)
    if start is not None:
        q[other.first_nuisance : other.first_effect] = _moved(start, start.problem, other)[other.first_nuisance : other.first_effect]
    return solve_from_afar(other, q, free=range(other.first_nuisance, other.first_effect))


def _moved(fit: Fit, of: Problem, to: Problem) -> Array:
    """The knobs of one problem laid out for another of the same model; releases of unknown runs stand at zero."""
    named = {knob.name: value * knob.scale for knob, value in zip(of.knobs, fit.q, strict=True)}
    return np.array([named.get(knob.name, 0.0) / knob.scale for knob in to.knobs])
