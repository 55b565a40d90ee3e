"""How likely each hypothesis is before anything is measured, and what a sum of probabilities lets one say.

Half is given to nothing being missing, for most comparisons are made with a model that is right; a tenth to a model file that is wrong
by no more than its tolerances. Of the rest a wrong drawing or a wrong balance gets more than its number of candidates would give it, and a
force that no catalogue holds gets little: it can follow anything. A second name has a quarter of the probability of a first one, shared
alike. These are conventions.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from identify.criteria import ANOTHER, NOTHING, UNNAMED, WITHIN, WRONG_DRAWING
from identify.selection.model_errors import TOLERANCES
from identify.selection.promises import FORCES
from identify.selection.unknown_force import is_unnamed

MODEL_ERRORS = frozenset({*(kind.name for kind, _ in TOLERANCES), FORCES})
_TABLES = 5

Prior = Callable[[tuple[str, ...]], float]


def log_prior(catalogue: Collection[str]) -> Prior:
    """Log prior of a set of names, for a catalogue."""
    effects = max(len([name for name in catalogue if name not in MODEL_ERRORS]), 1)
    rest = 1.0 - NOTHING - WITHIN - WRONG_DRAWING - UNNAMED
    shares = {True: WRONG_DRAWING / len(MODEL_ERRORS), False: rest / effects}

    def of(names: tuple[str, ...]) -> float:
        if not names:
            return float(np.log(NOTHING + WITHIN))
        each = [UNNAMED / _TABLES if is_unnamed(name) else shares[name in MODEL_ERRORS] for name in names]
        return float(np.sum(np.log(each)) + (len(names) - 1) * np.log(ANOTHER / (1.0 - NOTHING - WITHIN)))

    return of
