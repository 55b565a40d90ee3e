"""The formulas and parameters of a model's effects as a kernel wants them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measure.common.arrays import Array
from simulate.dispatch import lane_functions as lane_functions
from simulate.dispatch.compiled_code import compiled_once
from simulate.dispatch.formulas import SIGNATURES, FormulaTable, address
from simulate.dispatch.lane_forms import form_for_all
from simulate.model.effect import Effect
from simulate.model.rig import Rig

# The formulas that do work, in the order of the kernel's energy balance.
WITH_POWER = ("leg_force", "joint_resistance", "platform_wrench", "base_force")


def formula_table(effects: Sequence[Effect], first_parameter: int) -> FormulaTable:
    """The formulas of these effects; parameters stand one after the other from `first_parameter` on."""
    return _formula_table(tuple(type(effect) for effect in effects), first_parameter)


@compiled_once
def _formula_table(effects: tuple[type[Effect], ...], first_parameter: int) -> FormulaTable:
    rows: dict[str, list[tuple[int, int, int]]] = {kind: [] for kind in SIGNATURES}
    place = first_parameter
    for effect in effects:
        for kind, found in rows.items():
            formula = getattr(effect, kind)
            if formula is not None:
                alone = address(formula, kind)
                lanes = form_for_all(formula, kind)
                found.append((alone, place, 0 if lanes is None else lanes.address))
        place += len(effect.flat_names()) + effect.constants
    tables = {kind: np.array(found, dtype=np.int64).reshape(-1, 3) for kind, found in rows.items()}
    return FormulaTable(**tables, control=np.empty((0, 3), dtype=np.int64))


def flat_parameters(effects: Sequence[Effect], model: Rig | None = None) -> Array:
    """All parameters of these effects, one after the other, each followed by its constants; without a model these are zero."""
    parts = [np.empty(0)]
    for effect in effects:
        constants = np.zeros(effect.constants) if model is None else np.array(effect.constants_of(model), dtype=float)
        parts += [effect.flat(), constants]
    return np.concatenate(parts)
