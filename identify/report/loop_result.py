"""What a fit of loops says, as numbers for a file and as sentences for people."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from identify.actuator.actuator_fit import ActuatorFit, Disagreement, polynomial_errors_of, transition_of
from identify.actuator.rates_and_strokes import correlation_sentence, frequency_amplitude_correlation
from identify.actuator.stiffness import effective_stiffness, friction_without_inertia, slopes_and_inertia
from identify.actuator.suggestions import suggestions_of
from identify.actuator.verdict import errors, pooled_error
from identify.estimation.parameters import BETA_NAME, LINE_NAMES
from identify.loops.loop_data import LoopData, area, gap
from identify.loops.segments import sentence
from measure.common.arrays import Array
from simulate.model.model import Actuator, Covariance, Model, Rate


def result_of(fit: ActuatorFit, loops: Sequence[LoopData], notes: Sequence[str] = ()) -> dict[str, Any]:
    """The result as `fit-actuator --json` writes it."""
    return {
        "verdict": fit.verdict.word,
        "reason": fit.verdict.reason,
        "parameters": {
            name: {"value": e.value, "stderr": e.stderr, "ci95": list(e.ci95), "verdict": e.verdict} for name, e in fit.estimates.items()
        },
        "at_bound": fit.fit.at_bounds(),
        "half_height_N": fit.half_height_N,
        "half_height_at_m": fit.centre_m,
        "rate": _rate_with_errors(fit),
        "covariate": _covariate(fit, loops),
        "paper_recipe": _recipe(fit, loops),
        "loops": [_loop(fit, k, data, error) for k, (data, error) in enumerate(zip(loops, errors(loops, fit.residuals), strict=True))],
        "pooled_nrmse_percent": 100.0 * pooled_error(loops, fit.residuals),
        "friction": friction_without_inertia(loops, fit.effects, _missing_inertia(fit)).sentence,
        "slopes": slopes_and_inertia(loops, fit.effects, fit.estimates["a_l_N_per_m"].stderr),
        "transition": _transition(fit, loops),
        "frequency_amplitude_correlation": frequency_amplitude_correlation(loops),
        "effects": [{"name": effect.name, **dict(zip(effect.flat_names(), effect.flat(), strict=True))} for effect in fit.effects],
        "residual_depends_on": fit.left.sentence,
        "residual_shares": fit.left.shares,
        "record": [f"{Path(data.name).name}: {text}" for data in loops for text in (*data.remarks, sentence(data.parts))],
        "notes": list(notes),
        "faults": [{**asdict(fault), "loop": Path(fault.loop).name} for fault in fit.faults],
        "suggestions": [{**asdict(one), "sentence": one.sentence} for one in suggestions_of(fit.fit, fit.trials, loops)],
        "misfit": {"percent_of_half_height": 100.0 * fit.misfit.pooled, "significance": fit.misfit.significance},
        "disagreements": [_disagreement(one, loops) for one in fit.disagree],
    }


def _missing_inertia(fit: ActuatorFit) -> str:
    """The inertia that explains what is left, if one does best."""
    return fit.trials[0].name if fit.trials and fit.trials[0].effect.leg_mass is not None else ""


def _disagreement(one: Disagreement, loops: Sequence[LoopData]) -> dict[str, Any]:
    values = {Path(data.name).name: float(value) for data, value in zip(loops, one.values, strict=True)}
    return {"what": one.what, "values": values, "p_value": one.p_value, "sentence": one.sentence([data.name for data in loops])}


def _rate(fit: ActuatorFit) -> dict[str, Any] | None:
    rate = fit.fit.problem.rate
    return None if rate.abscissa == "none" else {"abscissa": rate.abscissa, **fit.polynomials()}


def _rate_with_errors(fit: ActuatorFit) -> dict[str, Any] | None:
    made = _rate(fit)
    return made and {**made, "stderr": polynomial_errors_of(fit)}


def drift_per_cycle(data: LoopData, of: Array) -> float:
    """How much the mean of `of`, (n,), grows from one full cycle to the next; by least squares, NaN below two cycles."""
    means = [float(np.mean(of[a:b])) for a, b in data.cycles.spans]
    return float(np.polyfit(np.arange(len(means)), means, 1)[0]) if len(means) > 1 else float("nan")


def closure(data: LoopData) -> float:
    """Force at the end of a full cycle minus that at its begin, N, median over the cycles; NaN without one.

    Both stand at the same turning point, so what is left is drift, transient, or the noise of two samples.
    """
    gaps = [float(data.force_N[b - 1] - data.force_N[a]) for a, b in data.cycles.spans]
    return float(np.median(gaps)) if gaps else float("nan")


def _transition(fit: ActuatorFit, loops: Sequence[LoopData]) -> dict[str, Any]:
    level = transition_of(fit, loops)
    columns = {key: getattr(level, key).tolist() for key in ("elongation_m", "level_N", "stderr_N", "departure_N")}
    return {**columns, "complete_from_m": level.complete_from_m, "sentence": level.sentence}


def _covariate(fit: ActuatorFit, loops: Sequence[LoopData]) -> dict[str, Any] | None:
    """What a covariate does to the force: newtons per unit, and its share of the height of the mean loop as measured."""
    problem = fit.fit.problem
    name = problem.covariate
    if not name:
        return None
    part = [_height(data, problem.covariate_force(fit.fit.q, k)) for k, data in enumerate(loops)]
    whole = [_height(data, data.force_N) for data in loops]
    share = 100.0 * float(np.mean(np.array(part) / np.array(whole)))
    return {"column": name, "N_per_unit": fit.fit.value(f"covariate.{name}"), "share_of_height_percent": share}


def _height(data: LoopData, force_N: Array) -> float:
    """Mean force while coiling minus mean force while uncoiling."""
    forward = data.speed_m_per_s[data.used] > 0.0
    return float(force_N[data.used][~forward].mean() - force_N[data.used][forward].mean())


def _recipe(fit: ActuatorFit, loops: Sequence[LoopData]) -> dict[str, Any] | None:
    if fit.recipe is None:
        return None
    known = np.isfinite(fit.recipe.beta_per_m)
    error = pooled_error(loops, [gap(fit.recipe.lines, data) for data in loops]) if known else float("nan")
    values = dict(zip((*LINE_NAMES, BETA_NAME), fit.recipe.lines, strict=True))
    return {**values, "statement": fit.recipe.statement, "pooled_nrmse_percent": 100.0 * error}


def _loop(fit: ActuatorFit, k: int, data: LoopData, error: float) -> dict[str, Any]:
    measured = area(data, data.force_N)
    modelled = data.force_N.copy()
    modelled[data.used] -= fit.residuals[k]
    return {
        "file": data.name,
        "frequency_Hz": data.frequency_Hz,
        "amplitude_m": data.amplitude_m,
        "cycles_used": len(data.cycles.spans),
        "samples_used": int(data.used.sum()),
        "samples_idle": int(len(data.used) - data.used.sum()),
        "effective_samples": fit.effective_samples[k],
        "nrmse_percent": 100.0 * error,
        "height_N": float(fit.misfit.heights_N[k]),
        "misfit_percent_of_half_height": 100.0 * float(fit.misfit.relative[k]),
        "area_J": measured,
        "area_error_percent": 100.0 * (area(data, modelled) / measured - 1.0) if measured else float("nan"),
        "effective_stiffness_N_per_m": effective_stiffness(data, fit.effects),
        "tare_N": fit.tares_N[k],
        "closure_N": closure(data),
        "drift_N_per_cycle": drift_per_cycle(data, data.force_N),
        "drift_m_per_cycle": drift_per_cycle(data, data.elongation_m),
        "force_noise_N": data.force_sigma_N,
        "conditions": {name: float(v[0]) for name, v in data.other.items() if len(v) and np.ptp(v) == 0.0},
        "parts": [asdict(part) for part in data.parts],
        "remarks": list(data.remarks),
    }


def actuator_of(fit: ActuatorFit) -> Actuator:
    """The actuator table of a model file.

    The force at a deployment's start is seen in no steady loop; the lower asymptote's b_l stands in for it.
    """
    a_l, b_l, a_u, b_u, beta = (float(v) for v in fit.lines)
    rate = _rate(fit)
    return Actuator(
        a_l_N_per_m=a_l,
        b_l_N=b_l,
        a_u_N_per_m=a_u,
        b_u_N=b_u,
        beta_per_m=beta,
        initial_force_N=b_l,
        rate=Rate(**rate) if rate else None,
        covariance=Covariance(tuple(fit.names), tuple(tuple(float(v) for v in row) for row in (fit.covariance + fit.covariance.T) / 2.0)),
    )


def model_of(fit: ActuatorFit, base: Model | None = None) -> Model:
    """A model with this actuator and the effects fitted with it, in place of those of `base` if there is one."""
    from dataclasses import replace

    from simulate.files.model_file import add_effects

    actuator = actuator_of(fit)
    return add_effects(replace(base, actuator=actuator) if base else Model(actuator, name="actuator"), fit.effects)


def summary(result: Mapping[str, Any]) -> list[str]:
    """The result in a few lines for people."""
    lines = [f"{'loop':<34} {'Hz':>7} {'mm':>8} {'cycles':>6} {'error':>7}  {'area':>7} {'mJ':>10} {'N/cycle':>9}"]
    for row in result["loops"]:
        name = row["file"] if len(row["file"]) <= 34 else "..." + row["file"][-31:]
        lines.append(
            f"{name:<34} {row['frequency_Hz']:7.3f} {1e3 * row['amplitude_m']:8.3f} {row['cycles_used']:6d} "
            f"{row['nrmse_percent']:5.2f} %  {row['area_error_percent']:+5.1f} % "
            f"{1e3 * row['area_J']:10.4g} {row['drift_N_per_cycle']:+9.2g}"
        )
    lines.append("")
    for name, e in result["parameters"].items():
        low, high = e["ci95"]
        said = "" if e["verdict"] == "ok" else f"   {e['verdict']}"
        lines.append(f"{name:<40} {e['value']:12.6g} +- {e['stderr']:<10.2g} 95 %: {low:.6g} to {high:.6g}{said}")
    lines += ["", *_remarks(result), f"verdict  {result['verdict']}: {result['reason']}"]
    return lines


def _remarks(result: Mapping[str, Any]) -> list[str]:
    lines = [f"record   {text}" for text in result["record"]]
    lines += [f"fault    {fault['loop']}: {fault['word']}, {fault['consequence']}: {fault['sentence']}" for fault in result["faults"]]
    lines += [f"note     {note}" for note in result["notes"]]
    lines.append(f"error    pooled {result['pooled_nrmse_percent']:.2f} % of the range of all forces")
    lines.append(f"misfit   {_misfit_sentence(result['misfit'])}")
    lines.append(f"residual depends on {result['residual_depends_on']}")
    lines += [f"suggest  {one['sentence']}: {one.get('command') or '--effect ' + one['name']}" for one in result["suggestions"]]
    lines.append(f"friction {result['friction']}")
    lines += [f"slopes   {result['slopes']}"] if result["slopes"] else []
    lines.append(f"transition zone {result['transition']['sentence']}")
    recipe = result["paper_recipe"]
    lines.append(f"paper's recipe: {recipe['statement'] if recipe else 'no straight parts on both branches'}")
    covariate = result["covariate"]
    if covariate:
        lines.append(
            f'covariate "{covariate["column"]}": {covariate["N_per_unit"]:.4g} N per unit, '
            f"{covariate['share_of_height_percent']:.0f} % of the loops' height"
        )
    correlated = correlation_sentence(result["frequency_amplitude_correlation"])
    return [*lines, correlated] if correlated else lines


def _misfit_sentence(misfit: Mapping[str, float]) -> str:
    """How much of the residual comes again in every cycle."""
    share, sure = misfit["percent_of_half_height"], misfit["significance"]
    if not np.isfinite(sure):
        return f"{share:.2f} % of half the loops' height at most; no cycle comes again, so noise cannot be told from it"
    return f"{share:.2f} % of half the loops' height comes again in every cycle ({sure:.1f} standard deviations of noise)"


def write_actuator(model: Model, path: Path, note: Mapping[str, Any], *, whole: bool) -> None:
    """Write the model file; without `whole` only what loops can tell: the actuator, its effects and where they come from."""
    import tomli_w

    from measure.common.output import write_text
    from simulate.files.model_file import document_of

    told = ("schema", "name", "actuator", "effect", "provenance")
    tables = {key: value for key, value in document_of(model, note).items() if whole or key in told}
    write_text(path, tomli_w.dumps(tables))
