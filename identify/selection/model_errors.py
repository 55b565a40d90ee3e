"""What the model file itself may be wrong by: columns of one tolerance each, which every hypothesis is allowed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from identify.estimation.fit import Fit
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

_SHOWN = 1e-6

TOLERANCES: Sequence[tuple[type[Effect], Callable[[Model], Array]]] = (
    (PlatformMass, lambda model: np.array([0.01 * model.nuisance.platform_mass_percent * model.platform.mass_kg])),
    (PlatformInertia, lambda model: np.full(3, 0.01 * model.nuisance.inertia_percent)),
    (CentreOfMassOffset, lambda model: np.full(3, model.nuisance.centre_of_mass_m)),
    (GeometryError, lambda model: np.full(36, model.nuisance.joints_m)),
    (StopStiffness, lambda model: np.array([0.01 * model.nuisance.end_stop_percent])),
    (EndStopDissipation, lambda model: np.array([0.01 * model.nuisance.end_stop_percent * model.end_stop.damping_N_s_per_m])),
    (ScaleError, lambda model: np.array([0.01 * model.nuisance.camera_scale_percent])),
)


@dataclass(frozen=True)
class ModelErrors:
    """Columns (m, q) of one tolerance each.

    names, places : (q,) the effect of the catalogue that each belongs to, and which of its parameters it is.
    """

    columns: Array
    names: tuple[str, ...]
    places: tuple[int, ...]

    def of(self, name: str) -> Array:
        """The columns of one kind of error."""
        return self.columns[:, [i for i, other in enumerate(self.names) if other == name]]

    def without(self, names: Collection[str]) -> ModelErrors:
        """All but some kinds."""
        kept = [i for i, other in enumerate(self.names) if other not in names]
        return ModelErrors(self.columns[:, kept], tuple(self.names[i] for i in kept), tuple(self.places[i] for i in kept))

    def effects(self, model: Model, sizes: Array) -> tuple[Effect, ...]:
        """The errors as effects of a model, from their sizes (q,) in tolerances, on top of what the model has of each."""
        made = []
        for kind, tolerance in TOLERANCES:
            mine = [i for i, name in enumerate(self.names) if name == kind.name]
            known, off = model.effect(kind), np.zeros(len(kind.flat_names()))
            off[[self.places[i] for i in mine]] = sizes[mine] * tolerance(model)[[self.places[i] for i in mine]]
            made += [known.with_flat(known.flat() + off)] if mine else []
        return tuple(made)


def model_errors(fit: Fit) -> ModelErrors:
    """The columns at a fit; without deployments there are none."""
    rows, parts, names, places = fit.problem.measured, [], [], []
    known = {effect.name for effect in fit.problem.effects}
    for kind, tolerance in TOLERANCES if fit.problem.films else ():
        size = tolerance(fit.problem.model)
        if kind.name not in known and np.any(size > 0.0):
            columns = _of_effect(fit, fit.problem.model.effect(kind), size)[:rows]
            shown = np.linalg.norm(columns, axis=0) > _SHOWN
            parts.append(columns[:, shown])
            names += [kind.name] * int(shown.sum())
            places += np.flatnonzero(shown).tolist()
    return ModelErrors(np.hstack([np.empty((rows, 0)), *parts]), tuple(names), tuple(places))


def _of_effect(fit: Fit, effect: Effect, tolerance: Array) -> Array:
    problem = fit.problem.with_another(effect)
    start = np.concatenate([fit.q, np.zeros(len(tolerance))])
    new = range(len(fit.q), len(start))
    return problem.jacobian(start, new, fit.gaps)[1] * (tolerance / problem.scales[len(fit.q) :])
