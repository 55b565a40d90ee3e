"""What the rivals share: the words of the command, the campaign as one problem, and the answer as a file like explain-gap's."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from identify.campaign.posing import problem_of
from identify.campaign.run import Run
from identify.campaign.runs import read_campaign
from identify.estimation.horizons import solve_from_afar
from identify.estimation.least_squares import laid_out, solve
from identify.estimation.problem import Fit
from identify.selection.promises import promises
from identify.selection.weighing import weighed
from measure.common.output import json_text, write_text
from simulate.effects import CATALOGUE
from simulate.files.model_file import read_model
from simulate.model.model import Model


@dataclass(frozen=True)
class Asked:
    """A case as a rival gets it: the model, what takes part, what is held out, and the fit of law and releases alone."""

    model: Model
    runs: Sequence[Run]
    held: Sequence[Run]
    before: Fit


@dataclass(frozen=True)
class Said:
    """A rival's answer. names : with the fit they come from; after : the last fit, None where no effect is fitted.

    held_out : gap over noise of the held-out runs, where the rival foretells them in another way than by a fit.
    """

    names: Sequence[str]
    after: Fit | None = None
    verdict: str | None = None
    held_out: float | None = None


def answer(arguments: Sequence[str], think: Callable[[Asked], Said]) -> int:
    """Read a case, let the rival think, write `result.json`."""
    words = argparse.ArgumentParser()
    words.add_argument("model", type=Path)
    words.add_argument("measured", type=Path, nargs="+")
    words.add_argument("-o", "--output", type=Path, required=True)
    words.add_argument("--quiet", action="store_true")
    given = words.parse_args(arguments)
    model, runs = read_model(given.model), read_campaign(given.measured)
    taking_part = [run for run in runs if not run.hold_out]
    held = [run for run in runs if run.hold_out]
    before = solve_from_afar(problem_of(model, taking_part))
    asked = Asked(model, taking_part, held, before)
    given.output.mkdir(parents=True, exist_ok=True)
    write_text(given.output / "result.json", json_text(_result(asked, think(asked))))
    return 0


@dataclass(frozen=True)
class Candidate:
    """An effect fitted on top of a fit."""

    name: str
    fit: Fit


def candidates(fit: Fit, only: Sequence[str] | None = None) -> list[Candidate]:
    """Each effect of the catalogue fitted alone on top of a fit, those that show at all; or only some of them."""
    kinds = {name: kind for name, kind in CATALOGUE.items() if only is None or name in only}
    found = []
    for one in promises(weighed(fit), kinds):
        if one.shape is not None:
            start = np.concatenate([fit.q[: fit.problem.first_effect], fit.q[fit.problem.first_effect :], one.sizes])
            found.append(Candidate(one.name, solve(fit.problem.with_another(one.shape), start)))
    return found


def _result(asked: Asked, said: Said) -> dict[str, Any]:
    after = asked.before if said.after is None else said.after
    verdict = said.verdict or ("no-gap" if not said.names else "named" if len(said.names) == 1 else "several")
    gap: dict[str, Any] = {"before": {"rms_over_noise": asked.before.rms}, "after": {"rms_over_noise": after.rms}}
    if asked.held:
        held_out = foretold(asked, after) if said.held_out is None else said.held_out
        gap["held_out"] = {"before": {"rms_over_noise": foretold(asked, asked.before)}, "after": {"rms_over_noise": held_out}}
    effects = [{"name": name, "equivalents": [], "parameters": _parameters(name, said.after)} for name in said.names]
    return {"verdict": verdict, "effects": effects, "gap": gap, "sentence": ", ".join(said.names) or verdict}


def foretold(asked: Asked, fit: Fit) -> float:
    """Gap over noise of the held-out runs with the base and effects of a fit."""
    return float(np.sqrt(np.mean(held_gaps(asked, fit) ** 2)))


def held_gaps(asked: Asked, fit: Fit) -> np.ndarray:
    """The gaps of all held-out runs, only their own releases fitted."""
    return np.concatenate([held_fit(asked, run, fit).measured_gaps for run in asked.held])


def held_fit(asked: Asked, run: Run, fit: Fit) -> Fit:
    """A held-out run seen with the base and effects of a fit."""
    problem = problem_of(asked.model, [run]).with_effects(fit.problem.effects)
    return solve_from_afar(problem, laid_out(fit, problem), free=range(problem.first_nuisance, problem.first_effect))


def _parameters(name: str, fit: Fit | None) -> dict[str, Any]:
    """Values with 1.96 standard errors to each side, for effects that were fitted."""
    if fit is None:
        return {}
    place = fit.problem.first_effect
    for effect in fit.problem.effects_at(fit.q):
        size = len(effect.flat())
        if effect.name == name:
            rows = np.arange(place, place + size)
            errors = np.sqrt(np.maximum(np.diag(fit.covariance)[rows], 0.0)) * fit.problem.scales[rows]
            numbers = zip(effect.flat_names(), effect.flat().tolist(), errors.tolist(), strict=True)
            return {key: {"value": v, "stderr": e, "ci95": [v - 1.96 * e, v + 1.96 * e]} for key, v, e in numbers}
        place += size
    return {}
