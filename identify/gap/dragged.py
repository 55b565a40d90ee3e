"""Releases and laws that a fit moved far beyond what the model file allows: rather another rig, table or clock than a missing effect."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from identify.criteria import DRAGGED, LAW_LOST
from identify.estimation.parameters import BASE, STORED_FORCE, Parameter
from identify.estimation.problem import Fit
from simulate.model.rig import Geometry

_HEIGHT = "position_z_m"
_SAID = 2


@dataclass(frozen=True)
class Dragged:
    """A parameter that a fit moved by many of its spreads.

    name : the parameter's. shift : how far, in its own unit. spreads : the same in standard deviations of what is known of it beforehand.
    looks_like : what that points to, and what to write; nothing where only the user can tell.
    """

    name: str
    shift: float
    spreads: float
    looks_like: str = ""

    @property
    def sentence(self) -> str:
        """For people."""
        words = f"the fit moved {self.name} by {self.shift:.3g}, {self.spreads:.0f} times its spread"
        return f"{words}; {self.looks_like}" if self.looks_like else words


def in_words(moved: Sequence[Dragged]) -> list[str]:
    """The farthest few in a sentence each, those first that point to something, and how many more there are."""
    first = sorted(moved, key=lambda one: (not one.looks_like, -one.spreads))
    more = len(moved) - _SAID
    rest = [f"{more} more were moved by over {DRAGGED:.0f} of their spreads"] if more > 0 else []
    return [*(one.sentence for one in first[:_SAID]), *rest]


def dragged(fit: Fit) -> tuple[Dragged, ...]:
    """What a fit moved by more than ten standard deviations of its prior, the farthest first."""
    geometries = {film.run.name: film.model.geometry for film in fit.problem.films}
    found = []
    for q, one in zip(fit.q[: fit.problem.first_effect], fit.problem.parameters, strict=False):
        spreads = abs(float(q)) / one.spread if np.isfinite(one.spread) else 0.0
        if spreads > DRAGGED:
            shift = one.shift(float(q))
            found.append(Dragged(one.name, shift, spreads, _looks_like(one, shift, geometries.get(one.run))))
    return tuple(sorted(found, key=lambda one: -one.spreads))


def _looks_like(one: Parameter, shift: float, geometry: Geometry | None) -> str:
    if one.key == _HEIGHT and geometry is not None:
        height = geometry.stowed_height_m + shift
        return (
            f"the run looks as if it began at {height:.4g} m and not at {geometry.stowed_height_m:.4g} m: if it did, write "
            f"geometry.stowed_height_m = {height:.4g} under its [run.model]; otherwise "
            "the table counts from another place, or the model lacks something"
        )
    if one.key == "length_scale":
        return (
            f"the film's scale looks off by {100.0 * shift:.3g} %: look at what it was measured from. "
            "If that is right the model lacks something, and what else was moved in this run is not to be believed either"
        )
    if one.key == "instant_s":
        return "the clock looks as if it did not begin at the release: shift time_s so that the release is at 0"
    if one.key == STORED_FORCE or one.key.startswith("stored_force_N"):
        return "the stored force looks like that of another spring or another temperature: look at actuator.b_l_N and initial_force_N"
    return "the law looks like that of another spring: fit it to loops of this one" if one.name in BASE else ""


def lost(fit: Fit) -> Iterator[str]:
    """Numbers of the law that a fit leaves less sure than by half of what the model file has; that law is no better than the file's."""
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    for i in range(fit.problem.first_rate):
        one = fit.problem.parameters[i]
        error = float(deviations[i]) * abs(one.slope(float(fit.q[i])))
        if np.isinf(one.spread) and fit.q[i] != 0.0 and one.start != 0.0 and error > LAW_LOST * abs(one.start):
            yield f"{one.name} would be {one.value(float(fit.q[i])):.3g} +- {error:.2g} where the model file has {one.start:.4g}"
