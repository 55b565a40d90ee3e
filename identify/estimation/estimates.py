"""What a fit knows of each parameter: value, standard error, 95 % interval, and whether the data determine it at all."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.criteria import BETA_PARABOLA, INERTIA_APART, ON_ASYMPTOTE, OPEN_BETA, OWN_SHARE, TWO_SIDED_95
from identify.estimation.covariance import own_shares
from identify.estimation.parameters import BETA_NAME, LINE_NAMES, Estimate, Word
from identify.estimation.problem import Fit
from identify.estimation.profile_likelihood import Profile
from identify.loops.corners import SIDE
from identify.loops.loop_data import LoopData, acceleration_apart, centre_of
from identify.noise.effective_number import effective_number
from measure.common.arrays import Array


def estimates_of(fit: Fit) -> dict[str, Estimate]:
    """Force law, effects and covariate of a fit by their names; nuisance parameters are left out.

    The interval is Student's with the effective degrees of freedom. That of beta is one of its logarithm; an error of the turning
    points adds to the length 1 / beta, so that the interval may have no end above. A beta with which the force is on its asymptote
    again by the second sample behind a reversal is not determined, nor is an inertia where the acceleration follows the elongation.
    """
    from scipy.stats import t as student

    knowledge = _Knowledge(fit)
    reach = float(student.ppf(0.975, max(degrees_of_freedom(fit), 2.0)))
    made = {}
    for name in fit.problem.reported:
        value, error = fit.value(name), fit.stderr(name)
        ends = knowledge.beta_interval(reach) if name == BETA_NAME else (value - reach * error, value + reach * error)
        made[name] = Estimate(value, error, ends, knowledge.word(name))
    return made


def degrees_of_freedom(fit: Fit) -> float:
    """Effective number of samples of all blocks, minus the parameters that they have to tell."""
    independent = sum(effective_number(fit.gaps[block.rows]) for block in fit.problem.blocks if block.rows.stop > block.rows.start)
    return independent - float(np.count_nonzero(np.any(fit.jacobian[: fit.problem.measured] != 0.0, axis=0)))


class _Knowledge:
    """What the signatures of a fit say about its parameters."""

    def __init__(self, fit: Fit) -> None:
        self.fit, self.problem = fit, fit.problem

    @cached_property
    def shares(self) -> Array:
        """Own share of each parameter's signature; levels are taken in the middle of the elongations, where slopes do not move them."""
        return own_shares(self.centred)

    @cached_property
    def centred(self) -> Array:
        """The Jacobian with each slope turned about the middle of the elongations."""
        table = self.fit.jacobian.copy()
        if self.problem.loops:
            turn, scales = centre_of([loop.data for loop in self.problem.loops]), self.problem.scales
            for slope, level in self._pairs():
                table[:, slope] -= turn * scales[slope] / scales[level] * table[:, level]
        return table

    def _pairs(self) -> list[tuple[int, int]]:
        """Places of each slope and the level beside it, constant and of every order of the rate."""
        order, first = self.problem.rate.order, self.problem.first_rate
        return [(0, 1), (2, 3), *((first + side + j, first + side + order + j) for side in (0, 2 * order) for j in range(order))]

    def word(self, name: str) -> Word:
        """Whether a parameter is known."""
        index = self.problem.index_of(name)
        if self.problem.held[index]:
            return "ok"
        clear = bool(self.fit.clear_of_bounds[index])
        if name in LINE_NAMES:
            return "not-identifiable" if self.shares[self._group(index)].min() < OWN_SHARE else "ok" if clear else "at-bound"
        if name == BETA_NAME:
            return "at-bound" if not clear else "not-identifiable" if self._beta_unknown else "ok"
        return "not-identifiable" if self._own(index) < OWN_SHARE else "ok" if clear else "at-bound"

    def _group(self, line: int) -> list[int]:
        """A slope with its coefficients of the rate; a level with those of its slope as well."""
        order, first = self.problem.rate.order, self.problem.first_rate
        lines = [line] if line % 2 == 0 else [line - 1, line]
        return [*lines, *(first + side * order + j for side in lines for j in range(order))]

    def _own(self, index: int) -> float:
        """Own share of an effect's parameter; in loops also away from sharp turns, and of an inertia only where accelerations differ."""
        own = float(self.shares[index])
        if self.problem.films or not self.problem.loops:
            return own
        own = min(own, float(self._shares_away[index]))
        return own if acceleration_apart(self._data) > INERTIA_APART or not self._is_inertia(index) else 0.0

    def _is_inertia(self, index: int) -> bool:
        masses = [effect.leg_mass is not None for effect in self.problem.effects for _ in effect.flat_names()]
        return index >= self.problem.first_effect and masses[index - self.problem.first_effect]

    @cached_property
    def _shares_away(self) -> Array:
        return own_shares(self.centred[away_from_turns(self.fit)])

    @property
    def _data(self) -> list[LoopData]:
        return [loop.data for loop in self.problem.loops]

    def beta_interval(self, reach: float) -> tuple[float, float]:
        """`reach` standard deviations to each side of beta; without an end above where 1 / beta may be nothing."""
        beta, error = self.fit.value(BETA_NAME), self._log_error
        turns, noise = reach * self._log_turns, reach * np.sqrt(max(error**2 - self._log_turns**2, 0.0))
        up = np.hypot(noise, -np.log1p(-turns)) if turns < 1.0 else np.inf
        return beta * float(np.exp(-min(np.hypot(noise, np.log1p(turns)), 50.0))), beta * float(np.exp(min(up, 50.0)))

    @cached_property
    def _log_error(self) -> float:
        return self.fit.stderr(BETA_NAME) / self.fit.value(BETA_NAME)

    @cached_property
    def _log_turns(self) -> float:
        """The part of the standard deviation of log beta that comes from the turning points."""
        index = self.problem.index_of(BETA_NAME)
        return abs(float(self.fit.of_turns[index])) * self.problem.parameters[index].scale / self.problem.parameters[index].start

    @cached_property
    def _beta_unknown(self) -> bool:
        if not self.problem.loops or self.problem.films:
            return self.shares[self.problem.index_of(BETA_NAME)] < OWN_SHARE
        sooner = self.fit.value(BETA_NAME) * min(data.finest_way_m for data in self._data) > ON_ASYMPTOTE
        return sooner or self._log_turns >= 1.0 / TWO_SIDED_95 or is_open(self.fit, self._log_error)


def is_open(fit: Fit, error: float) -> bool:
    """Whether a beta twenty times larger or smaller would fit these loops nearly as well, within three standard deviations.

    Not asked where the covariance knows beta to 15 %: there a parabola is near enough.

    Parameters
    ----------
    error : one standard deviation of log beta by the covariance.
    """
    sure, unsure = BETA_PARABOLA
    if not sure < error < unsure:
        return error >= unsure
    index = fit.problem.index_of(BETA_NAME)
    beta, profile = fit.problem.parameters[index], Profile(fit, index)
    one = beta.start / beta.scale  # of log beta, in scales
    near, far = ([profile.rise(float(fit.q[index]) + sign * way * one) for sign in (-1.0, 1.0)] for way in (error, OPEN_BETA))
    return min(far) < 9.0 * float(np.mean(near))


def away_from_turns(fit: Fit) -> NDArray[np.bool_]:
    """The rows (m,) without the samples beside a reversal, where a motion that turns sharply is not known; half of a stroke stays.

    A viscous friction in triangles of one speed, for one, differs from a greater height of the loop in these samples alone.
    """
    kept = np.ones(len(fit.gaps), dtype=bool)
    blocks = [block for block in fit.problem.blocks if block.channel == "force_N"]
    for block, loop in zip(blocks, fit.problem.loops, strict=True):
        far, turns = np.ones(len(loop.data.force_N), dtype=bool), loop.data.cycles.reversals
        for turn in turns:
            beside = min([SIDE, *(abs(other - turn) // 4 for other in turns if other != turn)])
            far[max(turn - beside, 0) : turn + beside + 1] = False
        kept[block.rows] = far[loop.data.used]
    return kept
