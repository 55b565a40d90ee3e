"""The problem that loops alone pose: the same one as a campaign's, with no deployments and no model file to begin from."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from identify.actuator.effect_starts import starts_with_effects
from identify.actuator.rates_and_strokes import polynomials_for
from identify.campaign.measures import measures_of_loops
from identify.campaign.noise import loop_run
from identify.campaign.prepared import LoopRun, beta_bounds
from identify.campaign.run import Run
from identify.estimation.least_squares import solve
from identify.estimation.parameters import BASE, BETA_NAME, Change, amplitudes_of
from identify.estimation.problem import Fit, Problem
from identify.estimation.rate import Abscissa
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from measure.tables.loop import Loop
from simulate.model.effect import Effect
from simulate.model.model import Actuator, Model

_BETAS = 12  # from which the best is taken to begin with
HELD_IN_LOOPS = Change("force-offset.force_N", 0.0, held=True), Change("sensor-filter.time_s[1]", 0.0, held=True)
"""What no loop tells: an offset of the load cell beside a level of the law, and the camera's time constant."""
_FOREMOST = 2  # of the sizes and shapes of effects, that are fitted to the end


def problem_of_loops(
    loops: Sequence[LoopData],
    kinds: Sequence[type[Effect]] = (),
    abscissa: Abscissa = "none",
    order: int = 0,
    covariate: str = "",
    *,
    own_zeros: bool = False,
    drifting: bool = True,
    changes: Sequence[Change] = (),
) -> Problem:
    """The problem of loops, with these effects unknown beside the law.

    own_zeros : whether each loop has a zero of the load cell of its own. drifting : whether such a zero may drift.

    Raises
    ------
    InputError
        No loop, or one that does not turn; an effect that loops cannot show; too few rates for the polynomials; a covariate is missing.
    """
    require_turns(loops)
    for kind in kinds:
        if not kind.acts_on_shaker():
            raise InputError(f'effect "{kind.name}" does not act on a single actuator, so no loop shows it; fit it to deployments.')
    for data in loops:
        if covariate and covariate not in data.other:
            raise InputError(f'{data.name}: no column "{covariate}" of numbers for the covariate; {nearest(covariate, data.other)}')
    model = _guess(loops)
    runs = tuple(_run(name, data, model) for name, data in zip(_names(loops), loops, strict=True))
    return Problem(
        model=model,
        films=(),
        loops=runs,
        effects=tuple(kind() for kind in kinds),
        covariate=covariate,
        own_zeros=own_zeros,
        zeros_at_will=True,
        rate=polynomials_for(loops, abscissa, order),
        measures=measures_of_loops(loops),
        changes=(
            *_held(changes),
            *([] if drifting else [Change(f"{run.label}.drift_N_per_s", 0.0, held=True) for run in (r.run for r in runs)]),
        ),
    )


def _held(changes: Sequence[Change]) -> tuple[Change, ...]:
    """What a user wants, and what no loop tells held at zero, unless he wants it otherwise."""
    told = {change.name for change in changes}
    return (*changes, *(change for change in HELD_IN_LOOPS if change.name not in told))


def require_turns(loops: Sequence[LoopData]) -> None:
    """Refuse what is no loop at all.

    Raises
    ------
    InputError
    """
    if not loops:
        raise InputError("no loop to fit; name at least one file.")
    for data in loops:
        if not data.cycles.reversals:
            raise InputError(
                f"{data.name}: the elongation never turns, so there is no loop, only one branch. "
                "Check which column was taken for the elongation, or record at least one full cycle."
            )


def _names(loops: Sequence[LoopData]) -> list[str]:
    """A name for each loop: that of its file, numbered where several have one."""
    files = [Path(data.name).name or "loop" for data in loops]
    many = {name for name, count in Counter(files).items() if count > 1}
    return [f"{name.removesuffix('.csv')}-{k + 1}" if name in many else name for k, name in enumerate(files)]


def _run(name: str, data: LoopData, model: Model) -> LoopRun:
    return loop_run(Run(Loop(data.time_s, data.elongation_m, data.force_N, data.name), name=name), model, data)


def _guess(loops: Sequence[LoopData]) -> Model:
    """A law to count from: flat asymptotes at a quarter and three quarters of the forces seen, and a beta between its bounds."""
    force = np.concatenate([data.force_N[data.used] for data in loops])
    low, high = np.quantile(force, [0.25, 0.75])
    beta = float(np.sqrt(np.prod(beta_bounds(loops))))
    return Model(Actuator(0.0, float(low), 0.0, float(high), beta, float(np.max(np.abs(force)))), name="actuator")


def solve_loops(problem: Problem, start: Array | None = None, *, robust: bool = False) -> Fit:
    """Fit loops from wherever the law fits them best: for each of a dozen betas the lines are a linear problem.

    With effects the fit begins at the solution without them, so that it is never worse than that.

    Parameters
    ----------
    start : where to begin; searched where not given.
    robust : samples far off the model count less (soft l1 loss), against spikes.
    """
    if start is not None or not problem.effects:
        return solve(problem, searched(problem) if start is None else start, robust=robust)
    return with_effects(problem, solve_loops(problem.with_effects(()), robust=robust), robust=robust)


def with_effects(problem: Problem, base: Fit, *, robust: bool = False) -> Fit:
    """The best fit with effects, begun at the solution without them and from several sizes of each.

    Parameters
    ----------
    base : the fit of the same problem without effects.
    """
    off = next(starts_with_effects(problem, base.q))
    lowered = [(own, *_lowered(own, q)) for own in variants(problem) for q in list(starts_with_effects(own, base.q))[1:]]
    foremost = sorted(lowered, key=lambda found: found[2])[:_FOREMOST]
    begun = [(problem, searched(problem)), (problem, off), *((own, q) for own, q, _ in foremost)]
    found = min((solve(own, q, robust=robust) for own, q in begun), key=_cost)
    return found if _cost(found) <= _cost(base) else _switched_off(problem, off, base, robust=robust)


def variants(problem: Problem, first: int = 0) -> list[Problem]:
    """The problem with each of the effects, from `first` on, in each of its shapes that has bounds of its own."""
    choices = [[effect] if k < first else _of_own_bounds(effect) for k, effect in enumerate(problem.effects)]
    return [problem.with_effects(effects) for effects in product(*choices)]


def _of_own_bounds(effect: Effect) -> list[Effect]:
    """An effect that is off, at one shape for each set of bounds within which a search of it stays."""
    amplitudes, _ = amplitudes_of(type(effect))
    found: dict[tuple, Effect] = {}
    for shape in (effect, *effect.starts()):
        off = shape.with_flat(np.where(amplitudes, effect.flat(), shape.flat()))
        if any(amplitudes):
            found.setdefault(tuple(off.own_bounds().values()), off)
    return list(found.values()) or [effect]


def _cost(fit: Fit) -> float:
    """Sum of squares, a fit that ran away counted as infinite."""
    return fit.cost if np.isfinite(fit.cost) else np.inf


def _lowered(problem: Problem, start: Array) -> tuple[Array, float]:
    """A start with the lines that fit it best, and the sum of squares that is left."""
    return _linear(problem.with_exact_motion(), start)


def _switched_off(problem: Problem, q: Array, base: Fit, *, robust: bool) -> Fit:
    """The solution without the effects as one with them, where they mend nothing."""
    gaps, jacobian = problem.jacobian(q)
    return Fit(problem, q, gaps, jacobian, base.converged, None, robust, base.evaluations)


def searched(problem: Problem) -> Array:
    """Where a fit of loops begins, (k,): at the beta that leaves least, effects at a noticeable size; as a user wants it, where he does."""
    exact = problem.with_exact_motion()
    index, told = problem.index_of(BETA_NAME), {change.name for change in problem.changes if change.value is not None}
    low, high = problem.bounds
    fixed = BETA_NAME in told or problem.held[index]
    trials = [problem.start[index]] if fixed else np.linspace(low[index], high[index], _BETAS + 2)[1:-1]
    begun = [np.where(np.arange(len(problem.parameters)) == index, place, problem.start) for place in trials]
    found, _ = min((_linear(exact, q) for q in begun), key=lambda trial: trial[1])
    sizes = np.where([parameter.name in told for parameter in problem.parameters], problem.start, 1.0)
    found[problem.first_effect :] = sizes[problem.first_effect :]
    given = np.array([parameter.name in told for parameter in problem.parameters]) | problem.held
    return np.where(given, problem.start, np.clip(found, low, high))


def _linear(problem: Problem, begun: Array) -> tuple[Array, float]:
    """The lines, covariate and zeros that fit best with everything else as it is, and the sum of squares that they leave."""
    q = begun.copy()
    columns = [*range(4), *range(len(BASE), problem.first_rate), *range(problem.first_zero, problem.first_effect)]
    gaps, slopes = problem.jacobian(q, columns)
    size = np.sqrt(np.sum(slopes**2, axis=0)) + 1e-300
    step = np.linalg.lstsq(slopes / size, -gaps, rcond=1e-12)[0]
    q[columns] += step / size
    left = gaps + slopes / size @ step
    return q, float(left @ left)
