"""Whether another column of the file (pressure, temperature, voltage) explains part of the force."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identify.loops.loop_data import LoopData
from measure.common.arrays import Array

_ALREADY_THERE = 0.9995  # correlation with force, elongation or time, from which on a column is that quantity in other units
WORTH_NAMING = 0.05  # share of the residual
_AS_MUCH = 0.95  # of the largest share, from which on noise may decide which of two columns has it: often they are one quantity


def shares(loops: Sequence[LoopData], residuals: Sequence[Array], tables: Sequence[Array]) -> dict[str, float]:
    """Share of the residual's sum of squares that each further column would take away in a joint fit, to first order.

    The column is freed of what the fitted parameters can imitate; what is left of it is compared with the residual. Columns that are
    the force, the elongation or the time in other units are left out.
    """
    left, table = np.concatenate(residuals), np.concatenate(tables)
    power = float(left @ left)
    normal = table.T @ table
    found = {}
    for name in sorted(set.intersection(*(set(data.other) for data in loops))):
        if any(_is_a_copy(data, data.other[name]) for data in loops):
            continue
        column = np.concatenate([data.other[name][data.used] for data in loops])
        column = column - column.mean()
        own = column - table @ np.linalg.lstsq(normal, table.T @ column, rcond=1e-12)[0]
        if power > 0.0 and own @ own > 1e-8 * (column @ column):
            found[name] = float((own @ left) ** 2 / (own @ own) / power)
    return found


def _is_a_copy(data: LoopData, column: Array) -> bool:
    if np.ptp(column) == 0.0:
        return True
    known = (data.force_N, data.elongation_m, data.time_s)
    return any(abs(np.corrcoef(column, quantity)[0, 1]) > _ALREADY_THERE for quantity in known)


def hint(found: dict[str, float]) -> str:
    """The sentence that names the column worth trying, and those that explain as much; or nothing."""
    if not found or max(found.values()) < WORTH_NAMING:
        return ""
    name, *others = sorted(found, key=lambda key: -found[key])
    alike = [f'"{other}"' for other in others if found[other] > _AS_MUCH * found[name]]
    share = f"{100 * found[name]:.0f} % of what is left" + (f", {' and '.join(alike)} as much" if alike else "")
    return f'column "{name}" explains {share}; --covariate "{name}" fits its share of the force jointly'
