"""A sweep as one file for other programs: factors, responses and regression, with units, seed and provenance."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from measure.tables.dataset_file import Attribute, Variable, write_dataset
from measure.tables.frames import unit_in_name
from simulate.model.responses import RESPONSES
from simulate.sweeps.factors import Factor
from simulate.sweeps.result import SweepResult


def write_sweep(result: SweepResult, path: Path, note: Mapping[str, Any] | None = None) -> None:
    """Write a sweep as HDF5 (.h5, by h5py, which is an extra) or netCDF 3 (.nc), for xarray, MATLAB and others.

    Parameters
    ----------
    result : from `sweep`.
    path : its ending decides.
    note : what made it, as `measure.common.output.provenance` gives it; kept as JSON in the attribute `provenance`.

    The variables along `run` are the coded level of each factor by its letter, its value (`A_value`), every response and
    `diverged_at_s`, NaN where a run has none; along `term` the coefficients of the regression. Each has the attributes `units` and
    `long_name`, a factor also `key`, `low`, `high` and `spread`. Of the file: model, design, seed, response, failure_deg, formula.

    Raises
    ------
    InputError
        Another ending, h5py is not installed, the file cannot be written.
    """
    terms = result.coefficient_columns()
    sizes = {"run": result.counts.runs, "term": len(terms["name"])}
    write_dataset(Path(path), sizes, {**_of_runs(result), **_of_terms(result, terms)}, _about(result, note))


def _about(result: SweepResult, note: Mapping[str, Any] | None) -> dict[str, Attribute]:
    design = result.sweep.design
    made: dict[str, Attribute] = {
        "title": f"deployments of {result.sweep.model.name}",
        "model": result.sweep.model.name,
        "design": design.kind,
        "seed": str(design.seed),  # a whole number of 64 bits, which netCDF 3 does not have
        "response": result.response,
        "failure_deg": float(result.failure_deg),
        "formula": result.report["formula"],
    }
    return made if note is None else {**made, "provenance": json.dumps(note, ensure_ascii=False, default=str)}


def _of_runs(result: SweepResult) -> dict[str, Variable]:
    columns = result.run_columns()
    made: dict[str, Variable] = {}
    for factor in result.sweep.factors:
        about = _of_factor(factor)
        made[factor.letter] = Variable("run", columns[factor.letter], {**about, "units": "1", "long_name": f"coded level of {factor.key}"})
        unit = unit_in_name(re.sub(r"\[\d+\]$", "", factor.key)) or "1"
        values = _values(factor, result.run_columns()[factor.letter])
        made[f"{factor.letter}_value"] = Variable("run", values, {**about, "units": unit, "long_name": factor.key})
    for name, response in RESPONSES.items():
        made[name] = Variable("run", columns[name], {"units": response.unit, "long_name": response.doc})
    diverged = {"units": "s", "long_name": "when the run diverged; none where it did not"}
    return {**made, "diverged_at_s": Variable("run", columns["diverged_at_s"], diverged)}


def _of_factor(factor: Factor) -> dict[str, Attribute]:
    spread = "normal, coded 1 is one standard deviation" if factor.normal else "between low and high"
    return {"key": factor.key, "low": factor.low, "high": factor.high, "spread": spread}


def _values(factor: Factor, coded: Any) -> Iterator[float]:
    return (factor.value(level) for level in coded)


def _of_terms(result: SweepResult, terms: Mapping[str, Any]) -> dict[str, Variable]:
    coefficient = f"coefficient_{result.unit}"
    about = {"units": result.unit, "long_name": f"of the regression of {result.response} on coded levels"}
    return {
        "term_name": Variable("term", terms["name"], {"long_name": "product of factors; 1 is the constant"}),
        "coefficient": Variable("term", terms[coefficient], about),
        "variability_percent": Variable("term", terms["variability_percent"], {"units": "percent"}),
    }
