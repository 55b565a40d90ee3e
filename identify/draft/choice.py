"""Which form of the grammar says what a table of forces says, with the fewest numbers.

Around a fit the measurements say of a table's forces F, base and releases and all else integrated out,

    -2 ln L(F) = F' A F - 2 b' F + constant,

with A the information and A^-1 b the forces that suit best. A form f(x; p) takes the place of F; its amplitudes follow in one step, its
shapes by a search from several starts. Forms are compared by  gain - parameters x ln(samples),  as in the BIC.

A force on the platform may act off its centre of mass, at an arm a: F along one axis and a F as a moment go with one course then, of which
A_ff + a (A_fm + A_mf) + a^2 A_mm  and  b_f + a b_m  are the information and the drive.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar

from identify.criteria import ENOUGH
from identify.draft.forms import FORMS, Form, sum_of
from identify.gap.leg_force import ForceAlongLegSpeed, LegTable
from identify.gap.platform_force import AXES, KNOTS, MOVES, ForceAlongSpeed, ForceTable
from identify.gap.unnamed import Unnamed
from measure.common.arrays import Array

_SEARCHED = 3  # starts from which shapes are searched on
_ADDED_TO = 3  # forms to which another one is added
_CLOSE_ENOUGH = 1e-3  # of the places' extent, for a shape: the form is fitted to the measurements themselves afterwards
_ANGLES = 36  # at which an arm is tried, from a moment by itself over a force by itself to the moment turned round
_MOMENT = MOVES.index("theta_y_rad")  # the axis of the moment; those before it are of forces
_WORTH_MORE = 2.0  # times what noise brings that a form leaves, from which on another one is added


@dataclass(frozen=True)
class Chosen:
    """A form for a table. values : (k,) its parameters. score : gain less the price of its parameters.

    axis : of what acts on the platform: upwards, to the side, or a moment. arm_m : at which a force acts there, None for one at the centre
    of mass.
    """

    table: Unnamed
    form: Form
    values: Array
    score: float
    axis: int = 0
    arm_m: float | None = None

    @property
    def shapes(self) -> Array:
        """Its shapes, behind the amplitudes."""
        return self.values[len(self.form.amplitudes) :]

    @property
    def rank(self) -> float:
        """What forms of different tables are compared by: twice the log evidence of the table, less what the form leaves of its gain.

        Each table's gain is measured by the noise that is left with it, so gains by themselves compare forms of one table only.
        """
        return _rank(self.table, self.score)


def chosen_forms(tables: Sequence[Unnamed], samples: float, within: float = np.inf) -> list[Chosen]:
    """The best form of each table, those that say most first.

    Parameters
    ----------
    samples : number of independent samples that were measured.
    within : a rank so far below the best one is not asked for: what cannot come nearer is left out.
    """
    found: dict[int, Chosen] = {}
    ranked = [(_rank(tables[place], seen.at_best(samples)), place, axis, seen) for place, axis, seen in _all_seen(tables, samples)]
    for at_best, place, axis, seen in sorted(ranked, key=lambda row: -row[0]):
        if at_best < max((one.rank for one in found.values()), default=-np.inf) - within:
            break
        one = _best_on(tables[place], seen, samples)
        if one is not None and (place not in found or one.score > found[place].score):
            found[place] = replace(one, axis=axis, arm_m=seen.arm_m)
    return sorted(found.values(), key=lambda one: -one.rank)


def _rank(table: Unnamed, score: float) -> float:
    return 2.0 * table.log_z + score - _most(table.information, table.drive)


def _most(information: Array, drive: Array) -> float:
    """Fall of -2 ln L that forces of any course bring; of noise alone about their number."""
    return float(drive @ np.linalg.lstsq(information, drive, rcond=1e-12)[0])


def _all_seen(tables: Sequence[Unnamed], samples: float) -> Iterator[tuple[int, int, _Seen]]:
    """Which table, which axis of it, and what was measured there; of a force at an arm where that says more than its price."""
    for place, table in enumerate(tables):
        alone = {}
        for axis in range(AXES) if isinstance(table.table, ForceTable) else range(isinstance(table.table, LegTable)):
            rows = _rows_of(table, axis)
            if len(rows):
                alone[axis] = _Seen(_x_of(table, rows), table.information[np.ix_(rows, rows)], table.drive[rows])
                yield place, axis, alone[axis]
        for axis in [axis for axis in alone if axis < _MOMENT and _MOMENT in alone]:
            seen = _off_centre(table, axis)
            if seen is not None and seen.most > max(alone[axis].most, alone[_MOMENT].most) + seen.price_of(0, samples):
                yield place, axis, seen


def _rows_of(table: Unnamed, axis: int) -> NDArray[np.intp]:
    """Rows of an axis of a table on the platform, or all rows of one in the legs."""
    return np.flatnonzero(table.places // KNOTS == axis) if isinstance(table.table, ForceTable) else np.arange(len(table.places))


def _x_of(table: Unnamed, rows: NDArray[np.intp]) -> Array:
    """Places of the variable of some rows, (n,)."""
    assert isinstance(table.table, LegTable | ForceTable)
    return table.table.places[table.places[rows] % KNOTS]


def _off_centre(table: Unnamed, axis: int) -> _Seen | None:
    """What was measured of a force along an axis that makes a moment at the likeliest arm; None where the two share no places."""
    force, moment = _rows_of(table, axis), _rows_of(table, _MOMENT)
    shared = np.intersect1d(table.places[force] % KNOTS, table.places[moment] % KNOTS)
    if not len(shared):
        return None
    f, m = (rows[np.isin(table.places[rows] % KNOTS, shared)] for rows in (force, moment))
    of_f, of_m, mixed = (table.information[np.ix_(rows, others)] for rows, others in ((f, f), (m, m), (f, m)))
    size = float(np.sqrt(np.trace(of_f) / np.trace(of_m)))

    def at(angle: float) -> _Seen:
        arm = size * float(np.tan(angle))
        information = of_f + arm * (mixed + mixed.T) + arm**2 * of_m
        return _Seen(_x_of(table, f), information, table.drive[f] + arm * table.drive[m], arm)

    step = np.pi / _ANGLES
    begun = max(np.arange(1, _ANGLES) * step - 0.5 * np.pi, key=lambda angle: at(angle).most)
    best = minimize_scalar(lambda angle: -at(angle).most, bounds=(begun - step, begun + step), method="bounded")
    return at(float(best.x))  # type: ignore[attr-defined]


def _best_on(table: Unnamed, seen: _Seen, samples: float) -> Chosen | None:
    """The best form of a table, or sum of that and another one; on the platform of one axis."""
    x = seen.x
    known = [form for form in FORMS if _makes_sense(form, table, x)]
    ends = (float(x[0]), float(x[-1]))
    tried = [one for form in known if (one := _fitted(form, seen, table, samples, form.starts(*ends))) is not None]
    tried.sort(key=lambda one: -one.score)
    if not tried or tried[0].score >= seen.most - _WORTH_MORE * len(x):
        return tried[0] if tried else None
    best = tried[0]
    for first in tried[:_ADDED_TO]:
        for form in known:
            both = sum_of(first.form, form)
            if both.parameters < len(x) and seen.most - seen.price_of(both.parameters, samples) > best.score:
                starts = [(*first.shapes.tolist(), *shapes) for shapes in form.starts(*ends)]
                one = _fitted(both, seen, table, samples, starts)
                best = one if one is not None and one.score > best.score else best
    return best


def _makes_sense(form: Form, table: Unnamed, x: Array) -> bool:
    speed = isinstance(table.table, ForceAlongLegSpeed | ForceAlongSpeed)
    if form.only_platform and isinstance(table.table, LegTable):
        return False
    if form.name == "decay" and (speed or x[0] < 0.0):
        return False
    return (speed or not form.only_speed) and form.parameters < len(x)


@dataclass(frozen=True)
class _Seen:
    """What was measured of the forces at places x, (n,), at an arm if they act off the centre of mass."""

    x: Array
    information: Array
    drive: Array
    arm_m: float | None = None

    def price_of(self, parameters: int, samples: float) -> float:
        """What a form of so many parameters has to gain; the arm is one more."""
        return (parameters + (self.arm_m is not None)) * float(np.log(samples))

    def at_best(self, samples: float) -> float:
        """The score that no form exceeds: that of any course for the price of a single parameter."""
        return self.most - self.price_of(1, samples)

    @cached_property
    def most(self) -> float:
        """Fall of -2 ln L that forces of any course bring; of noise alone about their number."""
        return _most(self.information, self.drive)

    def gain(self, form: Form, shapes: Sequence[float] | Array) -> tuple[float, Array]:
        """Fall of -2 ln L against no force, and the amplitudes that make it."""
        basis = form.basis(self.x, shapes)
        if not np.isfinite(basis).all():
            return 0.0, np.zeros(basis.shape[1])
        pull, matrix = basis.T @ self.drive, basis.T @ self.information @ basis
        if len(pull) == 1:
            amplitudes = pull / matrix[0] if matrix[0, 0] > 0.0 else np.zeros(1)
        else:
            amplitudes = np.linalg.lstsq(matrix, pull, rcond=1e-12)[0]
        return float(pull @ amplitudes), amplitudes


def _fitted(form: Form, seen: _Seen, table: Unnamed, samples: float, starts: Sequence[tuple[float, ...]]) -> Chosen | None:
    first, last = float(seen.x[0]), float(seen.x[-1])
    tried = sorted(starts, key=lambda shapes: -seen.gain(form, shapes)[0])[:_SEARCHED]
    found = [_searched(form, seen, shapes, first, last) for shapes in tried]
    shapes = max(found, key=lambda one: seen.gain(form, one)[0])
    gain, amplitudes = seen.gain(form, shapes)
    if gain <= 0.0:
        return None
    return Chosen(table, form, np.array([*amplitudes, *shapes]), gain - seen.price_of(form.parameters, samples))


def _searched(form: Form, seen: _Seen, shapes: tuple[float, ...], first: float, last: float) -> tuple[float, ...]:
    """Shapes searched on from a start, within their bounds."""
    if not shapes:
        return shapes
    bounds = [shape.bounds(first, last) for shape in form.shapes]
    width = last - first
    ends = [(low / width, high / width) for low, high in bounds]
    found = minimize(
        lambda parts: -seen.gain(form, (parts * width).tolist())[0],
        np.array(shapes) / width,
        bounds=ends,
        method="Nelder-Mead",
        options={"xatol": _CLOSE_ENOUGH, "fatol": ENOUGH},
    )
    return tuple((found.x * width).tolist())
