"""What is asked of a controller, and what comes of it: plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from simulate.control.uncertainty import Uncertainty
from simulate.model.control import Controller
from simulate.model.model import Model

LIMIT = "force_limit_N"


class Requirement(NamedTuple):
    """abs(theta_z) below an angle with a probability."""

    angle_deg: float
    probability: float


@dataclass(frozen=True)
class Task:
    """What is to be designed.

    model : its controller, if it has one, is left out. law : name of a law. fixed : keys of the controller that are given.
    most_force_N : of one actuator. requirements : angles and probabilities. confidence : of the certificate. draws : for each kind
    of stops, or as many as the probability asks for.
    """

    model: Model
    law: str
    fixed: Mapping[str, Any]
    most_force_N: float
    requirements: tuple[Requirement, ...]
    uncertainty: Uncertainty
    confidence: float = 0.95
    draws: int | None = None
    seed: int = 0


@dataclass(frozen=True)
class Design:
    """What came of it: the controller, if one was found, the one that came nearest, and all that is known about it."""

    task: Task
    controller: Controller | None
    nearest: Controller
    report: dict[str, Any]

    @property
    def model(self) -> Model:
        """The model with the controller."""
        return replace(self.task.model, controller=self.controller)

    @property
    def certified(self) -> bool:
        """Whether every requirement is certified with every kind of stops."""
        return self.report["verdict"] == "certified"
