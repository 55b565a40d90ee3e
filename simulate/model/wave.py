"""Effects that are waves: several of one frequency, in different phases and along different axes, make one again."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

from measure.common.arrays import Array
from simulate.model.effect import Effect


@dataclass(frozen=True)
class Wave(Effect, ABC):
    """An effect that is a wave.

    summed : names of the parameters in which waves may differ that make one again: a phase, an axis.
    """

    summed: ClassVar[tuple[str, ...]]

    @abstractmethod
    def sum_of(self, shapes: Array, amounts: Array) -> Effect:
        """The wave that several make together, or that comes nearest to it.

        Parameters
        ----------
        shapes : (k, n) their parameters laid flat, which differ from those of this one in `summed` alone.
        amounts : (k,) the first parameter of each.
        """
