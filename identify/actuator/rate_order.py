"""How far the asymptotes really follow the rate: the order of their polynomials, judged by frequencies left out of the fit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.actuator.loops_alone import problem_of_loops, solve_loops
from identify.actuator.rates_and_strokes import groups_of_rate, rates_of
from identify.criteria import OWN_SHARE, WORTH_AN_ORDER
from identify.estimation.covariance import own_shares
from identify.estimation.least_squares import laid_out
from identify.estimation.parameters import Change
from identify.estimation.problem import Fit, Problem
from identify.estimation.rate import Abscissa
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from simulate.effects import HubInertia
from simulate.model.effect import Effect

PAPERS_ORDER = 2


@dataclass(frozen=True)
class RateOrder:
    """Error on frequencies left out, in parts of the force range, by order; the order to take; and the paper's polynomials.

    papers : coefficients of order 2 by name, lowest power first, fitted to all loops whatever order is taken; None with fewer than
    three frequencies. imitated : parameters of effects that polynomials of order 2 can imitate, as slopes in the frequency
    squared do a hub's inertia. inertia : error on frequencies left out and mass in kg of a fit with a hub's inertia instead of
    polynomials; None where one is fitted already, or with fewer than three frequencies.
    """

    left_out: dict[int, float]
    chosen: int
    papers: dict[str, tuple[float, ...]] | None
    imitated: tuple[str, ...] = ()
    inertia: tuple[float, float] | None = None

    @property
    def is_inertia(self) -> bool:
        """Whether the loops turn as a mass turns them: its one number predicts frequencies left out better than any polynomial does."""
        of_polynomials = [error for order, error in self.left_out.items() if order]
        return bool(self.inertia and of_polynomials and self.inertia[0] * (1.0 + WORTH_AN_ORDER) < min(self.left_out.values()))

    @property
    def inertia_row(self) -> dict[str, float | bool] | None:
        """The inertia as the JSON of a fit gives it."""
        if self.inertia is None:
            return None
        return {"mass_kg": self.inertia[1], "left_out_nrmse_percent": 100.0 * self.inertia[0], "turns_the_loops": self.is_inertia}

    def sentences(self, taken: int) -> list[str]:
        """The orders with their errors, and the paper's polynomials, for people."""
        listed = ", ".join(f"order {order}: {100 * error:.2f} %" for order, error in self.left_out.items())
        untold = [str(order) for order in range(PAPERS_ORDER + 1) if order not in self.left_out]
        tail = f"; too few frequencies to judge order {' and '.join(untold)}" if untold else ""
        said = [f"error on frequencies left out of the fit: {listed or 'none'}{tail}; order {taken} is taken"]
        said += [_inertia_sentence(*self.inertia)] if self.inertia and self.is_inertia else []
        if self.papers is None:
            return [*said, "the paper's polynomials of order 2 want three frequencies"]
        shown = ("{} = {:.5g} {:+.3g} x {:+.3g} x^2".format(name, *row) for name, row in self.papers.items())
        tail = f"; with them {', '.join(self.imitated)} cannot be told from the lines" if self.imitated else ""
        return [*said, f"the paper's polynomials of order 2: {', '.join(shown)}{tail}"]


def _inertia_sentence(error: float, mass_kg: float) -> str:
    return (
        f"the loops turn with the square of the frequency, as an inertia turns them: {mass_kg:.4g} kg at the hub predict frequencies left "
        f"out to {100 * error:.2f} %. Give --effect hub-inertia instead of --rate: it acts on the acceleration, and the same polynomials "
        "in a deployment are a force that follows the speed"
    )


def choose_order(
    loops: Sequence[LoopData],
    kinds: tuple[type[Effect], ...],
    abscissa: Abscissa,
    changes: Sequence[Change] = (),
    watch: Callable[[int], object] = lambda _: None,
) -> RateOrder:
    """Fit without each frequency in turn, predict it, and take the lowest order that predicts about as well as any.

    Parameters
    ----------
    changes : parameters that are held, bounded, or begin elsewhere.
    watch : called after every fit with how many have been made.

    With fewer than three frequencies nothing can be left out, and order 0 is taken.
    """
    groups = groups_of_rate(rates_of(loops, abscissa))
    left_out: dict[int, float] = {}
    fit, flat, papers, imitated = None, None, None, ()
    for order in range(min(PAPERS_ORDER, len(groups) - 1) + 1):
        fit = _whole(problem_of_loops(loops, kinds, abscissa, order, changes=changes), fit)
        flat = flat or fit
        if order == PAPERS_ORDER:
            papers, imitated = fit.problem.polynomials_at(fit.q), _imitated(fit)
        if order <= len(groups) - 2:
            parts = [r for group in groups for r in _predicted(fit, group)]
            left_out[order] = float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))
            watch((order + 1) * len(groups))
    if not left_out:
        return RateOrder({}, 0, papers, imitated)
    best = min(left_out.values())
    chosen = next(order for order, error in left_out.items() if error <= (1.0 + WORTH_AN_ORDER) * best)
    return RateOrder(left_out, chosen, papers, imitated, _with_inertia(loops, kinds, groups, changes, flat))


def _with_inertia(
    loops: Sequence[LoopData], kinds: tuple[type[Effect], ...], groups: list[list[int]], changes: Sequence[Change], flat: Fit | None
) -> tuple[float, float] | None:
    """Error on frequencies left out and mass of a fit with a hub's inertia and no polynomials, begun from that without either."""
    if len(groups) < PAPERS_ORDER + 1 or any(kind.leg_mass is not None for kind in kinds):
        return None
    fit = _whole(problem_of_loops(loops, (*kinds, HubInertia), changes=changes), flat)
    parts = [r for group in groups for r in _predicted(fit, group)]
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2))), fit.value(f"{HubInertia.name}.mass_kg")


def _whole(problem: Problem, lower: Fit | None) -> Fit:
    """The fit to all loops, begun from that of one order less."""
    return solve_loops(problem, None if lower is None else laid_out(lower, problem))


def _imitated(fit: Fit) -> tuple[str, ...]:
    """Parameters of effects that the polynomials can imitate."""
    own, first = own_shares(fit.jacobian), fit.problem.first_effect
    return tuple(parameter.name for k, parameter in enumerate(fit.problem.parameters) if k >= first and own[k] < OWN_SHARE)


def _predicted(fit: Fit, group: list[int]) -> list[Array]:
    """Residuals of the loops of one frequency under a fit of all the others, in parts of their force range.

    The fit begins from that to all loops, which is near, and so takes a few steps.
    """
    whole = fit.problem
    ours = [tuple(loop for k, loop in enumerate(whole.loops) if (k in group) == left_out) for left_out in (True, False)]
    here, others = (replace(whole, loops=loops) for loops in ours)
    found = solve_loops(others, laid_out(fit, others))
    there = replace(found, problem=here, q=laid_out(found, here))
    return [left / loop.data.force_range_N for left, loop in zip(there.residuals_N, here.loops, strict=True)]
