"""The truth of a case: what acts, how much of it, whether these runs can see it, and from what they cannot tell it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from simulate.effects import CATALOGUE
from simulate.model.model import Model

from .detectable import Variant, class_of, left_by_any_pair, needed
from .shapes import NOT_A_SIZE, Hidden, drawn, rivals
from .specs import HIDDEN, OUTSIDE, Spec
from .yardstick import Yardstick

UNSEEN_AMOUNT = 3.0  # typical sizes of an effect that these runs cannot show
LEAST = {"backlash": 3e-5}  # a play below three times the laser's noise shows in no loop, whatever the force says
_ROUNDS, _CLOSE = 12, 0.02


@dataclass(frozen=True)
class Truth:
    """One thing that acts. detectable : the amount that these runs can detect, None where they cannot.

    multiple : size in detectable sizes, as drawn or as far as the effect's bounds allow. alike : names that cannot be told from it.
    """

    hidden: Hidden
    amount: float
    detectable: float | None
    multiple: float
    alike: tuple[str, ...]

    def as_dict(self) -> dict[str, Any]:
        """For the sealed file."""
        effect = self.hidden.at(self.amount)
        excluded = NOT_A_SIZE.get(effect.name, ())
        values = dict(zip(effect.flat_names(), effect.flat().tolist(), strict=True))
        at = self.hidden.at(self.detectable).flat() - self.hidden.off if self.detectable is not None else None
        return {
            "name": effect.name,
            "values": values,
            "sizes": [name for name in values if name not in excluded],
            "identifiable": self.detectable is not None,
            "detectable": None if at is None else dict(zip(effect.flat_names(), at.tolist(), strict=True)),
            "multiple": self.multiple,
            "class": list(self.alike),
        }


def truths_of(spec: Spec, runs: Yardstick, chance: np.random.Generator) -> list[Truth]:
    """Draw what is hidden in a case, and size it by what its runs can detect."""
    if not spec.hidden:
        return []
    true, reach_m = runs.bench.rig.true, runs.bench.reach_m
    variants = runs.variants([lines for kind in map(CATALOGUE.__getitem__, HIDDEN) for lines in rivals(kind, true, reach_m)])
    return [_truth(spec, drawn(name, true, reach_m, chance), runs, variants) for name in spec.hidden]


def _truth(spec: Spec, hidden: Hidden, runs: Yardstick, variants: Sequence[Variant]) -> Truth:
    """An effect of the catalogue counts by all that shows of it, one from outside by what no pair of effects can say."""

    def shows(amount: float) -> float:
        if hidden.name in OUTSIDE:
            return left_by_any_pair(runs.change(hidden, amount), variants)
        left = runs.left(hidden, amount)
        return float(left @ left)

    wanted = needed(1 if hidden.name in OUTSIDE else hidden.parameters)
    detectable = amount_for(shows, wanted, hidden.most)
    if detectable is not None and hidden.name in LEAST:
        detectable = max(detectable, LEAST[hidden.name] / float(np.max(np.abs(hidden.direction))))
    if detectable is None:
        return Truth(hidden, min(UNSEEN_AMOUNT, 0.5 * hidden.most), None, 0.0, ())
    amount = min(spec.size * detectable, 0.9 * hidden.most)
    change = runs.change(hidden, detectable)
    alike = class_of(change * amount / detectable, hidden.parameters, [v for v in variants if v.name != hidden.name])
    return Truth(hidden, amount, detectable, amount / detectable, tuple(alike))


def amount_for(shows: Any, wanted: float, most: float) -> float | None:
    """The amount at which an effect shows as much as is wanted; None where it never does.

    What shows grows with the square of the amount, so a few steps of that rule are enough; where it does not (a play of the
    legs) the amount is halved in between, and where it jumps the least amount seen to show enough is taken.
    """
    amount, low, high = min(1.0, most), 0.0, np.inf
    for _ in range(_ROUNDS):
        seen = shows(amount)
        if abs(seen / wanted - 1.0) < _CLOSE or (seen < wanted and amount == most):
            break
        low, high = (amount, high) if seen < wanted else (low, amount)
        step = amount * float(np.clip(np.sqrt(wanted / max(seen, 1e-12 * wanted)), 1e-3, 1e3))
        between = float(np.sqrt(low * high)) if low > 0.0 and high < np.inf else 0.5 * amount
        amount = min(step if low < step < high else between, most)
    else:
        amount = high if high < np.inf else amount
    return float(amount) if shows(amount) > 0.5 * wanted else None


def true_model(model: Model, truths: Sequence[Truth]) -> Model:
    """The rig with all that is hidden in it."""
    for truth in truths:
        model = model.with_effect(truth.hidden.at(truth.amount))
    return model


def expected(truths: Sequence[Truth]) -> str:
    """The kind of answer that is right: none, effect, several, or unknown."""
    seen = [truth for truth in truths if truth.detectable is not None]
    if not seen:
        return "none"
    if any(truth.hidden.name in OUTSIDE for truth in seen):
        return "unknown"
    return "effect" if len(seen) == 1 else "several"
