"""By how much a model file may be wrong: a tolerance for every parameter of the effects that say so."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from measure.common.arrays import Array
from simulate.effects import (
    CentreOfMassOffset,
    EndStopDissipation,
    GeometryError,
    PlatformInertia,
    PlatformMass,
    ScaleError,
    StopStiffness,
)
from simulate.model.effect import Effect
from simulate.model.model import Model
from simulate.model.rig import Nuisance


@dataclass(frozen=True)
class Tolerance:
    """What a model file may be wrong by in every parameter of an effect, (n,), in the unit of these."""

    kind: type[Effect]
    one: Callable[[Nuisance], float]

    def step(self, model: Model) -> Array:
        """What a tolerance more adds to each parameter, (n,), from where a model has it."""
        return np.full(len(self.kind.flat_names()), self.one(model.nuisance))

    def values(self, model: Model, sizes: Array) -> Array:
        """The parameters (n,) that are so many tolerances (n,) from where a model has them."""
        return model.effect(self.kind).flat() + self.step(model) * sizes

    def sizes(self, model: Model, values: Array) -> Array:
        """How many tolerances (n,) such parameters are from where a model has them."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return (values - model.effect(self.kind).flat()) / self.step(model)


@dataclass(frozen=True)
class Factor(Tolerance):
    """A tolerance in parts of a quantity that is never negative, which is off by a factor: twice as large as likely as half.

    whole : the quantity, in the unit of the parameters.
    """

    whole: Callable[[Model], float] = lambda _: 1.0

    def step(self, model: Model) -> Array:
        """From where the quantity is."""
        return self.one(model.nuisance) * (self.whole(model) + model.effect(self.kind).flat())

    def values(self, model: Model, sizes: Array) -> Array:
        """In equal ratios."""
        off, share = model.effect(self.kind).flat(), self.one(model.nuisance)
        return off + (self.whole(model) + off) * np.expm1(share * sizes)

    def sizes(self, model: Model, values: Array) -> Array:
        """In equal ratios."""
        off = model.effect(self.kind).flat()
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log1p((values - off) / (self.whole(model) + off)) / self.one(model.nuisance)


_TOLERANCES = (
    Factor(PlatformMass, lambda nuisance: 0.01 * nuisance.platform_mass_percent, lambda model: model.platform.mass_kg),
    Factor(PlatformInertia, lambda nuisance: 0.01 * nuisance.inertia_percent),
    Tolerance(CentreOfMassOffset, lambda nuisance: nuisance.centre_of_mass_m),
    Tolerance(GeometryError, lambda nuisance: nuisance.joints_m),
    Factor(StopStiffness, lambda nuisance: 0.01 * nuisance.end_stop_percent),
    Factor(EndStopDissipation, lambda nuisance: 0.01 * nuisance.end_stop_percent, lambda model: model.end_stop.damping_N_s_per_m),
    Factor(ScaleError, lambda nuisance: 0.01 * nuisance.camera_scale_percent),
)
TOLERANCE_OF: Mapping[str, Tolerance] = {one.kind.name: one for one in _TOLERANCES}
