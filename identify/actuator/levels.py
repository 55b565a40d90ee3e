"""Force levels: a load cell's zero says nothing about an actuator, so a fit of loops is made without them, and they are put back behind it.

A constant that is added to the force of a file then changes nothing but the level that is reported.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.estimation.parameters import Change
from identify.estimation.problem import Fit
from identify.loops.loop_data import LoopData, predict
from measure.common.arrays import Array
from simulate.model.effect import Effect

_LEVELS = ("b_l_N", "b_u_N")
_SAME = 1e-9  # of a level


@dataclass(frozen=True)
class Levels:
    """What is taken off the force of each loop before a fit, (loops,) N, and the mean that is put back, N. own : each loop has its zero."""

    of_loops_N: Array
    mean_N: float
    own: bool

    def without(self, loops: Sequence[LoopData]) -> tuple[LoopData, ...]:
        """The loops about a force of zero."""
        return tuple(replace(d, force_N=d.force_N - level) for d, level in zip(loops, self.of_loops_N, strict=True))

    def changes_without(self, changes: Sequence[Change], sign: float = -1.0) -> tuple[Change, ...]:
        """What a user wants of the levels, counted from the mean one."""
        return tuple(_moved(change, sign * self.mean_N) if change.name in _LEVELS else change for change in changes)

    def put_back(self, fit: Fit, changes: Sequence[Change]) -> Fit:
        """The same fit with levels as they were measured; parameters, gaps and slopes are the same numbers."""
        law = fit.problem.model.actuator
        raised = replace(law, b_l_N=law.b_l_N + self.mean_N, b_u_N=law.b_u_N + self.mean_N)  # type: ignore[operator]
        model = replace(fit.problem.model, actuator=raised)
        loops = tuple(
            replace(run, model=model, data=replace(run.data, force_N=run.data.force_N + self.mean_N)) for run in fit.problem.loops
        )
        return replace(fit, problem=replace(fit.problem, model=model, loops=loops, changes=tuple(changes)))


def levels_of(loops: Sequence[LoopData], kinds: Sequence[type[Effect]], *, own: bool) -> Levels:
    """The mean force of each loop's samples that count, or of all where they have one zero.

    Where an effect acts on the level itself, only the differences between loops are taken off.
    """
    means = np.array([_mean_force(data) for data in loops])
    means = means if own else np.full(len(loops), means.mean())
    mean = float(means.mean())
    return Levels(means, mean, own) if all(_is_free_of_level(kind, loops[0]) for kind in kinds) else Levels(means - mean, 0.0, own)


def _mean_force(data: LoopData) -> float:
    counted = np.zeros(len(data.force_N), dtype=bool)
    for a, b in data.cycles.spans:
        counted[a:b] = True
    counted &= data.used
    return float(data.force_N[counted if np.any(counted) else data.used].mean())


def _is_free_of_level(kind: type[Effect], data: LoopData) -> bool:
    """Whether a force that is higher by a constant is shown higher by that constant, with this effect at a noticeable size."""
    effect = kind().with_flat(np.clip(kind.typical(), *np.array(list(kind.bounds().values())).T))
    height, stroke = data.force_range_N, float(np.ptp(data.elongation_m))
    lines = np.array([0.0, -height / 2.0, 0.0, height / 2.0, 10.0 / stroke])
    raised = lines + np.array([0.0, height, 0.0, height, 0.0])
    change = predict(raised, data, height, (effect,)) - predict(lines, data, 0.0, (effect,))
    return bool(np.max(np.abs(change - height)) < _SAME * height)


def _moved(change: Change, by_N: float) -> Change:
    return replace(change, **{key: None if at is None else at + by_N for key in ("value", "low", "high") for at in [getattr(change, key)]})


def drift_significance(fit: Fit) -> float:
    """Root mean square of the drifts of the loops, in their standard errors."""
    names = [f"{run.run.label}.drift_N_per_s" for run in fit.problem.loops]
    return float(np.sqrt(np.mean([(fit.value(name) / max(fit.stderr(name), 1e-300)) ** 2 for name in names])))
