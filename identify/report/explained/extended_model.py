"""The model that an explanation hands on: the user's own, with what was found."""

from __future__ import annotations

from dataclasses import replace

from identify.gap.dragged import lost
from identify.selection.explanation import Explanation
from identify.selection.model_errors import FORCES
from simulate.files.model_file import add_effects
from simulate.model.model import Model


def extended(model: Model, explanation: Explanation) -> Model:
    """The user's model with base and effects as found, ready to be written; a law that the fit knows worse than the file stays the file's.

    Parameters
    ----------
    model : the model file's.
    explanation : what `explain` found.

    Returns
    -------
    Model
        To be handed to `write_model`.
    """
    at = explanation.model
    named = tuple(finding.effect for finding in explanation.findings)
    made = add_effects(model, (*at.effects, *(effect for effect in named if effect.name == FORCES)))
    law = at.actuator if not any(lost(explanation.after)) else model.actuator
    return replace(made, actuator=replace(law, covariance=None))
