"""Asymptotes that follow frequency or speed from loop to loop, as polynomials of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.loops.loop_data import LoopData
from measure.common.arrays import Array

Abscissa = Literal["none", "frequency_Hz", "speed_m_per_s"]


@dataclass(frozen=True)
class RatePolynomials:
    """What the four lines follow and by which order, z = (x - middle) / half from -1 to 1 over the rates seen.

    With z the coefficients hardly depend on each other; a coefficient of z^0 is the line in the middle of the rates.
    """

    abscissa: Abscissa = "none"
    order: int = 0
    middle: float = 0.0
    half: float = 1.0

    def z_of(self, data: LoopData) -> float:
        """The scaled rate of a loop."""
        return 0.0 if self.abscissa == "none" else (rate_of(data, self.abscissa) - self.middle) / self.half

    def unscaled(self, coefficients: Array) -> Array:
        """Coefficients (order + 1,) of a polynomial in z as those of the same polynomial in the rate itself, lowest power first."""
        shift = np.polynomial.Polynomial([-self.middle / self.half, 1.0 / self.half])
        return np.asarray(np.polynomial.Polynomial(coefficients)(shift).coef, dtype=float)


NO_RATE = RatePolynomials()


def rate_of(data: LoopData, abscissa: Abscissa) -> float:
    """Frequency of a loop, or its speed in the middle of the stroke."""
    return data.frequency_Hz if abscissa == "frequency_Hz" else data.mid_stroke_speed_m_per_s
