"""Makes a case: a folder that may be shown to anybody, and the truth in a file elsewhere.

FOLDER/cases/TOKEN/     model.toml, campaign.toml, run-1.csv ...      all that the code under test is given
FOLDER/sealed/TOKEN.json                                              what acts, and how much of it these runs can show
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from measure.common.output import write_text
from measure.tables.loop import Loop, write_loop
from measure.tables.trajectory import Trajectory, write_trajectory
from simulate.files.model_file import write_model
from simulate.model.model import Model

from .bench import Bench, in_run
from .camera import shown, table_of
from .campaigns import Campaign, Deployment, Shaking, planned
from .engines import loop_by, motion_by
from .rigs import Rig, drawn_rig
from .shaker import cell_shows, loop_of, stroke_of
from .specs import Spec
from .truths import Truth, expected, true_model, truths_of
from .yardstick import Yardstick

AFTER_S = 0.054  # the platform is moved on beyond the last frame, for clocks that are off


def case_folder(folder: Path, spec: Spec) -> Path:
    """Where the case's files are."""
    return folder / "cases" / spec.token


def sealed_file(folder: Path, spec: Spec) -> Path:
    """Where its truth is."""
    return folder / "sealed" / f"{spec.token}.json"


def made(spec: Spec, folder: Path) -> Path:
    """The folder of a case, made if it is not there yet; the truth is sealed last, so a case without one is made again."""
    sealed = sealed_file(folder, spec)
    if not sealed.exists():
        _make(spec, case_folder(folder, spec), sealed)
    return case_folder(folder, spec)


def _make(spec: Spec, folder: Path, sealed: Path) -> None:
    case = drawn_case(spec)
    folder.mkdir(parents=True, exist_ok=True)
    write_model(case.rig.known, folder / "model.toml")
    tables = tables_of(case.model, case.campaign, spec, np.random.default_rng(int(spec.token, 16)))
    runs = [*case.campaign.deployments, *case.campaign.shakings]
    rows = [listed(folder, number, *pair) for number, pair in enumerate(zip(runs, tables, strict=True), 1)]
    write_text(folder / "campaign.toml", tomli_w.dumps({"run": rows}))
    sealed.parent.mkdir(parents=True, exist_ok=True)
    write_text(sealed, json.dumps(_sealed(spec, case.truths, case.model), indent=1))


@dataclass(frozen=True)
class Case:
    """Everything that was drawn for a case. model : the rig with what is hidden in it."""

    rig: Rig
    campaign: Campaign
    truths: list[Truth]
    model: Model


def drawn_case(spec: Spec) -> Case:
    """What a spec stands for, always the same."""
    chance = spec.chance
    rig = drawn_rig(chance)
    campaign = planned(spec, rig.known, chance)
    truths = truths_of(spec, Yardstick(Bench(rig, campaign)), chance)
    return Case(rig, campaign, truths, true_model(rig.true, truths))


def listed(folder: Path, number: int, run: Deployment | Shaking, table: Trajectory | Loop) -> dict[str, Any]:
    """Write a run's table and say what the list of runs holds of it."""
    name = f"run-{number}.csv"
    write_trajectory(table, folder / name) if isinstance(table, Trajectory) else write_loop(table, folder / name)
    row: dict[str, Any] = {"file": name, **({"hold_out": True} if run.hold_out else {})}
    for key, value in run.changes.items() if isinstance(run, Deployment) else ():
        table_name, _, entry = key.partition(".")
        row.setdefault("model", {}).setdefault(table_name, {})[entry] = value
    return row


def tables_of(model: Model, campaign: Campaign, spec: Spec, chance: np.random.Generator) -> list[Trajectory | Loop]:
    """What camera, clock, laser and load cell make of every run."""
    made: list[Trajectory | Loop] = [_deployment(model, run, spec, chance) for run in campaign.deployments]
    for run in campaign.shakings:
        stroke = stroke_of(run)
        force = loop_by(spec.engine, model, stroke, run.start_force_N)
        made.append(loop_of(cell_shows(force, stroke, run, model.effects), stroke, run, chance))
    return made


def _deployment(model: Model, run: Deployment, spec: Spec, chance: np.random.Generator) -> Trajectory:
    at = in_run(model, run)
    motion = motion_by(spec.engine, at, run.time_s[-1] + AFTER_S)
    if run.rendered:
        from .on_film import tracked

        return tracked(motion, run, at, int(spec.token, 16) % 2**31)
    assert at.geometry is not None
    return table_of(shown(motion, run, model.effects), run, at.geometry.stowed_height_m, chance)


def _sealed(spec: Spec, truths: Sequence[Truth], model: Model) -> dict[str, Any]:
    law = {key: getattr(model.actuator, key) for key in ("a_l_N_per_m", "b_l_N", "a_u_N_per_m", "b_u_N", "beta_per_m", "initial_force_N")}
    return {"spec": spec.as_dict(), "expected": expected(truths), "effects": [truth.as_dict() for truth in truths], "law": law}
