"""The answer of `explain-gap` in sentences."""

from __future__ import annotations

import numpy as np

from identify.criteria import LIKELY, SLIGHT
from identify.gap.comparison import Held
from identify.gap.dragged import Dragged, dragged, in_words
from identify.selection.explanation import Explanation
from identify.selection.model_errors import FORCES
from identify.selection.verdict import Finding
from simulate.effects import GeometryError

FILMS_ALONE = "films alone do not tell an effect of so many numbers from all others, so it is not named alone"
_WORTH_A_WORD = 0.5  # of a tolerance
_MEASURED = {GeometryError.name: "the coordinates of the joints", FORCES: "the stored force before each run"}


def sentence(found: Explanation) -> str:
    """The finding in a sentence; what a fit had to move far beyond the model file stands first."""
    return "; ".join([*in_words(moved_far(found)), _finding_in_words(found)])


def moved_far(found: Explanation) -> tuple[Dragged, ...]:
    """What the fit behind the answer moved far; where nothing closes the gap, what the releases alone moved under the model as given."""
    return dragged(found.as_given if found.is_open else found.after)


def _finding_in_words(found: Explanation) -> str:
    plain = {
        "no-gap": "what is left between model and measurement is noise" + _colour(found) + _likelier(found) + _within(found),
        "unknown": "there is a gap" + _why_unknown(found) + _in_formula(found),
    }
    if found.verdict in plain:
        return plain[found.verdict]
    names = ", ".join(_named(finding) for finding in found.findings)
    tail = f"; {left_sentence(found)}" if found.verdict == "partly" else ""
    more = _or_nothing(found) + _at_bound(found) + _by_chance(found) + _by_films(found) + _forces_by_run(found) + _within(found)
    return _opening(found) + names + more + tail


def _opening(found: Explanation) -> str:
    """What stands before the names. A class of one name is said like a name; what stands beside it (nothing, or chance) follows it."""
    opens = {"named": "missing effect: ", "class": "missing effect, one of a class: ", "several": "missing effects: ", "partly": "mainly "}
    is_one = found.verdict == "class" and not any(finding.equivalents for finding in found.findings)
    return opens["named" if is_one else found.verdict]


def _missed(found: Explanation) -> str:
    """That a run held out is left with more than noise, and the others are not."""
    most = _left_with_most(found)
    return f"{most.name}, which was held out, is left with {most.left:.2g} times its noise; the other runs are left with noise only"


def _left_with_most(found: Explanation) -> Held:
    """The run held out that is left with most."""
    return max(found.held, key=lambda one: one.left)


def _why_unknown(found: Explanation) -> str:
    if found.missed:
        return f": {_missed(found)}"
    if not found.vetoed:
        return ", and nothing in the catalogue explains it"
    best = f"what explains it best ({' and '.join(found.vetoed)})"
    return f", and {best} makes the gap of a run held out larger than chance does, so it is not named"


def _by_chance(found: Explanation) -> str:
    """That the gap of a run held out grows with what is said, but no more than chance may do."""
    if not (found.findings and any(held.grows for held in found.held)):
        return ""
    return "; the gap of a run held out grows by no more than the fits leave open, so nothing is named alone"


def _by_films(found: Explanation) -> str:
    """That an effect of many numbers is not named alone where no loop says anything of it."""
    return "" if of_films_alone(found) is None else f"; {FILMS_ALONE}"


def of_films_alone(found: Explanation) -> Finding | None:
    """What is not named alone because it has many numbers and no loop says anything of it."""
    return next((one for one in found.findings if found.verdict == "class" and one.is_never_alone(found.after.problem)), None)


def left_sentence(found: Explanation) -> str | None:
    """What is left where names explain a part only."""
    if found.verdict != "partly":
        return None
    if found.missed:
        return _missed(found)
    share, over = 100.0 * found.share_closed, found.over_noise(found.after)
    goes = f", {found.missing.goes_with}" if found.missing is not None else ""
    return f"{share:.0f} % of the gap; {over:.3g} times the noise is left{goes}{_in_formula(found)}"


def _in_formula(found: Explanation) -> str:
    """What is drafted, where something is."""
    return "" if found.drafted is None else f"; drafted: {found.drafted.sentence}"


def _at_bound(found: Explanation) -> str:
    ends = [f"{finding.name}.{name}" for finding in found.findings for name in finding.at_bound]
    return f" ({', '.join(ends)} at its bound)" if ends else ""


def within_tolerances(found: Explanation) -> str:
    """What of the model file was moved within its tolerances or beyond, and by how many of them; nothing where it was not."""
    shown = [(size, f"{effect.name} by {size:.1f}") for effect, size in found.within if size >= _WORTH_A_WORD]
    beyond, within = ([text for size, text in shown if (size > SLIGHT) is far] for far in (True, False))
    if not shown:
        return ""
    if not beyond:
        return f"the model file is off within its tolerances: {', '.join(within)} of them"
    off = f"the model file is off beyond its tolerances: {', '.join(beyond)} of them"
    return f"{off}, and within them: {', '.join(within)}" if within else off


def _within(found: Explanation) -> str:
    return f"; {words}" if (words := within_tolerances(found)) else ""


def _colour(found: Explanation) -> str:
    """The noise's memory on an average over its channels, where it has some."""
    rows = [one.rows.stop - one.rows.start for one in found.noise]
    lag = float(np.average([one.lag1 for one in found.noise], weights=rows)) if rows else 0.0
    return f", correlated by {lag:.1f} from sample to sample" if lag >= 0.15 else ""


def _likelier(found: Explanation) -> str:
    """What is more probable than nothing where nothing is not excluded: neither is sure. An error within its tolerances is nothing."""
    within = {effect.name for effect in found.after.problem.effects} | {"no-gap"}
    nothing = sum(weight for name, weight in found.weights.items() if set(name.split(" + ")) <= within)
    others = {name: weight for name, weight in found.weights.items() if weight > nothing and not set(name.split(" + ")) <= within}
    if not others:
        return ""
    name = max(others, key=lambda one: others[one])
    words = "a force without a name" if name == "unknown" else name
    against = ", and a run held out speaks against it" if name in found.vetoed else ""
    return f"; {words} would explain it too and is likelier ({others[name]:.2f} to {nothing:.2f}), but not sure{against}"


def _or_nothing(found: Explanation) -> str:
    """That nothing may be missing at all, where a class cannot exclude it."""
    return "" if found.weight_of_nothing is None else f", or nothing at all ({found.weight_of_nothing:.2f})"


def noise_sentence(found: Explanation) -> str | None:
    """Which tables showed no noise and were given some; None where all were measured."""
    runs = list(dict.fromkeys(one.run for one in found.noise_added))
    if not runs:
        return None
    given = ", ".join(f"{name} {sigma:.2g}" for name, sigma in {one.channel: one.sigma for one in found.noise_added}.items())
    return f"{', '.join(runs)}: values without noise, as a simulation writes them; noise of a fine instrument was added ({given})"


def _named(finding: Finding) -> str:
    return " or ".join((finding.name, *finding.equivalents))


def _forces_by_run(found: Explanation) -> str:
    """By how much the runs want other stored forces, where that was found: `(test1.csv +3.2 %, test2.csv -4.0 %)`."""
    finding = next((one for one in found.findings if one.name == FORCES), None)
    if finding is None:
        return ""
    runs = [film.run.name for film in found.after.problem.films]
    parts = [f"{run} {100.0 * value:+.1f} %" for run, value in zip(runs, finding.effect.flat(), strict=False)]
    return f"; the runs want different stored forces: {', '.join(parts)}"


def next_experiment(found: Explanation) -> str | None:
    """Which further test would split a class or settle a doubt."""
    if found.next_tests:
        best, name = found.next_tests[0], found.findings[0].name
        split = ", ".join(f"{rival} in {100 * chance:.0f} %" for rival, chance in best.chances.items())
        words = best.condition.words + (f", {best.runs} times" if best.runs > 1 else "")
        if best.surest < LIKELY:
            return f"No single further test is likely to tell {name} from its rivals; {words} would split off {split} of cases."
        return f"To tell {name} from its rivals, add {words}; predicted to split off {split} of cases."
    if found.missed:
        name = _left_with_most(found).name
        return f"Compare how {name} was made (load, release, temperature, camera) with the others, or hold out another run."
    if measured := _measured_instead(found):
        return f"Measure {' and '.join(measured)}; that needs no further deployment."
    rivals = ", ".join(found.findings[0].equivalents) if found.verdict == "class" else ""
    if found.weight_of_nothing is not None and not rivals:
        return f"Add further runs like these, or others that show more of it: whether {found.findings[0].name} is there at all is not sure."
    if rivals and not found.rivals:
        return f"What may stand in the place of {found.findings[0].name} ({rivals}) was weighed and not fitted: try a larger --budget."
    if (one := of_films_alone(found)) is not None:
        return _further_than_films(one, found)
    if found.verdict == "unknown":
        return f"Add {_other_condition(found)}: a force that follows time, place or speed moves differently then."
    return None


def _measured_instead(found: Explanation) -> list[str]:
    """What of a class can be measured without a deployment."""
    if found.verdict != "class":
        return []
    doubted = {found.findings[0].name, *found.findings[0].equivalents}
    return [words for name, words in _MEASURED.items() if name in doubted]


def _further_than_films(one: Finding, found: Explanation) -> str:
    """What would show whether an effect of many numbers is there: loops if they show it, else a condition that no fit has seen."""
    if one.effect.acts_on_shaker():
        return f"Add loops of one actuator on a shaker at two frequencies: they show {one.name} by itself."
    return f"Hold out {_other_deployment(found)}: {one.name} has to predict it."


def _other_condition(found: Explanation) -> str:
    """A condition that the campaign has not got yet."""
    problem = found.before.problem
    if not problem.films:
        return "loops at another frequency with the same amplitude"
    if not problem.loops:
        return "loops of one actuator on a shaker at two frequencies, which pin the force law"
    return _other_deployment(found)


def _other_deployment(found: Explanation) -> str:
    """A condition that no deployment of the campaign has."""
    problem = found.before.problem
    heights = {film.model.geometry.stowed_height_m for film in problem.films if film.model.geometry is not None}
    masses = {film.model.platform.mass_kg for film in problem.films}
    if len(heights) < 2:
        return "a deployment from another start height"
    if len(masses) < 2:
        return "a deployment with ballast on the platform"
    return "a deployment with the platform turned by 120 deg"
