"""What came out of a search for what is missing, as plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from identify.campaign.noiseless import AddedNoise
from identify.design.further_test import NextTest
from identify.draft.drafted import Drafted
from identify.estimation.problem import Fit
from identify.gap.comparison import Held
from identify.gap.leg_force import LegForce
from identify.gap.platform_force import MissingForce
from identify.gap.size import DetectionLimit, NoiseOfChannel, rms_over_noise, share_closed
from identify.selection.verdict import Finding, Names, may_be_nothing
from measure.notebook.shown import Shown
from simulate.model.effect import Effect
from simulate.model.model import Model


@dataclass(frozen=True, repr=False)
class Explanation(Shown, by="identify.report.showing.ShowingExplanation"):
    """What came out.

    verdict : the word, see `verdict`. weights : probability of each hypothesis. as_given : the model file itself; before : base refitted;
    after : with the findings. noise : of each channel, under the foremost hypothesis. ranking : what was fitted and weighed.
    rivals : by name, the fits that stand in the place of a single finding. missing, in_legs : the force that no effect explains,
    where something is left. drafted : an effect of one's own that says it in a formula. located : the force that was missing before
    anything was named, as a first look along time. vetoed : names that are not said because a run held out speaks against them.
    missed : whether the only reason for the verdict is that a run held out is left with more than noise.
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
    missed: bool = False
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
    def is_open(self) -> bool:
        """Whether a force without a name is left of the runs that took part."""
        return self.verdict in ("unknown", "partly") and not self.missed

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
