"""Fit every effect alone and name the one that leaves the least error. It always names one."""

from __future__ import annotations

from collections.abc import Sequence

from .asking import Asked, Said, answer, candidates


def main(arguments: Sequence[str]) -> int:
    """Takes the words of explain-gap."""
    return answer(arguments, think)


def think(asked: Asked) -> Said:
    """The least sum of squares wins, whatever it is."""
    tried = candidates(asked.before)
    if not tried:
        return Said(())
    best = min(tried, key=lambda c: c.fit.cost)
    return Said((best.name,), best.fit)
