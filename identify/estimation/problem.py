"""All measurements against one model, as one vector: measured minus modelled, in units of the noise.

All that is unknown is fitted together: fitted to a residual, the base would already have swallowed part of an effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from identify.campaign.noise import whitened
from identify.campaign.prepared import Film, lengths_of
from identify.estimation.fit import Block, Fitted
from identify.estimation.observation import View, observe, observe_beside
from identify.estimation.parameterisation import Unknowns
from identify.estimation.parameters import BASE, LINE_NAMES, Change, lines_of
from identify.loops.loop_data import LoopData, gap_and_motion_errors, with_turns_moved
from measure.common.arrays import Array
from simulate.dispatch.threads import side_by_side
from simulate.model.effect import Effect
from simulate.model.model import Model
from simulate.model.rig import altered

_STEP, _STEP_OF_LOOPS, _STEP_OF_LINES = 1e-5, 1e-3, 1e-2  # in scales; a loop is linear in its lines and zeros, so that any step is exact
_DIVERGED = 1e3


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

    @cached_property
    def unseen(self) -> NDArray[np.bool_]:
        """Which parameters are of a release, across all that its film shows, (k,)."""
        across = [i for index in range(len(self.films)) for i in self.unseen_of_release(index)]
        return np.isin(np.arange(len(self.parameters)), across)

    def with_effects(self, effects: Sequence[Effect]) -> Problem:
        """The same measurements with other unknown effects."""
        return replace(self, effects=tuple(effects))

    def with_another(self, effect: Effect) -> Problem:
        """The same measurements with one unknown effect more, behind the others."""
        return self.with_effects((*self.effects, effect))

    def with_model(self, change: Callable[[Model], Model]) -> Problem:
        """The same measurements of a changed model, in every run alike."""
        films = tuple(replace(film, model=change(film.model)) for film in self.films)
        loops = tuple(replace(loop, model=change(loop.model)) for loop in self.loops)
        return replace(self, model=change(self.model), films=films, loops=loops)

    @property
    def stated_noise(self) -> list[float]:
        """Standard deviation that the measurements of each block were taken to have, in the unit of its channel."""
        of = {(film.run.name, name): float(np.nanmedian(film.sigma[i])) for film in self.films for i, name in enumerate(film.channels)}
        of |= {(loop.run.name, "force_N"): loop.data.force_sigma_N for loop in self.loops}
        return [of[block.run, block.channel] for block in self.blocks]

    def only_films_show(self, effect: Effect) -> bool:
        """Whether no loop says anything of an effect."""
        return not (self.loops and effect.acts_on_shaker())

    def with_exact_motion(self) -> Problem:
        """The same with the motion of each loop taken as exact: its gaps are then plain differences."""
        loops = (replace(loop, data=replace(loop.data, motion_errors=loop.data.motion_errors[:0])) for loop in self.loops)
        return replace(self, loops=tuple(loops))

    def with_changes(self, changes: Sequence[Change]) -> Problem:
        """The same measurements with other parameters held, bounded, or begun elsewhere."""
        return replace(self, changes=tuple(changes))

    def until(self, horizon_s: float) -> Problem:
        """The same with the films cut at a time; loops are whole."""
        return replace(self, until_s=horizon_s)

    def gaps(self, q: Array) -> Array:
        """Measured minus modelled, over the noise, film by film and loop by loop; behind them the parameters over their priors."""
        films = side_by_side(lambda i: self._film_gap(self.films[i], observe(self._view(q, i)), *self.datum_at(q, i)), len(self.films))
        return np.concatenate([*films, *self._loop_gaps(q), self.prior(q)])

    def gaps_beside(self, points: Sequence[Array], *, known: Array | None = None, longer: bool = False) -> list[Array]:
        """`gaps` at points that hardly differ from the first one, with the same steps, side by side: differences are smooth.

        known : the gaps at the first point, where they have been worked out before.
        longer : whether the films are simulated in longer steps, at the first point, too, where only differences are wanted.
        """
        first = {} if known is None else dict(enumerate(known[rows] for rows in self._film_rows))
        films = self._film_gaps(points, [None] * len(points), first, longer=longer)
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
        base = [name != "initial_force_N" for name in BASE] + [True] * (self.first_nuisance - len(BASE))
        return np.array(base + releases + [True] * (self.first_effect - self.first_zero) + of_effects)

    @cached_property
    def _film_rows(self) -> list[slice]:
        """Where each film stands in the vector of gaps, all its channels."""
        own = [[block.rows for block in self.blocks if block.run == film.run.name] for film in self.films]
        return [slice(rows[0].start, rows[-1].stop) for rows in own]

    def _film_gaps(
        self, points: Sequence[Array], touched: Sequence[int | None], first: dict[int, Array], *, longer: bool = False
    ) -> list[list[Array]]:
        """Gaps of each film at each point.

        touched : for each point the one film that it can differ in from the first point, `LOOPS` for the loops alone, or None where all may
        differ. first : of the first point by film, where they have been worked out before.
        """

        def of_film(i: int) -> dict[int, Array]:
            wanted = [k for k in range(1, len(points)) if touched[k] in (None, i)]
            made = {0: first[i]} if i in first and not wanted else {}
            wanted = wanted if made else [0, *wanted]
            views = [self._view(points[k], i) for k in wanted]
            if not wanted:
                return made
            datums, scales = zip(*(self.datum_at(points[k], i) for k in wanted), strict=True)
            seen = observe_beside(self._view(points[0], i), views, longer=longer)
            return made | dict(zip(wanted, self._film_gap(self.films[i], seen, np.array(datums), np.array(scales)), strict=True))

        made = side_by_side(of_film, len(self.films))
        return [[of.get(k, of[0]) for of in made] for k in range(len(points))]

    def _view(self, q: Array, index: int) -> View:
        film, model = self.films[index], self.model_at(q, self.films[index].model)
        model = altered(model, effects=tuple(effect.in_run(index) for effect in model.effects))
        onset_s = film.expected_s if film.by_onset else None
        return View(model, film.time_s[film.time_s <= self.until_s], self.release_at(q, index), film.turned, onset_s)

    def _film_gap(self, film: Film, seen: dict[str, Array], datum: Array, scale: Array | float) -> Array:
        """Gaps (..., m) of what is seen of one film, every channel (..., n), with its datum (..., z) and scale (...)."""
        modelled = np.stack([seen[channel] for channel in film.channels], axis=-2)
        n = modelled.shape[-1]
        gone = modelled[..., film.zeroed, :] - modelled[..., film.zeroed, :1]
        gone[..., lengths_of(film), :] *= 1.0 + np.asarray(scale)[..., None, None]
        modelled[..., film.zeroed, :] = gone + (film.nominal[film.zeroed] + datum)[..., None]
        over_noise = np.nan_to_num((film.values[:, :n] - modelled) / film.sigma[:, :n], nan=_DIVERGED, posinf=_DIVERGED, neginf=-_DIVERGED)
        return over_noise[..., film.counts[:, :n]]

    def _loop_gaps(self, q: Array) -> list[Array]:
        return [whitened(gap, of_motion) for gap, of_motion in (self._loop_gap(q, k) for k in range(len(self.loops)))]

    def _loop_gap(self, q: Array, index: int, data: LoopData | None = None) -> tuple[Array, Array]:
        """The gap of a loop, (n,), and what each error of its motion does to it, (n, k), over the noise; of its data in another state."""
        loop = self.loops[index]
        lines, zero_N = self.lines_at(q, self._z[index], self._lines_of_loops[index]), self._zero_of(q, index)
        effects = combined(loop.model.effects, self.effects_at(q))
        left, of_motion = gap_and_motion_errors(lines, data or loop.data, effects, zero_N)
        return left / loop.data.force_sigma_N, of_motion / loop.data.force_sigma_N

    def _zero_of(self, q: Array, index: int) -> Array | float:
        """What the load cell shows of a loop without the actuator's force, N, (n,) or nothing: its own zero, and the covariate's share."""
        if not (self.own_zeros or self.covariate):
            return 0.0
        data, (zeros_N, drifts_N_per_s) = self.loops[index].data, self.zeros_at(q)
        since = data.time_s[0] if self.zeros_at_will else data.time_s.mean()
        shown = zeros_N[index] + drifts_N_per_s[index] * (data.time_s - since)
        return shown + self.covariate_force(q, index) if self.covariate else shown

    def covariate_force(self, q: Array, index: int) -> Array:
        """The part of the force of a loop that follows the covariate, N, (n,)."""
        share, data = q[len(BASE)] * self.scales[len(BASE)], self.loops[index].data
        if self.covariate not in data.other:  # a test that is thought of, at the covariate's mean
            return np.zeros(len(data.time_s))
        return share * (data.other[self.covariate] - self.covariate_mean)

    @cached_property
    def _exact(self) -> tuple[LoopData, ...]:
        return tuple(replace(loop.data, motion_errors=loop.data.motion_errors[:0]) for loop in self.loops)

    @cached_property
    def _lines_of_loops(self) -> tuple[Array, ...]:
        return tuple(lines_of(loop.model) for loop in self.loops)

    @cached_property
    def _z(self) -> tuple[float, ...]:
        return tuple(self.rate.z_of(loop.data) for loop in self.loops)

    def jacobian(
        self, q: Array, columns: Sequence[int] | None = None, known: Array | None = None, *, longer: bool = False
    ) -> tuple[Array, Array]:
        """Gaps (m,) and their rate of change with the parameters (m, k), by differences; zero for a parameter that is held.

        A parameter at its upper bound is stepped downwards. The errors of a loop's motion count as they do at `q`: their own change is
        left out, which makes a fit the root of a weighted score and keeps it from growing an inertia that makes its loops less sure.

        known : the gaps, where they have been worked out before. longer : whether differences of films are taken in longer steps.
        """
        chosen = np.arange(len(q)) if columns is None else np.asarray(columns, dtype=int)
        here = self.gaps(q) if known is None else self.gaps_beside([q], known=known)[0]
        table = np.zeros((len(here), len(chosen)))
        for place in np.flatnonzero(~self.held[chosen]):
            table[self.measured :, place] = self._prior_slope(q, chosen[place])
        moving = [place for place in range(len(chosen)) if not self.held[chosen[place]]]
        if self.films and moving:
            table[: self._film_end, moving] = self._film_slopes(q, chosen[moving].tolist(), here[: self._film_end], longer)
        if self.loops and moving:
            table[self._film_end : self.measured, moving] = self._loop_slopes(q, chosen[moving].tolist())
        return here, table

    @cached_property
    def _film_end(self) -> int:
        return max((rows.stop for rows in self._film_rows), default=0)

    def _step(self, q: Array, index: int, size: float) -> float:
        return -size if q[index] + size > self.parameters[index].high else size

    def _prior_slope(self, q: Array, index: int) -> Array:
        step = self._step(q, index, _STEP)
        return (self.prior(_stepped(q, index, step)) - self.prior(q)) / step

    def _film_slopes(self, q: Array, columns: Sequence[int], here: Array, longer: bool) -> Array:
        steps = [self._step(q, i, _STEP) for i in columns]
        points = [q, *(_stepped(q, i, step) for i, step in zip(columns, steps, strict=True))]
        known = {i: here[rows] for i, rows in enumerate(self._film_rows)}
        first, *there = self._film_gaps(points, [None, *(self.owner_of(i) for i in columns)], known, longer=longer)
        return np.stack([(np.concatenate(gaps) - np.concatenate(first)) / step for gaps, step in zip(there, steps, strict=True)], axis=1)

    def _loop_slopes(self, q: Array, columns: Sequence[int]) -> Array:
        """Slopes of all loops, (n, k). A coefficient of z^j acts as the line's constant one does, z^j times as strongly."""
        made = []
        for k in range(len(self.loops)):
            (left, of_motion), sources = self._loop_gap(q, k), [self._source(i, k) for i in columns]
            own = {source: self._loop_slope(q, k, source, left) for source in {source for source, _ in sources if source is not None}}
            table = [np.zeros_like(left) if source is None else share * own[source] for source, share in sources]
            made.append(whitened(np.stack(table, axis=1), of_motion))
        return np.concatenate(made)

    def _source(self, index: int, loop: int) -> tuple[int | None, float]:
        """The parameter whose slope serves for that of `index` in a loop, and how many times; None where a loop does not feel it."""
        if self.first_rate <= index < self.first_nuisance:
            line, order = divmod(index - self.first_rate, self.rate.order)
            return line, self._z[loop] ** (order + 1)
        if self.first_zero <= index < self.first_effect:
            return self._source_of_zero(index, loop)
        return (index, 1.0) if self._seen_by_loops[index] else (None, 0.0)

    def _source_of_zero(self, index: int, loop: int) -> tuple[int | None, float]:
        """Likewise of a zero or a drift: each acts on its own loop, and a zero on all where they count from their mean."""
        of, count = (index - self.first_zero) % len(self.loops), len(self.loops)
        is_drift = index >= self.first_zero + count
        if of == loop or is_drift or not self.zeros_count_from_mean:
            return (index, 1.0) if of == loop else (None, 0.0)
        own = self.first_zero + loop
        return own, -self.scales[index] / self.scales[own] / (count - 1)

    def _loop_slope(self, q: Array, loop: int, index: int, left: Array) -> Array:
        """Slope of one loop; by central differences where it is no straight line and both sides lie within the bounds."""
        if index < len(LINE_NAMES) or self.first_zero <= index < self.first_effect:
            ahead, behind = self._step(q, index, _STEP_OF_LINES), 0.0
        else:
            ahead = self._step(q, index, _STEP_OF_LOOPS)
            behind = -ahead if ahead > 0.0 and q[index] - ahead >= self.parameters[index].low else 0.0
        there, here = (self._exact_gap(q, loop, index, step) if step else left for step in (ahead, behind))
        return (there - here) / (ahead - behind)

    def _exact_gap(self, q: Array, loop: int, index: int, step: float) -> Array:
        return self._loop_gap(_stepped(q, index, step), loop, self._exact[loop])[0]

    def turned(self, q: Array, here: Array) -> Array:
        """Change (m,) of the gaps `here` with all turning points of all loops one standard deviation further out."""
        change = np.zeros(len(here))
        for k, rows in enumerate(block.rows for block in self.blocks if block.channel == "force_N"):
            left, of_motion = self._loop_gap(q, k)
            moved, _ = self._loop_gap(q, k, with_turns_moved(self._exact[k], self.loops[k].data.turns_sigma_m))
            change[rows] = whitened(moved - left, of_motion)
        return change


def combined(effects: Sequence[Effect], others: Sequence[Effect]) -> tuple[Effect, ...]:
    """Effects that a shaker shows, each of the others in place of one of the same name."""
    named = {effect.name: effect for effect in (*effects, *others)}
    return tuple(effect for effect in named.values() if effect.acts_on_shaker())


def _stepped(q: Array, index: int, step: float) -> Array:
    moved = q.copy()
    moved[index] += step
    return moved


Fit: TypeAlias = Fitted[Problem]
"""A problem of measurements at its least squares."""
