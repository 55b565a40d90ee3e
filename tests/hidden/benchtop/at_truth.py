"""The hypothesis that is right, everything in it where it was drawn: what its numbers come to from there is the fit's, not the search's."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from identify.campaign.posing import problem_of
from identify.campaign.runs import read_campaign
from identify.estimation.parameters import BASE, Parameter
from identify.estimation.problem import Problem
from identify.estimation.tolerances import TOLERANCE_OF
from identify.selection.stand import Stand
from simulate.files.model_file import read_model
from simulate.model.model import Model

from .cases import Spec
from .making import Case, drawn_case, made
from .nuisances import joints_of

_AXES = "xyz"


def at_truth(spec: Spec, folder: Path) -> tuple[Stand, dict[str, float]]:
    """Where the truth of a case with an effect stands, and the effect's numbers by their names. folder : where the case is made."""
    case, files = drawn_case(spec), made(spec, folder)
    assert case.hidden is not None
    effect = case.hidden.at(case.amount)
    runs = [run for run in read_campaign([files / "campaign.toml"]) if not run.hold_out]
    problem = problem_of(read_model(files / "model.toml"), runs).with_effects([type(effect)()])
    q = np.array([_place(parameter, case, problem) for parameter in problem.parameters[: problem.first_effect]])
    own = (effect.flat() - problem.effects[0].flat()) / problem.scales[problem.first_effect :]
    errors = {key: size for key, size in _errors(case, problem.model).items() if key[0] != effect.name}
    values = dict(zip(effect.flat_names(), effect.as_stated().flat().tolist(), strict=True))
    return Stand.off_by(problem, np.append(q, own), errors), values


def _place(parameter: Parameter, case: Case, problem: Problem) -> float:
    """Where a parameter of base or releases is, in its scale."""
    if not parameter.run:
        if parameter.name not in BASE:
            return 0.0
        true, known = (float(np.mean(getattr(rig.actuator, parameter.name))) for rig in (case.rig.true, case.rig.known))
        return parameter.place_of_shift(true - known)
    names = [film.run.name for film in problem.films]
    if parameter.run not in names:
        return 0.0
    index = names.index(parameter.run)
    film, run = problem.films[index], [one for one in case.campaign.deployments if not one.hold_out][index]
    pose = {f"position_{axis}_m": value for axis, value in zip(_AXES, run.position_m, strict=True)}
    pose |= {f"theta_{axis}_rad": value for axis, value in zip(_AXES, run.theta_rad, strict=True)}
    common = float(case.forces[index] * np.mean(case.rig.true.actuator.b_l_N))
    legs = {f"stored_force_N[{leg}]": force - common for leg, force in enumerate(run.legs_N)}
    known = pose | legs | {"instant_s": run.instant_s - film.expected_s, "stored_force_fraction": float(case.forces[index])}
    return known.get(parameter.key, 0.0) / parameter.scale


def _errors(case: Case, given: Model) -> dict[tuple[str, int], float]:
    """What the model file is wrong by, in tolerances."""
    true, known = case.rig.true, case.rig.known
    off = {
        "platform-mass": true.platform.mass_kg - known.platform.mass_kg,
        "platform-inertia": np.divide(true.platform.inertia_kg_m2, known.platform.inertia_kg_m2) - 1.0,
        "centre-of-mass-offset": np.subtract(true.platform.centre_of_mass_m, known.platform.centre_of_mass_m),
        "geometry-error": (joints_of(true) - joints_of(known)).ravel(),
        "stop-stiffness": true.end_stop.stiffness_N_per_m / known.end_stop.stiffness_N_per_m - 1.0,
        "end-stop-dissipation": true.end_stop.damping_N_s_per_m - known.end_stop.damping_N_s_per_m,
    }
    sizes = {name: TOLERANCE_OF[name].sizes(given, np.atleast_1d(values)) for name, values in off.items()}
    return {(name, place): float(size) for name, of in sizes.items() for place, size in enumerate(of)}
