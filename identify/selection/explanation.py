"""What came out of a search for what is missing, as plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.campaign.noiseless import AddedNoise
from identify.criteria import NO_WORSE
from identify.design.further_test import NextTest
from identify.draft.effect_file import Variable
from identify.estimation.problem import Fit
from identify.gap.leg_force import LegForce
from identify.gap.platform_force import MissingForce
from identify.gap.size import gap_size
from identify.selection.verdict import Finding, Names, may_be_nothing
from measure.notebook.shown import Shown
from simulate.model.effect import Effect
from simulate.model.model import Model


@dataclass(frozen=True)
class NoiseOfChannel:
    """sigma : standard deviation in the channel's unit. lag1 : correlation from sample to sample. rows : of the gap vector. over : sigma in
    units of that which the channel was taken to have."""

    run: str
    channel: str
    sigma: float
    lag1: float
    outliers_percent: float
    rows: slice
    over: float


def gap_left(*fits: Fit) -> float:
    """Root mean square of what fits leave, together, over the noise that the measurements were taken to have; spikes apart."""
    return gap_size(fit.part(block) for fit in fits for block in fit.problem.blocks)


def rms_over_noise(fit: Fit, noise: Sequence[NoiseOfChannel]) -> float:
    """Root mean square of a fit's gap in units of the estimated noise, spikes apart."""
    return gap_size(fit.gaps[one.rows] / one.over for one in noise)


def noise_over_stated(noise: Sequence[NoiseOfChannel], apart: Sequence[Fit]) -> float:
    """Noise of runs that took no part over what their tables were taken to have, at least one: that of the same channels elsewhere."""
    channels = {block.channel for fit in apart for block in fit.problem.blocks}
    return max(1.0, float(np.median([one.over for one in noise if one.channel in channels] or [1.0])))


def share_closed(before: Fit, after: Fit, noise: Sequence[NoiseOfChannel]) -> float:
    """Part of the excess over noise that goes, 0 to 1."""
    was, is_now = rms_over_noise(before, noise) ** 2, rms_over_noise(after, noise) ** 2
    excess = was - min(1.0, is_now)
    return float(np.clip((was - is_now) / excess, 0.0, 1.0)) if excess > 0.0 else 0.0


@dataclass(frozen=True)
class Drafted:
    """A drafted effect. source : the text of its file. fit : base, releases, what is named, and it. held_without, held_with : the runs held
    out, none where there are none. noise : of each channel beside it, none where it leaves more than noise."""

    variable: Variable
    formula: str
    source: str
    fit: Fit
    held_without: tuple[Fit, ...] = ()
    held_with: tuple[Fit, ...] = ()
    noise: tuple[NoiseOfChannel, ...] = ()

    @property
    def before(self) -> float | None:
        """Gap of the runs held out without it, root mean square over the noise; None where there are none."""
        return gap_left(*self.held_without) / noise_over_stated(self.noise, self.held_without) if self.held_without else None

    @property
    def after(self) -> float | None:
        """The same with it."""
        return gap_left(*self.held_with) / noise_over_stated(self.noise, self.held_with) if self.held_with else None

    @property
    def effect(self) -> Effect:
        """The effect as fitted."""
        return self.fit.problem.effects_at(self.fit.q)[-1]

    @property
    def carries_over(self) -> bool:
        """Whether the runs held out are met no worse with it; true where there are none."""
        return self.before is None or self.after is None or self.after <= NO_WORSE * self.before

    @property
    def at_bound(self) -> list[str]:
        """Which of its parameters ended at a bound."""
        own = f"{self.effect.name}."
        return [f"{name.removeprefix(own)} at its {end}" for name, end in self.fit.at_bounds().items() if name.startswith(own)]

    @property
    def sentence(self) -> str:
        """What is drafted, and what it is worth."""
        gap = "" if self.before is None else f"; held-out gap {self.before:.3g} -> {self.after:.3g} times the noise"
        worth = "" if self.carries_over else "; it does not carry over and is not added to the model"
        ends = f" ({', '.join(self.at_bound)})" if self.at_bound else ""
        return f"{self.variable.where}: {self.formula}{ends}{gap}{worth}"


@dataclass(frozen=True)
class DetectionLimit:
    """What could have been seen of one effect.

    sizes : for each parameter, alone, the smallest size that would be found nine times out of ten, in its unit, whatever the
    effect's shape (a frequency, a time constant) of those from which a search starts. easiest : the same for the shape that shows
    most. NaN where the measurements do not show it within its bounds, or base and releases can do the same.
    """

    effect: Effect
    sizes: Mapping[str, float]
    easiest: Mapping[str, float]


@dataclass(frozen=True)
class Held:
    """A run that took no part: its gap before and after, only its own release fitted."""

    before: Fit
    after: Fit

    @property
    def grows(self) -> bool:
        """Whether the names make it worse."""
        return gap_left(self.after) > NO_WORSE * gap_left(self.before)


@dataclass(frozen=True, repr=False)
class Explanation(Shown, by="identify.report.showing.ShowingExplanation"):
    """What came out.

    verdict : the word, see `verdict`. weights : probability of each hypothesis. as_given : the model file itself; before : base refitted;
    after : with the findings. noise : of each channel, under the foremost hypothesis. ranking : what was fitted and weighed.
    rivals : by name, the fits that stand in the place of a single finding. missing, in_legs : the force that no effect explains,
    where something is left. drafted : an effect of one's own that says it in a formula. located : the force that was missing before
    anything was named, as a first look along time. vetoed : names that are not said because they make the gap of a run held out larger.
    """

    verdict: str
    weights: Mapping[str, float]
    findings: tuple[Finding, ...]
    as_given: Fit
    before: Fit
    after: Fit
    noise: tuple[NoiseOfChannel, ...]
    ranking: tuple[Ranked, ...]
    rivals: Mapping[str, Fit]
    held: tuple[Held, ...]
    missing: MissingForce | None
    in_legs: LegForce | None
    located: MissingForce | None
    drafted: Drafted | None
    limits: tuple[DetectionLimit, ...]
    next_tests: tuple[NextTest, ...]
    within: tuple[tuple[Effect, float], ...] = ()
    vetoed: tuple[str, ...] = ()
    noise_added: tuple[AddedNoise, ...] = ()

    @property
    def model(self) -> Model:
        """The extended model: base as refitted, the effects found added, and the drafted one where it carries over."""
        fit = self.drafted.fit if self.drafted is not None and self.drafted.carries_over else self.after
        model, own = fit.problem.model_at(fit.q), {effect.name for effect in fit.problem.effects}
        return replace(model, effects=tuple(one.as_stated() if one.name in own else one for one in model.effects))

    @property
    def share_closed(self) -> float:
        """Part of the gap's excess over noise that the findings close, 0 to 1."""
        return share_closed(self.before, self.after, self.noise)

    def over_noise(self, fit: Fit) -> float:
        """Root mean square gap of one of the fits, in units of the noise that was estimated."""
        return rms_over_noise(fit, self.noise)

    @property
    def weight_of_nothing(self) -> float | None:
        """How probable it is that nothing is missing, where a class cannot exclude that; else None."""
        return self.weights["no-gap"] if self.verdict == "class" and may_be_nothing(self.weights) else None


@dataclass(frozen=True)
class Ranked:
    """A row of the ranking: twice the log evidence over that of nothing, and the probability. fitted : whether whole, or only weighed."""

    names: Names
    delta_bic: float
    weight: float
    fitted: bool

    @property
    def name(self) -> str:
        """Names joined."""
        return " + ".join(self.names) or "no-gap"
