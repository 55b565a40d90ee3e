"""What may be said, from the probabilities of all hypotheses: one rule.

no-gap     nothing missing is foremost, and what is left is noise; or it has more than 0.05, where no single name is foremost, or where the
           runs held out are less probable with the names
unknown    a force without a name has more than 0.05, or what is left is no noise; or a run held out speaks against the names, or against
           nothing, for it is left with more than noise
partly     the same, where the foremost names close the larger part of the gap; or a run held out is left with more than noise beside them
named      one name is in every member of the smallest set that holds 0.95
class      the foremost name and those that may stand in its place hold that set together; nothing may be among them
several    the foremost hypothesis has more than one name, and none with fewer of them has more than 0.05

An error of the model file that is hardly beyond its tolerance is no name. Each name with its evidence is a finding.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from identify.criteria import CREDIBLE, EQUAL, FEW_PARAMETERS
from identify.estimation.problem import Problem
from identify.selection.model_errors import MODEL_ERRORS
from measure.common.arrays import Array
from simulate.model.effect import Effect

Names = tuple[str, ...]


@dataclass(frozen=True)
class Verdict:
    """word : see above. names : what is said to be missing. equivalents : for each of these the names that may stand in its place.

    weights : probability of each name or set of names, the unnamed force of all tables together as `unknown`. vetoed : names that would
    be said, did a run held out not speak against them.
    """

    word: str
    names: Names
    equivalents: Mapping[str, Names]
    weights: Mapping[str, float]
    vetoed: Names = ()


@dataclass(frozen=True)
class Finding:
    """An effect named, with its evidence. equivalents : effects that may stand in its place.

    stderr, ci95 : (k,) and (k, 2) of its parameters laid flat, cut at the bounds; NaN and the bounds for a parameter that does not show.
    at_bound : names of parameters that end at a bound. p_value : how likely parameters as large are, were they zero.
    delta_bic : twice the log evidence over that without it.
    """

    effect: Effect
    stderr: Array
    ci95: Array
    equivalents: tuple[str, ...]
    p_value: float
    delta_bic: float
    share: float
    at_bound: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The effect's name in the catalogue."""
        return self.effect.name

    def is_never_alone(self, problem: Problem) -> bool:
        """Whether it has so many numbers that films alone, where no loop says anything of it, do not tell it from all others."""
        return self.name not in MODEL_ERRORS and len(self.effect.flat()) > FEW_PARAMETERS and problem.only_films_show(self.effect)


def verdict_of(weights: Mapping[Names, float], *, foremost: Names | None = None, closes_most: bool, leaves_noise: bool = True) -> Verdict:
    """The verdict before the runs held out are asked.

    Parameters
    ----------
    weights : probability of each hypothesis; they add up to one.
    foremost : the names that were fitted as the most probable ones; by default those that are.
    closes_most : whether the names of the foremost hypothesis close the larger part of the gap.
    leaves_noise : whether what it leaves is as fast as noise.
    """
    listed, credible = _listed(weights), credible_set(weights)
    nothing = may_be_nothing(listed)
    names = tuple(name for name in (foremost_of(weights) if foremost is None else foremost) if not is_unnamed(name))
    unnamed = of_the_unnamed(weights) > 1.0 - CREDIBLE
    if leaves_noise and nothing and (not foremost_of(weights) or unnamed or len(names) != 1):
        return Verdict("no-gap", (), {}, listed)
    rivals = _rivals(names, credible)
    if not leaves_noise or unnamed:
        return Verdict("partly" if names and closes_most else "unknown", names, rivals, listed)
    word = "several" if len(names) > 1 else "class" if nothing or any(rivals.values()) else "named"
    return Verdict(word, names, rivals, listed)


def doing_without(verdict: Verdict, slight: Collection[str]) -> Verdict:
    """The same without errors of the model file that are hardly beyond their tolerances: no findings, unless a rival may be one."""
    out = {name for name in slight if name in verdict.names and not verdict.equivalents.get(name)}
    names = tuple(name for name in verdict.names if name not in out)
    if not out or verdict.word not in ("named", "class", "several"):
        return verdict
    rivals = any(verdict.equivalents.get(name) for name in names) or may_be_nothing(verdict.weights)
    word = "no-gap" if not names else "several" if len(names) > 1 else "class" if rivals else "named"
    return replace(verdict, word=word, names=names)


def in_a_class(verdict: Verdict) -> Verdict:
    """The same where a name is not to be said alone: the most probable other one stands beside it."""
    others = [name for name in verdict.weights if name not in (*verdict.names, "unknown", "no-gap") and " + " not in name]
    return replace(verdict, word="class", equivalents={verdict.names[0]: tuple(others[:1])}) if verdict.word == "named" else verdict


def after_a_veto(verdict: Verdict, *, leaves_noise: bool) -> Verdict:
    """The same where a run held out speaks against its names: none of them is said.

    leaves_noise : whether what they leave of the other runs is as fast as noise.
    """
    word = "no-gap" if may_be_nothing(verdict.weights) and leaves_noise else "unknown"
    return replace(verdict, word=word, names=(), vetoed=verdict.names if verdict.word != "unknown" else ())


def may_be_nothing(listed: Mapping[str, float]) -> bool:
    """Whether that nothing is missing cannot be excluded, by the probabilities as a verdict lists them."""
    return listed.get("no-gap", 0.0) > 1.0 - CREDIBLE


def of_the_unnamed(weights: Mapping[Names, float]) -> float:
    """Probability that a force without a name is there."""
    return sum(weight for names, weight in weights.items() if any(is_unnamed(name) for name in names))


def foremost_of(weights: Mapping[Names, float]) -> Names:
    """The most probable hypothesis; of those that are hardly less probable the one with the fewest names, the first by the alphabet.

    So that rounding does not decide between two that measurements cannot tell apart.
    """
    most = max(weights.values())
    return min((names for names, weight in weights.items() if weight >= EQUAL * most), key=lambda names: (len(names), names))


def credible_set(weights: Mapping[Names, float]) -> list[Names]:
    """The most probable hypotheses that hold 0.95 together."""
    chosen, held = [], 0.0
    for names in sorted(weights, key=lambda one: -weights[one]):
        chosen.append(names)
        held += weights[names]
        if held >= CREDIBLE:
            break
    return chosen


def _rivals(names: Names, credible: Sequence[Names]) -> dict[str, Names]:
    """For each name what stands in its place in those members of the credible set that do without it."""
    found = {}
    for name in names:
        others = set(names) - {name}
        found[name] = tuple(
            dict.fromkeys(one for member in credible if name not in member for one in member if one not in others and not is_unnamed(one))
        )
    return found


def _listed(weights: Mapping[Names, float]) -> dict[str, float]:
    """Probabilities by the words of a result: names joined by `+`, nothing as `no-gap`, all tables together as `unknown`."""
    rows: dict[str, float] = {}
    for names, weight in weights.items():
        word = "no-gap" if not names else "unknown" if any(is_unnamed(name) for name in names) else " + ".join(names)
        rows[word] = rows.get(word, 0.0) + weight
    return dict(sorted(rows.items(), key=lambda row: -row[1]))


def is_unnamed(name: str) -> bool:
    """Whether a name of a hypothesis is that of a table."""
    return name.startswith("missing-force")
