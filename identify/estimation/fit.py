"""What a least-squares problem offers, and the problem at its least squares: parameters, gaps, and what they are worth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Generic, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from identify.estimation.covariance import clipped, inverse_of, sandwich, scaled, shift_of
from identify.estimation.parameters import Change, Parameter
from identify.loops.loop_data import LoopData
from identify.noise.effective_number import effective_number
from measure.common.arrays import Array
from simulate.model.effect import Effect
from simulate.model.measures import Measures
from simulate.model.model import Model

AT_BOUND = 1e-4  # in scales, or of the width between bounds where that is less than one
_NOTHING, _UNDONE = 1e-3, 1e-6  # of the noise, by a typical size of a parameter; of what the parameter does


@dataclass(frozen=True)
class Block:
    """Where one run and channel stands in the vector of gaps. samples : its indices in the run's own samples."""

    run: str
    channel: str
    rows: slice
    samples: NDArray[np.intp]


class OneLoop(Protocol):
    """A loop that takes part in a problem."""

    @property
    def data(self) -> LoopData:
        """Its samples, made ready."""
        ...


class Posed(Protocol):
    """What a least-squares problem offers: parameters q, in scales, and the gaps that a fit makes small, priors behind them."""

    @property
    def model(self) -> Model:
        """The model of the measurements."""
        ...

    @property
    def measures(self) -> Measures:
        """How large what was measured is."""
        ...

    @property
    def films(self) -> Sequence[object]:
        """The deployments that take part."""
        ...

    @property
    def loops(self) -> Sequence[OneLoop]:
        """The loops that take part."""
        ...

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The unknown effects."""
        ...

    @property
    def changes(self) -> tuple[Change, ...]:
        """What a user wants of the parameters."""
        ...

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All unknowns, k of them."""
        ...

    @cached_property
    def start(self) -> Array:
        """Where a fit begins, (k,)."""
        ...

    @cached_property
    def scales(self) -> Array:
        """One of each parameter in its own unit, (k,)."""
        ...

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Which parameters no fit may move, (k,)."""
        ...

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds, (k,) each, in scales."""
        ...

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Run by run and channel by channel, the rows of the gaps."""
        ...

    @property
    def measured(self) -> int:
        """Rows of the gaps before the priors."""
        ...

    @property
    def first_nuisance(self) -> int:
        """Index of the first parameter of a release."""
        ...

    @property
    def first_zero(self) -> int:
        """Index of the first parameter of a loop's zero."""
        ...

    @property
    def first_effect(self) -> int:
        """Index of the first parameter of an effect."""
        ...

    @cached_property
    def unseen(self) -> NDArray[np.bool_]:
        """Which parameters are of a release, across all that its film shows, (k,)."""
        ...

    def index_of(self, name: str) -> int:
        """Place of a parameter by its name."""
        ...

    def rows_of(self, name: str) -> NDArray[np.intp]:
        """Places of the parameters of an effect."""
        ...

    def slopes_at(self, q: Array) -> Array:
        """Change of each value with its own q, (k,)."""
        ...

    def effects_at(self, q: Array) -> tuple[Effect, ...]:
        """The unknown effects as the parameters have them."""
        ...

    def gaps(self, q: Array) -> Array:
        """Measured minus modelled over the noise, priors behind, (m,)."""
        ...

    def gaps_beside(self, points: Sequence[Array], *, known: Array | None = None, longer: bool = False) -> list[Array]:
        """The gaps at points that hardly differ from the first one, (m,) each; `known` at the first. longer : for differences only."""
        ...

    def jacobian(
        self, q: Array, columns: Sequence[int] | None = None, known: Array | None = None, *, longer: bool = False
    ) -> tuple[Array, Array]:
        """Gaps (m,) and their rate of change with the parameters, or some of them, (m, k). longer : in longer steps of films."""
        ...

    def turned(self, q: Array, here: Array) -> Array:
        """Change (m,) of the gaps `here` with all turning points one standard deviation further out."""
        ...

    def with_another(self, effect: Effect) -> Self:
        """The same with one unknown effect more."""
        ...

    def with_exact_motion(self) -> Self:
        """The same with the motion of each loop taken as exact."""
        ...

    def with_changes(self, changes: Sequence[Change]) -> Self:
        """The same with other parameters held, bounded, or begun elsewhere."""
        ...


P = TypeVar("P", bound=Posed)
P_co = TypeVar("P_co", bound=Posed, covariant=True)


@dataclass(frozen=True)
class Fitted(Generic[P_co]):
    """A problem with its parameters at the least squares: gaps (m,) in units of the noise, their Jacobian (m, k).

    converged : whether the solver stopped because nothing improved any more. moved : the parameters of the Jacobian's columns where
    these are not all. robust : whether gaps far off counted less. widened : further covariance (k, k), of errors that no gap shows.
    """

    problem: P_co
    q: Array
    gaps: Array
    jacobian: Array
    converged: bool
    moved: tuple[int, ...] | None = None
    robust: bool = False
    evaluations: int = 0
    widened: Array | None = None

    @property
    def cost(self) -> float:
        """Sum of squares of gaps and priors."""
        return float(self.gaps @ self.gaps)

    @cached_property
    def basis(self) -> Array:
        """Orthonormal columns (m, k) of what the parameters can do to the gaps, each parameter by its own measure."""
        norms = np.linalg.norm(self.jacobian, axis=0)
        return np.linalg.qr(self.jacobian[:, norms > 0] / norms[norms > 0])[0]

    @property
    def determined(self) -> float:
        """Effective number of parameters: those that the measurements determine and not their priors, the trace of the hat matrix."""
        return float(np.sum(self.basis[: self.problem.measured] ** 2))

    def free_of_parameters(self, columns: Array) -> Array:
        """Columns (m, n) freed of what the parameters can do themselves: projected on what is perpendicular to that."""
        return columns - self.basis @ (self.basis.T @ columns)

    def moves(self, parameter: int) -> bool:
        """Whether moving a parameter does anything to the gaps."""
        return float(np.linalg.norm(self.jacobian[:, parameter])) > _NOTHING

    def shows(self, parameter: int) -> bool:
        """Whether moving a parameter does anything to the gaps that all others together cannot undo."""
        column = self.jacobian[:, parameter]
        free = replace(self, jacobian=np.delete(self.jacobian, parameter, axis=1)).free_of_parameters(column)
        return self.moves(parameter) and float(np.linalg.norm(free)) > _UNDONE * float(np.linalg.norm(column))

    @property
    def measured_gaps(self) -> Array:
        """The gaps of measured values, priors left out."""
        return self.gaps[: self.problem.measured]

    @property
    def rms(self) -> float:
        """Root mean square of the gap over the noise."""
        return float(np.sqrt(np.mean(self.measured_gaps**2)))

    @cached_property
    def variance_inflation(self) -> float:
        """Samples per independent sample, one where neighbours are independent; never below one."""
        parts = [self.gaps[block.rows] for block in self.problem.blocks]
        independent = sum(effective_number(part) for part in parts if len(part))
        return max(1.0, self.problem.measured / max(independent, 1.0))

    @property
    def unit(self) -> float:
        """Of a sum of squares, one independent sample's worth of the noise that is left."""
        return self.variance_inflation * max(1.0, self.rms**2)

    @property
    def effective_samples(self) -> float:
        """Number of independent samples."""
        return self.problem.measured / self.variance_inflation

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the parameters, (k, k), in scales: the sandwich, and what an error of the turning points adds."""
        gaps = clipped(self.gaps, self._rows) if self.robust else self.gaps
        known = sandwich(self.jacobian, gaps, self._rows, self.clear_of_bounds) + np.outer(self.of_turns, self.of_turns)
        moving = ~self.problem.held[self.columns]
        return (known if self.widened is None else known + self.widened) * np.outer(moving, moving)

    @cached_property
    def covariance_if_white(self) -> Array:
        """Covariance of the parameters, (k, k), in scales, were the gaps white noise as large as it is said to be."""
        table, size = scaled(self.jacobian)
        return inverse_of(table.T @ table) / np.outer(size, size)

    @cached_property
    def of_turns(self) -> Array:
        """What the parameters bend by, (k,), where all turning points of all loops are one standard deviation further out.

        A fit bends to such an error, so no gap shows it.
        """
        return shift_of(self.jacobian, self.problem.turned(self.q, self.gaps), self.clear_of_bounds)

    @cached_property
    def clear_of_bounds(self) -> NDArray[np.bool_]:
        """Which of the columns' parameters stand clear of their bounds, and are not held."""
        low, high = (bound[self.columns] for bound in self.problem.bounds)
        width = np.minimum(high - low, 1.0)
        q = self.q[self.columns]
        return (q - low > AT_BOUND * width) & (high - q > AT_BOUND * width) & ~self.problem.held[self.columns]

    def at_bounds(self) -> dict[str, str]:
        """Which parameters ran to a bound, and to which, in words: {"hub-inertia.mass_kg": "lower bound 0"}."""
        found = {}
        for k, clear in zip(self.columns, self.clear_of_bounds, strict=True):
            parameter, q = self.problem.parameters[k], float(self.q[k])
            if not clear and parameter.vary:
                side, bound = min((("lower", parameter.low), ("upper", parameter.high)), key=lambda end: abs(end[1] - q))
                found[parameter.name] = f"{side} bound {parameter.value(bound):.4g}"
        return found

    @property
    def columns(self) -> NDArray[np.intp]:
        """The parameters of the Jacobian's columns: all, or those that were left free."""
        return np.arange(len(self.q)) if self.moved is None else np.array(self.moved, dtype=np.intp)

    @property
    def _rows(self) -> list[slice]:
        return [block.rows for block in self.problem.blocks]

    def stderr(self, name: str) -> float:
        """One standard deviation of a parameter, in its own unit."""
        return float(np.sqrt(self.covariance_of([name])[0, 0]))

    def value(self, name: str) -> float:
        """A parameter in its own unit."""
        index = self.problem.index_of(name)
        return self.problem.parameters[index].value(float(self.q[index]))

    def covariance_of(self, names: Sequence[str]) -> Array:
        """Covariance of these parameters, in their own units."""
        places = [self.problem.index_of(name) for name in names]
        slopes = self.problem.slopes_at(self.q)[places]
        rows = np.searchsorted(self.columns, places)
        return self.covariance[np.ix_(rows, rows)] * np.outer(slopes, slopes)

    def part(self, block: Block) -> Array:
        """The gap of one run and channel."""
        return self.gaps[block.rows]

    def difference(self, block: Block) -> Array:
        """Measured minus modelled of one run and channel over its noise, the motion of a loop taken as exact."""
        return self._differences[block.rows]

    @cached_property
    def _differences(self) -> Array:
        return self.problem.with_exact_motion().gaps(self.q) if self.problem.loops else self.gaps

    @property
    def residuals_N(self) -> tuple[Array, ...]:
        """Measured minus modelled of each loop's samples that count, N, the motion taken as exact."""
        loops = self.problem.loops
        blocks = self.problem.blocks[len(self.problem.blocks) - len(loops) :]
        return tuple(self.difference(block) * loop.data.force_sigma_N for block, loop in zip(blocks, loops, strict=True))
