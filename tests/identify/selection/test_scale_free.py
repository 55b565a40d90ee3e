"""The answer follows the measurements and not the size of the rig, the order of the runs or the unit of the force."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace

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


@dataclass(frozen=True)
class Scale:
    """By what forces, lengths and times are multiplied; masses follow, so that the motion stays the same in these units."""

    force: float = 1.0
    length: float = 1.0
    time: float = 1.0

    def of(self, name):
        """The factor of a quantity by the unit that its name ends with."""
        force, length, time, mass = unit_of(name)
        return self.force ** (force + mass) * self.length ** (length - mass) * self.time ** (time + 2 * mass)


def scaled(part, scale):
    """The same model in other sizes."""
    if isinstance(part, Effect):
        return part.with_flat(part.flat() * np.array([scale.of(name) for name in part.flat_names()]))
    changed = {}
    for item in fields(part):
        value = getattr(part, item.name)
        if is_dataclass(value):
            changed[item.name] = scaled(value, scale)
        elif item.name == "effects":
            changed[item.name] = tuple(scaled(effect, scale) for effect in value)
        elif scale.of(item.name) != 1.0 and isinstance(value, float | tuple):
            changed[item.name] = (
                (np.array(value) * scale.of(item.name)).tolist() if isinstance(value, tuple) else scale.of(item.name) * value
            )
            changed[item.name] = as_tuples(changed[item.name])
    return replace(part, **changed)


def as_tuples(value):
    return tuple(as_tuples(one) for one in value) if isinstance(value, list) else value


def measured(run, scale):
    """A run as it would have been measured in other sizes."""
    table = run.table
    if isinstance(table, Loop):
        changed = {name: getattr(table, name) * scale.of(name) for name in ("time_s", "elongation_m", "force_N")}
        return replace(run, table=replace(table, **changed))
    moved = {kind: {name: values * scale.of(name) for name, values in getattr(table, kind).items()} for kind in ("channels", "sigma")}
    return replace(run, table=replace(table, time_s=table.time_s * scale.time, **moved))


@pytest.fixture
def asked(campaign):
    folder = campaign(ViscousFriction(HIDDEN), 640, loops=((0.5, 0.04), (2.0, 0.04)), deployments=({},), hold_out=False)
    return read_model(folder / "model.toml"), read_campaign([folder / "campaign.toml"])


def answer(model, runs):
    """Verdict, names, sizes and their standard errors."""
    found = explain(model, runs, FEW, budget=BUDGETS["quick"])
    return found.verdict, [one.name for one in found.findings], [(one.effect.flat(), one.stderr) for one in found.findings]


@pytest.mark.parametrize(
    "pair",
    [
        pytest.param((Scale(1e-3, 1e2, 3.0), Scale(1e3, 1e-2, 0.1)), id="all at once", marks=pytest.mark.slow),
        pytest.param((Scale(force=1e-3), Scale(force=1e3)), id="forces and masses", marks=pytest.mark.calibrate),
        pytest.param((Scale(length=1e-3, time=0.1), Scale(length=1e3, time=3.0)), id="lengths and times", marks=pytest.mark.calibrate),
    ],
)
def test_neither_the_size_of_the_rig_nor_the_order_of_the_runs_changes_the_answer(asked, pair):
    """A millionth of the size, and the runs in the other order: the same names, sizes and standard errors.

    Longer times cost more steps, so they are scaled less here; a hundredth and a hundred times have the same answer. Forces, lengths
    and times change at once by powers of which no simple product is one.
    """
    model, runs = asked
    found = []
    for scale, order in zip(pair, (1, -1), strict=True):
        verdict, names, sizes = answer(scaled(model, scale), [measured(run, scale) for run in runs[::order]])
        assert (verdict, names) == ("named", ["viscous-friction"])
        unit = scale.of("damping_N_s_per_m")
        found.append([(value / unit, stderr / unit) for value, stderr in sizes])
    for (value, stderr), (value_too, stderr_too) in zip(*found, strict=True):
        assert value_too == pytest.approx(value, abs=0.2 * float(stderr[0]))
        assert stderr_too == pytest.approx(stderr, rel=0.05)
