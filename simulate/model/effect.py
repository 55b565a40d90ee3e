"""What a physical effect is to the rest of the program: a name, parameters with bounds, and formulas.

An effect is a frozen dataclass in a file of its own. It carries no state, and its defaults switch it off. It acts through one
or more of the methods listed at `Effect`; those that it does not define cost nothing.

Formulas that run inside the compiled kernels (`leg_...`, `strip_...`, `joint_...`, `platform_...`, `base_...`) are plain static
functions of numbers. They are compiled from this very source, for the loop fit and for the six-leg model alike, so there is one
formula. They may use `math`, and `p[i]`, the effect's parameters in the order of their declaration, vectors laid flat.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import Field, dataclass, field, fields, replace
from functools import cache
from itertools import product
from typing import Any, ClassVar, Self, TypeVar

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError, found, nearest
from simulate.model.measures import NUMBER, PROTOTYPE, Exponents, Measures, unit_of
from simulate.model.rig import Rig

Bounds = dict[str, tuple[float, float]]
RigT = TypeVar("RigT", bound=Rig)
EffectT = TypeVar("EffectT", bound="Effect")
_LARGEST = sys.float_info.max
ANY_RIG = 1e6  # times the bounds for the prototype: no rig is so much larger or smaller


def parameter(
    default: float | tuple[float, ...],
    *,
    low: float,
    high: float,
    typical: float,
    doc: str,
    source: str = "",
    starts: tuple[float | tuple[float, ...], ...] = (),
    linear: bool = True,
    units: tuple[str, ...] = (),
    mirror: str = "",
) -> Any:
    """A parameter of an effect; its unit stands in its name.

    Parameters
    ----------
    default : the value that switches the effect off; a tuple for a vector.
    low, high : bounds, the same for every entry of a vector. A sign that physics excludes is excluded here.
    typical : a size at which the effect would be noticed; a search starts there. Sizes and bounds that have a unit are those for
        a rig of the prototype's measures, see `measures`.
    doc, source : what it is, and where the formula or the bounds come from.
    starts : values from which a search starts, for a parameter that shapes an effect (a time constant, a frequency) and shows
        nothing of itself while the effect is off; of an effect that is not linear, sizes at which it is tried.
    linear : whether the effect grows in proportion to it from where it is switched off; a gap that opens does not.
    units : of each entry, `N_per_m`, where the name does not end with it.
    mirror : what a vector becomes on a rig that is seen in a mirror: "shift" (x, y, z of a place, a speed, an axis), "rotation"
        (about x, y, z), "legs" (one value a leg), "joints" (x, y, z of the six base joints, then of those of the platform); else the same.

    Returns
    -------
    A field of the effect's dataclass.
    """
    limits = {"low": low, "high": high, "typical": typical, "doc": doc, "source": source, "units": units}
    return field(default=default, metadata={**limits, "starts": starts, "linear": linear, "mirror": mirror})


class Formulas:
    """The compiled formulas of an effect, none by default (a plain class, so that they are not taken for parameters)."""

    leg_force: Any = None
    leg_mass: Any = None
    strip_elongation: Any = None
    leg_asymptotes: Any = None
    leg_transverse: Any = None
    joint_resistance: Any = None
    platform_wrench: Any = None
    platform_mass: Any = None
    base_mass: Any = None
    base_force: Any = None


@dataclass(frozen=True)
class Effect(Formulas):
    """One physical effect. Subclasses add parameters, made with `parameter`, and those of these methods by which they act.

    Formulas compiled for the kernels, all static, SI units (u elongation, v = u', R the hysteretic force of the leg,
    travel = elongation since the last reversal, huge before the first, p parameters):

        leg_force(u, v, t, R, travel, p) -> N        added to the leg's force, positive pushes the platform away
        leg_mass(u, p) -> kg                         axial inertia: the leg's force falls by leg_mass * u''
        strip_elongation(u, before, p) -> m          what of the leg's elongation reaches the strip, that is the force law,
                                                     which stood at `before`; u where nothing lies between
        leg_asymptotes(u, v, t, p, h)                changes h[0] = h_l and h[1] = h_u in place
        leg_transverse(length, full_length, p, g)    adds inertia across the leg at its platform joint to g[0], kg,
                                                     and its slope over the length to g[1], kg/m
        joint_resistance(rate, p) -> N m s           moment over angular speed, against the rotation of each joint
        platform_wrench(t, pose, twist, p, wrench)   adds force (3) and moment (3) at the centre of mass to wrench
        platform_mass(pose, p, mass)                 changes the bare platform's 6 x 6 mass matrix, row by row, symmetric
        base_mass(p) -> kg                           mass of the base ring, which moves along the vertical; zero holds it
        base_force(place, speed, p) -> N             what holds it, from its height over where it was and the rate of that

    pose is position of the centre of mass (3) and unit quaternion (4, scalar first), twist is velocity (3) and angular
    velocity (3), everything in world axes. Behind its own parameters an effect finds in p what its `constants_of` gave.

    Methods in Python (model is the rig with its base parameters; what is returned is of the same kind):

        adjust(model) -> model                       changes the base model (a stop, a release, a leg's stored force)
        constants_of(model) -> numbers               as many as `constants` says, for the formulas of a deployment
        stiffness(model) -> (N/m, N s/m)             what the formulas do not show at rest, a contact; the step follows it
        as_stated() -> effect                        the same with its numbers as one states them, each of `directions` a unit vector
        observe(time_s, channels) -> channels        what a camera makes of the motion, seen between its frames if it `remembers`
        true_time(shown_s) -> s                      the rig's time at which the camera's clock showed this
        observe_force(time_s, elongation, force)     what a load cell makes of the force
    """

    name: ClassVar[str]
    acts_on: ClassVar[str]
    constants: ClassVar[int] = 0
    directions: ClassVar[tuple[str, ...]] = ()
    remembers: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for item, size, low, high in _limits_of(type(self)):
            value = getattr(self, item.name)
            entries = value if size else (value,)
            if type(entries) is tuple and len(entries) == max(size, 1) and all(type(v) is float and low <= v <= high for v in entries):
                continue
            self._check(item.name, value, item.default, item.metadata)
            if size:
                object.__setattr__(self, item.name, tuple(float(v) for v in value))

    def _check(self, key: str, value: Any, default: Any, limits: Mapping[str, Any]) -> None:
        if isinstance(default, tuple) and not isinstance(value, tuple | list | np.ndarray):
            raise InputError(f'effect "{self.name}": {key} is {found(value)}; give a list of {len(default)} numbers.')
        entries = value if isinstance(default, tuple) else (value,)
        if isinstance(default, tuple) and len(entries) != len(default):
            raise InputError(f'effect "{self.name}": {key} has {len(entries)} values; give {len(default)}.')
        for entry in entries:
            if isinstance(entry, bool) or not isinstance(entry, int | float | np.floating) or not math.isfinite(entry):
                raise InputError(f'effect "{self.name}": {key} is {found(entry)}; give a finite number.')
            low, high = self._allowed(key, limits)
            if not low <= entry <= high:
                raise InputError(f'effect "{self.name}": {key} is {entry:g}; it must lie within {low:g} and {high:g}.')

    @staticmethod
    def _allowed(key: str, limits: Mapping[str, Any]) -> tuple[float, float]:
        """Between which values an entry may lie on any rig: a number between its bounds, a size with a unit far beyond them."""
        low, high = limits["low"], limits["high"]
        if all(unit_of(f"_{unit}") == NUMBER for unit in limits["units"] or (key,)):
            return low, high
        return low * ANY_RIG if low < 0.0 else low / ANY_RIG, high * ANY_RIG

    def adjust(self, model: RigT) -> RigT:
        """The base model as this effect changes it; most effects leave it alone."""
        return model

    def in_run(self, index: int) -> Effect:
        """The effect as it is in one deployment of a campaign, by its place there; most effects are the same in all."""
        del index
        return self

    def as_stated(self) -> Self:
        """The same effect with its numbers as one states them; most effects have one way only."""
        return self

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """What the formulas need to know of the base model; most effects need nothing."""
        del model
        return ()

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """Spring and damper that the formulas do not show at rest, N/m and N s/m; the step is chosen by them."""
        del model
        return 0.0, 0.0

    def observe(self, time_s: Array, channels: Mapping[str, Array]) -> Mapping[str, Array]:
        """The channels of a trajectory as they are seen; most effects do not stand between rig and camera."""
        del time_s
        return channels

    def true_time(self, shown_s: Array) -> Array:
        """The rig's time for a time shown by the camera's clock; most effects leave the clock alone."""
        return shown_s

    def observe_force(self, time_s: Array, elongation_m: Array, force_N: Array) -> Array:
        """The force as the load cell shows it; most effects do not stand between actuator and cell."""
        del time_s, elongation_m
        return force_N

    @classmethod
    def bounds(cls, model: Rig | None = None, measures: Measures = PROTOTYPE) -> Bounds:
        """Lower and upper bound of each flat parameter for a rig of these measures; an effect may narrow them for the model at hand."""
        del model
        rows = zip(cls._flat_metadata(), cls._ratios(measures), strict=True)
        return {name: (meta["low"] * ratio, meta["high"] * ratio) for (name, meta), ratio in rows}

    def own_bounds(self, model: Rig | None = None, measures: Measures = PROTOTYPE) -> Bounds:
        """The bounds within which a search that starts from this effect may move; most effects may go wherever their kind may."""
        return type(self).bounds(model, measures)

    def prior_spread(self, model: Rig, measures: Measures = PROTOTYPE) -> float:
        """One standard deviation of each parameter's prior, in typical sizes, of an effect that needs one to be fitted at all."""
        del model, measures
        return math.inf

    @classmethod
    def acts_on_shaker(cls) -> bool:
        """Whether an actuator alone on a shaker shows it: a force, a mass or asymptotes of a leg, or what a load cell makes of it."""
        formulas = (cls.leg_force, cls.leg_mass, cls.strip_elongation, cls.leg_asymptotes)
        return any(formula is not None for formula in formulas) or cls.observe_force is not Effect.observe_force

    @classmethod
    def typical(cls, measures: Measures = PROTOTYPE) -> Array:
        """A noticeable size of each flat parameter on a rig of these measures."""
        return np.array([meta["typical"] for _, meta in cls._flat_metadata()]) * cls._ratios(measures)

    @classmethod
    def _ratios(cls, measures: Measures) -> Array:
        """By how much each flat parameter is larger on a rig of these measures than on the prototype."""
        return np.array([measures.of(unit) for unit in cls._units()])

    @classmethod
    def _units(cls) -> list[Exponents]:
        """The unit of each flat parameter."""
        found = []
        for name, meta in cls._flat_metadata():
            units, (key, _, place) = meta["units"], name.partition("[")
            found.append(unit_of(f"_{units[int(place[:-1]) if place else 0]}") if units else unit_of(key))
        return found

    @classmethod
    def is_linear(cls) -> bool:
        """Whether the effect grows in proportion to its parameters from zero on, so that its derivative there describes its onset."""
        return all(meta["linear"] for _, meta in cls._flat_metadata())

    @classmethod
    def flat_names(cls) -> list[str]:
        """Names of the parameters with vectors laid flat: `force_N[0]`, `force_N[1]` ..."""
        return [name for name, _ in cls._flat_metadata()]

    @classmethod
    def _flat_metadata(cls) -> list[tuple[str, Mapping[str, Any]]]:
        rows = []
        for item in fields(cls):
            names = [f"{item.name}[{i}]" for i in range(len(item.default))] if isinstance(item.default, tuple) else [item.name]
            rows += [(name, item.metadata) for name in names]
        return rows

    def flat(self) -> Array:
        """The parameters as one vector, in the order of `flat_names`."""
        values = [getattr(self, item.name) for item in fields(self)]
        return np.array([entry for value in values for entry in (value if isinstance(value, tuple) else (value,))], dtype=float)

    def starts(self, measures: Measures = PROTOTYPE) -> tuple[Self, ...]:
        """The effect with its shape at every combination of the values from which a search starts; itself where there are none."""
        ratios = {item.name: measures.of(unit_of(item.name)) for item in fields(self)}
        shapes = [
            (item.name, [_times(value, ratios[item.name]) for value in item.metadata["starts"]])
            for item in fields(self)
            if item.metadata["starts"]
        ]
        return tuple(
            replace(self, **dict(zip([name for name, _ in shapes], values, strict=True)))
            for values in product(*(values for _, values in shapes))
        )

    def with_flat(self, vector: Array) -> Self:
        """The same effect with other parameters, given as one vector."""
        changed: dict[str, Any] = {}
        place = 0
        for item in fields(self):
            size = len(item.default) if isinstance(item.default, tuple) else 1
            entries = [float(v) for v in vector[place : place + size]]
            changed[item.name] = tuple(entries) if isinstance(item.default, tuple) else entries[0]
            place += size
        return replace(self, **changed)


@cache
def _limits_of(kind: type[Effect]) -> list[tuple[Field[Any], int, float, float]]:
    """Each parameter of a kind: its length, zero for a single number, and the least and largest finite value that it may have."""
    rows = []
    for item in fields(kind):
        low, high = kind._allowed(item.name, item.metadata)
        rows.append((item, len(item.default) if isinstance(item.default, tuple) else 0, max(low, -_LARGEST), min(high, _LARGEST)))
    return rows


def _times(value: float | tuple[float, ...], ratio: float) -> float | tuple[float, ...]:
    return tuple(ratio * entry for entry in value) if isinstance(value, tuple) else ratio * value


Catalogue = Mapping[str, type[Effect]]


class LegEffect(Effect):
    """An effect inside every leg; it shows in a loop as well as in a deployment."""

    acts_on = "leg"


class PlatformEffect(Effect):
    """An effect on the platform as a whole."""

    acts_on = "platform"


class ModelEffect(Effect):
    """A base quantity that is not what the model file says (a stop, a release, the legs one by one)."""

    acts_on = "model"


class MeasurementEffect(Effect):
    """An effect between the rig and the numbers: camera, clock or load cell."""

    acts_on = "measurement"


def effects_among(namespace: Mapping[str, Any]) -> list[type[Effect]]:
    """The kinds of effects among the names of a module, in the order in which they stand there: those that have a name of their own."""
    kinds = [value for value in namespace.values() if isinstance(value, type) and issubclass(value, Effect)]
    return [kind for kind in kinds if isinstance(getattr(kind, "name", None), str)]


def effect_from(catalogue: Catalogue, name: str, parameters: Mapping[str, Any]) -> Effect:
    """Make an effect from its entry in a model file.

    Parameters
    ----------
    catalogue : the kinds of effects by name.
    name, parameters : as the file gives them, in the units of their names.

    Raises
    ------
    InputError
        No such effect, or no such parameter; the nearest known one is named.
    """
    if name not in catalogue:
        raise InputError(f'no effect is named "{name}"; {nearest(name, catalogue)}')
    kind = catalogue[name]
    known = [item.name for item in fields(kind)]
    if unknown := [key for key in parameters if key not in known]:
        raise InputError(f'effect "{name}" has no parameter "{unknown[0]}"; {nearest(unknown[0], known)}')
    return kind(**parameters)
