"""A whole sweep in one call: factors and design worked out, a step chosen, all runs simulated."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.common.running.duration import timed
from simulate.model.model import Model
from simulate.model.responses import THETA_Z, response_named
from simulate.sweeps.chunks import Chunks
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import Factor, factors_of, with_named_effects
from simulate.sweeps.indices import KINDS
from simulate.sweeps.limits import DESIGNS, FAILURE_DEG, FARTHEST
from simulate.sweeps.rare_events import RareFailure, subset_simulation
from simulate.sweeps.result import SweepResult
from simulate.sweeps.step_search import choose_step
from simulate.sweeps.sweep import Sweep, run_by, run_on

_SAMPLE = 32  # runs
Progress = Callable[[Iterable[int], int], Iterable[int]]


def sweep(
    model: Model,
    factors: Sequence[str | Factor] = (),
    design: str = "full",
    runs: int | None = None,
    seed: int = 0,
    workers: int | None = None,
    response: str = "theta_z_deg",
    failure_deg: float = FAILURE_DEG,
    *,
    indices: str | None = None,
    rare: int | None = None,
    executor: Executor | None = None,
    folder: Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    foretell: Callable[[float], object] | None = None,
) -> SweepResult:
    """Simulate a design of deployments and explain a response by its factors, as `sweep-deployments` does.

    Parameters
    ----------
    model : with a geometry.
    factors : what is varied, `"actuator.stored_force_N[0]=+-10%"`, `"platform.mass_kg=0.7..0.9"`, `"release.theta_rad[2]=sigma:0.001"`; by
        default the paper's twelve, stored force and slope of each leg at +-10 %.
    design : "full", "fractional", "latin-hypercube", "sobol" or "random".
    runs : of a sampled or fractional design; by default 1024, or the least of a fractional one.
    seed : of a sampled design. Same input and seed, same digits, whatever the workers.
    workers : cores; by default all.
    response : what the regression explains, a name of `simulate.model.responses.RESPONSES`.
    failure_deg : a run whose abs(theta_z) goes beyond this angle has failed.
    indices : "sobol" or "morris": the runs are chosen for these indices of each factor, instead of by a design.
    rare : runs of each level of a subset simulation, which finds the probability of rare failures; none without.
    executor : computes the runs elsewhere (processes, a cluster); `workers` is then its own business.
    folder : keep the responses there, piece by piece, instead of in memory.
    resume : keep what stands in that folder of an earlier run of the same sweep.
    progress : wraps the pieces as they come in, given their number.
    foretell : called before they begin with the seconds that they will take on this machine, from a sample of the runs.

    Returns
    -------
    SweepResult

    Raises
    ------
    InputError
        No geometry, an unknown response or factor, a design that cannot be, more steps than anybody waits for.
    """
    response_named(response)
    chosen = choose_step(_posed(model, factors, _kind(design, indices), runs, seed), failure_deg)
    shown: Progress = progress or (lambda pieces, _: pieces)
    if foretell is not None and executor is None:
        done = sum(last - first for first, last in Chunks(folder, chosen.sweep).standing()) if folder is not None and resume else 0
        foretell(_seconds(chosen.sweep, workers) * (chosen.sweep.design.runs - done))
    begun = time.perf_counter()
    if folder is None:
        pieces = _in_memory(chosen.sweep, workers, executor, shown)
    else:
        pieces = _on_disk(Chunks(folder, chosen.sweep), workers, executor, resume, shown)
    failure = rare_failure(chosen.sweep, failure_deg, rare, seed) if rare is not None else None
    return SweepResult(chosen.sweep, pieces, response, failure_deg, chosen.report, time.perf_counter() - begun, failure)


def _seconds(sweep: Sweep, workers: int | None) -> float:
    """How long one run takes among many, from a sample of them."""
    sample = min(_SAMPLE, sweep.design.runs)
    return timed(lambda: next(run_on(sweep, workers, [(0, sample)]))) / sample


def rare_failure(sweep: Sweep, failure_deg: float, runs: int, seed: int = 0) -> RareFailure:
    """Probability that abs(theta_z) goes beyond an angle, with each factor spread as it says, by subset simulation.

    A run that diverges counts as one that failed. runs : of each level, at least `limits.FEWEST_RARE`.
    """
    normal = np.array([factor.normal for factor in sweep.factors])

    def turned_deg(places: Array) -> Array:
        coded = np.where(normal, np.clip(places, -FARTHEST, FARTHEST), 2.0 * ndtr(places) - 1.0)
        return np.nan_to_num(np.degrees(np.abs(sweep.responses_at(coded)[:, THETA_Z])), nan=np.inf)

    from scipy.special import ndtr

    return subset_simulation(turned_deg, len(sweep.factors), failure_deg, runs, seed)


def _kind(design: str, indices: str | None) -> str:
    """The kind of design, checked."""
    if indices is not None:
        if indices not in KINDS:
            raise InputError(f'no indices are named "{indices}"; take one of {", ".join(KINDS)}.')
        return KINDS[indices]
    if design not in DESIGNS:
        raise InputError(f'no design is named "{design}"; take one of {", ".join(DESIGNS)}.')
    return design


def _posed(model: Model, factors: Sequence[str | Factor], design: str, runs: int | None, seed: int) -> Sweep:
    """The sweep, refused where no run of it could be simulated."""
    given = [factor for factor in factors if isinstance(factor, Factor)]
    settings = [factor for factor in factors if isinstance(factor, str)]
    model = with_named_effects(model, settings)
    varied = tuple(given) if given and not settings else (*given, *factors_of(model, settings, len(given)))
    normal = [i for i, factor in enumerate(varied) if factor.normal]
    posed = Sweep(model, varied, design_of(design, len(varied), runs, seed, normal))
    posed.require_runnable()
    return posed


def _computed(sweep: Sweep, workers: int | None, executor: Executor | None, only: Iterable[tuple[int, int]]) -> Iterator[tuple[int, Array]]:
    return run_on(sweep, workers, only) if executor is None else run_by(executor, sweep, only)


def _in_memory(sweep: Sweep, workers: int | None, executor: Executor | None, progress: Progress) -> list[Array]:
    """Responses piece by piece, in order."""
    kept: dict[int, Array] = {}

    def keep() -> Iterator[int]:
        for first, answers in _computed(sweep, workers, executor, sweep.pieces()):
            kept[first] = answers
            yield first

    for _ in progress(keep(), len(sweep.pieces())):
        pass
    return [kept[first] for first in sorted(kept)]


def _on_disk(chunks: Chunks, workers: int | None, executor: Executor | None, resume: bool, progress: Progress) -> Chunks:
    """The same, kept in a folder; only what is missing there is computed."""
    try:
        chunks.open(resume)
        missing = chunks.missing
        for _ in progress(chunks.keep(_computed(chunks.sweep, workers, executor, missing)), len(missing)):
            pass
    except BaseException:
        chunks.give_up()
        raise
    return chunks
