"""What effects that were tried say about a fit: a sentence, a command to type, a fault of a channel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from identify.actuator.actuator_fit import Trial, as_good
from identify.actuator.verdict import pooled_error
from identify.criteria import MOVES
from identify.estimation.parameters import BASE
from identify.estimation.problem import Fit
from identify.loops.loop_data import Fault, FaultWord, LoopData
from simulate.effects import CATALOGUE

_OF_CHANNELS: dict[str, tuple[FaultWord, str]] = {
    "sensor-lag": ("lag", "the force comes late or early against the elongation"),
    "sensor-filter": ("filter", "the force channel is filtered"),
    "force-offset": ("drift", "the zero of the load cell drifts"),
}
CHANNEL_EFFECTS = tuple(CATALOGUE[name] for name in _OF_CHANNELS if name in CATALOGUE)


@dataclass(frozen=True)
class Suggestion:
    """An effect worth fitting: its parameters in words, the error without and with it in per cent, and which others do as well."""

    name: str
    parameters: dict[str, float]
    before_percent: float
    after_percent: float
    as_well: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """With what, how much better."""
        values = ", ".join(f"{key} {value:.4g}" for key, value in self.parameters.items())
        others = f"; {', '.join(self.as_well)} as well" if self.as_well else ""
        return f"with {self.name} {self.after_percent:.2f} % instead of {self.before_percent:.2f} % ({values}{others})"


def suggestions_of(fit: Fit, trials: Sequence[Trial], loops: Sequence[LoopData]) -> tuple[Suggestion, ...]:
    """The effects that were found, the one that explains most first."""
    if not trials:
        return ()
    rivals = (*trials[0].alike, *(trial.name for trial in as_good(trials)[1:]))
    before = 100.0 * pooled_error(loops, fit.residuals_N)
    return tuple(
        Suggestion(trial.name, _parameters(trial), before, before * (1.0 - trial.fall) ** 0.5, rivals if k == 0 else ())
        for k, trial in enumerate(trials)
    )


def _parameters(trial: Trial) -> dict[str, float]:
    effect = trial.effect
    return dict(zip(effect.flat_names(), map(float, effect.flat()), strict=True))


def sentence_of(fit: Fit, trials: Sequence[Trial], loops: Sequence[LoopData]) -> str:
    """What the foremost effect would do; nothing where none is surely there."""
    found = suggestions_of(fit, trials, loops)
    return f"{found[0].sentence}: --effect {found[0].name}" if found else ""


def moved_beyond(fit: Fit, trial: Trial) -> bool:
    """Whether an effect moves a parameter of the law by more than its standard error."""
    spread = np.sqrt(np.maximum(np.diag(fit.covariance)[: len(BASE) - 1], 1e-300))
    return bool(np.any(np.abs(trial.moved[: len(BASE) - 1]) > MOVES * spread))


def faults_of_trials(loops: Sequence[LoopData], trials: Sequence[Trial]) -> list[Fault]:
    """Faults of the channels among the effects that explain what is left best."""
    found = []
    for trial in as_good(trials) if trials else ():
        if trial.name in _OF_CHANNELS:
            word, what = _OF_CHANNELS[trial.name]
            values = _parameters(trial)
            shown = ", ".join(f"{key} {value:.4g}" for key, value in values.items() if value)
            name = Path(loops[0].name).name if len(loops) == 1 else f"{len(loops)} loops"
            said = f"{what} ({shown}); --effect {trial.name} takes it into the fit"
            found.append(Fault(word, "force", name, "named", float(list(values.values())[-1]), said))
    return found


def faults_of_drifts(fit: Fit, loops: Sequence[LoopData]) -> list[Fault]:
    """The drift of each loop's zero, where it is part of the fit."""
    drifts = fit.problem.zeros_at(fit.q)[1]
    rows = zip(loops, drifts, strict=True) if np.any(drifts) else ()
    said = "the zero of the load cell drifts by {:.3g} N/s; that is part of the fit, counted from the begin of the record"
    return [Fault("drift", "force", data.name, "modelled", float(drift), said.format(drift)) for data, drift in rows]
