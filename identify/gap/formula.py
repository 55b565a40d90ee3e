"""A missing force in a short formula: a description of the estimate for people, never a name for its cause.

    F = sum of c_i f_i,   f_i among 1, z, v, v |v|, sgn v, a, t

Terms join one by one, weighted least squares on the estimated force, while the BIC falls (a sparse regression on a library
of terms, after Brunton et al. 2016, by forward selection).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from identify.campaign.prepared import Film
from identify.gap.localise import smooth_derivative
from identify.gap.platform_force import MissingForce
from measure.common.arrays import Array

_MOST_TERMS = 3
_LEAST_SHARE = 0.5  # of the force's weighted square: a formula that says less is no description
_UNITS = {"1": "", "z": " /m", "v": " s/m", "v |v|": " s2/m2", "sgn v": "", "a": " s2/m", "t": " /s"}


def described(missing: MissingForce, film: Film) -> str | None:
    """The vertical force as a formula of what the platform does in a film, or None where none says at least half of it.

    A force at a few places only is none: as many terms would say anything.

    z is the height above the start, t the time since the release; the film gives speed and acceleration at each place of the table.
    """
    known = np.isfinite(missing.sigma_N[:, 0])
    force, sigma = missing.force_N[known, 0], missing.sigma_N[known, 0]
    terms = _library(missing, film)
    if terms is None or len(force) <= 2 * _MOST_TERMS or not np.any(np.abs(force) > 3.0 * sigma):
        return None
    terms = {name: values[known] for name, values in terms.items()}
    chosen, sizes, left = _selected(terms, force, sigma)
    whole = float(np.sum((force / sigma) ** 2))
    if not chosen or left > (1.0 - _LEAST_SHARE) * whole:
        return None
    words = " ".join(f"{size:+.3g}{_UNITS[name]}{'' if name == '1' else ' ' + name}" for name, size in zip(chosen, sizes, strict=True))
    return f"F_z = ({words}) N describes {100 * (1 - left / whole):.0f} % of it; a description, not a cause"


def _library(missing: MissingForce, film: Film) -> Mapping[str, Array] | None:
    """Terms at the places of the table, from the film's elevation; None where it has none or they are passed more than once."""
    if "z_m" not in film.channels:
        return None
    good = np.isfinite(film.values[film.channels.index("z_m")])
    time, height = film.time_s[good] - film.expected_s, film.values[film.channels.index("z_m")][good]
    step = float(np.median(np.diff(time)))
    speed, acceleration = smooth_derivative(height, step, 1), smooth_derivative(height, step, 2)
    rising = slice(0, int(np.argmax(height)) + 1)
    axis = {"time_s": time, "height_m": np.maximum.accumulate(height), "speed_m_per_s": np.maximum.accumulate(speed)}
    column = next(iter(missing.columns))
    at = np.interp(missing.places, axis[column][rising], time[rising])
    z, v, a = (np.interp(at, time, curve) for curve in (height - height[0], speed, acceleration))
    return {"1": np.ones(len(at)), "z": z, "v": v, "v |v|": v * np.abs(v), "sgn v": np.sign(v), "a": a, "t": at}


def _selected(terms: Mapping[str, Array], force: Array, sigma: Array) -> tuple[list[str], Array, float]:
    """Names, sizes and what they leave, weighted; terms join while the BIC falls."""
    chosen: list[str] = []
    sizes, left = np.empty(0), float(np.sum((force / sigma) ** 2))
    while len(chosen) < _MOST_TERMS:
        tried = {name: _fitted([*chosen, name], terms, force, sigma) for name in terms if name not in chosen}
        best = min(tried, key=lambda name: tried[name][1])
        if left - tried[best][1] < np.log(len(force)):
            break
        chosen.append(best)
        sizes, left = tried[best]
    return chosen, sizes, left


def _fitted(names: Sequence[str], terms: Mapping[str, Array], force: Array, sigma: Array) -> tuple[Array, float]:
    columns = np.stack([terms[name] / sigma for name in names], axis=1)
    sizes = np.linalg.lstsq(columns, force / sigma, rcond=None)[0]
    return sizes, float(np.sum((force / sigma - columns @ sizes) ** 2))
