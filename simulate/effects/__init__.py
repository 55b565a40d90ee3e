"""The catalogue: every effect by name, one file each. Adding one is a file and a line here."""

from ..effect import Effect
from .air_drag import AirDrag
from .backlash import Backlash
from .base_excitation import BaseExcitation
from .cable_pendulum import CablePendulum
from .camera_roll import CameraRoll
from .centre_of_mass_offset import CentreOfMassOffset
from .counterweight_inertia import CounterweightInertia
from .curved_asymptotes import CurvedAsymptotes
from .end_stop_dissipation import EndStopDissipation
from .force_offset import ForceOffset
from .force_relaxation import ForceRelaxation
from .gravity_imbalance import GravityImbalance
from .handrail_contact import HandrailContact
from .hub_inertia import HubInertia
from .joint_friction import JointFriction
from .leg_disparity import LegDisparity
from .leg_mass import LegMass
from .power_law_friction import PowerLawFriction
from .pulley_friction import PulleyFriction
from .pulley_inertia import PulleyInertia
from .rate_dependent_asymptotes import RateDependentAsymptotes
from .release_pose import ReleasePose
from .scale_error import ScaleError
from .sensor_lag import SensorLag
from .stribeck_friction import StribeckFriction
from .time_offset import TimeOffset
from .transition_zone import TransitionZone
from .viscous_friction import ViscousFriction

_KINDS: tuple[type[Effect], ...] = (
    HubInertia,
    ViscousFriction,
    PowerLawFriction,
    StribeckFriction,
    RateDependentAsymptotes,
    CurvedAsymptotes,
    TransitionZone,
    ForceRelaxation,
    Backlash,
    LegDisparity,
    LegMass,
    JointFriction,
    EndStopDissipation,
    GravityImbalance,
    CounterweightInertia,
    PulleyInertia,
    PulleyFriction,
    CablePendulum,
    AirDrag,
    HandrailContact,
    BaseExcitation,
    CentreOfMassOffset,
    ReleasePose,
    ScaleError,
    CameraRoll,
    TimeOffset,
    SensorLag,
    ForceOffset,
)

CATALOGUE: dict[str, type[Effect]] = {kind.name: kind for kind in _KINDS}

__all__ = [
    "CATALOGUE",
    "AirDrag",
    "Backlash",
    "BaseExcitation",
    "CablePendulum",
    "CameraRoll",
    "CentreOfMassOffset",
    "CounterweightInertia",
    "CurvedAsymptotes",
    "EndStopDissipation",
    "ForceOffset",
    "ForceRelaxation",
    "GravityImbalance",
    "HandrailContact",
    "HubInertia",
    "JointFriction",
    "LegDisparity",
    "LegMass",
    "PowerLawFriction",
    "PulleyFriction",
    "PulleyInertia",
    "RateDependentAsymptotes",
    "ReleasePose",
    "ScaleError",
    "SensorLag",
    "StribeckFriction",
    "TimeOffset",
    "TransitionZone",
    "ViscousFriction",
]
