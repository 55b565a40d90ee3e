"""A fit as lmfit shows it: parameters by name with errors and correlations, for `report_fit`, `conf_interval` and uncertainties.

lmfit is imported here only, and here only names are turned into the identifiers that it wants. Nothing is ever read from its files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from identify.estimation.fit import Fitted, Posed
from measure.common.arrays import Array

if TYPE_CHECKING:
    from lmfit import Minimizer, Parameters
    from lmfit.minimizer import MinimizerResult


def identifier(name: str) -> str:
    """A parameter's name as lmfit has it: `hub_inertia__mass_kg` for `hub-inertia.mass_kg`."""
    made = re.sub(r"\W", "_", name.replace(".", "__").replace("[", "_").replace("]", ""))
    return f"_{made}" if made[0].isdigit() else made


def identifiers(names: Sequence[str]) -> dict[str, str]:
    """The name behind each identifier; where two names would have the same, the later one is numbered."""
    made: dict[str, str] = {}
    for name in names:
        key = wanted = identifier(name)
        count = 1
        while key in made:
            count += 1
            key = f"{wanted}_{count}"
        made[key] = name
    return made


def lmfit_result(fit: Fitted[Posed]) -> MinimizerResult:
    """The fit as lmfit's own result; values, bounds and errors in the parameters' units, and the engine's own covariance.

    `result.user_names` gives the name behind each identifier.
    """
    from lmfit.minimizer import MinimizerResult

    names = identifiers([parameter.name for parameter in fit.problem.parameters])
    made, moved = _parameters(fit, names), _moved(fit)
    keys, places = [list(names)[i] for i in moved], [fit.problem.parameters[i].name for i in moved]
    covariance = fit.covariance_of(places)
    _set_errors(made, keys, covariance)
    return MinimizerResult(
        params=made,
        user_names=names,
        var_names=keys,
        covar=covariance,
        init_vals=[made[key].init_value for key in keys],
        init_values={key: made[key].init_value for key in keys},
        residual=fit.gaps,
        nfev=fit.evaluations,
        method="least_squares",
        success=fit.converged,
        message="converged" if fit.converged else "stopped before it had converged",
        errorbars=True,
        aborted=False,
        scale_covar=False,
        uvars=_with_uncertainties(made, keys, covariance),
        **_statistics(fit.gaps, len(keys)),
    )


def lmfit_minimizer(fit: Fitted[Posed]) -> Minimizer:
    """The problem as a function of lmfit's parameters, begun from the fit."""
    from lmfit import Minimizer

    names = identifiers([parameter.name for parameter in fit.problem.parameters])
    parameters = dict(zip(names, fit.problem.parameters, strict=True))

    def gaps(trial: Any) -> Array:
        return fit.problem.gaps(np.array([parameters[key].place(float(trial[key].value)) for key in names]))

    return Minimizer(gaps, _parameters(fit, names), scale_covar=False)


def _moved(fit: Fitted[Posed]) -> list[int]:
    """Places of the parameters that the fit could move and that do something to what was measured."""
    clear = dict(zip(fit.columns.tolist(), np.any(fit.jacobian[: fit.problem.measured] != 0.0, axis=0).tolist(), strict=True))
    return [i for i in range(len(fit.q)) if clear.get(i, False) and not fit.problem.held[i]]


def _parameters(fit: Fitted[Posed], names: dict[str, str]) -> Parameters:
    from lmfit import Parameters

    made, moved = Parameters(), set(_moved(fit))
    for i, (key, parameter) in enumerate(zip(names, fit.problem.parameters, strict=True)):
        low, high = (parameter.value(bound) if np.isfinite(bound) else bound for bound in (parameter.low, parameter.high))
        made.add(key, value=parameter.value(float(fit.q[i])), vary=i in moved, min=low, max=high)
        made[key].init_value = parameter.value(float(fit.problem.start[i]))
    return made


def _set_errors(made: Parameters, keys: Sequence[str], covariance: Array) -> None:
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    for i, key in enumerate(keys):
        made[key].stderr = float(errors[i])
        made[key].correl = {
            other: float(covariance[i, j] / (errors[i] * errors[j]))
            for j, other in enumerate(keys)
            if j != i and errors[i] > 0.0 and errors[j] > 0.0
        }


def _statistics(gaps: Array, varied: int) -> dict[str, float]:
    """Sum of squares and what lmfit makes of it: aic and bic take the samples for independent, unlike the engine's own."""
    count, chisqr = len(gaps), max(float(gaps @ gaps), 1e-250)
    likelihood = count * float(np.log(chisqr / count))
    return {
        "ndata": count,
        "nvarys": varied,
        "nfree": count - varied,
        "chisqr": chisqr,
        "redchi": chisqr / max(1, count - varied),
        "aic": likelihood + 2.0 * varied,
        "bic": likelihood + float(np.log(count)) * varied,
    }


def _with_uncertainties(made: Parameters, keys: Sequence[str], covariance: Array) -> dict[str, Any]:
    """Values that carry their errors and correlations through a user's own formulas."""
    from uncertainties import correlated_values

    return dict(zip(keys, correlated_values([made[key].value for key in keys], covariance), strict=True))
