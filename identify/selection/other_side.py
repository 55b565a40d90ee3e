"""A hypothesis on the other side of what no film shows: in the mirror, where a rig that nearly is its own image looks nearly the same.

Releases, centre of mass, legs and all other directions must change sides together: alone, no step leads there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from identify.criteria import CREDIBLE, ENOUGH, HARDLY, LOSES, TO_COMPARE
from identify.selection.courses import Course, led_beside, stepped
from identify.selection.evidence import Both
from identify.selection.model_errors import mirrored
from identify.selection.stand import Stand, Weighed
from measure.common.arrays import Array
from simulate.effects import CentreOfMassOffset, GeometryError
from simulate.model.mirror import mirrored_effect
from simulate.model.rig import geometry_of

_OFF = 2.0  # tolerances by which the centre of mass starts off to a side


def on_the_likelier_side(one: Weighed, *, thoroughly: bool = True) -> Weighed:
    """The same hypothesis, off by errors of the model file, or a likelier one, found from its mirror image across what no film shows.

    To a rig that is its own mirror image both would be one. The small things that make it none tell the sides apart, but lie in
    different minima.

    Parameters
    ----------
    thoroughly : whether the search starts from all places that may lead to the best one. Else it starts from the image, if films are
        close to it; and if that leads to no place as likely, from where ever longer films lead on the other side.
    """
    stand, found = one.within, one.both.within
    if found is None or one.both.share_of_exact > CREDIBLE:
        return one
    begun = found.kept
    for axis, turned in stand.given.mirrors():
        for start in _images(one.within, axis, turned, thoroughly=thoroughly):
            other, of_other = stepped(start, start.weighed(), most=TO_COMPARE)
            if of_other.kept > found.kept + HARDLY:
                stand, found = other, of_other
            if of_other.kept > begun - LOSES and not thoroughly:
                break
    if stand is one.within:
        return one
    stand, found = stepped(stand, found)
    return Weighed(one.exact, stand, Both(one.both.exact, found))


def all_sides(one: Weighed) -> tuple[Weighed, ...]:
    """Where the numbers of a hypothesis are stated, and in each mirror the same names on the other side; the likeliest comes first.

    Each is taken on until a step would move a parameter by less than a fifth of its standard error, and no prior draws it towards nought:
    to compare hypotheses it may be a whole one short. Names without a direction are the same on every side: then there is one only.
    """
    stand, noise = one.stand, one.evidence.noise
    images = [_image(stand, axis, turned) for axis, turned in stand.given.mirrors() if _has_sides(stand, axis)]
    places = [replace(place, widely=True) for place in (stand, *images)]
    sides = [stepped(place, place.weighed(noise), gain=0.5 * ENOUGH) for place in places]
    return tuple(Weighed(at, at, Both(of, None)) for at, of in sorted(sides, key=lambda side: -side[1].kept))


def brought_to(one: Weighed, stand: Stand) -> Weighed:
    """A hypothesis with its likelier stand at the place where it is stated, but with the priors by which it is compared."""
    at, both = replace(stand, widely=False), one.both
    found = at.weighed(one.evidence.noise)
    return Weighed(at, one.within, Both(found, both.within)) if both.is_exact else Weighed(one.exact, at, Both(both.exact, found))


def _has_sides(stand: Stand, axis: int) -> bool:
    """Whether an effect of the hypothesis is another one in the mirror."""
    return not np.allclose(_effects_in_mirror(stand, axis), stand.fit.q)


def _image(stand: Stand, axis: int, turned: Sequence[int]) -> Stand:
    """A stand in a mirror across an axis, some of its parameters turned round."""
    q = _effects_in_mirror(stand, axis)
    q[list(turned)] *= -1.0
    return Stand.placed(stand.given, q, mirrored(stand.errors_by_key, axis, geometry_of(stand.given.model)))


def _off_to(side: float, image: Stand, axis: int, turned: Sequence[int]) -> Stand:
    """An image whose centre of mass is off to a side, 1.0 or -1.0; its joints are as drawn, and what no film shows of a release is zero."""
    q, errors = image.fit.q.copy(), image.errors_by_key
    q[list(turned)] = 0.0
    drawn = {key: 0.0 for key in errors if key[0] == GeometryError.name}
    return Stand.placed(image.given, q, errors | drawn | ({(CentreOfMassOffset.name, axis): _OFF * side} if errors else {}))


def _effects_in_mirror(stand: Stand, axis: int) -> Array:
    """Parameters (k,) of a stand with its effects in a mirror."""
    problem, q = stand.given, stand.fit.q.copy()
    for shape, effect in zip(problem.effects, problem.effects_at(q), strict=True):
        rows, image = problem.rows_of(effect.name), mirrored_effect(effect, axis, geometry_of(stand.given.model))
        q[rows] = (image.flat() - shape.flat()) / problem.scales[rows]
    return q


def _images(stand: Stand, axis: int, turned: Sequence[int], *, thoroughly: bool) -> Iterator[Stand]:
    """Where a search on the other side starts: from the mirror image, and from where ever longer films lead.

    The films lead from a centre of mass on the other side than it is now. A thorough search starts from both sides, for releases and joints
    may have bent to the wrong one. Left out is a start that only follows one before it, and, if the search is not thorough, an image that
    is far from the films.
    """
    image = _image(stand, axis, turned)
    if thoroughly or not image.misses:
        yield image
    other = math.copysign(1.0, image.errors_by_key.get((CentreOfMassOffset.name, axis), 0.0))
    courses: list[Course] = []
    for side in (other, -other) if thoroughly else (other,):
        start = _off_to(side, image, axis, turned)
        led = led_beside(start, start.fit.q, start.sizes, courses)
        if led is not None:
            yield led
