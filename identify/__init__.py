"""What explains what was seen.

from identify import compare, explain, fit_actuator, prepare, read_campaign
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from measure.common.front_door import loaded_late

if TYPE_CHECKING:
    from identify.actuator.actuator_fit import ActuatorFit as ActuatorFit
    from identify.actuator.fit_actuator import fit_actuator as fit_actuator
    from identify.campaign.run import Run as Run
    from identify.campaign.runs import read_campaign as read_campaign
    from identify.gap.compare import compare as compare
    from identify.gap.comparison import Comparison as Comparison
    from identify.loops.prepare import prepare as prepare
    from identify.report.explained.extended_model import extended as extended
    from identify.selection.explain import explain as explain
    from identify.selection.explanation import Explanation as Explanation

_HOMES = {
    "prepare": "loops.prepare",
    "fit_actuator": "actuator.fit_actuator",
    "ActuatorFit": "actuator.actuator_fit",
    "Run": "campaign.run",
    "read_campaign": "campaign.runs",
    "compare": "gap.compare",
    "Comparison": "gap.comparison",
    "explain": "selection.explain",
    "Explanation": "selection.explanation",
    "extended": "report.explained.extended_model",
}

__all__ = ["ActuatorFit", "Comparison", "Explanation", "Run", "compare", "explain", "extended", "fit_actuator", "prepare", "read_campaign"]

__getattr__ = loaded_late(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(_HOMES)
