"""The least-squares problem that loops pose: what is free, what is a nuisance, where to begin, and its solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identify.actuator.layout import Layout
from identify.loops.loop_data import LoopData, gap, gap_and_level
from measure.common.arrays import Array
from measure.common.errors import InputError

_BETAS = 12  # from which the best is taken to begin with
_STEP, _STEP_FROM = 1e-6, 1e-3  # of a difference, relative to a number of at least this size
_OUTLIER = 2.0  # robust standard deviations from which on a residual counts less, where asked for


@dataclass(frozen=True)
class LoopProblem:
    """What is free, the loops, whether each has a force level of its own, the bounds of beta, whether outliers count less."""

    shape: Layout
    loops: tuple[LoopData, ...]
    own_levels: bool
    beta: tuple[float, float]
    robust: bool = False

    def residuals(self, theta: Array) -> tuple[Array, ...]:
        """Measured minus modelled of each loop, the nuisances taken out; of the levels only their mean stays in."""
        left, levels = self._left(theta)
        mean = float(np.mean(levels))
        return tuple(r + mean for r in left)

    def tares(self, theta: Array) -> tuple[float, ...]:
        """What is taken off the force of each loop."""
        _, levels = self._left(theta)
        return tuple(float(x) for x in levels - levels.mean())

    def _left(self, theta: Array) -> tuple[list[Array], Array]:
        """What is left of each loop, and the level taken out of it, zero where all have one."""
        effects = self.shape.effects(theta)
        seen = enumerate(self._without_covariate(theta))
        if not self.own_levels:
            return [gap(self.shape.lines(theta, k), data, effects) for k, data in seen], np.zeros(len(self.loops))
        found = [gap_and_level(self.shape.lines(theta, k), data, effects) for k, data in seen]
        return [r for r, _ in found], np.array([level for _, level in found])

    def jacobian(self, theta: Array) -> Array:
        """Derivative of the residuals, all loops below each other, (n, p), by differences inside the bounds.

        A coefficient of order j acts on a loop through its lines only, z^j times as strongly as the constant one: four differences
        serve the polynomials of any order.
        """
        at, before = self._left(theta), self.bounds()[1]
        columns = []
        for place in self._differenced():
            step = _STEP * max(abs(theta[place]), _STEP_FROM)
            step = -step if theta[place] + step > before[place] else step
            moved = theta.copy()
            moved[place] += step
            after = self._left(moved)
            slopes = [(a - b) / step for a, b in zip(after[0], at[0], strict=True)], (after[1] - at[1]) / step
            orders = range(self.shape.order + 1) if place < self.shape.line_values else (0,)
            columns += [self._joined(*slopes, self.shape.z**j) for j in orders]
        return np.stack(columns, axis=1)

    def _differenced(self) -> list[int]:
        """Places of the vector that a difference is taken for: of each polynomial the constant one, and all behind the lines."""
        n = self.shape.line_values
        size = n + 1 + sum(len(kind.flat_names()) for kind in self.shape.kinds) + bool(self.shape.covariate)
        return [*range(0, n, self.shape.order + 1), *range(n, size)]

    @staticmethod
    def _joined(slopes: Sequence[Array], of_levels: Array, share: Array) -> Array:
        mean = float(np.mean(of_levels * share))
        return np.concatenate([slope * part + mean for slope, part in zip(slopes, share, strict=True)])

    def _without_covariate(self, theta: Array) -> tuple[LoopData, ...]:
        if not self.shape.covariate:
            return self.loops
        return tuple(replace(data, force_N=data.force_N - self.shape.covariate_force(theta, data)) for data in self.loops)

    def bounds(self) -> tuple[Array, Array]:
        """Lines and covariate are free; log beta and the effects keep to theirs."""
        limits = [limit for kind in self.shape.kinds for limit in kind.bounds().values()]
        before, behind = np.full(self.shape.line_values, np.inf), np.full(int(bool(self.shape.covariate)), np.inf)
        low = np.concatenate([-before, [np.log(self.beta[0])], [a for a, _ in limits], -behind])
        return low, np.concatenate([before, [np.log(self.beta[1])], [b for _, b in limits], behind])

    def free(self, theta: Array) -> NDArray[np.bool_]:
        """Which entries stand clear of their bounds."""
        low, high = self.bounds()
        width = np.where(np.isfinite(high - low), high - low, 0.0)
        return (theta - low > 1e-6 * width) & (high - theta > 1e-6 * width)

    def start(self) -> Array:
        """Where the fit begins: for each of a dozen betas the rest is a linear problem; the best one is taken."""
        low, high = np.log(self.beta)
        trials = [self._linear(float(x)) for x in np.linspace(low, high, _BETAS + 2)[1:-1]]
        theta, _ = min(trials, key=lambda trial: trial[1])
        return np.clip(theta, *self.bounds())

    def _linear(self, log_beta: float) -> tuple[Array, float]:
        """The vector with constant lines and no effects that fits best at a given beta, and its sum of squares."""
        m, n = self.shape.order + 1, self.shape.line_values
        off = np.concatenate([np.empty(0), *(kind().flat() for kind in self.shape.kinds)])
        theta = np.concatenate([np.zeros(n), [log_beta], off, np.zeros(int(bool(self.shape.covariate)))])
        places = [*range(0, n, m), *range(n + 1 + len(off), len(theta))]
        at_zero = np.concatenate(self.residuals(theta))
        columns = np.stack([at_zero - np.concatenate(self.residuals(theta + unit)) for unit in np.eye(len(theta))[places]], axis=1)
        length = np.sqrt(np.sum(columns**2, axis=0)) + 1e-300
        scaled = columns / length
        values = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ at_zero, rcond=1e-12)[0] / length
        left = at_zero - columns @ values
        theta[places] = values
        theta[n + 1 : n + 1 + len(off)] = np.concatenate([np.empty(0), *(kind.typical() for kind in self.shape.kinds)])
        return theta, float(left @ left)


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


def beta_bounds(loops: Sequence[LoopData]) -> tuple[float, float]:
    """Between which betas these loops can tell anything, 1/m.

    Below, the force would not come near an asymptote within the longest stroke; above, it would be there before the
    elongation's noise, or a fiftieth of a sample's way, has passed.
    """
    stroke = max(float(np.ptp(d.elongation_m[d.used])) for d in loops)
    finest = min(max(d.elongation_sigma_m, float(np.median(np.abs(np.diff(d.elongation_m[d.used])))) / 50.0) for d in loops)
    return 0.3 / stroke, max(3.0 / max(finest, 1e-9 * stroke), 100.0 / stroke)


def minimise(problem: LoopProblem, start: Array | None = None, *, roughly: bool = False) -> tuple[Array, bool]:
    """Least squares by lmfit; the vector, and whether it has converged.

    Parameters
    ----------
    start : where to begin; found where not given.
    roughly : stop where a step gains less than a millionth of the sum of squares: enough for a prediction, not for a result.
    """
    import lmfit

    low, high = problem.bounds()
    begin = problem.start() if start is None else np.clip(start, low, high)
    names = [f"p{k}" for k in range(len(begin))]
    parameters = lmfit.Parameters()
    for name, value, least, most in zip(names, begin, low, high, strict=True):
        parameters.add(name, value=float(value), min=float(least), max=float(most))

    def residual(trial: Any) -> Array:
        return np.concatenate(problem.residuals(np.array([trial[name].value for name in names])))

    def slopes(trial: Any) -> Array:
        return problem.jacobian(np.array([trial[name].value for name in names]))

    options: dict[str, Any] = {"jac": slopes, "x_scale": "jac", "xtol": 1e-10, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 200}
    if roughly:
        options |= {"xtol": 1e-6, "ftol": 1e-6, "gtol": 1e-6}
    if problem.robust:
        at_start = np.concatenate(problem.residuals(begin))
        options |= {"loss": "soft_l1", "f_scale": _OUTLIER * 1.4826 * max(float(np.median(np.abs(at_start))), 1e-12)}
    with np.errstate(invalid="ignore", divide="ignore"):  # of lmfit's own covariance, singular where a design tells nothing, and not used
        result: Any = lmfit.minimize(residual, parameters, method="least_squares", **options)
    theta = np.array([result.params[name].value for name in names])
    return theta, bool(result.success) and bool(np.all(np.isfinite(theta)))
