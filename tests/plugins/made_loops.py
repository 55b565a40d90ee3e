"""A loop made ready whose motion, force and noise are known exactly: nothing of it was estimated."""

from __future__ import annotations

import numpy as np

from identify.loops.loop_data import Cycles, LoopData, Path


def triangles(cycles: int, half: int, stroke_m: float = 0.1) -> np.ndarray:
    """Elongation of whole cycles at constant speed, `half` samples a stroke, from its smallest value on, m."""
    return np.append(np.tile(np.concatenate([np.arange(half), np.arange(half, 0, -1)]) * stroke_m / half, cycles), 0.0)


def loop_data(elongation_m, force_N, *, half, step_s=0.01, sigma_N=0.01, name="made", used=None, **more):
    """A loop of `triangles`; its cycles are from one smallest elongation to the next."""
    u, force = np.asarray(elongation_m, float), np.asarray(force_N, float)
    n = len(u)
    time = step_s * np.arange(n)
    v = np.append(np.diff(u), 0.0) / step_s
    reversals = tuple(range(half, n - 1, half))
    spans = tuple((a, a + 2 * half + 1) for a in range(0, n - 2 * half, 2 * half))
    fields = {
        "name": name,
        "time_s": time,
        "elongation_m": u,
        "speed_m_per_s": v,
        "acceleration_m_per_s2": np.zeros(n),
        "force_N": force,
        "used": np.ones(n, bool) if used is None else used,
        "force_sigma_N": sigma_N,
        "elongation_sigma_m": 1e-5,
        "turns_sigma_m": 0.0,
        "cycles": Cycles(reversals, spans, 1.0 / (2 * half * step_s), float(np.ptp(u)) / 2.0),
        "path": Path(time, u, v, np.zeros(n)),
        "at": np.arange(n),
        "motion_errors": np.empty((0, 3, n)),
    }
    return LoopData(**{**fields, **more})
