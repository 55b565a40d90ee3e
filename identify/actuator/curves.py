"""What a fit of loops is in numbers and as a table: points, chi-square, criteria, correlations; measured, corrected and fitted force."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from identify.actuator.fit_actuator import ActuatorFit
from identify.estimation.parameters import LINE_NAMES
from measure.common.arrays import Array

_STRONG = 0.95  # correlation of two estimates from which on it is said


def corrected_force(fit: ActuatorFit, loop: int) -> Array:
    """Force of a loop as the law sees it, N, (n,): without the tare that it was given and without the covariate's part.

    The covariate's part is that of its difference from the mean over all loops, so that the corrected loops are those at the mean.
    """
    force = fit.loops[loop].force_N - fit.tares_N[loop]
    problem = fit.fit.problem
    return force - problem.covariate_force(fit.fit.q, loop) if problem.covariate else force


def curve_columns(fit: ActuatorFit) -> dict[str, Any]:
    """The samples that count of all loops as the columns of a table.

    Returns
    -------
    file; time_s, elongation_m, speed_m_per_s; force_N as measured, fitted_N and residual_N; corrected_N as in `corrected_force`.
    """
    used = [data.used for data in fit.loops]
    measured = np.concatenate([data.force_N[rows] for data, rows in zip(fit.loops, used, strict=True)])
    left = np.concatenate(fit.residuals)
    corrected = [corrected_force(fit, k)[rows] for k, rows in enumerate(used)]
    columns = {
        name: np.concatenate([getattr(data, name)[rows] for data, rows in zip(fit.loops, used, strict=True)])
        for name in ("time_s", "elongation_m", "speed_m_per_s")
    }
    names = [Path(data.name).name for data, rows in zip(fit.loops, used, strict=True) for _ in range(int(rows.sum()))]
    forces = {"force_N": measured, "corrected_N": np.concatenate(corrected), "fitted_N": measured - left, "residual_N": left}
    return {"file": names, **columns, **forces}


def coefficients_of(fit: ActuatorFit, line: int) -> list[str]:
    """Names of the coefficients of one of the four lines over the scaled rate, lowest power first."""
    return [LINE_NAMES[line], *(f"rate.{LINE_NAMES[line]}[{j}]" for j in range(1, fit.fit.problem.rate.order + 1))]


def line_at(fit: ActuatorFit, line: int, x: Array, elongation_m: float | None = None) -> tuple[Array, Array]:
    """One of a_l, b_l, a_u, b_u over the rate, and its standard error, (n,) each.

    Parameters
    ----------
    line : 0 to 3. x : the rate, (n,). elongation_m : where the level of b_l or b_u is taken, a u + b; without it at zero.
    """
    rate = fit.fit.problem.rate
    powers = ((x - rate.middle) / rate.half)[:, None] ** np.arange(rate.order + 1)
    names = coefficients_of(fit, line)
    if elongation_m is not None:
        names, powers = names + coefficients_of(fit, line - 1), np.hstack([powers, elongation_m * powers])
    value = powers @ np.array([fit.fit.value(name) for name in names])
    return value, np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", powers, fit.fit.covariance_of(names), powers), 0.0))


def polynomial_errors_of(fit: ActuatorFit) -> dict[str, list[float]]:
    """Standard errors of the coefficients of a_l, b_l, a_u, b_u in the rate itself, lowest power first."""
    rate = fit.fit.problem.rate
    turn = np.array([np.pad(c := rate.unscaled(row), (0, rate.order + 1 - len(c))) for row in np.eye(rate.order + 1)])
    covariances = [fit.fit.covariance_of(coefficients_of(fit, line)) for line in range(4)]
    return {
        name: np.sqrt(np.maximum(np.diag(turn.T @ covariance @ turn), 0.0)).tolist()
        for name, covariance in zip(("a_l", "b_l", "a_u", "b_u"), covariances, strict=True)
    }


def statistics_of(fit: ActuatorFit) -> dict[str, Any]:
    """Number of points and parameters, chi-square, AIC and BIC, and the correlations of the estimates.

    chi-square is the sum of squares over the noise of each loop, n points, k parameters; AIC = n ln(chi2 / n) + 2 k and
    BIC = n ln(chi2 / n) + k ln n as lmfit has them, with the samples taken for independent; `_effective` with the number of independent
    samples instead of n.
    """
    gaps, k = fit.fit.measured_gaps, _free(fit)
    n, independent, chi2 = len(gaps), float(fit.fit.effective_samples), float(gaps @ gaps)
    mean = float(np.log(max(chi2, 1e-250) / n))
    return {
        "points": n,
        "effective_points": independent,
        "free_parameters": k,
        "chi_square": chi2,
        "reduced_chi_square": chi2 / max(1, n - k),
        "aic": n * mean + 2.0 * k,
        "bic": n * mean + k * float(np.log(n)),
        "aic_effective": independent * mean + 2.0 * k,
        "bic_effective": independent * mean + k * float(np.log(independent)),
        "correlations": _correlations(fit),
    }


def _free(fit: ActuatorFit) -> int:
    """Parameters that the fit could move and that do something to what was measured."""
    whole = fit.fit
    moved = np.any(whole.jacobian[: whole.problem.measured] != 0.0, axis=0)
    return int(np.count_nonzero(moved & ~whole.problem.held[whole.columns]))


def _correlations(fit: ActuatorFit) -> dict[str, Any]:
    """Correlations of the estimates, (k, k), with their names; of an estimate that is held, zero."""
    errors = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    known = np.outer(errors, errors)
    matrix = np.where(known > 0.0, fit.covariance / np.where(known > 0.0, known, 1.0), np.eye(len(errors)))
    return {"names": list(fit.names), "matrix": np.clip(matrix, -1.0, 1.0).tolist()}


def statistics_sentence(statistics: dict[str, Any]) -> str:
    """The statistics in a line for people, with the estimates that hardly go apart."""
    names, matrix = statistics["correlations"]["names"], np.array(statistics["correlations"]["matrix"])
    pairs = [(abs(matrix[i, j]), f"{names[i]} and {names[j]} {matrix[i, j]:+.3f}") for i in range(len(names)) for j in range(i)]
    strong = [text for size, text in sorted(pairs, reverse=True) if size > _STRONG][:3]
    said = (
        f"{statistics['points']} points, worth {statistics['effective_points']:.0f} independent ones, {statistics['free_parameters']} "
        f"parameters; chi-square {statistics['chi_square']:.5g}, {statistics['reduced_chi_square']:.3g} reduced; "
        f"AIC {statistics['aic_effective']:.1f}, BIC {statistics['bic_effective']:.1f}"
    )
    return f"{said}; correlated: {', '.join(strong)}" if strong else said
