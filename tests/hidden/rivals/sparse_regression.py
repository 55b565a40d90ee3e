"""Sparse regression on what is left of acceleration and force: a library of terms, Lasso with its penalty by cross-validation.

    left''(t) = sum of terms c_i g_i(u, v, a, t)          the effect behind the largest c_i |g_i| is named

Law and releases are fitted first, then differentiated: the way of pysindy and its kind, with this rig's effects as the library. Nothing
is named where no term survives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.signal import savgol_filter
from sklearn.linear_model import LassoCV
from sklearn.preprocessing import StandardScaler

from .asking import Asked, Said, answer

Array = np.ndarray
Term = Callable[[Array, Array, Array, Array], Array]

_WINDOW, _ORDER = 15, 3
_FOLDS = 5
# Terms of elongation (or rise), its rate, its acceleration and time.
IN_BOTH: dict[str, list[Term]] = {
    "hub-inertia": [lambda u, v, a, t: a],
    "viscous-friction": [lambda u, v, a, t: v],
    "power-law-friction": [lambda u, v, a, t: np.sign(v) * np.abs(v) ** 0.5, lambda u, v, a, t: v * np.abs(v) ** 1.5],
    "stribeck-friction": [lambda u, v, a, t: np.tanh(v / 2e-3) * np.exp(-((v / 0.1) ** 2))],
    "rate-dependent-asymptotes": [lambda u, v, a, t: np.abs(v), lambda u, v, a, t: u * np.abs(v)],
    "curved-asymptotes": [lambda u, v, a, t: u**2, lambda u, v, a, t: u**3],
    "transition-zone": [lambda u, v, a, t: np.exp(-u / 0.08)],
    "force-relaxation": [lambda u, v, a, t: 1.0 - np.exp(-t / 0.3)],
}
IN_LOOPS: dict[str, list[Term]] = {
    "sensor-lag": [lambda u, v, a, t: np.gradient(a, t)],
    "force-offset": [lambda u, v, a, t: np.ones_like(t), lambda u, v, a, t: t],
    "backlash": [lambda u, v, a, t: np.exp(-((v / 0.01) ** 2)) * np.sign(a)],
}
IN_FILMS: dict[str, list[Term]] = {
    "gravity-imbalance": [lambda u, v, a, t: np.ones_like(t)],
    "pulley-friction": [lambda u, v, a, t: np.tanh(v / 2e-3)],
    "air-drag": [lambda u, v, a, t: v * np.abs(v)],
    "time-offset": [lambda u, v, a, t: np.gradient(a, t)],
    "scale-error": [lambda u, v, a, t: u],
    "end-stop-dissipation": [lambda u, v, a, t: np.where(u > 0.98 * u.max(), v, 0.0)],
    "base-excitation": [lambda u, v, a, t, f=f: np.sin(2 * np.pi * f * t) for f in (4.0, 8.0, 16.0)],
    "cable-pendulum": [lambda u, v, a, t: -np.abs(u - u.mean())],
}


def main(arguments: Sequence[str]) -> int:
    """Takes the words of explain-gap."""
    return answer(arguments, think)


def think(asked: Asked) -> Said:
    """Regression on loops and on elevations apart; the term that carries most of either is the answer."""
    strengths: dict[str, float] = {}
    for rows, library in ((_of_loops(asked), {**IN_BOTH, **IN_LOOPS}), (_of_films(asked), {**IN_BOTH, **IN_FILMS})):
        if rows:
            for name, strength in regression(rows, library).items():
                strengths[name] = max(strength, strengths.get(name, 0.0))
    best = max(strengths, key=lambda name: strengths[name], default=None)
    return Said((best,)) if best is not None and strengths[best] > 0.0 else Said(())


Row = tuple[Array, Array, Array, Array, Array]


def regression(rows: Sequence[Row], library: dict[str, list[Term]]) -> dict[str, float]:
    """Share of the left-over that each effect's strongest term carries, zero for terms that the penalty takes out."""
    names = [name for name, terms in library.items() for _ in terms]
    columns = np.concatenate([np.column_stack([g(u, v, a, t) for terms in library.values() for g in terms]) for u, v, a, t, _ in rows])
    left = np.concatenate([row[4] for row in rows])
    scaled = StandardScaler().fit_transform(columns)
    found = LassoCV(cv=_FOLDS, max_iter=20_000).fit(scaled, left / (np.std(left) or 1.0))
    strengths: dict[str, float] = {}
    for name, coefficient in zip(names, np.abs(found.coef_), strict=True):
        strengths[name] = max(float(coefficient), strengths.get(name, 0.0))
    return strengths


def _of_loops(asked: Asked) -> list[Row]:
    rows, fit = [], asked.before
    for loop, block in zip(fit.problem.loops, [b for b in fit.problem.blocks if b.channel == "force_N"], strict=True):
        d, used = loop.data, loop.data.used
        rows.append((d.elongation_m[used], d.speed_m_per_s[used], d.acceleration_m_per_s2[used], d.time_s[used], fit.part(block)))
    return rows


def _of_films(asked: Asked) -> list[Row]:
    """The elevation: what was measured, and the acceleration of its gap, both by a local polynomial."""
    rows, fit = [], asked.before
    for film in fit.problem.films:
        for block in fit.problem.blocks:
            if block.run == film.run.name and block.channel == "z_m" and len(block.samples) > _WINDOW:
                t = film.time_s[block.samples]
                step = float(np.median(np.diff(t)))
                rise = film.values[film.channels.index("z_m")][block.samples]
                v, a = (savgol_filter(rise, _WINDOW, _ORDER, deriv=k, delta=step) for k in (1, 2))
                rows.append((rise - rise[0], v, a, t - t[0], savgol_filter(fit.part(block), _WINDOW, _ORDER, deriv=2, delta=step)))
    return rows
