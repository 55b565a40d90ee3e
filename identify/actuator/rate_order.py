"""How far the asymptotes really follow the rate: the order of their polynomials, judged by frequencies left out of the fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.actuator.layout import (
    DISTINCT,
    LINE_NAMES,
    Abscissa,
    Layout,
    abscissa_of,
    distinct,
    layout,
)
from identify.actuator.loop_problem import LoopProblem, beta_bounds, minimise
from identify.estimation.covariance import OWN_SHARE, own_shares
from identify.loops.loop_data import LoopData, gap
from measure.common.arrays import Array
from simulate.model.effect import Effect

PAPERS_ORDER = 2
_WORTH_AN_ORDER = 0.03  # relative gain in left-out error that justifies one order more


@dataclass(frozen=True)
class RateOrder:
    """Error on frequencies left out, in parts of the force range, by order; the order to take; and the paper's polynomials.

    papers : coefficients of order 2 by name, lowest power first, fitted to all loops whatever order is taken; None with fewer than
    three frequencies. imitated : parameters of effects that polynomials of order 2 can imitate, as slopes in the frequency
    squared do a hub's inertia.
    """

    left_out: dict[int, float]
    chosen: int
    papers: dict[str, tuple[float, ...]] | None
    imitated: tuple[str, ...] = ()

    def sentences(self, taken: int) -> list[str]:
        """The orders with their errors, and the paper's polynomials, for people."""
        listed = ", ".join(f"order {order}: {100 * error:.2f} %" for order, error in self.left_out.items())
        untold = [str(order) for order in range(PAPERS_ORDER + 1) if order not in self.left_out]
        tail = f"; too few frequencies to judge order {' and '.join(untold)}" if untold else ""
        said = [f"error on frequencies left out of the fit: {listed or 'none'}{tail}; order {taken} is taken"]
        if self.papers is None:
            return [*said, "the paper's polynomials of order 2 want three frequencies"]
        shown = ("{} = {:.5g} {:+.3g} x {:+.3g} x^2".format(name, *row) for name, row in self.papers.items())
        tail = f"; with them {', '.join(self.imitated)} cannot be told from the lines" if self.imitated else ""
        return [*said, f"the paper's polynomials of order 2: {', '.join(shown)}{tail}"]


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
    left_out: dict[int, float] = {}
    shape = layout(loops, kinds, abscissa, 0)
    theta, papers, imitated = None, None, ()
    for order in range(min(PAPERS_ORDER, len(groups) - 1) + 1):
        shape, theta = _whole(loops, kinds, abscissa, order, theta)
        if order == PAPERS_ORDER:
            papers, imitated = shape.polynomials(theta), _imitated(loops, shape, theta)
        if order <= len(groups) - 2:
            parts = [r for group in groups for r in _predicted(loops, x, group, shape, theta)]
            left_out[order] = float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
            watch((order + 1) * len(groups))
    if not left_out:
        return RateOrder({}, 0, papers, imitated)
    best = min(left_out.values())
    chosen = next(order for order, error in left_out.items() if error <= (1.0 + _WORTH_AN_ORDER) * best)
    return RateOrder(left_out, chosen, papers, imitated)


def _whole(
    loops: Sequence[LoopData], kinds: tuple[type[Effect], ...], abscissa: Abscissa, order: int, lower: Array | None
) -> tuple[Layout, Array]:
    """The fit to all loops, begun from that of one order less."""
    shape = layout(loops, kinds, abscissa, order)
    start = None
    if lower is not None:
        lines = np.pad(lower[: 4 * order].reshape(4, order), ((0, 0), (0, 1)))
        start = np.concatenate([lines.ravel(), lower[4 * order :]])
    theta, _ = minimise(LoopProblem(shape, tuple(loops), False, beta_bounds(loops)), start, roughly=True)
    return shape, theta


def _imitated(loops: Sequence[LoopData], shape: Layout, theta: Array) -> tuple[str, ...]:
    own = own_shares([LoopProblem(shape, tuple(loops), False, beta_bounds(loops)).jacobian(theta)])
    named = enumerate(shape.names()[len(LINE_NAMES) + 1 :], start=shape.line_values + 1)
    return tuple(name for place, name in named if own[place] < OWN_SHARE)


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


def _predicted(loops: Sequence[LoopData], x: Array, group: list[int], whole: Layout, theta: Array) -> list[Array]:
    """Residuals of the loops of one frequency under a fit of all the others, in parts of their force range.

    The fit begins from that to all loops, which is near, and so takes a few steps.
    """
    kept = [k for k in range(len(loops)) if k not in group]
    shape, others = replace(whole, z=whole.z[kept]), tuple(loops[k] for k in kept)
    theta, _ = minimise(LoopProblem(shape, others, False, beta_bounds(others)), theta, roughly=True)
    effects = shape.effects(theta)
    return [gap(shape.lines_at(theta, float(x[k])), loops[k], effects) / loops[k].force_range_N for k in group]
