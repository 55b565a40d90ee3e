"""An explanation as JSON, to the letter of what others' scripts rely on, and as a sentence for people."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from identify.campaign.load_cell_zeros import drifts_of, zeros_of
from identify.design.further_test import NextTest
from identify.draft.effect_file import FILE
from identify.gap.dragged import lost
from identify.gap.localise import force_in_loops, locate
from identify.gap.size import gap_left, gap_size, noise_over_stated
from identify.loops.covariates import hint, shares
from identify.report.sentences import left_sentence, moved_far, next_experiment, noise_sentence, sentence
from identify.selection.explanation import Explanation, Ranked
from identify.selection.verdict import Finding

_PLACES = 12
_RANKED = 30


def result_of(found: Explanation, missing_force_file: str | None = None) -> dict[str, Any]:
    """The result of `explain-gap --json`.

    Parameters
    ----------
    found : what `explain` found.
    missing_force_file : where the table of the missing force was written, where something is left.

    Returns
    -------
    dict
        As in the contract of the command; only plain numbers, texts, lists and tables.
    """
    return {
        "verdict": found.verdict,
        "weights": dict(found.weights),
        "noise": [
            {"run": one.run, "channel": one.channel, "sigma": one.sigma, "lag1": one.lag1, "outliers_percent": one.outliers_percent}
            for one in found.noise
        ],
        "effects": [_finding(finding) for finding in found.findings],
        "where": [_place(place) for place in locate(found.before)[:_PLACES]] if found.verdict != "no-gap" else [],
        "gap": _gaps(found),
        "ranking": [_ranked(row, found) for row in found.ranking[:_RANKED]],
        "missing_force": _missing_force(found, missing_force_file),
        "drafted": _draft(found),
        "next_experiment": next_experiment(found),
        "next_experiments": [_predicted(test) for test in found.next_tests],
        "detectable": [
            {"name": one.effect.name, "parameters": dict(one.sizes), "easiest_shape": dict(one.easiest)} for one in found.limits
        ],
        "base": base_moves(found),
        "within_tolerances": [
            {"name": effect.name, "in_tolerances": size, "parameters": dict(zip(effect.flat_names(), effect.flat().tolist(), strict=True))}
            for effect, size in found.within
        ],
        "dragged": [{**asdict(one), "sentence": one.sentence} for one in moved_far(found)],
        "law_not_written": list(lost(found.after)),
        "loop_zeros_N": zeros_of(found.after),
        "loop_drifts_N_per_s": drifts_of(found.after),
        "noise_added": [asdict(one) for one in found.noise_added],
        "noise_sentence": noise_sentence(found),
        "left": left_sentence(found),
        "sentence": sentence(found),
    }


def _ranked(row: Ranked, found: Explanation) -> dict[str, Any]:
    held = [found.over_noise(one.after) for one in found.held if row.name in [finding.name for finding in found.findings]]
    return {
        "name": row.name,
        "delta_bic": row.delta_bic,
        "weight": row.weight,
        "held_out_rms_over_noise": held[0] if held else float("nan"),
        "fitted_jointly": row.fitted,
    }


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        "name": finding.name,
        "equivalents": list(finding.equivalents),
        "parameters": parameters_of(finding),
        "at_bound": list(finding.at_bound),
        "p_value": finding.p_value,
        "delta_bic": finding.delta_bic,
        "share_of_gap_percent": 100.0 * finding.share,
    }


def parameters_of(finding: Finding) -> dict[str, Any]:
    """Value, standard error and 95 % interval of each parameter, and whether these measurements show anything of it."""
    flat = zip(finding.effect.flat_names(), finding.effect.flat(), finding.stderr, finding.ci95, strict=True)
    return {
        name: {"value": float(value), "stderr": float(stderr), "ci95": ci95.tolist(), "identifiable": not np.isnan(stderr)}
        for name, value, stderr, ci95 in flat
    }


def _place(place: Any) -> dict[str, Any]:
    keys = ("run", "channel", "phase", "from_s", "to_s", "share_percent", "depends_on")
    return {key: getattr(place, key) for key in keys}


def _gaps(found: Explanation) -> dict[str, Any]:
    gaps: dict[str, Any] = {
        "as_given": {"rms_over_noise": found.over_noise(found.as_given)},
        "before": {"rms_over_noise": found.over_noise(found.before)},
        "after": {"rms_over_noise": found.over_noise(found.after)},
        "by_run": by_run(found),
    }
    if found.held:
        over = noise_over_stated(found.noise, [held.before for held in found.held])
        gaps["held_out"] = {
            "before": {"rms_over_noise": gap_left(*(held.before for held in found.held)) / over},
            "after": {"rms_over_noise": gap_left(*(held.after for held in found.held)) / over},
            "lead": float(np.sum([held.lead for held in found.held])),
            "missed": found.missed,
        }
    return gaps


def by_run(found: Explanation) -> list[dict[str, Any]]:
    """Gap over noise before and after for each run and channel, held-out runs marked."""
    pairs = [(found.before, found.after, False), *((held.before, held.after, True) for held in found.held)]
    return [
        {
            "run": block.run,
            "channel": block.channel,
            "held_out": held_out,
            "before": gap_size([before.part(block)]),
            "after": gap_size([after.part(block)]),
        }
        for before, after, held_out in pairs
        for block in before.problem.blocks
    ]


def base_moves(found: Explanation) -> dict[str, Any]:
    """How the force law was bent without the effects, and how it moved back with them, in its units."""
    rows = {}
    for i in range(found.before.problem.first_nuisance):
        parameter = found.before.problem.parameters[i]
        stderr = float(np.sqrt(max(found.after.covariance[i, i], 0.0))) * parameter.scale
        rows[parameter.name] = {
            "shift_before": float(found.before.q[i] * parameter.scale),
            "shift_after": float(found.after.q[i] * parameter.scale),
            "stderr": stderr,
        }
    return rows


def _missing_force(found: Explanation, file: str | None) -> str | None:
    if not found.is_open:
        return None
    texts = [f"Table: {file}"] if file else []
    texts[:0] = [found.in_legs.sentence] if found.in_legs else []
    if found.after.problem.loops:
        texts[:0] = [force_in_loops(found.after)[0], *_column_worth_trying(found)]
    if found.missing is not None:
        texts = [found.missing.sentence, *texts]
    return " ".join(texts)


def _draft(found: Explanation) -> dict[str, Any] | None:
    """The drafted effect: its file, its formula, and the gap of runs held out without and with it."""
    drafted = found.drafted
    if drafted is None:
        return None
    return {
        "file": FILE,
        "formula": drafted.formula,
        "goes_with": drafted.variable.name,
        "acts_on": "legs" if drafted.variable.in_legs else "platform",
        "kind": drafted.variable.kind,
        "parameters": dict(zip(drafted.effect.flat_names(), drafted.effect.flat().tolist(), strict=True)),
        "at_bound": drafted.at_bound,
        "gap": {"before": found.over_noise(found.after), "after": found.over_noise(drafted.fit)},
        "held_out": None if drafted.before is None else {"before": drafted.before, "after": drafted.after},
        "in_extended_model": drafted.carries_over,
        "sentence": drafted.sentence,
    }


def _column_worth_trying(found: Explanation) -> list[str]:
    """The sentence on a further column of the loops that goes with what is left, if there is one."""
    fit, problem = found.after, found.after.problem
    if problem.covariate:
        return []
    loops = [(loop.data, block) for loop, block in zip(problem.loops, problem.blocks[-len(problem.loops) :], strict=True)]
    noise = [data.force_sigma_N for data, _ in loops]
    left = [sigma * fit.part(block) for sigma, (_, block) in zip(noise, loops, strict=True)]
    slopes = [sigma * fit.jacobian[block.rows] for sigma, (_, block) in zip(noise, loops, strict=True)]
    text = hint(shares([data for data, _ in loops], left, slopes))
    return [f"{text[0].upper()}{text[1:]}."] if text else []


def missing_table(found: Explanation) -> dict[str, Any] | None:
    """The force that no effect explains, as a table: on the platform, or in the loops where no deployment was given."""
    if not found.is_open:
        return None
    return found.missing.columns if found.missing is not None else force_in_loops(found.after)[1]


def _predicted(test: NextTest) -> dict[str, Any]:
    """A further test for programs: what to change, and how likely it splits off each rival."""
    of = test.condition
    row: dict[str, Any] = {"condition": of.words, "runs": test.runs, "model": dict(of.changes), "splits": dict(test.chances)}
    if of.frequency_Hz:
        return {**row, "kind": "loop", "frequency_Hz": of.frequency_Hz, "amplitude_m": of.amplitude_m}
    return {**row, "kind": "deployment", "times_as_long": of.longer, "channels": list(of.channels) or None}
