"""The platform as one rigid body: its rotation, its kinetic energy, the solution of its 6 x 6 systems, and the rates of its state."""

from __future__ import annotations

import math

from numba import njit

from measure.common.arrays import Array
from simulate.kernel.layout import KINETIC, RATE, RIGHT, ROTATION, SYSTEM, TRIAL


@njit(cache=True, error_model="numpy", forceinline=True)
def rotate(w: Array, n: int) -> None:
    """Rotation matrices of the trial states, platform axes to world axes, row by row."""
    for i in range(n):
        a, b, c, d = w[(TRIAL + 3) * n + i], w[(TRIAL + 4) * n + i], w[(TRIAL + 5) * n + i], w[(TRIAL + 6) * n + i]
        w[ROTATION * n + i] = 1 - 2 * (c * c + d * d)
        w[(ROTATION + 1) * n + i] = 2 * (b * c - a * d)
        w[(ROTATION + 2) * n + i] = 2 * (b * d + a * c)
        w[(ROTATION + 3) * n + i] = 2 * (b * c + a * d)
        w[(ROTATION + 4) * n + i] = 1 - 2 * (b * b + d * d)
        w[(ROTATION + 5) * n + i] = 2 * (c * d - a * b)
        w[(ROTATION + 6) * n + i] = 2 * (b * d - a * c)
        w[(ROTATION + 7) * n + i] = 2 * (c * d + a * b)
        w[(ROTATION + 8) * n + i] = 1 - 2 * (b * b + c * c)


@njit(cache=True, error_model="numpy", forceinline=True)
def kinetic_energy(w: Array, n: int) -> None:
    """Half of v' M v, J: the mass matrix holds everything that moves."""
    for i in range(n):
        energy = 0.0
        for row in range(6):
            a = w[(TRIAL + 7 + row) * n + i]
            energy += 0.5 * w[(SYSTEM + row * (row + 3) // 2) * n + i] * a * a
            for column in range(row):
                energy += w[(SYSTEM + row * (row + 1) // 2 + column) * n + i] * a * w[(TRIAL + 7 + column) * n + i]
        w[KINETIC * n + i] = energy


@njit(cache=True, error_model="numpy", forceinline=True)
def solve(w: Array, n: int) -> None:
    """Solve the 6 x 6 systems by Cholesky; the accelerations replace the right side. Written out, so that it stays in registers."""
    for i in range(n):
        l00 = 1.0 / math.sqrt(w[SYSTEM * n + i])
        l10 = w[(SYSTEM + 1) * n + i] * l00
        l11 = 1.0 / math.sqrt(w[(SYSTEM + 2) * n + i] - l10 * l10)
        l20 = w[(SYSTEM + 3) * n + i] * l00
        l21 = (w[(SYSTEM + 4) * n + i] - l20 * l10) * l11
        l22 = 1.0 / math.sqrt(w[(SYSTEM + 5) * n + i] - l20 * l20 - l21 * l21)
        l30 = w[(SYSTEM + 6) * n + i] * l00
        l31 = (w[(SYSTEM + 7) * n + i] - l30 * l10) * l11
        l32 = (w[(SYSTEM + 8) * n + i] - l30 * l20 - l31 * l21) * l22
        l33 = 1.0 / math.sqrt(w[(SYSTEM + 9) * n + i] - l30 * l30 - l31 * l31 - l32 * l32)
        l40 = w[(SYSTEM + 10) * n + i] * l00
        l41 = (w[(SYSTEM + 11) * n + i] - l40 * l10) * l11
        l42 = (w[(SYSTEM + 12) * n + i] - l40 * l20 - l41 * l21) * l22
        l43 = (w[(SYSTEM + 13) * n + i] - l40 * l30 - l41 * l31 - l42 * l32) * l33
        l44 = 1.0 / math.sqrt(w[(SYSTEM + 14) * n + i] - l40 * l40 - l41 * l41 - l42 * l42 - l43 * l43)
        l50 = w[(SYSTEM + 15) * n + i] * l00
        l51 = (w[(SYSTEM + 16) * n + i] - l50 * l10) * l11
        l52 = (w[(SYSTEM + 17) * n + i] - l50 * l20 - l51 * l21) * l22
        l53 = (w[(SYSTEM + 18) * n + i] - l50 * l30 - l51 * l31 - l52 * l32) * l33
        l54 = (w[(SYSTEM + 19) * n + i] - l50 * l40 - l51 * l41 - l52 * l42 - l53 * l43) * l44
        l55 = 1.0 / math.sqrt(w[(SYSTEM + 20) * n + i] - l50 * l50 - l51 * l51 - l52 * l52 - l53 * l53 - l54 * l54)
        y0 = w[RIGHT * n + i] * l00
        y1 = (w[(RIGHT + 1) * n + i] - l10 * y0) * l11
        y2 = (w[(RIGHT + 2) * n + i] - l20 * y0 - l21 * y1) * l22
        y3 = (w[(RIGHT + 3) * n + i] - l30 * y0 - l31 * y1 - l32 * y2) * l33
        y4 = (w[(RIGHT + 4) * n + i] - l40 * y0 - l41 * y1 - l42 * y2 - l43 * y3) * l44
        y5 = (w[(RIGHT + 5) * n + i] - l50 * y0 - l51 * y1 - l52 * y2 - l53 * y3 - l54 * y4) * l55
        y5 *= l55
        y4 = (y4 - l54 * y5) * l44
        y3 = (y3 - l43 * y4 - l53 * y5) * l33
        y2 = (y2 - l32 * y3 - l42 * y4 - l52 * y5) * l22
        y1 = (y1 - l21 * y2 - l31 * y3 - l41 * y4 - l51 * y5) * l11
        y0 = (y0 - l10 * y1 - l20 * y2 - l30 * y3 - l40 * y4 - l50 * y5) * l00
        w[RIGHT * n + i] = y0
        w[(RIGHT + 1) * n + i] = y1
        w[(RIGHT + 2) * n + i] = y2
        w[(RIGHT + 3) * n + i] = y3
        w[(RIGHT + 4) * n + i] = y4
        w[(RIGHT + 5) * n + i] = y5


@njit(cache=True, error_model="numpy", forceinline=True)
def state_rates(w: Array, n: int) -> None:
    """Rates of position, quaternion, velocity and angular velocity, from the solved system."""
    for i in range(n):
        a, b, c, d = w[(TRIAL + 3) * n + i], w[(TRIAL + 4) * n + i], w[(TRIAL + 5) * n + i], w[(TRIAL + 6) * n + i]
        x, y, z = w[(TRIAL + 10) * n + i], w[(TRIAL + 11) * n + i], w[(TRIAL + 12) * n + i]
        w[(RATE + 3) * n + i] = -0.5 * (x * b + y * c + z * d)
        w[(RATE + 4) * n + i] = 0.5 * (x * a + y * d - z * c)
        w[(RATE + 5) * n + i] = 0.5 * (y * a + z * b - x * d)
        w[(RATE + 6) * n + i] = 0.5 * (z * a + x * c - y * b)
    for k in range(3 * n):
        w[RATE * n + k] = w[(TRIAL + 7) * n + k]
    for k in range(6 * n):
        w[(RATE + 7) * n + k] = w[RIGHT * n + k]
