"""What each candidate would leave of the gap if it alone were added: exact where it was fitted, linearised where not."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

from identify.criteria import CREDIBLE
from identify.estimation.covariance import scaled
from identify.estimation.problem import Fit
from identify.gap.signatures import chords, columns_of_shapes
from identify.selection.explanation import Explanation, Ranked
from identify.selection.model_errors import FORCES
from measure.common.arrays import Array
from simulate.model.effect import Effect

SHOWN = 6
_MUCH = 1.5  # times the gap that the foremost leaves, from which on a candidate is excluded by what it leaves


@dataclass(frozen=True)
class Candidate:
    """A candidate by itself. left : root mean square gap over the noise with it alone. fitted : whether whole, or linearised."""

    name: str
    left: float
    fitted: bool
    weight: float
    named: bool
    why: str


def candidates(found: Explanation, most: int = SHOWN) -> list[Candidate]:
    """The foremost candidates of the ranking with what each leaves alone, and in plain words why it is named or excluded."""
    rows = sorted((row for row in found.ranking if len(row.names) == 1), key=lambda row: (-row.weight, -row.delta_bic))[:most]
    named = {finding.name for finding in found.findings}
    open_ones = {name for finding in found.findings for name in finding.equivalents}
    made = [_candidate(found, row, named, open_ones) for row in rows]
    return sorted((one for one in made if one is not None), key=lambda one: (not one.named, one.left))


def _candidate(found: Explanation, row: Ranked, named: set[str], open_ones: set[str]) -> Candidate | None:
    (name,) = row.names
    left, fitted = _left(found, name)
    if left is None:
        return None
    return Candidate(name, left, fitted, row.weight, name in named, _why(found, row, left, named, open_ones))


def _left(found: Explanation, name: str) -> tuple[float | None, bool]:
    if len(found.findings) == 1 and found.findings[0].name == name:
        return found.over_noise(found.after), True
    if name in found.rivals:
        return found.over_noise(found.rivals[name]), True
    effect = _effect(found, name)
    return (None if effect is None else left_alone(found, effect)), False


def _effect(found: Explanation, name: str) -> Effect | None:
    """The effect as the model file has it, by its name."""
    kinds = [type(limit.effect) for limit in found.limits] + [type(finding.effect) for finding in found.findings]
    kind = next((kind for kind in kinds if kind.name == name and name != FORCES), None)
    return None if kind is None else found.before.problem.model.effect(kind)


def left_alone(found: Explanation, effect: Effect) -> float:
    """Root mean square gap over the noise with base, releases and this effect fitted in the linearised model, in its best shape."""
    fit = found.before
    free = fit.clear_of_bounds
    base = np.where(free, fit.jacobian, 0.0)
    return min((found.over_noise(replace(fit, gaps=one)) for one in _gaps(fit, base, effect)), default=found.over_noise(fit))


def _gaps(fit: Fit, base: Array, effect: Effect) -> Iterator[Array]:
    measured = fit.problem.measured  # what is known of the effect beforehand stands behind; here it is asked what it could close
    base, of_base = scaled(base)
    along, root = np.linalg.qr(base)  # once for all shapes: as many rows as columns tell the same
    for columns, low, high in _signatures(fit, effect):
        shown = np.linalg.norm(columns[:measured], axis=0) > 0.0
        own, sizes = scaled(np.pad(columns[:measured, shown], ((0, len(base) - measured), (0, 0))))
        free = np.full(len(of_base), np.inf)
        ends = (np.concatenate([sign * free, end[shown] * sizes]) for sign, end in ((-1.0, low), (1.0, high)))
        further = np.column_stack([own, -fit.gaps])
        shared = along.T @ further
        rest = np.linalg.qr(further - along @ shared).R
        whole = np.block([[root, shared], [np.zeros((len(rest), len(of_base))), rest]])
        yield fit.gaps + np.hstack([base, own]) @ lsq_linear(whole[:, :-1], whole[:, -1], tuple(ends)).x


def _signatures(fit: Fit, effect: Effect) -> Iterator[tuple[Array, Array, Array]]:
    """Columns of the effect in each of its shapes, with the bounds of its sizes."""
    if not effect.is_linear():
        for _, change in chords(fit, effect):
            yield change[:, None], np.zeros(1), np.ones(1)
        return
    for shape, branch, columns in columns_of_shapes(fit, effect):
        low, high = (np.array(branch) - shape.flat()[:, None]).T / shape.typical(fit.problem.measures)
        yield columns, np.minimum(low, 0.0), np.maximum(high, np.finfo(float).eps)


def _why(found: Explanation, row: Ranked, left: float, named: set[str], open_ones: set[str]) -> str:
    """Why a candidate is named or excluded."""
    (name,) = row.names
    if name in named:
        return "named"
    if name in open_ones:
        of = [finding.name for finding in found.findings if name in finding.equivalents]
        return f"stays possible: these data cannot tell it from {', '.join(of)}"
    after, before = found.over_noise(found.after), found.over_noise(found.before)
    if left > 0.95 * before:
        return "excluded: closes nothing of the gap"
    if named and left > _MUCH * after:
        return f"excluded: alone it leaves {left:.3g} times the noise"
    if row.weight < 1.0 - CREDIBLE:
        return f"excluded: it does not explain the gap as well, its probability is {_small(row.weight)}"
    return f"not excluded, its probability is {_small(row.weight)}"


def _small(share: float) -> str:
    return f"{100 * share:.2g} %" if share >= 1e-4 else "below 0.01 %"


def names_left(found: Explanation, shown: Sequence[Candidate]) -> list[Ranked]:
    """What else was tried, the likeliest first."""
    known = {(one.name,) for one in shown}
    return [row for row in found.ranking if row.names not in known]


def bars_of_gaps(tried: Sequence[Candidate], before: float) -> list[dict[str, Any]]:
    """Bars on a logarithmic scale from a little below the noise to the gap without any effect."""
    low, high = min([0.7, *(one.left for one in tried)]), max([before, 2.0, *(one.left for one in tried)])

    def share(value: float) -> float:
        return float(np.log(max(value, low) / low) / np.log(high / low))

    return [
        {
            "name": one.name,
            "text": ("" if one.fitted else "~ ") + f"{one.left:#.3g}".rstrip("."),
            "share": share(one.left),
            "line": share(1.0),
            "look": "effect" if one.named else "",
            "remark": one.why,
        }
        for one in tried
    ]
