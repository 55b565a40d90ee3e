"""How large a hidden force is: in multiples of what the runs of the case can detect under its nuisances."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from board.bench import Bench, seen
from board.detectable import needed
from board.freedom import shown_besides
from board.shapes import Hidden
from board.yardstick import Yardstick

from simulate.model.model import Model

from .nuisances import FORCE, FORCES, alone, in_tolerances, tolerance_of, tolerances

Array = np.ndarray

EFFECT_SIZE, OUTSIDE_SIZE = 5.0, 10.0
SHOWS = 1.5  # times the detectable size, from which on a test finds an error in 95 of 100
_ROUNDS = 12
_PART = 1e-2  # of an error: so small a part acts along straight lines


@dataclass(frozen=True)
class LooseYardstick(Yardstick):
    """A yardstick that leaves free, too, what the model file may have wrong and what force each run started with."""

    @cached_property
    def besides(self) -> Array:
        """What cameras add, errors of the model file, and the stored force of each run, in their spreads, (m, k)."""
        bench = self.bench
        here = bench.here
        errors = [values - here for values in bench.vectors([other.rig.true for other in tolerances(bench)])]
        forces = [_whole(with_forces(bench, row), i, bench) - here for i, row in enumerate(1e-3 * FORCE * np.eye(len(bench.films)))]
        return np.hstack([shown_besides(bench), 1e3 * np.stack([*errors, *forces], axis=1)])


def with_forces(bench: Bench, off: Array) -> Bench:
    """The same with a stored force that is off by a part in each run, (runs,)."""
    level = np.broadcast_to(bench.rig.true.actuator.b_l_N, 6)
    films = tuple(replace(run, legs_N=run.legs_N + part * level) for run, part in zip(bench.films, off.tolist(), strict=True))
    return replace(bench, campaign=replace(bench.campaign, deployments=films))


def error_shows(name: str, built: Model, forces: Array, runs: LooseYardstick) -> float:
    """How many times what these runs can detect an error of the model file is, its own tolerance and all else free beside it.

    Along straight lines from the truth, of a small part of the error: a fit to the whole of it may be lost behind the stops, and would then
    count as shown what law and releases can follow. At most as many as the error has itself in its tolerances: it may be just these.

    built : the rig as it is. forces : (runs,) by what part the stored force is off in each deployment.
    """
    bench, of_films = runs.bench, forces[: len(runs.bench.films)]
    other = with_forces(bench, _PART * of_films) if name == FORCES else bench.with_model(alone(bench.rig.true, built, name, _PART))
    change = np.concatenate([other.here - bench.here, np.zeros(len(runs.free.basis) - len(bench.here))])
    left, own = runs.free.left(change) / _PART, in_tolerances(bench.rig.true, built, of_films, name)
    return float(np.sqrt(min(left @ left, own @ own) / needed(1)))


def _whole(other: Bench, number: int, bench: Bench) -> Array:
    """All values of the bench, those of one run from the other."""
    values = bench.here.copy()
    (values[bench.rows[number]],) = seen([(other.rig.true, other.runs[number])])
    return values


def amount_of(hidden: Hidden, runs: LooseYardstick, outside: bool) -> tuple[float, float]:
    """The amount to hide, and how many times the detectable one it is; 0, 0 where these runs cannot show it.

    The amount is found along straight lines, and therefore counted up to the stops only, but for what acts at the stops: behind them a
    release does not act linearly. Of a large effect all that is free may bend to more than straight lines foresee: then it is as many
    times the detectable one as what is left is. What the model file states with a tolerance must stand out from that, too.
    """
    multiple, wanted = OUTSIDE_SIZE if outside else EFFECT_SIZE, needed(1 if outside else hidden.parameters)
    amount = _detectable(hidden, runs, wanted)
    if amount is None:
        return 0.0, 0.0
    amount = max(amount, float(np.sqrt(wanted) * tolerance_of(hidden.name, runs.bench.rig.true) / np.linalg.norm(hidden.direction)))
    hide = min(multiple * amount, 0.9 * hidden.most)
    left = runs.left_by(runs.bench.with_model(runs.bench.rig.true.with_effect(hidden.at(hide))))
    return hide, min(hide / amount, float(np.sqrt(left @ left / wanted)))


def _detectable(hidden: Hidden, runs: LooseYardstick, wanted: float) -> float | None:
    """The amount that shows as much as is wanted; None where none does.

    Each guess takes what shows to grow by the square of the amount; a guess outside of where the amount must lie is replaced by its middle.
    """
    amount, shows, low, high = min(1.0, hidden.most), 0.0, 0.0, np.inf
    for _ in range(_ROUNDS):
        there = runs.bench.with_model(runs.bench.rig.true.with_effect(hidden.at(amount))).here
        left = runs.free.left(np.concatenate([there - runs.bench.here, np.zeros(len(runs.free.basis) - len(there))]))
        shows = float(left @ left)
        if abs(shows / wanted - 1.0) < 0.1 or (shows < wanted and amount == hidden.most):
            break
        low, high = (amount, high) if shows < wanted else (low, amount)
        by_square = amount * float(np.clip(np.sqrt(wanted / max(shows, 1e-9)), 0.02, 20.0))
        amount = min(by_square if low < by_square < high else float(np.sqrt(low * high)), hidden.most)
    return amount if shows > 0.5 * wanted else None
