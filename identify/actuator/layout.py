"""Which numbers a fit of loops is free to choose, and what they are called in a model file.

The fit works with levels at the middle of the elongation instead of intercepts, and with the logarithm of beta: the
centred lines hardly depend on each other, and beta is known, if at all, to a factor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.loops.loop_data import LoopData
from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from simulate.model.effect import Effect

Abscissa = Literal["none", "frequency_Hz", "speed_m_per_s"]

LINE_NAMES = ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N")
BETA_NAME = "beta_per_m"
SAME_STROKE = 0.05  # relative difference of amplitudes that count as one
DISTINCT = 0.02  # frequencies closer than this, relatively, are one frequency


@dataclass(frozen=True)
class Layout:
    """The vector of a fit: polynomials of a_l, level_l, a_u, level_u, then log beta, then the effects' parameters,
    then the covariate's coefficient.

    kinds : effects fitted jointly. centre_m : elongation at which levels are taken. order : of the polynomials in the
    abscissa; zero where there is none. middle, half : the abscissa's scaling, z = (x - middle) / half. z : of each loop.
    covariate : name of the column a part of the force is proportional to, or nothing; reference : its mean over all loops.
    """

    kinds: tuple[type[Effect], ...]
    centre_m: float
    abscissa: Abscissa
    order: int
    middle: float
    half: float
    z: Array
    covariate: str = ""
    reference: float = 0.0

    @property
    def line_values(self) -> int:
        """How many entries describe the four lines."""
        return 4 * (self.order + 1)

    def lines(self, theta: Array, loop: int) -> Array:
        """a_l, b_l, a_u, b_u, beta of one loop."""
        return self._lines_at(theta, float(self.z[loop]))

    def lines_at(self, theta: Array, x: float) -> Array:
        """a_l, b_l, a_u, b_u, beta at a value of the abscissa."""
        return self._lines_at(theta, (x - self.middle) / self.half)

    def middle_lines(self, theta: Array) -> Array:
        """a_l, b_l, a_u, b_u, beta in the middle of the abscissa."""
        return self._lines_at(theta, 0.0)

    def _lines_at(self, theta: Array, z: float) -> Array:
        lower, level_l, upper, level_u = theta[: self.line_values].reshape(4, -1) @ z ** np.arange(self.order + 1)
        beta = np.exp(theta[self.line_values])
        return np.array([lower, level_l - lower * self.centre_m, upper, level_u - upper * self.centre_m, beta])

    def effects(self, theta: Array) -> tuple[Effect, ...]:
        """The effects with the vector's parameters."""
        made, place = [], self.line_values + 1
        for kind in self.kinds:
            size = len(kind.flat_names())
            made.append(kind().with_flat(theta[place : place + size]))
            place += size
        return tuple(made)

    def covariate_force(self, theta: Array, data: LoopData) -> Array:
        """The part of the force of a loop that follows the covariate, N, (n,)."""
        return theta[-1] * (data.other[self.covariate] - self.reference)

    def names(self) -> list[str]:
        """Names of `values`, as in a model file; effects as `name.parameter`, the covariate's newtons per unit behind them."""
        effects = [f"{kind.name}.{key}" for kind in self.kinds for key in kind.flat_names()]
        return [*LINE_NAMES, BETA_NAME, *effects, *([f"N_per_unit.{self.covariate}"] if self.covariate else [])]

    def values(self, theta: Array) -> Array:
        """The numbers a model file wants, lines taken in the middle of the abscissa."""
        return np.concatenate([self.middle_lines(theta), theta[self.line_values + 1 :]])

    def slopes(self, theta: Array) -> Array:
        """Derivative of `values` with respect to the vector, for the covariance."""
        m, extra = self.order + 1, len(theta) - self.line_values - 1
        table = np.zeros((5 + extra, len(theta)))
        for row, column in enumerate(range(0, 4 * m, m)):
            table[row, column] = 1.0
        table[1, 0] = table[3, 2 * m] = -self.centre_m
        table[4, 4 * m] = np.exp(theta[4 * m])
        table[5:, 4 * m + 1 :] = np.eye(extra)
        return table

    def polynomials(self, theta: Array) -> dict[str, tuple[float, ...]]:
        """Coefficients of a_l, b_l, a_u, b_u in the abscissa itself, lowest power first."""
        scaled = theta[: self.line_values].reshape(4, -1).copy()
        scaled[1] -= scaled[0] * self.centre_m
        scaled[3] -= scaled[2] * self.centre_m
        shift = np.polynomial.Polynomial([-self.middle / self.half, 1.0 / self.half])
        rows = [np.polynomial.Polynomial(row)(shift).coef for row in scaled]
        return {key: tuple(float(c) for c in row) for key, row in zip(("a_l", "b_l", "a_u", "b_u"), rows, strict=True)}


def layout(
    loops: Sequence[LoopData], kinds: tuple[type[Effect], ...] = (), abscissa: Abscissa = "none", order: int = 0, covariate: str = ""
) -> Layout:
    """The vector that suits these loops.

    Raises
    ------
    InputError
        An effect that no loop can show; fewer frequencies than the polynomials need; a loop without the covariate.
    """
    for kind in kinds:
        _require_visible(kind)
    everywhere = np.concatenate([d.elongation_m[d.used] for d in loops])
    centre = float((everywhere.min() + everywhere.max()) / 2.0)
    reference = _reference(loops, covariate)
    if abscissa == "none":
        return Layout(kinds, centre, "none", 0, 0.0, 1.0, np.zeros(len(loops)), covariate, reference)
    require_abscissa(loops, abscissa, order)
    x = abscissa_of(loops, abscissa)
    middle, half = float((x.min() + x.max()) / 2.0), float(np.ptp(x) / 2.0) or 1.0
    return Layout(kinds, centre, abscissa, order, middle, half, (x - middle) / half, covariate, reference)


def _reference(loops: Sequence[LoopData], covariate: str) -> float:
    if not covariate:
        return 0.0
    for data in loops:
        if covariate not in data.other:
            raise InputError(f'{data.name}: no column "{covariate}" of numbers for the covariate; {nearest(covariate, data.other)}')
    return float(np.mean(np.concatenate([d.other[covariate][d.used] for d in loops])))


def abscissa_of(loops: Sequence[LoopData], abscissa: Abscissa) -> Array:
    """Frequency, or speed in the middle of the stroke, of each loop."""
    return np.array([d.frequency_Hz if abscissa == "frequency_Hz" else d.mid_stroke_speed_m_per_s for d in loops])


def distinct(values: Array) -> int:
    """How many values there are, where values within two per cent count as one."""
    ordered = np.sort(values)
    return 1 + int(np.sum(np.diff(ordered) > DISTINCT * np.abs(ordered[1:])))


def strokes(loops: Sequence[LoopData]) -> list[list[LoopData]]:
    """Loops with a full cycle in groups of one amplitude, in rising order."""
    groups: list[list[LoopData]] = []
    for data in sorted(loops, key=lambda d: d.amplitude_m):
        if groups and data.amplitude_m < (1.0 + SAME_STROKE) * groups[-1][0].amplitude_m:
            groups[-1].append(data)
        else:
            groups.append([data])
    return groups


def by_stroke(loops: Sequence[LoopData]) -> list[int]:
    """Places of the largest group of loops of one stroke, by frequency; of all loops where no two have one."""
    return _largest(loops, "amplitude_m", "frequency_Hz", SAME_STROKE)


def by_frequency(loops: Sequence[LoopData]) -> list[int]:
    """Places of the largest group of loops of one frequency, by amplitude; of all loops where no two have one."""
    return _largest(loops, "frequency_Hz", "amplitude_m", DISTINCT)


def _largest(loops: Sequence[LoopData], alike: str, then: str, within: float) -> list[int]:
    known = [k for k, data in enumerate(loops) if np.isfinite(getattr(data, alike))]
    groups = [[j for j in known if abs(getattr(loops[j], alike) / getattr(loops[k], alike) - 1.0) <= within] for k in known]
    group = max(groups, key=len, default=[])
    chosen = group if len(group) > 1 else list(range(len(loops)))
    return sorted(chosen, key=lambda k: float(np.nan_to_num(getattr(loops[k], then))))


def visible(kind: type[Effect]) -> bool:
    """Whether an effect can show in a loop at all: it acts on a leg or on the load cell."""
    in_leg = any(getattr(kind, hook) is not None for hook in ("leg_force", "leg_mass", "leg_asymptotes"))
    return in_leg or kind.observe_force is not Effect.observe_force


def _require_visible(kind: type[Effect]) -> None:
    if not visible(kind):
        raise InputError(f'effect "{kind.name}" does not act on a single actuator, so no loop shows it; fit it to deployments.')


def require_abscissa(loops: Sequence[LoopData], abscissa: Abscissa, order: int) -> None:
    """Refuse polynomials that these loops cannot carry.

    Raises
    ------
    InputError
        A loop without a frequency; fewer frequencies than a polynomial of this order needs.
    """
    x = abscissa_of(loops, abscissa)
    for data, value in zip(loops, x, strict=True):
        if not np.isfinite(value):
            raise InputError(f"{data.name}: no full cycle, so no {abscissa}; leave the loop out or fit without --rate.")
    if distinct(x) < order + 1:
        raise InputError(
            f"{distinct(x)} different values of {abscissa} in these loops; a polynomial of order {order} needs {order + 1}. "
            f"Give --rate-order {distinct(x) - 1} or more loops."
        )
