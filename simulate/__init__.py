"""What a model would do.

from simulate import Model, deploy, effects, read_model
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from measure.common.front_door import loaded_late

if TYPE_CHECKING:
    from simulate.deployment.deploy import deploy as deploy
    from simulate.deployment.result import Deployment as Deployment
    from simulate.files.model_file import read_model as read_model
    from simulate.files.model_file import write_model as write_model
    from simulate.loop import loop_force as loop_force
    from simulate.model.model import Actuator as Actuator
    from simulate.model.model import EndStop as EndStop
    from simulate.model.model import Geometry as Geometry
    from simulate.model.model import Gravity as Gravity
    from simulate.model.model import Model as Model
    from simulate.model.model import Nuisance as Nuisance
    from simulate.model.model import Platform as Platform
    from simulate.model.model import Release as Release
    from simulate.model.model import Simulation as Simulation

_HOMES = {
    "Actuator": "model.model",
    "EndStop": "model.model",
    "Geometry": "model.model",
    "Gravity": "model.model",
    "Model": "model.model",
    "Nuisance": "model.model",
    "Platform": "model.model",
    "Release": "model.model",
    "Simulation": "model.model",
    "read_model": "files.model_file",
    "write_model": "files.model_file",
    "loop_force": "loop",
    "deploy": "deployment.deploy",
    "Deployment": "deployment.result",
}

__all__ = [
    "Actuator",
    "Deployment",
    "EndStop",
    "Geometry",
    "Gravity",
    "Model",
    "Nuisance",
    "Platform",
    "Release",
    "Simulation",
    "deploy",
    "loop_force",
    "read_model",
    "write_model",
]

__getattr__ = loaded_late(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(_HOMES)
