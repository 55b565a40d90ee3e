"""A hypothesis taken to where it is likeliest and weighed: with the model file as it is, and as far off as its tolerances allow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from identify.criteria import CREDIBLE, HARDLY, NEAR, ROUGHLY, UNUSUAL_P
from identify.estimation.horizons import before_the_stops, horizons
from identify.estimation.least_squares import solve, to_the_end
from identify.estimation.problem import Fit, Problem
from identify.gap.bent_law import is_bent, loops_miss, with_law_as_given
from identify.gap.gap_test import gap_test
from identify.noise.noise_model import ChannelNoise
from identify.selection.courses import Course, Leg, cut, led_beside, stepped, tried
from identify.selection.evidence import Both, Evidence
from identify.selection.first_look import Promise
from identify.selection.model_errors import sizes_in_tolerances
from identify.selection.promises import begun, posed
from identify.selection.stand import Stand, Weighed
from measure.common.arrays import Array
from simulate.model.rig import geometry_of

_FEW_STEPS, _SHARES = 8, (1.0, 0.5, 0.2, 0.1)  # of least squares, and parts of the first step of all that are tried
_DIRECTIONS, _OFF = 2, 3.0  # in which errors act across a mirror, and how many tolerances off they begin


def weighed(fit: Fit) -> Weighed:
    """Take a fit to the largest probability under coloured noise and tolerances, and weigh it there.

    Least squares have taken the noise for white and the model file for exact. Where its tolerances may matter they are simulated, too.
    A model file that misses as it is waits for these: it is taken uphill only if it may still hold a share.
    """
    exact, lost = Stand.exact(fit), loops_miss(fit)
    found, waits = exact.weighed(), exact.misses and not lost
    if not waits:
        exact, found = stepped(exact, found)
    within = Stand.loose(exact.fit)
    both = Both(found, None) if lost else _both(found, within)
    if both.share_of_exact <= CREDIBLE:
        within, of_within = settled(within, found.noise)
        both = Both(found, of_within)
    if waits and both.share_of_exact > 1.0 - CREDIBLE:
        exact, found = stepped(exact, found)
        both = replace(both, exact=found)
    return Weighed(exact, within, both)


def weighed_within(given: Problem, q: Array, errors: Mapping[tuple[str, int], float]) -> Weighed:
    """Weigh a hypothesis from where the model file is off by some errors; as it is, it is fitted from there in a few steps.

    given : the problem, with the model file as it is. q : (k,) its parameters. errors : by name and place, in tolerances.
    """
    return _weighed_from(Stand.off_by(given, q, errors))


def weighed_towards(stand: Stand, q: Array, errors: Mapping[tuple[str, int], float], noise: tuple[ChannelNoise, ...]) -> Weighed:
    """Weigh a hypothesis from where it stands, its first step towards another place: as far as that raises its probability under a noise.

    All the way where that moves what does not show here, as the period of a wave that has no height yet.

    q : (k,) the parameters there. errors : of the model file, by name and place, in tolerances.
    """
    sizes, first = np.array([errors.get(key, 0.0) for key in stand.errors.keys]), stand.fit.problem.first_effect
    step, shown = q - stand.fit.q, np.any(stand.columns.values != 0.0, axis=0)
    way = np.insert(step, first, (sizes - stand.sizes)[stand.free()])
    if np.any(step[first:][~shown] != 0.0):
        return _weighed_from(stand.moved_to(*tried(stand, way, noise)[1:]))
    best = max((tried(stand, share * way, noise) for share in _SHARES), key=lambda one: one[0])
    return _weighed_from(stand.moved_to(*best[1:]) if best[0] > stand.log_probability(noise) else stand)


def _weighed_from(stand: Stand) -> Weighed:
    within, found = stepped(stand, stand.weighed())
    short = solve(stand.given, within.fit.q, most_steps=_FEW_STEPS, enough=ROUGHLY, loosely=True)
    exact = Stand.exact(short)
    exact, of_exact = (exact, exact.weighed(found.noise)) if exact.misses else settled(exact, found.noise)
    return Weighed(exact, within, Both(of_exact, found if within.lines().errors.shape[1] else None))


def fitted(beside: Weighed, promise: Promise) -> Weighed:
    """A hypothesis with one name more, fitted whole from where it was promised."""
    problem, end = posed(beside, promise)
    if promise.errors is None or beside.both.is_exact:
        return weighed(to_the_end(solve(problem, end, loosely=True)))
    return weighed_towards(begun(beside, problem, promise, end), end, promise.errors, beside.evidence.noise)


def led_anew(one: Weighed) -> Weighed | None:
    """The same hypothesis led by ever longer films from base and releases as the model file has them, its effects as they are.

    Its fit began where the base had bent to what was missing, and may have stayed there. Where nothing is unusual, neither what it leaves
    nor where it stands, or where no film reaches its stop, behind which there are other places, only a law that is bent is begun anew. None
    where it falls behind what is there now or leads to no likelier place.
    """
    stand = one.within
    if not one.is_unusual or gap_test(one.fit).p_value > UNUSUAL_P or not horizons(stand.given):
        return _unbent(one)
    cuts = (cut(stand, stand.fit.q, stand.sizes, horizon) for horizon in horizons(stand.given))
    courses = [[Leg.of(early, early.weighed()) for early in cuts]]
    led = led_beside(stand, stand.origin, np.zeros(len(stand.sizes)), courses)
    there = led and _on_other_sides(stand, led, courses)
    if there is None or there.weighed().log_z < stand.weighed().log_z + HARDLY:
        return None
    return weighed_within(one.exact.given, there.fit.q, there.errors_by_key)


def _unbent(one: Weighed) -> Weighed | None:
    """The same hypothesis from the law as the model file has it, all else as it is, if that is likelier."""
    if one.fit.problem.loops or not is_bent(one.fit):
        return None
    q = one.fit.q.copy()
    q[: one.fit.problem.first_nuisance] = 0.0
    there = weighed_within(one.exact.given, q, one.within.errors_by_key)
    return there if there.log_z > one.log_z + HARDLY else None


def without(one: Weighed, name: str) -> Weighed:
    """Weigh a hypothesis with one name less from where it stands; an error of the model file becomes one within its tolerances."""
    given, there = one.exact.given, one.fit
    kept = np.setdiff1d(np.arange(len(there.q)), there.problem.rows_of(name))
    problem = given.with_effects([effect for effect in given.effects if effect.name != name])
    errors = errors_without(one, (name,))
    q = there.q[kept]
    return weighed_within(problem, q, errors) if errors else weighed(to_the_end(solve(problem, q, loosely=True)))


def errors_without(one: Weighed, names: Iterable[str]) -> dict[tuple[str, int], float]:
    """Errors of the model file by name and place, in tolerances, without some names; one that is an error itself becomes one of them."""
    errors = {} if one.both.is_exact else one.within.errors_by_key
    for name in names:
        errors |= sizes_in_tolerances(one.fit, name)
    return errors


def stands_of(one: Weighed, *, closely: bool = False) -> list[tuple[Weighed, float]]:
    """Where straight lines are taken, and what the hypothesis itself reaches with the same measurements.

    Close to the measurements they lead where they say. Farther off they are taken with the films up to their first stop as well. And as the
    law may have bent to what is missing, where no loops hold it, they are taken from the law of the model file, too. Beside names that
    leave noise a further one is small.

    closely : whether the first stop counts although the hypothesis seems to be close, for it is improbable or something else is likelier.
    """
    far = bool(one.fit.problem.films) and (closely or one.stand.misses)
    bends = not one.fit.problem.loops
    stands, problem = [(one, one.along_lines)], before_the_stops(one.exact.fit.problem)
    is_small = bool(one.names) and one.leaves_noise
    if is_small or not (far or (bends and is_bent(one.fit))):
        return stands
    near = weighed_within(problem, one.fit.q, errors_without(one, ())) if problem is not one.exact.fit.problem else one
    if far and near is not one:
        stands.append((near, near.along_lines))
    if not bends:
        return stands
    exact = Stand.exact(with_law_as_given(near.exact.fit))
    loose = Stand.loose(exact.fit)
    given = Weighed(exact, loose, _both(exact.weighed(), loose))
    return [*stands, (given, max(near.along_lines, given.along_lines))]


def _both(exact: Evidence, within: Stand) -> Both:
    return Both(exact, within.weighed(exact.noise) if within.lines().errors.shape[1] else None)


def settled(stand: Stand, noise: tuple[ChannelNoise, ...] = ()) -> tuple[Stand, Evidence]:
    """A stand taken to the largest probability under coloured noise, and its evidence there.

    Steps of Gauss and Newton, shortened where the simulation does not keep what the straight lines promise, as long as they raise the
    probability of measurements and parameters. With nothing added to the model films are met up to the first stop first, then ever further.
    """
    if len(stand.sizes) and not stand.names:
        stand = _from_afar(stand)
    return stepped(stand, stand.weighed(noise))


def _from_afar(stand: Stand) -> Stand:
    """A stand led by ever longer films from the model file as it is; where that leaves a gap, at last from least squares, which bend it."""
    courses: list[Course] = []
    start = np.where(stand.given.unseen, stand.fit.q, stand.origin)  # at nought nothing pulls at what no film shows
    led = led_beside(stand, start, np.zeros(len(stand.sizes)), courses, in_any_case=True)
    assert led is not None  # there is nothing to follow
    led = _on_other_sides(stand, led, courses)
    return _likelier(led, led_beside(stand, stand.fit.q, stand.sizes, [])) if led.misses else led  # it follows no course that missed


def _on_other_sides(stand: Stand, led: Stand, courses: list[Course]) -> Stand:
    """A stand as it was led, or a likelier one.

    Where what no film shows is improbable, it is led from either side of the mirror in which the films look the same, until that is
    probable. Where films are missed the first one that leads on ends the search: names may close the rest.
    """
    missed, begun = led.misses, led.weighed()
    if led.across_p(begun) >= UNUSUAL_P:
        return led
    for q, sizes in _off_to_sides(led):
        led = _likelier(led, led_beside(stand, q, sizes, courses))
        found = led.weighed()
        if (missed and found.log_z > begun.log_z + NEAR) or (not missed and led.across_p(found) >= UNUSUAL_P):
            break
    return led


def _likelier(one: Stand, other: Stand | None) -> Stand:
    return one if other is None else max(one, other, key=lambda each: each.weighed().log_z)


def _off_to_sides(stand: Stand) -> Iterator[tuple[Array, Array]]:
    """Parameters (k,) and errors (q,) off to either side of each mirror: along what of the errors changes its sign there and shows most.

    What no film shows of the releases is nought: to which side each of them falls the errors tell.
    """
    for axis, turned in stand.given.mirrors():
        q = stand.fit.q.copy()
        q[turned] = 0.0
        odd = stand.errors.odd_part(axis, geometry_of(stand.given.model))
        shown = np.linalg.svd(stand.errors.columns * stand.free() @ odd, full_matrices=False)[2]
        for direction in shown[:_DIRECTIONS]:
            yield q, _OFF * direction
            yield q, -_OFF * direction
