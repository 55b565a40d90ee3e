"""What the steps of a load cell do to a fit: rounding is no noise, for it comes again in every cycle."""

from __future__ import annotations

import numpy as np

from identify.estimation.covariance import shift_of
from identify.estimation.fit import Block
from identify.estimation.problem import Fit
from identify.loops.loop_data import LoopData
from measure.common.arrays import Array


def covariance_of_rounding(fit: Fit) -> Array:
    """What rounding may bend the parameters by, (k, k), in scales; zeros where no force comes in steps.

    While the reading stands still the force is anywhere within the step, and may go anywhere within it. So for all samples of one branch at
    one reading the error is a constant and a ramp along the elongation, each uniform, q^2 / 12, and in every cycle alike. A flat branch
    that never leaves a step has any slope up to q over its length.
    """
    whole = np.zeros((len(fit.q), len(fit.q)))
    for block, run in zip(fit.problem.blocks, fit.problem.loops, strict=True):
        for error in _errors(fit, block, run.data) if run.data.force_step_N else ():
            shift = shift_of(fit.jacobian, error, fit.clear_of_bounds)
            whole += np.outer(shift, shift)
    return whole


def _errors(fit: Fit, block: Block, data: LoopData) -> list[Array]:
    """One standard deviation of the error of each reading on each branch, (m,), in units of the noise."""
    force, away = data.force_N[data.used], data.speed_m_per_s[data.used] > 0.0
    readings = 2 * np.round((force - force.min()) / data.force_step_N).astype(int) + away
    made = []
    for reading in np.unique(readings):
        here, u = readings == reading, data.elongation_m[data.used]
        middle, half = (u[here].max() + u[here].min()) / 2.0, max(float(np.ptp(u[here])) / 2.0, 1e-300)
        for shape in (np.ones(len(u)), (u - middle) / half):
            error = np.zeros(len(fit.gaps))
            error[block.rows] = here * shape * data.force_step_N / (np.sqrt(12.0) * data.force_sigma_N)
            made.append(error)
    return made


def rounded_only(fit: Fit) -> bool:
    """Whether a force comes in steps and what is left is no more than rounding makes; then nothing else can be looked for in it."""
    return any(run.data.force_step_N for run in fit.problem.loops) and fit.rms < 1.0
