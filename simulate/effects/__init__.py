"""The catalogue: every effect by name, one file each. Adding one is a file and a line here."""

from ..effect import Effect
from .end_stop_dissipation import EndStopDissipation
from .gravity_imbalance import GravityImbalance
from .hub_inertia import HubInertia
from .leg_disparity import LegDisparity
from .rate_dependent_asymptotes import RateDependentAsymptotes
from .release_pose import ReleasePose
from .scale_error import ScaleError
from .time_offset import TimeOffset
from .viscous_friction import ViscousFriction

_KINDS: tuple[type[Effect], ...] = (
    HubInertia,
    ViscousFriction,
    RateDependentAsymptotes,
    LegDisparity,
    EndStopDissipation,
    GravityImbalance,
    ReleasePose,
    ScaleError,
    TimeOffset,
)

CATALOGUE: dict[str, type[Effect]] = {kind.name: kind for kind in _KINDS}

__all__ = [
    "CATALOGUE",
    "EndStopDissipation",
    "GravityImbalance",
    "HubInertia",
    "LegDisparity",
    "RateDependentAsymptotes",
    "ReleasePose",
    "ScaleError",
    "TimeOffset",
    "ViscousFriction",
]
