"""The platform as one rigid body: its rotation, its kinetic energy, the solution of its 6 x 6 systems, and the rates of its state."""

from __future__ import annotations

from typing import Any

from numba import njit

from simulate.dispatch.lanes import Rows, inverse_root
from simulate.kernel.layout import KINETIC, RATE, RIGHT, ROTATION, SYSTEM, TRIAL


@njit(cache=True, error_model="numpy", forceinline=True)
def rotate(w: Rows) -> None:
    """Rotation matrices of the trial states, platform axes to world axes, row by row."""
    matrix = rotation_matrix(w[TRIAL + 3], w[TRIAL + 4], w[TRIAL + 5], w[TRIAL + 6])
    for k in range(9):
        w[ROTATION + k] = matrix[k]


@njit(cache=True, error_model="numpy", forceinline=True)
def rotation_matrix(a: Any, b: Any, c: Any, d: Any) -> Any:
    """The nine entries, row by row, of a unit quaternion, scalar first: of one run or of runs side by side."""
    return (
        1 - 2 * (c * c + d * d),
        2 * (b * c - a * d),
        2 * (b * d + a * c),
        2 * (b * c + a * d),
        1 - 2 * (b * b + d * d),
        2 * (c * d - a * b),
        2 * (b * d - a * c),
        2 * (c * d + a * b),
        1 - 2 * (b * b + c * c),
    )


@njit(cache=True, error_model="numpy", forceinline=True)
def kinetic_energy(w: Rows) -> None:
    """Half of v' M v, J: the mass matrix holds everything that moves."""
    w[KINETIC] = 0.0
    for row in range(6):
        a = w[TRIAL + 7 + row]
        w[KINETIC] += 0.5 * w[SYSTEM + row * (row + 3) // 2] * a * a
        for column in range(row):
            w[KINETIC] += w[SYSTEM + row * (row + 1) // 2 + column] * a * w[TRIAL + 7 + column]


@njit(cache=True, error_model="numpy", forceinline=True)
def solve(w: Rows) -> None:
    """Solve the 6 x 6 systems by Cholesky; the accelerations replace the right side. Written out, so that it stays in registers."""
    l00 = inverse_root(w[SYSTEM])
    l10 = w[SYSTEM + 1] * l00
    l11 = inverse_root(w[SYSTEM + 2] - l10 * l10)
    l20 = w[SYSTEM + 3] * l00
    l21 = (w[SYSTEM + 4] - l20 * l10) * l11
    l22 = inverse_root(w[SYSTEM + 5] - l20 * l20 - l21 * l21)
    l30 = w[SYSTEM + 6] * l00
    l31 = (w[SYSTEM + 7] - l30 * l10) * l11
    l32 = (w[SYSTEM + 8] - l30 * l20 - l31 * l21) * l22
    l33 = inverse_root(w[SYSTEM + 9] - l30 * l30 - l31 * l31 - l32 * l32)
    l40 = w[SYSTEM + 10] * l00
    l41 = (w[SYSTEM + 11] - l40 * l10) * l11
    l42 = (w[SYSTEM + 12] - l40 * l20 - l41 * l21) * l22
    l43 = (w[SYSTEM + 13] - l40 * l30 - l41 * l31 - l42 * l32) * l33
    l44 = inverse_root(w[SYSTEM + 14] - l40 * l40 - l41 * l41 - l42 * l42 - l43 * l43)
    l50 = w[SYSTEM + 15] * l00
    l51 = (w[SYSTEM + 16] - l50 * l10) * l11
    l52 = (w[SYSTEM + 17] - l50 * l20 - l51 * l21) * l22
    l53 = (w[SYSTEM + 18] - l50 * l30 - l51 * l31 - l52 * l32) * l33
    l54 = (w[SYSTEM + 19] - l50 * l40 - l51 * l41 - l52 * l42 - l53 * l43) * l44
    l55 = inverse_root(w[SYSTEM + 20] - l50 * l50 - l51 * l51 - l52 * l52 - l53 * l53 - l54 * l54)
    y0 = w[RIGHT] * l00
    y1 = (w[RIGHT + 1] - l10 * y0) * l11
    y2 = (w[RIGHT + 2] - l20 * y0 - l21 * y1) * l22
    y3 = (w[RIGHT + 3] - l30 * y0 - l31 * y1 - l32 * y2) * l33
    y4 = (w[RIGHT + 4] - l40 * y0 - l41 * y1 - l42 * y2 - l43 * y3) * l44
    y5 = (w[RIGHT + 5] - l50 * y0 - l51 * y1 - l52 * y2 - l53 * y3 - l54 * y4) * l55
    y5 *= l55
    y4 = (y4 - l54 * y5) * l44
    y3 = (y3 - l43 * y4 - l53 * y5) * l33
    y2 = (y2 - l32 * y3 - l42 * y4 - l52 * y5) * l22
    y1 = (y1 - l21 * y2 - l31 * y3 - l41 * y4 - l51 * y5) * l11
    y0 = (y0 - l10 * y1 - l20 * y2 - l30 * y3 - l40 * y4 - l50 * y5) * l00
    w[RIGHT] = y0
    w[RIGHT + 1] = y1
    w[RIGHT + 2] = y2
    w[RIGHT + 3] = y3
    w[RIGHT + 4] = y4
    w[RIGHT + 5] = y5


@njit(cache=True, error_model="numpy", forceinline=True)
def state_rates(w: Rows) -> None:
    """Rates of position, quaternion, velocity and angular velocity, from the solved system."""
    a, b, c, d = w[TRIAL + 3], w[TRIAL + 4], w[TRIAL + 5], w[TRIAL + 6]
    x, y, z = w[TRIAL + 10], w[TRIAL + 11], w[TRIAL + 12]
    w[RATE + 3] = -0.5 * (x * b + y * c + z * d)
    w[RATE + 4] = 0.5 * (x * a + y * d - z * c)
    w[RATE + 5] = 0.5 * (y * a + z * b - x * d)
    w[RATE + 6] = 0.5 * (z * a + x * c - y * b)
    for k in range(3):
        w[RATE + k] = w[TRIAL + 7 + k]
    for k in range(6):
        w[RATE + 7 + k] = w[RIGHT + k]
