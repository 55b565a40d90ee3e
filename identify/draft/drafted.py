"""What a draft came to, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

from identify.criteria import NO_WORSE
from identify.draft.effect_file import Variable
from identify.estimation.problem import Fit
from identify.gap.size import NoiseOfChannel, gap_left, noise_over_stated
from simulate.model.effect import Effect


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
