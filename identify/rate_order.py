"""How far the asymptotes really follow the rate: the order of their polynomials, judged by frequencies left out of the fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from measure.tables import Array
from simulate.effect import Effect

from .loop_problem import LoopProblem, beta_bounds, minimise
from .loops import LoopData, gap
from .parameters import DISTINCT, Abscissa, abscissa_of, distinct, layout

PAPERS_ORDER = 2
_WORTH_AN_ORDER = 0.03  # relative gain in left-out error that justifies one order more


@dataclass(frozen=True)
class RateOrder:
    """Error on frequencies left out, in parts of the force range, by order; and the order to take."""

    left_out: dict[int, float]
    chosen: int

    @property
    def sentence(self) -> str:
        """The orders with their errors, for people."""
        listed = ", ".join(f"order {order}: {100 * error:.2f} %" for order, error in self.left_out.items())
        return f"error on frequencies left out of the fit: {listed}; order {self.chosen} is taken"


def choose_order(
    loops: Sequence[LoopData], kinds: tuple[type[Effect], ...], abscissa: Abscissa, watch: Callable[[int], object] = lambda _: None
) -> RateOrder:
    """Fit without each frequency in turn, predict it, and take the lowest order that predicts about as well as any.

    Parameters
    ----------
    watch : told after every fit how many have been made.

    With fewer than three frequencies nothing can be left out, and order 0 is taken.
    """
    x = abscissa_of(loops, abscissa)
    groups = _groups(x)
    most = min(PAPERS_ORDER, len(groups) - 2)
    left_out: dict[int, float] = {}
    made = 0
    for order in range(most + 1):
        parts = []
        for group in groups:
            parts += _predicted(loops, x, group, kinds, abscissa, order)
            made += 1
            watch(made)
        left_out[order] = float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
    if not left_out:
        return RateOrder({}, 0)
    best = min(left_out.values())
    return RateOrder(left_out, next(order for order, error in left_out.items() if error <= (1.0 + _WORTH_AN_ORDER) * best))


def _groups(x: Array) -> list[list[int]]:
    """Loops of one frequency together, in rising order."""
    order = np.argsort(x)
    groups: list[list[int]] = [[int(order[0])]]
    for k in order[1:]:
        if x[k] - x[groups[-1][-1]] > DISTINCT * abs(x[k]):
            groups.append([])
        groups[-1].append(int(k))
    assert len(groups) == distinct(x)
    return groups


def _predicted(
    loops: Sequence[LoopData], x: Array, group: list[int], kinds: tuple[type[Effect], ...], abscissa: Abscissa, order: int
) -> list[Array]:
    """Residuals of the loops of one frequency under a fit of all the others, in parts of their force range."""
    others = tuple(data for k, data in enumerate(loops) if k not in group)
    shape = layout(others, kinds, abscissa, order)
    theta, _ = minimise(LoopProblem(shape, others, False, beta_bounds(others)))
    effects = shape.effects(theta)
    return [gap(shape.lines_at(theta, float(x[k])), loops[k], effects) / loops[k].force_range_N for k in group]
