"""A controller designed and certified: gains searched on the corners of what differs, failures counted on fresh draws.

The draws that certify are never those that decided. Where a certificate is refused the angles are tightened and the search goes on, on new
draws, at most three times; each certificate then has a third of the doubt that is allowed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from measure.common.running.duration import timed
from simulate.control.catalogue import known_laws
from simulate.control.certificate import MOST_DRAWS, counted, described, draws_for, margins
from simulate.control.gain_search import Found, Scales, Search, ranges_of, scales_of
from simulate.control.task import LIMIT, Design, Task
from simulate.control.trials import Trials, turned_deg
from simulate.control.uncertainty import STOPS, with_stops
from simulate.deployment.deploy import deploy
from simulate.model.control import Controller, SampledController
from simulate.model.model import Model

RESERVE, TIGHTER, TRIES = 1.25, 1.3, 3
_MARGIN_DRAWS, _RIVAL_DRAWS, _RIVAL_POINTS = 128, 512, 16
_MOST_FORCE = 2.0  # mean stored forces, what other laws may use

_MARGINS = 20  # changes of a controller that are tried, about
Say = Callable[[str], object]
Foretell = Callable[[float], object]


def design_control(task: Task, say: Say = lambda _: None, foretell: Foretell = lambda _: None) -> Design:
    """Choose the gains of a law and certify them.

    Parameters
    ----------
    task : what is to be designed.
    say : called with each part of the work as it begins. foretell : called before it with about how many seconds it takes.

    Raises
    ------
    InputError
        No such law; more draws than anybody waits for; a rig that does not reach its full height even without control.
    """
    _require_possible(task)
    scales = scales_of(task.model, task.uncertainty.disparity, _rise_s(task.model))
    search = _search_of(task, known_laws()[task.law], task.fixed, scales, RESERVE)
    foretell(_seconds(task, search))
    found, certificate, tries = _found(task, search, say)
    nearest = found or search.nearest()
    verdict = "none-found" if found is None else "certified" if _all(certificate) else "not-certified"
    report = {
        "verdict": verdict,
        "law": task.law,
        "controller": nearest.controller.table(),
        "requirements": [r._asdict() for r in task.requirements],
        "confidence": task.confidence,
        "certificate": certificate,
        "tries": tries,
        **_judged(task, nearest, scales, search, say),
    }
    return Design(task, nearest.controller if found is not None else None, nearest.controller, report)


def _found(task: Task, search: Search, say: Say) -> tuple[Found | None, list[dict[str, Any]], int]:
    """The controller, its certificate, and how many were tried; None where no gains were good enough on the corners."""
    last: Found | None = None
    certificate: list[dict[str, Any]] = []
    for tries in range(TRIES):
        say("gains on the corners")
        found = search.least(task.most_force_N, task.seed + tries)
        if found is None:
            return last, certificate, tries
        say("fresh draws")
        last, certificate = found, _certified(task, found.controller, tries)
        if _all(certificate):
            return last, certificate, tries + 1
        if tries + 1 < TRIES:
            search.reserve *= TIGHTER
            search.tried.clear()
    return last, certificate, TRIES


def _seconds(task: Task, search: Search) -> float:
    """About how long the whole takes where the first certificate holds, from one try on the corners."""
    corners, rivals = len(search.trials.rows), len(known_laws()) - 1
    runs = corners * search.most_tries + len(STOPS) * (_draws(task) + _RIVAL_DRAWS) + _MARGINS * _MARGIN_DRAWS
    runs += rivals * (corners * _RIVAL_POINTS * 3 // 2 + _RIVAL_DRAWS)
    return timed(lambda: search.untold(task.most_force_N)) * runs / corners


def _require_possible(task: Task) -> None:
    laws = known_laws()
    if task.law not in laws:
        raise InputError(f'no law is named "{task.law}"; take one of {", ".join(laws)}.')
    if _draws(task) > MOST_DRAWS:
        highest = max(r.probability for r in task.requirements)
        raise InputError(f"a probability of {highest:g} takes {_draws(task):.3g} draws; at most {MOST_DRAWS:g} are made.")


def _draws(task: Task) -> int:
    return task.draws or draws_for(task.requirements, _confidence(task))


def _confidence(task: Task) -> float:
    """Of one certificate, so that all that may be tried together have what is asked for."""
    return 1.0 - (1.0 - task.confidence) / TRIES


def _rise_s(model: Model) -> float:
    """Time to full height without control."""
    found = deploy(replace(model, controller=None)).time_to_full_height_s
    if found is None:
        raise InputError(
            f'model "{model.name}": without control it does not reach the full height within simulation.duration_s '
            f"({model.simulation.duration_s:g} s). Give it more time, or more force; a controller only holds it back."
        )
    return found


def _search_of(task: Task, kind: type[Controller], fixed: Mapping[str, Any], scales: Scales, reserve: float) -> Search:
    known = {key: value for key, value in fixed.items() if key in kind.__dataclass_fields__}
    corners = Trials.of(task.model, _corners(task))
    return Search(kind, known, ranges_of(kind, scales, known), corners, task.requirements, reserve)


def _corners(task: Task) -> list[Model]:
    """The corners, each with one of the three kinds of stops: by turns, moved on from release to release."""
    rigs = [list(task.uncertainty.corners(with_stops(task.model, factor), task.seed)) for factor in STOPS.values()]
    return [rigs[(i + i // 3) % 3][i] for i in range(len(rigs[0]))]


def _fresh(task: Task, factor: float, runs: int, stream: int) -> Trials:
    model = with_stops(task.model, factor)
    return Trials.of(model, task.uncertainty.drawn(model, runs, task.seed + 1000 * (stream + 1)))


def _certified(task: Task, controller: Controller, stream: int) -> list[dict[str, Any]]:
    """The certificate: for each kind of stops what was counted on fresh draws."""
    rows = []
    for k, (name, factor) in enumerate(STOPS.items()):
        answers = _fresh(task, factor, _draws(task), 10 * stream + k).answers(controller)
        rows.append({"stops": name, "kept": counted(answers, task.requirements, _confidence(task)), **described(answers)})
    return rows


def _all(certificate: Sequence[Mapping[str, Any]]) -> bool:
    return all(kept["certified"] for row in certificate for kept in row["kept"])


def _judged(task: Task, found: Found, scales: Scales, search: Search, say: Say) -> dict[str, Any]:
    """All that is said about a controller beside its certificate."""
    draws = _fresh(task, 1.0, _RIVAL_DRAWS, 90)
    say("margins")
    kept = margins(found.controller, draws.first(_MARGIN_DRAWS), task.requirements)
    say("without control")
    without = [
        {"stops": name, **_row(task, _fresh(task, factor, _RIVAL_DRAWS, 91 + k).answers(None))}
        for k, (name, factor) in enumerate(STOPS.items())
    ]
    say("other laws")
    return {
        "search": {"tried": len(search.tried), "shortfall_on_corners": found.shortfall, "reserve": search.reserve, "ranges": search.ranges},
        "step_error_deg": _step_error(found.controller, draws.first(_MARGIN_DRAWS)),
        "margins": kept,
        "without_control": without,
        "other_laws": [_rival(task, name, scales, draws) for name in known_laws() if name != task.law],
        "uncertainty": vars(task.uncertainty),
        "most_force_N": task.most_force_N,
        "seed": task.seed,
    }


def _row(task: Task, answers: Array) -> dict[str, Any]:
    return {"kept": counted(answers, task.requirements, task.confidence), **described(answers)}


def _rival(task: Task, law: str, scales: Scales, draws: Trials) -> dict[str, Any]:
    """Another law at its best, with the same sensors, and with as much force as it likes up to twice the stored force."""
    kind = known_laws()[law]
    fixed = task.fixed if issubclass(kind, SampledController) else {}
    search = _search_of(task, kind, fixed, scales, 1.0)
    if issubclass(kind, SampledController):
        search.ranges = {**search.ranges, LIMIT: (scales.gap_N, _MOST_FORCE * scales.force_N)}
    best = search.best(None, task.seed, points=_RIVAL_POINTS, fine=_RIVAL_POINTS // 2)
    return {"law": law, "controller": best.controller.table(), **_row(task, draws.answers(best.controller))}


def _step_error(controller: Controller, draws: Trials) -> float:
    """What half the step changes of theta_z at its largest, deg, in 95 % of the draws."""
    step = 0.5 * draws.step_s(controller)
    apart = turned_deg(draws.answers(controller)) - turned_deg(draws.answers(controller, step_s=step))
    return float(np.quantile(np.abs(np.nan_to_num(apart, nan=np.inf)), 0.95))
