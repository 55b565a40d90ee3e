"""One measurement, and what differed from the model in it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from simulate.files.model_file import with_changes
from simulate.model.model import Model


@dataclass(frozen=True)
class Run:
    """One measurement: a loop of an actuator or a deployment of the platform.

    changes : what differs from the model in this run, as the tables of `[run.model]`.
    hold_out : never used for fitting or naming, only for showing the gap.
    """

    table: Loop | Trajectory
    changes: Mapping[str, Any] = field(default_factory=dict)
    hold_out: bool = False
    name: str = ""
    path: Path | None = None

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.table.name)

    @property
    def label(self) -> str:
        """The name without its ending, with which the run's own parameters begin: `test2` of test2.csv."""
        return re.sub(r"\.(csv|c3d|trc)$", "", self.name)

    @property
    def is_loop(self) -> bool:
        """Whether this is a force-elongation loop; else it is a deployment."""
        return isinstance(self.table, Loop)

    def model(self, model: Model) -> Model:
        """The model as it was in this run."""
        return with_changes(model, self.changes, f"{self.name}, [run.model]")
