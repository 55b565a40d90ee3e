"""What the model file itself may be wrong by: columns of one tolerance each, which every hypothesis is allowed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from identify.criteria import EFFECT_SPREAD, SLIGHT, STATED_SPREAD
from identify.estimation.fit import Fitted, Posed
from identify.estimation.parameters import sizes_unknown
from identify.estimation.tolerances import TOLERANCE_OF, Tolerance
from identify.gap.signatures import Signature
from measure.common.arrays import Array
from simulate.effects import StoredForcePerRun
from simulate.model.effect import Effect
from simulate.model.mirror import mirrored_values
from simulate.model.model import Model
from simulate.model.rig import Geometry

_SHOWN = 1e-6
FORCES = StoredForcePerRun.name  # an error too, with a parameter for every run


MODEL_ERRORS = frozenset({*TOLERANCE_OF, FORCES})


@dataclass(frozen=True)
class ModelErrors:
    """Columns (m, q) of one tolerance each.

    names, places : (q,) the effect of the catalogue that each belongs to, and which of its parameters it is.
    """

    columns: Array
    names: tuple[str, ...]
    places: tuple[int, ...]

    @classmethod
    def none(cls, rows: int) -> ModelErrors:
        """No errors at all."""
        return cls(np.empty((rows, 0)), (), ())

    @property
    def keys(self) -> tuple[tuple[str, int], ...]:
        """Name and place of each error."""
        return tuple(zip(self.names, self.places, strict=True))

    @classmethod
    def possible(cls, problem: Posed) -> ModelErrors:
        """All that a problem's model has tolerances for and deployments may show, without columns yet; not those that are fitted."""
        known, model = {effect.name for effect in problem.effects}, problem.model
        steps = {name: of.step(model) for name, of in TOLERANCE_OF.items() if problem.films and name not in known}
        keys = [(name, place) for name, step in steps.items() if np.any(step > 0.0) for place in range(len(step))]
        return cls(np.empty((problem.measured, 0)), tuple(name for name, _ in keys), tuple(place for _, place in keys))

    def at(self, fit: Fitted[Posed]) -> ModelErrors:
        """The same errors at another fit."""
        shown = [of for name, of in TOLERANCE_OF.items() if name in self.names]
        places = [[place for name, place in zip(self.names, self.places, strict=True) if name == of.kind.name] for of in shown]
        return ModelErrors(_columns(fit, shown, places), self.names, self.places)

    def signature_of(self, effect: Effect, given: Posed, there: Model) -> Signature | None:
        """What an effect does to the gaps that is one of these errors, per typical size, in a model that is there; None of any other."""
        mine = [i for i, name in enumerate(self.names) if name == effect.name]
        if not mine:
            return None
        places, columns = [self.places[i] for i in mine], np.zeros((given.measured, len(effect.flat())))
        steps = TOLERANCE_OF[effect.name].step(there)
        columns[:, places] = self.columns[:, mine] * (effect.typical(given.measures) / steps)[places]
        return effect, tuple(effect.own_bounds(given.model, given.measures).values()), columns

    def odd_part(self, axis: int, geometry: Geometry) -> Array:
        """What of the errors changes its sign in a mirror across an axis: a projection (q, q) of their sizes."""
        images = [mirrored({**dict.fromkeys(self.keys, 0.0), key: 1.0}, axis, geometry) for key in self.keys]
        image = np.array([[one[key] for one in images] for key in self.keys]).reshape(len(self.keys), len(self.keys))
        return 0.5 * (np.eye(len(self.keys)) - image)

    def sizes_along_lines(self, given: Model, there: Model) -> Array:
        """Sizes (q,) that lead from another model to a given one along the slopes there; those of a factor differ from its own sizes."""
        kinds = [TOLERANCE_OF[name] for name in dict.fromkeys(self.names)]
        off = {of.kind.name: (there.effect(of.kind).flat() - given.effect(of.kind).flat()) / of.step(there) for of in kinds}
        return np.array([off[name][place] for name, place in self.keys])

    def effects(self, problem: Posed, sizes: Array) -> tuple[Effect, ...]:
        """The errors as effects of a problem's model, from their sizes (q,) in tolerances, on top of what it has of each; within bounds."""
        made, model = [], problem.model
        for name, of in TOLERANCE_OF.items():
            mine = [i for i, other in enumerate(self.names) if other == name]
            known, off = model.effect(of.kind), np.zeros(len(of.kind.flat_names()))
            off[[self.places[i] for i in mine]] = sizes[mine]
            low, high = np.array(list(known.own_bounds(model, problem.measures).values())).T
            made += [known.with_flat(np.clip(of.values(model, off), low, high))] if mine else []
        return tuple(made)


def model_errors(fit: Fitted[Posed]) -> ModelErrors:
    """The columns at a fit; without deployments, or where none of them shows, there are none.

    One that does not show here may show elsewhere: a law that has bent may keep a rig from its stops.
    """
    errors = ModelErrors.possible(fit.problem).at(fit)
    shows = (np.linalg.norm(errors.columns, axis=0) > _SHOWN).any()
    return errors if shows else ModelErrors.none(fit.problem.measured)


def slight_errors(fit: Fitted[Posed]) -> tuple[tuple[Effect, float], ...]:
    """Errors of the model file that were fitted like effects and came out hardly beyond their tolerances, with their size in these.

    The size is the root mean square over as many parameters as the measurements determine: the others stay at nought and say nothing.
    """
    found = []
    for effect in fit.problem.effects_at(fit.q):
        sizes = np.array(list(sizes_in_tolerances(fit, effect.name).values()))
        known = len(sizes) and np.all(np.isfinite(sizes))
        size = float(np.sqrt(np.sum(sizes**2) / _determined(fit, effect.name))) if known else np.inf
        found += [(effect, size)] if size < SLIGHT else []
    return tuple(found)


def _determined(fit: Fitted[Posed], name: str) -> float:
    """How many parameters of an effect the measurements determine and not their priors; at least one."""
    rows = fit.problem.rows_of(name)
    known = 1.0 - np.diag(fit.covariance)[rows] / effect_spreads(fit.problem, rows, np.abs(fit.q[rows])) ** 2
    return max(1.0, float(np.sum(np.clip(known, 0.0, 1.0))))


def effect_spreads(problem: Posed, rows: NDArray[np.intp], sizes: Array, *, widely: bool = False) -> Array:
    """Standard deviations (n,) of the priors of some parameters of effects, of such sizes (n,), in scales. widely : to state numbers."""
    known = np.array([problem.parameters[k].spread for k in rows])
    unknown = np.array([one for effect in problem.effects for one in sizes_unknown(type(effect))], dtype=bool)[rows - problem.first_effect]
    return as_wide(known, sizes, np.where(widely & unknown, STATED_SPREAD, EFFECT_SPREAD))


def as_wide(known: Array, sizes: Array, least: Array | float = EFFECT_SPREAD) -> Array:
    """Standard deviations (n,) of priors: ten noticeable sizes, or as large as the effect turns out beyond; less where less is known.

    How large an effect may be nobody knows beforehand, so the width of its prior is the likeliest one: an effect of a noticeable sizes
    loses log(a / 10) and a half by it, where a width of ten would take a^2 / 200.

    Parameters
    ----------
    known : (n,) what the effect knows of itself, else infinite. sizes : (n,) that its parameters surely have, in noticeable ones.
    least : width of what nothing is known of.
    """
    return np.where(np.isfinite(known), np.minimum(known, EFFECT_SPREAD), np.maximum(least, sizes))


def sizes_in_tolerances(fit: Fitted[Posed], name: str) -> dict[tuple[str, int], float]:
    """By name and place how far off a fitted error of the model file is, in its tolerances; nothing of any other effect.

    A tolerance of nought makes it infinite.
    """
    found = [effect for effect in fit.problem.effects_at(fit.q) if effect.name == name]
    if not found or name not in TOLERANCE_OF:
        return {}
    sizes = TOLERANCE_OF[name].sizes(fit.problem.model, found[0].flat())
    return {(name, place): float(size) for place, size in enumerate(sizes)}


def mirrored(errors: Mapping[tuple[str, int], float], axis: int, geometry: Geometry) -> dict[tuple[str, int], float]:
    """Errors by name and place, in tolerances, of a rig that is seen in a mirror across an axis."""
    found = dict(errors)
    for kind in (of.kind for name, of in TOLERANCE_OF.items() if name in {other for other, _ in errors}):
        sizes = np.array([errors.get((kind.name, place), 0.0) for place in range(len(kind.flat_names()))])
        found |= {(kind.name, place): size for place, size in enumerate(mirrored_values(kind, sizes, axis, geometry).tolist())}
    return found


def _columns(fit: Fitted[Posed], shown: Sequence[Tolerance], places: Sequence[Sequence[int]]) -> Array:
    """Columns (m, n) of one tolerance each for some of the parameters of some errors, simulated side by side."""
    model, first = fit.problem.model, len(fit.q)
    steps = [of.step(model) for of in shown]
    problem = reduce(lambda made, of: made.with_another(model.effect(of.kind)), shown, fit.problem)
    begins = first + np.cumsum([0, *(len(step) for step in steps)])
    new = [int(begin) + place for begin, own in zip(begins[:-1], places, strict=True) for place in own]
    start = np.concatenate([fit.q, np.zeros(int(begins[-1]) - first)])
    columns = problem.jacobian(start, new, fit.gaps, longer=True)[1][: fit.problem.measured]
    whole = np.concatenate([np.empty(0), *steps])
    return columns * (whole[np.array(new, dtype=int) - first] / problem.scales[new])
