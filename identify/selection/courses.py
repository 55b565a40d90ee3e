"""A stand taken uphill, to where it is likeliest, and led there by ever longer films: behind the stops straight lines lead nowhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from identify.criteria import CLOSE, HARDLY, NEAR, TO_COMPARE
from identify.estimation.covariance import Factored, within_bounds
from identify.estimation.horizons import stretches
from identify.estimation.problem import Problem
from identify.gap.gap_test import leaves_noise
from identify.noise.noise_model import ChannelNoise
from identify.selection.evidence import Evidence
from identify.selection.stand import Stand
from measure.common.arrays import Array

_MOST_STEPS = 25  # until a place is settled
_OF_A_LEG = 3.0  # log probability that a step must bring where longer films follow
_MOST_BENDS, _NEARER = 3, 0.7  # of a step that fails; what it may miss after one, in parts of what it missed before
_OF_GAIN = 0.3  # error of an evidence on the way, in parts of what a step must bring


@dataclass(frozen=True)
class Leg:
    """Where a stand came to with films up to some time: its log evidence, its place (k,), and the information (k, k) of that.

    A course has one for each time, the earliest first. misses : whether more than noise is left of these films. rms : of what is left.
    """

    log_z: float
    place: Array
    information: Factored
    misses: bool
    rms: float

    @classmethod
    def of(cls, stand: Stand, found: Evidence) -> Leg:
        """Of a stand and its evidence."""
        first = len(found.step)
        place = np.concatenate([stand.fit.q[:first], stand.sizes[stand.free()], stand.fit.q[first:]])
        return cls(found.log_z, place, found.information, not leaves_noise(stand.fit, found.noise), stand.fit.rms)

    def only_follows(self, other: Leg, information: Factored) -> bool:
        """Whether it fell far behind another, or came to where that has been, as the information (k, k) of longer films has it.

        Where it misses the films already it has to be as likely as the other: longer films cannot show it to be right.
        """
        return self.log_z < other.log_z - (0.0 if self.misses else NEAR) or 0.5 * information.over(self.place - other.place) <= NEAR


Course: TypeAlias = list[Leg]
Tried: TypeAlias = tuple[float, Problem, Array, Array, Array]


def led_beside(stand: Stand, q: Array, sizes: Array, courses: list[Course], *, in_any_case: bool = False) -> Stand | None:
    """A stand led from a place by ever longer films, beside other courses, to which its own is added.

    None where it only follows one, or leaves much more of longer films than of the first: still longer ones cannot show it to be right.

    in_any_case : whether it is led on then, for there is no other place.
    """
    course: Course = []
    others = list(courses)
    courses.append(course)
    *shorter, whole = stretches(stand.given)
    for place, stretch in enumerate(shorter):
        early, found = _led_on(stand, q, sizes, _met(course, others), *stretch)
        q, sizes = early.fit.q, early.sizes
        course.append(Leg.of(early, found))
        if any(course[place].only_follows(other[place], other[-1].information) for other in others if len(other) > place):
            return None
        if course[place].misses and course[place].rms >= CLOSE * course[0].rms and not in_any_case:
            return None
    return stepped(*_led_on(stand, q, sizes, _met(course, others), *whole), most=TO_COMPARE)[0]


def _met(course: Course, others: list[Course]) -> float | None:
    """Root mean square that a course leaves of the films it has met so far; None where it missed them or another course is ahead."""
    last = len(course) - 1
    if last < 0 or course[last].misses or any(course[last].log_z < other[last].log_z for other in others if len(other) > last):
        return None
    return course[last].rms


def _led_on(stand: Stand, q: Array, sizes: Array, met: float | None, end: float, middle: float) -> tuple[Stand, Evidence]:
    """A stand led on with films up to a time, s; where it misses them but met shorter ones, by way of the middle if not far off there.

    met : root mean square that it left of the shorter ones, None where it missed them or another course is ahead.
    """
    there = _leg(stand, q, sizes, end)
    if met is None or leaves_noise(there[0].fit, there[1].noise):
        return there
    early, _ = _leg(stand, q, sizes, middle)
    return there if early.fit.rms >= CLOSE * met else max(there, _leg(stand, early.fit.q, early.sizes, end), key=lambda one: one[1].log_z)


def _leg(stand: Stand, q: Array, sizes: Array, horizon: float) -> tuple[Stand, Evidence]:
    """A stand settled from a place with films up to a time, s."""
    early = cut(stand, q, sizes, horizon)
    return _uphill(early, early.weighed(same=_OF_GAIN * _OF_A_LEG), _OF_A_LEG, TO_COMPARE, surely=False)


def cut(stand: Stand, q: Array, sizes: Array, horizon: float) -> Stand:
    """A stand at a place with films up to a time, s."""
    early = replace(stand, given=stand.given.until(horizon))
    return early.at(early.with_errors(sizes), q, sizes)


def stepped(stand: Stand, found: Evidence, gain: float = HARDLY, most: int = _MOST_STEPS) -> tuple[Stand, Evidence]:
    """A stand taken uphill while a step brings the log probability that gain, and its evidence there as far as the simulation keeps it."""
    stand, found = _uphill(stand, found, gain, most)
    stand = stand if stand.is_fresh else stand.anew
    return stand, stand.borne_out(stand.weighed(found.noise))


def _uphill(stand: Stand, found: Evidence, gain: float, most: int, *, surely: bool = True) -> tuple[Stand, Evidence]:
    """A stand taken uphill; its linear pieces may come from the way, and its evidence is as exact as the gain."""
    length = np.inf
    for _ in range(most):
        after, length = _a_step_on(stand, found, gain, length, surely)
        if after is None:
            break
        stand, found = after, after.weighed(found.noise, _OF_GAIN * gain)
    return stand, found


def _a_step_on(stand: Stand, found: Evidence, gain: float, length: float, surely: bool) -> tuple[Stand | None, float]:
    """The stand a step farther, or at the same place with linear pieces worked out anew, and the length from which to try the next step.

    From fresh pieces ever shorter steps are tried; the stand is None where none that promises the gain brings it. How far straight lines
    lead changes little along a way: the next step may be twice as long.

    length : of the first step that is tried. surely : whether pieces from the way are worked out anew, too, where they promise nothing.
    """
    way, before, known = _way_within(stand, found), stand.log_probability(found.noise), found.information
    for reached, step in known.ever_shorter(way, 2.0 * gain, length):
        there = tried(stand, step, found.noise)
        if stand.is_fresh:
            promised = before + 0.5 * (known.over(way) - known.over(way - step))
            there = _bent(stand, found, step, there, before + gain, promised)
        if there[0] > before + gain:
            return stand.moved_to(*there[1:]), 2.0 * reached
        if not stand.is_fresh:
            return stand.anew, reached
    return stand.anew if surely and not stand.is_fresh else None, length


def _bent(stand: Stand, found: Evidence, step: Array, there: Tried, least: float, promised: float) -> Tried:
    """What a step brings once all parameters have made up for what straight lines left out; again while it misses much less each time.

    Along what the measurements hardly tell, the likeliest places lie on a bent line. least : log probability that is enough. promised : by
    the lines, where the step leads.
    """
    slopes, measured = stand.fit.jacobian, stand.given.measured
    for _ in range(_MOST_BENDS):
        if there[0] > least:
            break
        _, _, q, sizes, gaps = there
        left_out = (gaps - stand.fit.gaps - slopes @ (q - stand.fit.q))[:measured] - stand.errors.columns @ (sizes - stand.sizes)
        again = tried(stand, step + found.answer_to(left_out), found.noise)
        if promised - again[0] >= _NEARER * (promised - there[0]):
            break
        there = again
    return there


def tried(stand: Stand, way: Array, noise: tuple[ChannelNoise, ...]) -> Tried:
    """What a step brings a stand to: a log probability, and the problem, its parameters (k,), errors (q,) and gaps (m,) there."""
    (step, change), (low, high) = _parted(stand, way), stand.bounds
    q, sizes = np.clip(stand.fit.q + step, low, high), stand.sizes + change
    problem = stand.with_errors(sizes)
    gaps = problem.gaps(q)
    return stand.log_probability_at(gaps, q, sizes, noise), problem, q, sizes, gaps


def _way_within(stand: Stand, found: Evidence) -> Array:
    """How far base and releases, errors and amounts (p + q + k,) are from where an evidence has them within their bounds."""
    step, errors = stand.step(found), found.errors - stand.sizes[stand.free()]
    first, wide = len(found.step), np.full(len(errors), np.inf)
    low, high = (np.insert(end - stand.fit.q, first, side * wide) for end, side in zip(stand.bounds, (-1.0, 1.0), strict=True))
    return within_bounds(np.insert(step, first, errors), found.covariance, low, high)


def _parted(stand: Stand, way: Array) -> tuple[Array, Array]:
    """The same as steps of the parameters (k,) and of the errors (q,)."""
    kept, first, change = stand.free(), stand.fit.problem.first_effect, np.zeros(len(stand.sizes))
    own = slice(first, first + int(kept.sum()))
    change[kept] = way[own]
    return np.delete(way, own), change
