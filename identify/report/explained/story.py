"""An explanation told to somebody who knows nothing of the campaign: what is missing, how much, how sure, and what to do next."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from identify.criteria import CREDIBLE, GAP_P
from identify.gap.gap_test import gap_test, p_words
from identify.gap.size import gap_left
from identify.report.phrases import phrase_of
from identify.report.sentences import FILMS_ALONE, of_films_alone, within_tolerances
from identify.selection.explanation import Explanation
from measure.pages.in_use import percent
from measure.pages.page import facts_of, opened
from measure.pages.summary import Number, Summary, Tone

WORDS: Mapping[str, tuple[str, Tone]] = {
    "named": ("named: one effect is missing, its rivals are excluded", "good"),
    "several": ("several: more than one effect is missing", "good"),
    "class": ("class: one of a few answers is right, these data cannot tell which", "doubt"),
    "partly": ("partly: most of the gap has a name, the rest has not", "doubt"),
    "unknown": ("unknown: there is a gap, and no effect of the catalogue explains it", "bad"),
    "no-gap": ("no-gap: model and measurements differ by noise", "good"),
}
MISSED: Mapping[str, str] = {
    "partly": "partly: the runs that took part are explained, a run held out is not",
    "unknown": "unknown: a run held out has a gap, the runs that took part have none",
}
LIKELIEST = "class: one effect is by far the likeliest, but films alone do not exclude all others"
_QUOTED = 3
_MOST_OUTLIERS = 5.0  # percent: what the noise's heavy tails allow for


def summary_of(found: Explanation, note: Mapping[str, Any], result: Mapping[str, Any]) -> Summary:
    """The first screen of the page.

    Parameters
    ----------
    note : of provenance. result : of `result_of`.
    """
    word, tone = WORDS[found.verdict]
    alone = of_films_alone(found)
    word = MISSED[found.verdict] if found.missed else LIKELIEST if alone is not None and not alone.equivalents else word
    return Summary(
        word, tone, sentence(found, result), further(found, result), numbers(found, result), next_steps(found, result), facts(found, note)
    )


def sentence(found: Explanation, result: Mapping[str, Any]) -> str:
    """The finding as it may be quoted: what, how much, and how well the model then does on a run that took no part."""
    if not found.findings:
        return opened(result["sentence"]) + "."
    missing = "; and ".join(phrase_of(finding) for finding in found.findings)
    rivals = [name for finding in found.findings for name in finding.equivalents]
    told = f", or {' or '.join(rivals)} does the same" if rivals else ""
    told += "" if found.weight_of_nothing is None else f", or nothing is missing at all ({found.weight_of_nothing:.2f})"
    rest = f"; {result['left']}" if found.verdict == "partly" else ""
    return f"{opened(missing)}{told}; {_worth(result['gap'])}{rest}."


def times(value: float, digits: int = 3) -> str:
    """A gap over its noise, with all its digits: 1.00."""
    return f"{value:.0f}" if value >= 10.0**digits else f"{value:#.{digits}g}".rstrip(".")


def _worth(gap: Mapping[str, Any]) -> str:
    it, held = "with it", gap.get("held_out")
    if held is None:
        before, after = (times(gap[key]["rms_over_noise"], _QUOTED) for key in ("before", "after"))
        return f"{it} the measurements are met to {after} of the noise, without it to {before}"
    before, after = (times(held[key]["rms_over_noise"], _QUOTED) for key in ("before", "after"))
    return f"{it} a run that took no part is met to {after} of the noise, without it to {before}"


def numbers(found: Explanation, result: Mapping[str, Any]) -> list[Number]:
    """The gap over the noise at each stage; runs held out apart."""
    gap = result["gap"]
    shown = [
        Number("gap, model as given", times(gap["as_given"]["rms_over_noise"]), "times the noise", "given"),
        Number("force law refitted", times(gap["before"]["rms_over_noise"]), "what no other law can close", "refitted"),
    ]
    if found.findings:
        shown.append(Number("with the effect", times(gap["after"]["rms_over_noise"]), "1 is noise alone", "effect"))
    held = gap.get("held_out")
    if held is not None:
        before, after = (times(held[key]["rms_over_noise"]) for key in ("before", "after"))
        value = f"{before} → {after}" if found.findings else before
        shown.append(
            Number("runs held out", value, ", ".join(run.run for run in _held_runs(found)), "effect" if found.findings else "refitted")
        )
    return shown


def _held_runs(found: Explanation) -> list[Any]:
    return [next(iter(held.before.problem.blocks)) for held in found.held]


def further(found: Explanation, result: Mapping[str, Any]) -> list[str]:
    """How sure it is, and what was ruled out."""
    told = [sureness(found)]
    if of_films_alone(found) is not None:
        told.append(opened(FILMS_ALONE) + ".")
    if found.findings and (words := within_tolerances(found)):
        told.append(opened(words) + ". The extended model has it.")
    if result["missing_force"]:
        told.append(result["missing_force"])
    if result["noise_sentence"]:
        told.append(result["noise_sentence"] + ".")
    return [text for text in told if text]


def sureness(found: Explanation) -> str:
    """How probable the answer is, and the next best one."""
    rows = sorted(found.weights.items(), key=lambda row: -row[1])
    if not rows:
        return ""
    tried = len({name for row in found.ranking for name in row.names})
    (first, weight), *others = rows
    rest = f"; next comes {others[0][0]} with {percent(others[0][1])}" if others else ""
    return f"Of {tried} effects that were tried, and of nothing at all, {first} has {percent(weight)} of the probability{rest}."


def next_steps(found: Explanation, result: Mapping[str, Any]) -> list[str]:
    """What to do now, the first thing first."""
    steps = [text for text in (result["next_experiment"],) if text]
    if found.findings and found.verdict != "unknown":
        use = "Go on with extended.toml, the model with what was found in it; every command takes it."
        steps.append(use)
    if found.verdict in ("named", "several"):
        look = [f"{finding.name}: {_where_to_look(finding.effect.acts_on)}" for finding in found.findings]
        steps.append("Confirm it at the rig, without this program. " + " ".join(look))
    if found.verdict == "no-gap":
        steps.append("Nothing has to be added. What these measurements would have shown stands under “What could have been seen”.")
    if found.drafted is not None:
        steps.append(
            "Read drafted_effect.py, a formula for what is left: it describes and is no cause. Look at the rig for what could do it."
        )
    return steps


def _where_to_look(acts_on: str) -> str:
    looks = {
        "leg": "weigh, spin or pull one leg by itself.",
        "joints": "turn one joint by hand with a force gauge.",
        "platform": "look at platform, suspension and surroundings in a run with another load.",
        "model": "measure this quantity of the model file directly.",
        "measurement": "film a rule, a plumb line or a flash, or load the cell with a known weight.",
    }
    return looks.get(acts_on, "vary what it depends on.")


def facts(found: Explanation, note: Mapping[str, Any]) -> dict[str, str]:
    """Rig, data, date and versions."""
    problem = found.before.problem
    films, loops, held = len(problem.films), len(problem.loops), len(found.held)
    parts = [f"{count} {word}{'s' if count != 1 else ''}" for count, word in ((films, "deployment"), (loops, "loop")) if count]
    out = f"; held out: {held}" if held else ""
    return facts_of(note, rig=problem.model.name, data=f"{', '.join(parts)}, {problem.measured} measured values{out}")


def checks(found: Explanation) -> list[tuple[str, bool, str]]:
    """What was checked, whether it holds, and what was found."""
    left, after = gap_test(found.after), found.after
    bounds = [f"{finding.name} {name}" for finding in found.findings for name in finding.at_bound]
    lag = max((one.lag1 for one in found.noise), default=0.0)
    outliers = max((one.outliers_percent for one in found.noise), default=0.0)
    rows = [
        ("What is left is noise", left.slow_p > GAP_P, f"slow against fast parts of the gap: {p_words(left.slow_p)}"),
        ("Each run's release is where its tolerance lets one expect", left.release_p > GAP_P, p_words(left.release_p)),
        ("The fit has come to its end", after.converged, "nothing improves any more" if after.converged else "it was stopped"),
        ("No parameter of what was found is at a bound", not bounds, ", ".join(bounds) or "all are inside"),
        (
            "The noise has few outliers",
            outliers < _MOST_OUTLIERS,
            f"at most {outliers:.2g} % a channel; correlated up to {lag:.2f} from sample to sample",
        ),
    ]
    if found.findings:
        best = max(found.weights.values(), default=0.0)
        rows.append(("The rivals are excluded", best >= CREDIBLE, f"the foremost has {percent(best)} of the probability"))
    for held in found.held:
        before, now = gap_left(held.before), gap_left(held.after)
        if found.findings:
            words = f"{held.name}, which took no part, is met better"
            rows.append((words, now < before, f"{times(before)} → {times(now)} times the noise"))
    return rows
