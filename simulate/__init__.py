"""What a model would do.

from simulate import Model, deploy, effects, read_model, sweep
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from measure.common.front_door import loaded_late

if TYPE_CHECKING:
    from simulate import effects as effects
    from simulate.deployment.deploy import deploy as deploy
    from simulate.deployment.deploy import deploy_checked as deploy_checked
    from simulate.deployment.deploy import deploy_many as deploy_many
    from simulate.deployment.result import Deployment as Deployment
    from simulate.files.leg_fmu import write_fmu as write_fmu
    from simulate.files.model_file import read_model as read_model
    from simulate.files.model_file import write_model as write_model
    from simulate.loop import loop_force as loop_force
    from simulate.model.control import SampledController as SampledController
    from simulate.model.effect import LegEffect as LegEffect
    from simulate.model.effect import PlatformEffect as PlatformEffect
    from simulate.model.effect import parameter as parameter
    from simulate.model.model import Actuator as Actuator
    from simulate.model.model import EndStop as EndStop
    from simulate.model.model import Geometry as Geometry
    from simulate.model.model import Gravity as Gravity
    from simulate.model.model import Model as Model
    from simulate.model.model import Nuisance as Nuisance
    from simulate.model.model import Platform as Platform
    from simulate.model.model import Release as Release
    from simulate.model.model import Simulation as Simulation
    from simulate.sweeps.dataset import write_sweep as write_sweep
    from simulate.sweeps.result import SweepResult as SweepResult
    from simulate.sweeps.run_sweep import sweep as sweep
    from simulate.sweeps.tolerance import tolerance_of as tolerance_of

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
    "effects": "effects",
    "SampledController": "model.control",
    "LegEffect": "model.effect",
    "PlatformEffect": "model.effect",
    "parameter": "model.effect",
    "read_model": "files.model_file",
    "write_fmu": "files.leg_fmu",
    "write_model": "files.model_file",
    "loop_force": "loop",
    "deploy": "deployment.deploy",
    "deploy_checked": "deployment.deploy",
    "deploy_many": "deployment.deploy",
    "Deployment": "deployment.result",
    "sweep": "sweeps.run_sweep",
    "write_sweep": "sweeps.dataset",
    "SweepResult": "sweeps.result",
    "tolerance_of": "sweeps.tolerance",
}

__all__ = [
    "Actuator",
    "Deployment",
    "EndStop",
    "Geometry",
    "Gravity",
    "LegEffect",
    "Model",
    "Nuisance",
    "Platform",
    "PlatformEffect",
    "Release",
    "SampledController",
    "Simulation",
    "SweepResult",
    "deploy",
    "deploy_checked",
    "deploy_many",
    "effects",
    "loop_force",
    "parameter",
    "read_model",
    "sweep",
    "tolerance_of",
    "write_fmu",
    "write_model",
    "write_sweep",
]

__getattr__ = loaded_late(__name__, _HOMES)


def __dir__() -> list[str]:
    return sorted(_HOMES)
