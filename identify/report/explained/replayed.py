"""The run with the largest gap as it went and as the models have it, for the scene of a page."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from identify.campaign.prepared import Film
from identify.estimation.observation import duration_for, released
from identify.estimation.problem import Fit
from identify.selection.explanation import Explanation
from measure.tables.trajectory import Trajectory
from simulate.deployment.deploy import deploy
from simulate.model.model import Model, Simulation
from simulate.report.scene import scene_of

_RATE_HZ = 500.0


def scene(found: Explanation, run: str) -> dict[str, Any] | None:
    """The scene of a run, or of the first deployment where it is none; None without a deployment."""
    films = found.before.problem.films
    if not films:
        return None
    index = next((i for i, film in enumerate(films) if film.run.name == run), 0)
    fits = {
        "model as given": found.as_given,
        **({"with the effect": found.after} if found.findings else {"force law refitted": found.before}),
    }
    colours = ["--given", "--effect" if found.findings else "--refitted"]
    film = films[index]
    models = [_model(fit, index, film) for fit in fits.values()]
    duration = max(model.simulation.duration_s for model in models)
    runs = [deploy(replace(model, simulation=Simulation(duration, _RATE_HZ))) for model in models]
    begin = list(fits.values())[-1].problem.release_at(list(fits.values())[-1].q, index).instant_s
    values = {name: film.values[i] for i, name in enumerate(film.channels)}
    measured = Trajectory(film.time_s - begin, values, name=film.run.name)
    made = dict(zip(fits, runs, strict=True))
    return scene_of(made, colours, measured, link=f"time-{film.run.name}", begin_s=begin + film.clock_s)


def _model(fit: Fit, index: int, film: Film) -> Model:
    """The model of a run with what was fitted, its own release worked in."""
    release = fit.problem.release_at(fit.q, index)
    model = released(fit.problem.model_at(fit.q, film.model), release)
    effects = tuple(effect.in_run(index) for effect in model.effects)
    return replace(model, effects=effects, simulation=Simulation(float(duration_for(film.time_s, release)), _RATE_HZ))
