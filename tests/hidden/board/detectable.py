"""What a set of runs can detect and tell apart at all, by linear algebra and whoever looks at it.

Let d be what an effect changes in all measured values, over their noise, and A what the force law, the releases and the other
things that are free in each run can change, with their priors as further rows. What cannot be put down to them is

    lambda = min over x of |d - A x|^2

and a test at p = 1e-3 on the k numbers of the effect finds it with the probability that a noncentral chi-squared of k degrees and
noncentrality lambda exceeds its 99.9 % point. The detectable size is the amount at which this is one half. Two effects are one
class where the one, freed of A, is so nearly a combination of what the other can do that the difference is below that, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import lsq_linear, root_scalar
from scipy.stats import chi2, ncx2

Array = np.ndarray

FALSE_POSITIVE, FOUND = 1e-3, 0.5
ALIKE = 0.99


@cache
def needed(parameters: int) -> float:
    """The noncentrality at which a test on this many numbers finds an effect half of the time."""
    threshold = chi2.isf(FALSE_POSITIVE, parameters)
    found = root_scalar(lambda x: ncx2.sf(threshold, parameters, x) - FOUND, bracket=(1e-6, 1e3))
    return float(found.root)


@dataclass(frozen=True)
class Free:
    """What law and releases can do: an orthonormal basis (m, r) of their columns; what is left of a change is free of them."""

    basis: Array

    def left(self, columns: Array) -> Array:
        """Changes (m,) or (m, k) freed of what law and releases can do themselves."""
        return columns - self.basis @ (self.basis.T @ columns)


def free_of(columns: Array) -> Free:
    """The projection that takes out these columns (m, n), however many of them are alike."""
    norms = np.linalg.norm(columns, axis=0)
    u, s, _ = np.linalg.svd(columns[:, norms > 0] / norms[norms > 0], full_matrices=False)
    return Free(u[:, s > 1e-10 * s[0]])


@dataclass(frozen=True)
class Variant:
    """A shape of a rival, its columns freed of law and releases. low, high : how far its amounts may go.

    parameters : how many numbers a fit of the rival has, its shape among them.
    """

    name: str
    parameters: int
    columns: Array
    low: Array
    high: Array


def unexplained(change: Array, variants: Sequence[Variant]) -> float:
    """What is left of a freed change |.|^2 after the best of these variants, within bounds."""
    return min((_left_by(change, variant) for variant in variants), default=float(change @ change))


def _left_by(change: Array, variant: Variant) -> float:
    norms = np.linalg.norm(variant.columns, axis=0)
    used = norms > 1e-9
    if not used.any():
        return float(change @ change)
    q, r = np.linalg.qr(variant.columns[:, used] / norms[used])
    low, high = variant.low[used] * norms[used], variant.high[used] * norms[used]
    target = q.T @ change
    inside = lsq_linear(r, target, bounds=(low, np.maximum(high, low + 1e-12)))
    return max(float(change @ change - target @ target) + float(np.sum((target - r @ inside.x) ** 2)), 0.0)


def class_of(change: Array, parameters: int, variants: Sequence[Variant]) -> list[str]:
    """The names of the effects that these runs cannot tell from a freed change, made by so many numbers.

    Alike, or apart by less than is detectable: what a rival leaves would have to be found by a test on the numbers that it lacks, one
    at least, for nine numbers do better than four by chance already. A rival has to say half of the change at least; at the
    detectable size nothing can be told from nothing.
    """
    whole = float(change @ change)
    found = []
    for name in dict.fromkeys(variant.name for variant in variants):
        own = [variant for variant in variants if variant.name == name]
        left, lacks = unexplained(change, own), max(1, parameters - own[0].parameters)
        if left < (1.0 - ALIKE**2) * whole or left < min(needed(lacks), 0.5 * whole):
            found.append(name)
    return found


def left_by_any_pair(change: Array, variants: Sequence[Variant]) -> float:
    """What is left of a freed change after the best pair of effects, bounds not counted."""
    frame = _basis(np.column_stack([change, *(variant.columns for variant in variants)]))
    small, bases = frame.T @ change, [_basis(frame.T @ variant.columns) for variant in variants]
    least = float(small @ small)
    for i, first in enumerate(bases):
        rest = small - first @ (first.T @ small)
        for j in range(i):
            if variants[i].name != variants[j].name:
                second = _basis(bases[j] - first @ (first.T @ bases[j]))
                least = min(least, float(rest @ rest - np.sum((second.T @ rest) ** 2)))
    return max(least, 0.0)


def _basis(columns: Array) -> Array:
    """Orthonormal columns that span these; empty where there is nothing."""
    norms = np.linalg.norm(columns, axis=0)
    used = norms > 1e-9
    if not used.any():
        return np.empty((len(columns), 0))
    u, s, _ = np.linalg.svd(columns[:, used] / norms[used], full_matrices=False)
    return u[:, s > 1e-6 * s[0]]
