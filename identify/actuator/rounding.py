"""What the steps of a load cell do to a fit: rounding is no noise, for it comes again in every cycle."""

from __future__ import annotations

import numpy as np

from identify.estimation.covariance import shift_of
from identify.estimation.least_squares import Fit
from measure.common.arrays import Array

_DRAWS = 48


def covariance_of_rounding(fit: Fit) -> Array:
    """Mean square of what rounding bends the parameters by, (k, k), in scales; zeros where no force comes in steps.

    The modelled force, with parameters as uncertain as the fit has them and as much noise as the residual has beyond that of rounding, is
    rounded to the steps as the converter does, and what that does to the parameters is worked out by the slopes. Always the same draws.
    """
    steps = [run.data.force_step_N for run in fit.problem.loops]
    whole = np.zeros((len(fit.q), len(fit.q)))
    if not any(steps):
        return whole
    chance = np.random.default_rng(0)
    for _ in range(2):
        root = _root(fit.covariance + whole)
        shifts = np.array([shift_of(fit.jacobian, _rounded(fit, root, steps, chance), fit.clear_of_bounds) for _ in range(_DRAWS)])
        whole = shifts.T @ shifts / _DRAWS
    return whole


def rounded_only(fit: Fit) -> bool:
    """Whether a force comes in steps and what is left is no more than rounding makes; then nothing else can be looked for in it."""
    return any(run.data.force_step_N for run in fit.problem.loops) and fit.rms < 1.0


def _root(covariance: Array) -> Array:
    power, ways = np.linalg.eigh((covariance + covariance.T) / 2.0)
    return ways * np.sqrt(np.maximum(power, 0.0))


def _rounded(fit: Fit, root: Array, steps: list[float], chance: np.random.Generator) -> Array:
    """Error of rounding of all loops, (m,), in units of the noise, at parameters that are drawn."""
    error = np.zeros(len(fit.gaps))
    drawn = fit.jacobian @ (root @ chance.standard_normal(root.shape[1]))
    for block, run, step in zip(fit.problem.blocks, fit.problem.loops, steps, strict=True):
        sigma = run.data.force_sigma_N
        if step == 0.0:
            continue
        residual = fit.difference(block) * sigma
        noise = float(np.sqrt(max(np.mean(residual**2) - step**2 / 12.0, 0.0)))
        force = run.data.force_N[run.data.used] - residual - drawn[block.rows] * sigma
        force += noise * chance.standard_normal(len(force)) + step * chance.uniform(-0.5, 0.5)
        error[block.rows] = (np.round(force / step) * step - force) / sigma
    return error
