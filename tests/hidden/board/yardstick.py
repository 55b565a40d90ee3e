"""How much of an effect a case's runs show: what no force law, release, camera or laser can follow.

    shows(effect) = min over x of |y(effect, x) - y(nothing, 0)|^2 + |x|^2

y all measured values over their noise, x everything that is free, each in its spread. A straight line around the truth would not do:
behind the stops the platform follows a release in curves, and what such a line leaves over would count as seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .bench import Bench
from .detectable import Free, Variant, free_of
from .freedom import FreeParameter, columns, free_parameters, moved, shown_besides
from .shapes import Hidden

Array = np.ndarray

_NUDGE = 1e-3
_MOST_STEPS, _HALVINGS, _SETTLED = 8, 4, 0.01


@dataclass(frozen=True)
class Yardstick:
    """The generator's own view of a case, laid around the truth with nothing hidden."""

    bench: Bench

    @cached_property
    def parameters(self) -> list[FreeParameter]:
        """What moves the simulated runs, in spreads."""
        return free_parameters(self.bench)

    @cached_property
    def besides(self) -> Array:
        """What cameras add by themselves, (m, k)."""
        return shown_besides(self.bench)

    @cached_property
    def free(self) -> Free:
        """All that is free, along straight lines, with its priors as further rows."""
        return free_of(self._with_priors(np.hstack([columns(self.bench, self.parameters), self.besides])))

    def left(self, hidden: Hidden, amount: float) -> Array:
        """What an effect of this amount shows however all that is free bends, with the priors' rows behind, (m + n + k,)."""
        return self.left_by(self.bench.with_model(self.bench.rig.true.with_effect(hidden.at(amount))))

    def left_by(self, bench: Bench) -> Array:
        """What the same runs of another truth show however all that is free bends, with the priors' rows behind, (m + n + k,).

        By Gauss and Newton, each step from new straight lines, for as long as they lead down.
        """
        x = np.zeros(len(self.parameters) + self.besides.shape[1])
        best = self._left(bench, x)
        for _ in range(_MOST_STEPS):
            at = moved(bench, self.parameters, x[: len(self.parameters)])
            lines = self._with_priors(np.hstack([columns(at, self.parameters), self.besides]))
            step = np.linalg.lstsq(lines, -best, rcond=1e-12)[0]
            tried = ((x + step / 2**i, self._left(bench, x + step / 2**i)) for i in range(_HALVINGS))
            further, found = next(((y, left) for y, left in tried if left @ left < best @ best), (x, best))
            settled = found @ found > (1.0 - _SETTLED) * (best @ best)
            x, best = further, found
            if settled:
                break
        return best

    def _left(self, bench: Bench, x: Array) -> Array:
        own = len(self.parameters)
        return np.concatenate([moved(bench, self.parameters, x[:own]).here - self.bench.here + self.besides @ x[own:], x])

    def change(self, hidden: Hidden, amount: float) -> Array:
        """The same, freed of the straight lines around the truth too, so that it can be compared with rivals."""
        return self.free.left(self.left(hidden, amount))

    def variants(self, lines: Sequence[tuple[Hidden, ...]]) -> list[Variant]:
        """Rivals, shape by shape, each amount changed by a thousandth of a noticeable size (a play of the legs by all of it)."""
        flat = [hidden for group in lines for hidden in group]
        vectors = iter(self.bench.vectors([self.bench.rig.true.with_effect(hidden.at(_small(hidden))) for hidden in flat]))
        made = []
        for group in lines:
            freed = [self._freed(next(vectors) - self.bench.here) / _small(hidden) for hidden in group]
            low, high = np.array([_ends(hidden) for hidden in group]).T
            made.append(Variant(group[0].name, group[0].parameters, np.stack(freed, axis=1), np.minimum(low, 0.0), np.maximum(high, 0.0)))
        return made

    def _freed(self, change: Array) -> Array:
        return self.free.left(np.concatenate([change, np.zeros(len(self.free.basis) - len(change))]))

    def _with_priors(self, straight: Array) -> Array:
        return np.vstack([straight, np.eye(straight.shape[1])])


def _small(hidden: Hidden) -> float:
    return 1.0 if hidden.name == "backlash" else _NUDGE


def _ends(hidden: Hidden) -> tuple[float, float]:
    """How far an amount may go down and up; half a turn later a wave is its own opposite."""
    if hidden.name == "base-excitation":
        return -hidden.most, hidden.most
    return -replace(hidden, direction=-hidden.direction).most, hidden.most
