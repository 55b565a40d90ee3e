"""What is unknown in a comparison of a model with measurements, and what the model becomes where it is known.

Unknown are the force law (base), each run's own release (nuisance), the zeros of the loops, and the parameters of the effects that are
tried. Everything is a parameter, a number in units of its own scale, zero where the model file has it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from identify.campaign.prepared import Film, LoopRun
from identify.estimation.observation import RunRelease
from identify.estimation.parameters import (
    BASE,
    POSE,
    Parameter,
    base_parameters,
    effect_parameters,
    lines_of,
    release_parameters,
    zero_parameters,
)
from measure.common.arrays import Array
from simulate.files.model_file import add_effects
from simulate.model.effect import Effect
from simulate.model.model import LEGS, Model

LOOPS = -1  # in place of a film's number: what is common to no film


@dataclass(frozen=True)
class Unknowns:
    """Measurements, base model and the effects whose parameters are unknown.

    covariate : a further column of the loops to which a part of their force is proportional, none unless given.
    own_zeros : whether the load cell was set to zero for each loop anew, from where it may drift.
    until_s : films are cut there. effect_spread : prior of an effect's parameter around the model's value, in typical sizes;
    none unless given.
    """

    model: Model
    films: tuple[Film, ...]
    loops: tuple[LoopRun, ...]
    effects: tuple[Effect, ...] = ()
    covariate: str = ""
    own_zeros: bool = False
    until_s: float = np.inf
    effect_spread: float = np.inf

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """All unknowns: base, then each film's release, then the zeros of the loops, then the effects."""
        nuisance = [*(parameter for own in self.own_parameters for parameter in own), *self._zero_parameters]
        of_effects = [k for effect in self.effects for k in effect_parameters(effect, self.model, self.effect_spread)]
        return (*base_parameters(self.model, bool(self.loops)), *self._covariate_parameters, *nuisance, *of_effects)

    @cached_property
    def _covariate_parameters(self) -> tuple[Parameter, ...]:
        """The covariate's share of the force, in newtons per unit of its column; its weight is what it does to the force at all."""
        if not self.covariate:
            return ()
        spread = float(np.std(np.concatenate([loop.data.other[self.covariate] for loop in self.loops])) or 1.0)
        return (Parameter(f"covariate.{self.covariate}", 0.05 * abs(lines_of(self.model)[1]) / spread, np.inf, -np.inf, np.inf),)

    @cached_property
    def own_parameters(self) -> tuple[tuple[Parameter, ...], ...]:
        """The parameters of each film's own release."""
        return tuple(tuple(release_parameters(film)) for film in self.films)

    @cached_property
    def _zero_parameters(self) -> tuple[Parameter, ...]:
        return tuple(zero_parameters(self.loops, self.model)) if self.own_zeros else ()

    @property
    def first_nuisance(self) -> int:
        """Index of the first parameter of a release."""
        return len(BASE) + bool(self.covariate)

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

    def model_at(self, q: Array, base: Model | None = None) -> Model:
        """The model (of a run, or the campaign's own) with base and effects as the parameters say."""
        return add_effects(shifted(base or self.model, q[: len(BASE)] * self.scales[: len(BASE)]), self.effects_at(q))

    def effects_at(self, q: Array) -> tuple[Effect, ...]:
        """The unknown effects with the parameters that the parameters say."""
        place, made = self.first_effect, []
        for effect in self.effects:
            size = len(effect.flat())
            values = effect.flat() + q[place : place + size] * self.scales[place : place + size]
            bounds = np.array(list(effect.own_bounds(self.model).values()))
            made.append(effect.with_flat(np.clip(values, bounds[:, 0], bounds[:, 1])))
            place += size
        return tuple(made)

    def rows_of(self, name: str) -> NDArray[np.intp]:
        """Indices of the parameters of an unknown effect, by its name."""
        return np.array([i for i, parameter in enumerate(self.parameters) if parameter.name.startswith(f"{name}.")], dtype=np.intp)

    def release_at(self, q: Array, index: int) -> RunRelease:
        """The release of the film `index` as the parameters say."""
        values = self._own_values(q, index)
        pose = tuple(values.get(key, 0.0) for key in POSE)
        stored = tuple(values.get(f"stored_force_N[{leg}]", 0.0) for leg in range(LEGS))
        return RunRelease(pose[:3], pose[3:], self.films[index].expected_s + values.get("instant_s", 0.0), stored)

    def zeros_at(self, q: Array) -> tuple[Array, Array]:
        """What the load cell said without force in the middle of each loop, N, and by how much that drifted, N/s; (loops,) each."""
        if not self._zero_parameters:
            return np.zeros(len(self.loops)), np.zeros(len(self.loops))
        own = slice(self.first_zero, self.first_effect)
        zeros, drifts = (q[own] * self.scales[own]).reshape(2, len(self.loops))
        return zeros, drifts

    def _own_values(self, q: Array, index: int) -> dict[str, float]:
        place = self.first_nuisance + sum(len(own) for own in self.own_parameters[:index])
        return {p.key: float(q[place + i] * p.scale) for i, p in enumerate(self.own_parameters[index])}

    def datum_at(self, q: Array, index: int) -> tuple[Array, float]:
        """What a film that counts from its first frame may be wrong by: that frame's error (zeroed channels,), and its scale."""
        values, film = self._own_values(q, index), self.films[index]
        names = [channel for channel, zeroed in zip(film.channels, film.zeroed, strict=True) if zeroed]
        return np.array([values[f"first_frame_{channel}"] for channel in names]), values.get("length_scale", 0.0)

    @cached_property
    def covariate_mean(self) -> float:
        """Mean of the covariate over the samples of all loops."""
        return float(np.mean(np.concatenate([loop.data.other[self.covariate] for loop in self.loops])))

    def owner_of(self, parameter: int) -> int | None:
        """The film whose own release a parameter belongs to, `LOOPS` for a loop's zero, or None."""
        if self.first_zero <= parameter < self.first_effect:
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
        return np.concatenate([self._base_root @ (q[:5] * self.scales[:5]), q[others] / self._spreads[others]])


def shifted(model: Model, shifts: Array) -> Model:
    """The model with its force law shifted, in the order of `BASE`; six different legs are shifted alike."""
    law = model.actuator
    changed = {name: _plus(getattr(law, name), shift) for name, shift in zip(BASE, shifts, strict=True) if shift != 0.0}
    return replace(model, actuator=replace(law, **changed)) if changed else model


def _plus(value: float | tuple[float, ...], shift: float) -> float | tuple[float, ...]:
    return tuple(v + float(shift) for v in value) if isinstance(value, tuple) else value + float(shift)
