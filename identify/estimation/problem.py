"""All measurements against one model, as one vector: measured minus modelled, in units of the noise.

All that is unknown is fitted together: fitted to a residual, the base would already have swallowed part of an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.campaign.noise import whitened
from identify.campaign.prepared import Film, film_of, lengths_of, loop_of
from identify.campaign.runs import Run
from identify.estimation.observation import View, observe, observe_beside
from identify.estimation.parameterisation import Unknowns
from identify.estimation.parameters import BASE, lines_of
from identify.estimation.threads import side_by_side
from identify.loops.loop_data import LoopData, gap_and_sways
from measure.common.arrays import Array
from measure.common.errors import InputError, nearest
from simulate.model.effect import Effect
from simulate.model.model import Model

_STEP = 1e-5
_DIVERGED = 1e3


@dataclass(frozen=True)
class Block:
    """Where one run and channel stands in the vector of gaps; `samples` are its indices in the run's own samples."""

    run: str
    channel: str
    rows: slice
    samples: NDArray[np.intp]


@dataclass(frozen=True)
class Problem(Unknowns):
    """Measurements against a model of which some is unknown, as a vector of gaps; see `Unknowns` for its fields."""

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """Run by run and channel by channel, the rows of the gap vector; priors stand behind them."""
        found, start = [], 0
        for name, channel, samples in self._extents():
            found.append(Block(name, channel, slice(start, start + len(samples)), samples))
            start += len(samples)
        return tuple(found)

    def _extents(self) -> list[tuple[str, str, NDArray[np.intp]]]:
        films = [
            (film.run.name, channel, np.flatnonzero(film.counts[i] & (film.time_s <= self.until_s)))
            for film in self.films
            for i, channel in enumerate(film.channels)
        ]
        return films + [(loop.run.name, "force_N", np.flatnonzero(loop.data.used)) for loop in self.loops]

    @property
    def measured(self) -> int:
        """Number of measured values in the gap vector, priors not counted."""
        return self.blocks[-1].rows.stop if self.blocks else 0

    def with_effects(self, effects: Sequence[Effect]) -> Problem:
        """The same measurements with other unknown effects."""
        return replace(self, effects=tuple(effects))

    def with_another(self, effect: Effect) -> Problem:
        """The same measurements with one unknown effect more, behind the others."""
        return self.with_effects((*self.effects, effect))

    def with_exact_motion(self) -> Problem:
        """The same with the motion of each loop taken as exact: its gaps are then plain differences."""
        loops = (replace(loop, data=replace(loop.data, motion_errors=loop.data.motion_errors[:0])) for loop in self.loops)
        return replace(self, loops=tuple(loops))

    def until(self, horizon_s: float) -> Problem:
        """The same with the films cut at a time; loops are whole."""
        return replace(self, until_s=horizon_s)

    def gaps(self, q: Array) -> Array:
        """Measured minus modelled, over the noise, film by film and loop by loop; behind them the parameters over their priors."""
        films = side_by_side(lambda i: self._film_gap(self.films[i], observe(self._view(q, i)), *self.datum_at(q, i)), len(self.films))
        return np.concatenate([*films, *self._loop_gaps(q), self.prior(q)])

    def gaps_many(self, points: Sequence[Array]) -> list[Array]:
        """`gaps` at several points, each by itself."""
        return [self.gaps(q) for q in points]

    def gaps_beside(self, points: Sequence[Array], only: Sequence[int | None] | None = None, known: Array | None = None) -> list[Array]:
        """`gaps` at points that hardly differ from the first one, with the same steps, side by side: differences are smooth.

        only : for each point the one film that it can differ in from the first point, `LOOPS` for the loops alone, or None where
        all may differ.
        known : the gaps at the first point, where they have been worked out before.
        """
        touched = list(only) if only is not None else [None] * len(points)
        first = {} if known is None else dict(enumerate(known[rows] for rows in self._film_rows))
        films = self._film_gaps(points, touched, first)
        loops = self._loop_gaps(points[0]) if known is None else [known[b.rows] for b in self.blocks if b.channel == "force_N"]
        return [
            np.concatenate([*films[k], *(self._loop_gaps(q) if self._moves_loops(q, points[0]) else loops), self.prior(q)])
            for k, q in enumerate(points)
        ]

    def _moves_loops(self, q: Array, first: Array) -> bool:
        """Whether the loops of a point can differ from those of the first: by a parameter of base, zeros or what a shaker shows."""
        return bool(self.loops) and bool(np.any((q != first) & self._seen_by_loops))

    @cached_property
    def _seen_by_loops(self) -> NDArray[np.bool_]:
        of_effects = [effect.acts_on_shaker() for effect in self.effects for _ in effect.flat_names()]
        releases = [False] * (self.first_zero - self.first_nuisance)
        return np.array([True] * self.first_nuisance + releases + [True] * (self.first_effect - self.first_zero) + of_effects)

    @cached_property
    def _film_rows(self) -> list[slice]:
        """Where each film stands in the vector of gaps, all its channels."""
        own = [[block.rows for block in self.blocks if block.run == film.run.name] for film in self.films]
        return [slice(rows[0].start, rows[-1].stop) for rows in own]

    def _film_gaps(self, points: Sequence[Array], touched: Sequence[int | None], first: dict[int, Array]) -> list[list[Array]]:
        def of_film(i: int) -> dict[int, Array]:
            made = {0: first[i]} if i in first else {}
            wanted = [k for k in range(len(points)) if k not in made and (k == 0 or touched[k] in (None, i))]
            views = [self._view(points[k], i) for k in wanted]
            seen = observe_beside(self._view(points[0], i), views)
            return made | {k: self._film_gap(self.films[i], s, *self.datum_at(points[k], i)) for k, s in zip(wanted, seen, strict=True)}

        made = side_by_side(of_film, len(self.films))
        return [[of.get(k, of[0]) for of in made] for k in range(len(points))]

    def _view(self, q: Array, index: int) -> View:
        film, model = self.films[index], self.model_at(q, self.films[index].model)
        onset_s = film.expected_s if film.by_onset else None
        return View(model, film.time_s[film.time_s <= self.until_s], self.release_at(q, index), film.turned, onset_s)

    def _film_gap(self, film: Film, seen: dict[str, Array], datum: Array, scale: float) -> Array:
        n = len(next(iter(seen.values())))
        modelled = np.stack([seen[channel] for channel in film.channels])
        gone = modelled[film.zeroed] - modelled[film.zeroed, :1]
        gone[lengths_of(film)] *= 1.0 + scale
        modelled[film.zeroed] = gone + (film.nominal[film.zeroed] + datum)[:, None]
        over_noise = np.nan_to_num((film.values[:, :n] - modelled) / film.sigma[:, :n], nan=_DIVERGED, posinf=_DIVERGED, neginf=-_DIVERGED)
        return over_noise[film.counts[:, :n]]

    def _loop_gaps(self, q: Array) -> list[Array]:
        made, at = [], {}
        for loop, zero_N, drift_N_per_s in zip(self.loops, *self.zeros_at(q), strict=True):
            if id(loop.model) not in at:
                model = self.model_at(q, loop.model)
                at[id(loop.model)] = lines_of(model), tuple(effect for effect in model.effects if effect.acts_on_shaker())
            lines, effects = at[id(loop.model)]
            zeros_N = zero_N + drift_N_per_s * (loop.data.time_s - loop.data.time_s.mean())
            left, sways = gap_and_sways(lines, self._without_covariate(q, loop.data), effects, zeros_N)
            made.append(whitened(left / loop.data.force_sigma_N, sways / loop.data.force_sigma_N))
        return made

    def _without_covariate(self, q: Array, data: LoopData) -> LoopData:
        if not self.covariate:
            return data
        share = q[len(BASE)] * self.scales[len(BASE)] * (data.other[self.covariate] - self.covariate_mean)
        return replace(data, force_N=data.force_N - share)

    def jacobian(self, q: Array, columns: Sequence[int] | None = None, known: Array | None = None) -> tuple[Array, Array]:
        """Gaps (m,) and their rate of change with the parameters (m, k), by forward differences, all simulations side by side.

        A parameter at its upper bound is stepped downwards. known : the gaps, where they have been worked out before.
        """
        chosen = list(range(len(q))) if columns is None else list(columns)
        steps = [-_STEP if q[i] + _STEP > self.parameters[i].high else _STEP for i in chosen]
        points = [q, *(_stepped(q, i, step) for i, step in zip(chosen, steps, strict=True))]
        here, *there = self.gaps_beside(points, [None, *(self.owner_of(i) for i in chosen)], known)
        return here, np.stack([(g - here) / step for g, step in zip(there, steps, strict=True)], axis=1)


def _stepped(q: Array, index: int, step: float) -> Array:
    moved = q.copy()
    moved[index] += step
    return moved


def problem_of(model: Model, runs: Sequence[Run], covariate: str = "", *, own_zeros: bool = False) -> Problem:
    """The problem of a campaign; what is held out is left out by the caller.

    own_zeros : whether the load cell was set to zero for each loop anew, from where it may drift.

    Raises
    ------
    InputError
        A run cannot be used with this model, or a loop has no column of the covariate's name.
    """
    films = tuple(film_of(run, run.model(model)) for run in runs if not run.is_loop)
    loops = tuple(loop_of(run, run.model(model)) for run in runs if run.is_loop)
    for loop in loops:
        if covariate and covariate not in loop.data.other:
            raise InputError(f'{loop.run.name}: no column "{covariate}" for the covariate; {nearest(covariate, loop.data.other)}')
    return Problem(model, films, loops, covariate=covariate if loops else "", own_zeros=own_zeros)
