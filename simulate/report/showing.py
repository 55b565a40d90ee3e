"""How simulated results show themselves in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from simulate.report.plots import deployment_figure, result_figure

if TYPE_CHECKING:
    from simulate.deployment.result import Deployment
    from simulate.sweeps.result import SweepResult


class ShowingDeployment:
    """How a deployment shows itself."""

    def __init__(self, run: Deployment) -> None:
        self.run = run

    def figure(self) -> Any:
        """Positions, rotations and forces of the legs."""
        return deployment_figure(self.run)


class ShowingSweep:
    """How a sweep shows itself."""

    def __init__(self, result: SweepResult) -> None:
        self.result = result

    def figure(self) -> Any:
        """Coefficients and responses."""
        return result_figure(self.result)
