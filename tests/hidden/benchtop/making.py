"""Makes a case of the bench board: a folder that may be shown to anybody, and the truth in a file elsewhere.

FOLDER/cases/TOKEN/     model.toml, campaign.toml, run-1.csv ...      all that the code under test is given
FOLDER/sealed/TOKEN.json                                              what acts
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
from board.bench import Bench, in_run, motions
from board.camera import shown, table_of
from board.campaigns import AMPLITUDES_M, FREQUENCIES_HZ, Campaign, Deployment, Seen, Shaking, deployment, shaking
from board.engines import loop_by
from board.making import AFTER_S, listed
from board.platform_mujoco import moved_by_mujoco
from board.platform_ode import moved_by_ode
from board.rigs import Rig, drawn_rig
from board.shaker import cell_shows, stroke_of
from board.shapes import NOT_A_SIZE, Hidden, drawn
from board.specs import NOT_IN_MUJOCO
from board.specs import Spec as Noisy

from measure.common.output import write_text
from simulate.files.model_file import write_model
from simulate.model.model import Model

from .cases import Spec
from .nuisances import as_built, forces_of_runs
from .sizes import SHOWS, LooseYardstick, amount_of, error_shows
from .tracks import Track, drawn_track, recorded, tracked

Chance = np.random.Generator

_TRIES = 30  # to draw an error that shows
AT_THE_STOPS = ("end-stop-dissipation", "stop-stiffness")  # what only the frames behind the first stop show
DEPLOYED = 0.98  # of the deployed height: where the platform is taken to reach its stops


@dataclass(frozen=True)
class Case:
    """All that was drawn. engine : what moves the platform. forces : relative error of the stored force of each deployment.

    multiple : how many times what these runs can detect it is that is hidden.
    """

    rig: Rig
    campaign: Campaign
    track: Track
    engine: str
    forces: np.ndarray
    hidden: Hidden | None = None
    amount: float = 0.0
    multiple: float = 0.0

    @property
    def model(self) -> Model:
        """The rig as it is built, with what is hidden in it."""
        return self.rig.true if self.hidden is None else self.rig.true.with_effect(self.hidden.at(self.amount))


def made(spec: Spec, folder: Path) -> Path:
    """The folder of a case, made if it is not there yet."""
    case, sealed = folder / "cases" / spec.token, sealed_file(folder, spec)
    if not sealed.exists():
        _make(spec, case, sealed)
    return case


def sealed_file(folder: Path, spec: Spec) -> Path:
    """Where the truth of a case is."""
    return folder / "sealed" / f"{spec.token}.json"


def _make(spec: Spec, folder: Path, sealed: Path) -> None:
    case = drawn_case(spec)
    folder.mkdir(parents=True, exist_ok=True)
    write_model(case.rig.known, folder / "model.toml")
    chance = np.random.default_rng(int(spec.token, 16))
    runs = [*case.campaign.deployments, *case.campaign.shakings]
    rows = [listed(folder, number, run, _table(case, run, chance)) for number, run in enumerate(runs, 1)]
    write_text(folder / "campaign.toml", tomli_w.dumps({"run": rows}))
    sealed.parent.mkdir(parents=True, exist_ok=True)
    write_text(sealed, json.dumps(_sealed(spec, case), indent=1))


@lru_cache(1)  # a case is made, and then looked at
def drawn_case(spec: Spec) -> Case:
    """What a spec stands for, always the same; of an error the first one drawn that its runs show, or else what shows most."""
    chance = spec.chance
    case, tries = drawn_once(spec, chance), 1
    while spec.kind == "errors" and case.multiple < SHOWS and tries < _TRIES:
        case, tries = max(case, drawn_once(spec, chance), key=lambda one: one.multiple), tries + 1
    return case


def drawn_once(spec: Spec, chance: Chance) -> Case:
    """A case as it comes, whether its runs show what is hidden or not."""
    rig, track = drawn_rig(chance), drawn_track(chance)
    campaign = _planned(spec, rig.known, chance)
    forces = forces_of_runs(spec.hidden, len(campaign.deployments), chance)
    hidden, amount, multiple = _hidden(spec, rig, campaign, track, chance) if spec.kind in ("effects", "outside") else (None, 0.0, 0.0)
    built = replace(rig, true=as_built(rig.true, spec.hidden, chance))
    if spec.kind == "errors":
        multiple = error_shows(spec.hidden, built.true, forces, _yardstick(spec.hidden, rig, campaign, track))
    level = np.broadcast_to(rig.true.actuator.b_l_N, 6)
    films = tuple(replace(run, legs_N=run.legs_N + off * level) for run, off in zip(campaign.deployments, forces, strict=True))
    engine = "ode" if spec.hidden in NOT_IN_MUJOCO or chance.random() < 0.5 else "mujoco"
    return Case(built, replace(campaign, deployments=films), track, engine, forces, hidden, amount, multiple)


def _hidden(spec: Spec, rig: Rig, campaign: Campaign, track: Track, chance: Chance) -> tuple[Hidden, float, float]:
    """What is hidden, and how large, by what these runs can detect under their noise."""
    runs = _yardstick(spec.hidden, rig, campaign, track)
    hidden = drawn(spec.hidden, rig.true, runs.bench.reach_m, chance)
    return hidden, *amount_of(hidden, runs, spec.kind == "outside")


def _yardstick(name: str, rig: Rig, campaign: Campaign, track: Track) -> LooseYardstick:
    """These runs as they can show what is hidden, the noise as loud as its memory makes it."""
    films = campaign.deployments if name in AT_THE_STOPS else up_to_the_stops(rig.true, campaign.deployments)
    louder = tuple(replace(run, sigma={name: s * track.colour for name, s in run.sigma.items()}) for run in films)
    quieter = tuple(replace(run, sigma_N=run.sigma_N * _cell(track).colour) for run in campaign.shakings)
    return LooseYardstick(Bench(rig, Campaign(louder, quieter)))


def up_to_the_stops(rig: Model, films: Sequence[Deployment]) -> tuple[Deployment, ...]:
    """Films with the frames before the stops alone: behind them a fit of law and releases to what is hidden may be lost."""
    assert rig.geometry is not None
    found = []
    for run, motion in zip(films, motions([in_run(rig, run) for run in films]), strict=True):
        high = motion.place_m[:, 2] > DEPLOYED * rig.geometry.deployed_height_m
        stop_s = motion.time_s[np.argmax(high)] if high.any() else np.inf
        found.append(replace(run, frames=int(np.sum(run.time_s - run.instant_s < stop_s))))
    return tuple(found)


def _cell(track: Track) -> Track:
    """A load cell is half as slow as a camera's track."""
    return replace(track, lag1=0.5 * track.lag1)


def _planned(spec: Spec, known: Model, chance: Chance) -> Campaign:
    """Three or four deployments, the last one held out, and six loops for most."""
    assert known.geometry is not None
    mass, height = known.platform.mass_kg, known.geometry.stowed_height_m
    heavy, high = {"platform.mass_kg": round(1.25 * mass, 3)}, {"geometry.stowed_height_m": round(height + 0.05, 3)}
    between = {"platform.mass_kg": round(1.12 * mass, 3), "geometry.stowed_height_m": round(height + 0.025, 3)}
    conditions: list[dict[str, Any]] = [{}, high, heavy][: 2 + int(chance.random() < 0.7)]
    channels = ("z_m",) if spec.runs == "elevation" else ("x_m", "z_m", "theta_y_rad")
    seen, noisy = Seen(channels, bool(chance.random() < 0.5), bool(chance.random() < 0.5)), Noisy(())
    sigma = {name: chance.uniform(1e-4, 4e-4) if name.endswith("rad") else chance.uniform(2e-5, 1e-4) for name in channels}
    films = tuple(
        replace(deployment(noisy, known, c, seen, c is between, chance), sigma={k: float(v) for k, v in sigma.items()})
        for c in (*conditions, between)
    )
    if spec.runs != "loops":
        return Campaign(films)
    drifts, quantised = (chance.random(2) < (0.3, 0.4)).tolist()
    pairs = [(f, a) for f in FREQUENCIES_HZ for a in AMPLITUDES_M]
    return Campaign(films, tuple(shaking(noisy, known, *pair, drifts, quantised, chance) for pair in pairs))


def _table(case: Case, run: Deployment | Shaking, chance: Chance) -> Any:
    if isinstance(run, Shaking):
        stroke = stroke_of(run)
        force = loop_by("ode", case.model, stroke, run.start_force_N)
        return recorded(cell_shows(force, stroke, run, case.model.effects), stroke, run, _cell(case.track), chance)
    at = in_run(case.model, run)
    times = np.arange(round((run.time_s[-1] + AFTER_S) * 1000.0) + 1) / 1000.0
    motion = moved_by_mujoco(at, times) if case.engine == "mujoco" else moved_by_ode(at, times, "LSODA", 1e-8, 1e-10)
    assert at.geometry is not None
    quiet = replace(run, sigma=dict.fromkeys(run.channels, 0.0), tells_sigma=False)
    clean = table_of(shown(motion, run, case.model.effects), quiet, at.geometry.stowed_height_m, chance)
    if run.tells_sigma:
        clean = replace(clean, sigma={name: np.full(len(run.time_s), run.sigma[name]) for name in run.channels})
    return tracked(clean, dict(run.sigma), case.track, run.zeroed, chance)


def _sealed(spec: Spec, case: Case) -> dict[str, Any]:
    true, known = case.rig.true, case.rig.known
    values: dict[str, float] = {}
    if case.hidden is not None:
        effect = case.hidden.at(case.amount)
        all_values = dict(zip(effect.flat_names(), effect.flat().tolist(), strict=True))
        values = {name: value for name, value in all_values.items() if name not in NOT_A_SIZE.get(effect.name, ())}
    elif spec.hidden == "platform-mass":
        values = {"mass_kg": true.platform.mass_kg - known.platform.mass_kg}
    elif spec.hidden == "platform-inertia":
        ratio = np.divide(true.platform.inertia_kg_m2, known.platform.inertia_kg_m2) - 1.0
        values = {f"fraction[{i}]": float(value) for i, value in enumerate(ratio)}
    elif spec.hidden == "stop-stiffness":
        values = {"fraction": true.end_stop.stiffness_N_per_m / known.end_stop.stiffness_N_per_m - 1.0}
    return {
        "spec": spec.as_dict(),
        "values": values,
        "multiple": case.multiple,
        "engine": case.engine,
        "track": case.track.__dict__,
        "forces": case.forces.tolist(),
        "mass_kg": [known.platform.mass_kg, true.platform.mass_kg],
        "inertia_kg_m2": [list(known.platform.inertia_kg_m2), list(true.platform.inertia_kg_m2)],
        "stop": [known.end_stop.stiffness_N_per_m, true.end_stop.stiffness_N_per_m],
        "law": {key: getattr(true.actuator, key) for key in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m")},
    }
