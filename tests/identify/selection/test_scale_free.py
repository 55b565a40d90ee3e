"""The answer follows the measurements and not the size of the rig, the order of the runs or the unit of the force."""

from __future__ import annotations

from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest

from identify.campaign.runs import read_campaign
from identify.selection.explain import explain
from identify.selection.hypotheses import BUDGETS
from measure.tables.loop import Loop
from simulate.effects import CATALOGUE, ViscousFriction
from simulate.files.model_file import read_model
from simulate.model.effect import Effect
from simulate.model.measures import unit_of

FEW = {name: CATALOGUE[name] for name in ("hub-inertia", "viscous-friction", "curved-asymptotes", "transition-zone", "gravity-imbalance")}
HIDDEN = 0.0728 + 0.03  # the rig has the first part already


def heavier(part, factor):
    """The same model with all forces and masses multiplied, which changes no motion."""
    if isinstance(part, Effect):
        powers = [unit_of(name) for name in part.flat_names()]
        return part.with_flat(part.flat() * np.array([factor ** (force + mass) for force, _, _, mass in powers]))
    changed = {}
    for item in fields(part):
        value, (force, _, _, mass) = getattr(part, item.name), unit_of(item.name)
        if is_dataclass(value):
            changed[item.name] = heavier(value, factor)
        elif item.name == "effects":
            changed[item.name] = tuple(heavier(effect, factor) for effect in value)
        elif force + mass and isinstance(value, float | tuple):
            changed[item.name] = tuple(factor * one for one in value) if isinstance(value, tuple) else factor * value
    return replace(part, **changed)


def louder(run, factor):
    """A loop with its force multiplied; a deployment as it is."""
    if not isinstance(run.table, Loop):
        return run
    return replace(run, table=replace(run.table, force_N=factor * run.table.force_N))


@pytest.fixture
def asked(campaign):
    folder = campaign(ViscousFriction(HIDDEN), 640, loops=((0.5, 0.04), (2.0, 0.04)), deployments=({},), hold_out=False)
    return read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])


def answer(model, runs):
    """Verdict, names, sizes and their standard errors."""
    found = explain(model, runs, FEW, budget=BUDGETS["quick"])
    return found.verdict, [one.name for one in found.findings], [(one.effect.flat(), one.stderr) for one in found.findings]


@pytest.mark.slow
def test_neither_the_size_of_forces_and_masses_nor_the_order_of_the_runs_changes_the_answer(asked):
    """A millionth of the size, and the runs in the other order: the same names, sizes and standard errors."""
    model, runs = asked
    found = []
    for factor, order in ((1e-3, 1), (1e3, -1)):
        verdict, names, sizes = answer(heavier(model, factor), [louder(run, factor) for run in runs[::order]])
        assert (verdict, names) == ("named", ["viscous-friction"])
        found.append([(value / factor, stderr / factor) for value, stderr in sizes])
    for (value, stderr), (value_too, stderr_too) in zip(*found, strict=True):
        assert value_too == pytest.approx(value, abs=0.2 * float(stderr[0]))
        assert stderr_too == pytest.approx(stderr, rel=0.05)
