"""Forward selection by BIC on raw samples: add the best effect as long as `S + k ln n` falls, every sample counted as independent."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from identify.estimation.problem import Fit

from .asking import Asked, Said, answer, candidates

_MOST, _TRIED_AGAIN = 3, 8


def main(arguments: Sequence[str]) -> int:
    """Takes the words of explain-gap."""
    return answer(arguments, think)


def think(asked: Asked) -> Said:
    """Up to three effects; after the first round the eight that were best in it are tried again."""
    current, names, again = asked.before, [], None
    while len(names) < _MOST:
        tried = sorted(candidates(current, again), key=lambda c: bic(c.fit))
        if not tried or bic(tried[0].fit) >= bic(current):
            break
        current, names = tried[0].fit, [*names, tried[0].name]
        again = [c.name for c in tried[1 : _TRIED_AGAIN + 1]]
    return Said(names, current)


def bic(fit: Fit) -> float:
    """S + k ln n, S the sum of squares over the stated noise."""
    return fit.cost + len(fit.q) * float(np.log(fit.problem.measured))
