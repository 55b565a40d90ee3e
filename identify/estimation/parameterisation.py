"""What is unknown in a comparison of a model with measurements, and what the model becomes where it is known.

Unknown are the force law (base), each run's own release (nuisance), the zeros of the loops, and the parameters of the effects that are
tried. Everything is a parameter, a number in units of its own scale, zero where the model file has it. Loops alone pose the same problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from identify.campaign.prepared import TURNED_BY_MIRROR, Film, LoopRun, across_of, beta_bounds, release_parameters, zero_parameters
from identify.criteria import WEAK_PRIOR
from identify.estimation.observation import RunRelease
from identify.estimation.parameters import (
    BASE,
    BETA_NAME,
    POSE,
    STORED_FORCE,
    Change,
    Parameter,
    changed,
    effect_parameters,
    lines_of,
    rate_parameters,
)
from identify.estimation.rate import NO_RATE, RatePolynomials
from measure.common.arrays import Array
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect
from simulate.model.measures import PROTOTYPE, Measures
from simulate.model.model import LEGS, Model, per_leg
from simulate.model.rig import altered

_REMEMBERED = 512  # effects: the points of a Jacobian share all but one
LOOPS = -1  # in place of a film's number: what is common to no film


@lru_cache(maxsize=_REMEMBERED)
def _effect_from(kind: type[Effect], flat: bytes) -> Effect:
    """An effect from its parameters, (n,) as bytes."""
    return kind().with_flat(np.frombuffer(flat))


@dataclass(frozen=True)
class Unknowns:
    """Measurements, base model and the effects whose parameters are unknown.

    covariate : a further column of the loops to which a part of their force is proportional, none unless given.
    own_zeros : whether the load cell was set to zero for each loop anew, from where it may drift. zeros_at_will : to any level.
    rate : what the four lines of the loops follow, nothing unless given. changes : which parameters are held, bounded, or begin elsewhere.
    forces_differ : whether the stored force may differ from run to run by more than the model file says.
    until_s : films are cut there. effect_spread : prior of an effect's parameter around the model's value, in typical sizes; none unless
    given. measures : how large what was measured is: sizes and bounds of effects follow it, also where a problem goes on with other runs.
    """

    model: Model
    films: tuple[Film, ...]
    loops: tuple[LoopRun, ...]
    effects: tuple[Effect, ...] = ()
    covariate: str = ""
    own_zeros: bool = False
    zeros_at_will: bool = False
    forces_differ: bool = False
    until_s: float = np.inf
    effect_spread: float = np.inf
    rate: RatePolynomials = NO_RATE
    changes: tuple[Change, ...] = ()
    measures: Measures = PROTOTYPE

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All unknowns: base, covariate and rate, then each film's release, then the zeros of the loops, then the effects."""
        law = base_parameters(self.model, beta_bounds([loop.data for loop in self.loops]) if self.loops else None)
        base = [*law, *self._covariate_parameters, *rate_parameters(law[:4], self.rate.order)]
        nuisance = [*(parameter for own in self.own_parameters for parameter in own), *self._zero_parameters]
        of_effects = [k for effect in self.effects for k in effect_parameters(effect, self.model, self.measures, self.effect_spread)]
        return changed((*base, *nuisance, *of_effects), self.changes)

    @cached_property
    def _covariate_parameters(self) -> tuple[Parameter, ...]:
        """The covariate's share of the force, in newtons per unit of its column; its weight is what it does to the force at all."""
        if not self.covariate:
            return ()
        columns = [loop.data.other[self.covariate] for loop in self.loops if self.covariate in loop.data.other]
        spread = float(np.std(np.concatenate(columns))) if columns else 0.0
        force = abs(lines_of(self.model)[1]) or 1.0
        if self.zeros_at_will:  # the level says nothing
            force = max(float(np.ptp(loop.data.force_N[loop.data.used])) for loop in self.loops)
        return (Parameter(f"covariate.{self.covariate}", 0.05 * force / (spread or 1.0), np.inf, -np.inf, np.inf),)

    @cached_property
    def own_parameters(self) -> tuple[tuple[Parameter, ...], ...]:
        """The parameters of each film's own release."""
        return tuple(tuple(release_parameters(film, self.forces_differ)) for film in self.films)

    @cached_property
    def _zero_parameters(self) -> tuple[Parameter, ...]:
        return tuple(zero_parameters(self.loops, at_will=self.zeros_at_will)) if self.own_zeros else ()

    @property
    def first_rate(self) -> int:
        """Index of the first coefficient of the rate, behind base and covariate."""
        return len(BASE) + bool(self.covariate)

    @property
    def first_nuisance(self) -> int:
        """Index of the first parameter of a release."""
        return self.first_rate + 4 * self.rate.order

    def of_release(self, index: int) -> list[int]:
        """Indices of the parameters of a film's own release."""
        first = self.first_nuisance + sum(len(own) for own in self.own_parameters[:index])
        return list(range(first, first + len(self.own_parameters[index])))

    def unseen_of_release(self, index: int) -> list[int]:
        """Indices of what of a film's release is across all that it shows."""
        across = across_of(self.films[index])
        return [i for i in self.of_release(index) if self.parameters[i].key in across]

    def mirrors(self) -> Iterator[tuple[int, list[int]]]:
        """Axes along which no film shows anything (0 for x, 1 for y), and the indices of what a mirror across each turns round."""
        for axis, turned in enumerate(TURNED_BY_MIRROR):
            if self.films and all(turned <= across_of(film) for film in self.films):
                releases = [i for index in range(len(self.films)) for i in self.of_release(index)]
                yield axis, [i for i in releases if self.parameters[i].key in turned]

    @property
    def first_zero(self) -> int:
        """Index of the first parameter of a loop's zero, behind the releases."""
        return self.first_nuisance + sum(len(own) for own in self.own_parameters)

    @property
    def first_effect(self) -> int:
        """Index of the first parameter of an effect."""
        return self.first_zero + len(self._zero_parameters)

    @cached_property
    def scales(self) -> Array:
        """One of each parameter in its own unit."""
        return np.array([parameter.scale for parameter in self.parameters])

    @cached_property
    def start(self) -> Array:
        """Where a fit begins unless it is told, (k,): the model file's values, or those that a user gave, within the bounds."""
        given = {change.name: change.value for change in self.changes if change.value is not None}
        return np.array([_placed(parameter, given.get(parameter.name)) for parameter in self.parameters])

    @cached_property
    def held(self) -> NDArray[np.bool_]:
        """Which parameters no fit may move, (k,)."""
        return np.array([not parameter.vary for parameter in self.parameters])

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds, (k,) each, in scales."""
        low, high = np.array([(parameter.low, parameter.high) for parameter in self.parameters]).T
        return low, high

    def slopes_at(self, q: Array) -> Array:
        """Change of each value with its own q, (k,)."""
        return np.array([parameter.slope(float(place)) for parameter, place in zip(self.parameters, q, strict=True)])

    def base_shifts(self, q: Array) -> Array:
        """How far the force law is from the model file's, (6,), in the order of `BASE`."""
        return np.array([parameter.shift(float(place)) for parameter, place in zip(self.parameters[: len(BASE)], q, strict=False)])

    def index_of(self, name: str) -> int:
        """Place of a parameter by its name."""
        return [parameter.name for parameter in self.parameters].index(name)

    @property
    def reported(self) -> list[str]:
        """Names of the parameters that a user asks for: lines, beta, effects, covariate."""
        effects = [parameter.name for parameter in self.parameters[self.first_effect :]]
        return [*BASE[:5], *effects, *([f"covariate.{self.covariate}"] if self.covariate else [])]

    def model_at(self, q: Array, base: Model | None = None) -> Model:
        """The model (of a run, or the campaign's own) with base and effects as the parameters say."""
        return add_effects(shifted(base or self.model, self.base_shifts(q)), self.effects_at(q))

    def effects_at(self, q: Array) -> tuple[Effect, ...]:
        """The unknown effects with the parameters that the parameters say."""
        first, ((origin, low, high), places) = self.first_effect, self._laid_flat
        flat = np.clip(origin + q[first:] * self.scales[first:], low, high)
        return tuple(_effect_from(kind, flat[own].tobytes()) for kind, own in places)

    @cached_property
    def _laid_flat(self) -> tuple[Array, list[tuple[type[Effect], slice]]]:
        """Start and bounds of the parameters of all effects, (3, k), and which of them each effect has."""
        rows, places = [], []
        for effect in self.effects:
            bounds = effect.own_bounds(self.model, self.measures).values()
            rows += [(start, *ends) for start, ends in zip(effect.flat(), bounds, strict=True)]
            places.append((type(effect), slice(len(rows) - len(effect.flat()), len(rows))))
        return np.reshape(rows, (-1, 3)).T, places

    def rows_of(self, name: str) -> NDArray[np.intp]:
        """Indices of the parameters of an unknown effect, by its name."""
        return np.array([i for i, parameter in enumerate(self.parameters) if parameter.name.startswith(f"{name}.")], dtype=np.intp)

    def release_at(self, q: Array, index: int) -> RunRelease:
        """The release of the film `index` as the parameters say."""
        values = self._own_values(q, index)
        pose = tuple(values.get(key, 0.0) for key in POSE)
        stored = tuple(values.get(f"stored_force_N[{leg}]", 0.0) for leg in range(LEGS))
        return RunRelease(
            pose[:3], pose[3:], self.films[index].expected_s + values.get("instant_s", 0.0), stored, values.get(STORED_FORCE, 0.0)
        )

    def zeros_at(self, q: Array) -> tuple[Array, Array]:
        """What the load cell showed without force in the middle of each loop, N, and by how much that drifted, N/s; (loops,) each.

        Of zeros at any level: at the begin of each loop, for a cell is set to zero before it drifts.

        Several loops alone cannot tell a common zero from the law's level: their zeros count from their mean.
        """
        if not self._zero_parameters:
            return np.zeros(len(self.loops)), np.zeros(len(self.loops))
        own = slice(self.first_zero, self.first_effect)
        zeros, drifts = (q[own] * self.scales[own]).reshape(2, len(self.loops))
        return zeros - zeros.mean() if self.zeros_count_from_mean else zeros, drifts

    @property
    def zeros_count_from_mean(self) -> bool:
        """Whether nothing but a convention says what the zeros of the loops are on the average."""
        return not self.films and len(self.loops) > 1

    def _own_values(self, q: Array, index: int) -> dict[str, float]:
        place = self.first_nuisance + sum(len(own) for own in self.own_parameters[:index])
        return {p.key: float(q[place + i] * p.scale) for i, p in enumerate(self.own_parameters[index])}

    def datum_at(self, q: Array, index: int) -> tuple[Array, float]:
        """What a film that counts from its first frame may be wrong by: that frame's error (zeroed channels,), and its scale."""
        values, film = self._own_values(q, index), self.films[index]
        names = [channel for channel, zeroed in zip(film.channels, film.zeroed, strict=True) if zeroed]
        return np.array([values[f"first_frame_{channel}"] for channel in names]), values.get("length_scale", 0.0)

    def rate_coefficients(self, q: Array) -> Array:
        """Coefficients of z, z^2 ... of the four lines, (4, order), in the units of the lines."""
        own = slice(self.first_rate, self.first_nuisance)
        return (q[own] * self.scales[own]).reshape(4, self.rate.order)

    def lines_at(self, q: Array, z: float = 0.0, given: Array | None = None) -> Array:
        """The actuator's a_l, b_l, a_u, b_u, beta, (5,), at a scaled rate; given : those of a run's own model, else the campaign's."""
        lines = (self._lines if given is None else given) + self.base_shifts(q)[:5]
        lines[:4] += self.rate_coefficients(q) @ z ** np.arange(1, self.rate.order + 1)
        return lines

    @cached_property
    def _lines(self) -> Array:
        return lines_of(self.model)

    def polynomials_at(self, q: Array) -> dict[str, tuple[float, ...]]:
        """Coefficients of a_l, b_l, a_u, b_u in the rate itself, lowest power first."""
        rows = np.column_stack([self.lines_at(q)[:4], self.rate_coefficients(q)])
        named = zip(("a_l", "b_l", "a_u", "b_u"), rows, strict=True)
        return {key: tuple(float(c) for c in self.rate.unscaled(row)) for key, row in named}

    @cached_property
    def covariate_mean(self) -> float:
        """Mean of the covariate over the samples of all loops."""
        return float(np.mean(np.concatenate([loop.data.other[self.covariate][loop.data.used] for loop in self.loops])))

    def owner_of(self, parameter: int) -> int | None:
        """The film whose own release a parameter belongs to, `LOOPS` for what only loops show, or None."""
        if self.first_zero <= parameter < self.first_effect or len(BASE) <= parameter < self.first_nuisance:
            return LOOPS
        place = self.first_nuisance
        for index, own in enumerate(self.own_parameters):
            if place <= parameter < place + len(own):
                return index
            place += len(own)
        return None

    def prior(self, q: Array) -> Array:
        """The parameters that have a prior, over its spread."""
        return q[self._with_prior] / self._spreads[self._with_prior] if self._base_root is None else self._prior_with_covariance(q)

    @cached_property
    def _spreads(self) -> Array:
        return np.array([parameter.spread for parameter in self.parameters])

    @cached_property
    def _with_prior(self) -> NDArray[np.intp]:
        return np.flatnonzero(np.isfinite(self._spreads))

    @cached_property
    def _base_root(self) -> Array | None:
        """Inverse root of the covariance of the base that the model file carries; of no use where loops speak themselves."""
        covariance = self.model.actuator.covariance
        if covariance is None or self.loops or not all(name in covariance.names for name in BASE[:5]):
            return None
        order = [covariance.names.index(name) for name in BASE[:5]]
        return np.linalg.inv(np.linalg.cholesky(np.array(covariance.matrix)[np.ix_(order, order)]))

    def _prior_with_covariance(self, q: Array) -> Array:
        assert self._base_root is not None
        others = self._with_prior[self._with_prior >= 5]
        return np.concatenate([self._base_root @ self.base_shifts(q)[:5], q[others] / self._spreads[others]])


def _placed(parameter: Parameter, value: float | None) -> float:
    """The q of a value that a user gave; within the bounds, unless it is held there."""
    if value is None:
        return 0.0
    place = parameter.place(value)
    return float(np.clip(place, parameter.low, parameter.high)) if parameter.vary else place


def shifted(model: Model, shifts: Array) -> Model:
    """The model with its force law shifted, in the order of `BASE`; six different legs are shifted alike."""
    law = model.actuator
    changed = {name: _plus(getattr(law, name), shift) for name, shift in zip(BASE, shifts, strict=True) if shift != 0.0}
    return altered(model, actuator=altered(law, **changed)) if changed else model


def _plus(value: float | tuple[float, ...], shift: float) -> float | tuple[float, ...]:
    return tuple(v + float(shift) for v in value) if isinstance(value, tuple) else value + float(shift)


def base_parameters(model: Model, beta_bounds: tuple[float, float] | None) -> list[Parameter]:
    """The force law. Loops tell it; from films alone its prior is weak but not absent: it says what kind of spring it is.

    beta_bounds : between which betas loops can tell anything; None where there are no loops.
    """
    law = lines_of(model)
    force = float(np.mean(np.abs(per_leg(model.actuator.initial_force_N)))) or 1.0
    lines = [*np.array([0.1 * force / _stroke(model), 0.05 * force])[[0, 1, 0, 1]], 0.2 * law[4], 0.05 * force]
    spread = np.inf if beta_bounds else WEAK_PRIOR
    starts = [*law, float(np.mean(per_leg(model.actuator.initial_force_N)))]
    made = [
        Parameter(name, float(scale), spread, -np.inf, np.inf, start=float(start), log=name == BETA_NAME)
        for name, scale, start in zip(BASE, lines, starts, strict=True)
    ]
    made[5] = replace(made[5], spread=WEAK_PRIOR)
    if beta_bounds:
        made[4] = replace(made[4], low=made[4].place(beta_bounds[0]), high=made[4].place(beta_bounds[1]))
    return made


def _stroke(model: Model) -> float:
    """The way that a leg goes in a deployment, m; of an actuator alone a hundred lengths 1 / beta stand in for it."""
    if model.geometry is None:
        return 100.0 / float(lines_of(model)[4])
    return model.geometry.deployed_height_m - model.geometry.stowed_height_m
