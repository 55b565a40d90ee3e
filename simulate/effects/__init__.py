"""The catalogue: every effect by name, one file each. Adding one is a file and a line here."""

from simulate.effects.air_drag import AirDrag
from simulate.effects.backlash import Backlash
from simulate.effects.base_excitation import BaseExcitation
from simulate.effects.cable_pendulum import CablePendulum
from simulate.effects.camera_roll import CameraRoll
from simulate.effects.centre_of_mass_offset import CentreOfMassOffset
from simulate.effects.counterweight_inertia import CounterweightInertia
from simulate.effects.curved_asymptotes import CurvedAsymptotes
from simulate.effects.end_stop_dissipation import EndStopDissipation
from simulate.effects.force_offset import ForceOffset
from simulate.effects.force_relaxation import ForceRelaxation
from simulate.effects.gravity_imbalance import GravityImbalance
from simulate.effects.handrail_contact import HandrailContact
from simulate.effects.hub_inertia import HubInertia
from simulate.effects.joint_friction import JointFriction
from simulate.effects.leg_disparity import LegDisparity
from simulate.effects.leg_mass import LegMass
from simulate.effects.power_law_friction import PowerLawFriction
from simulate.effects.pulley_friction import PulleyFriction
from simulate.effects.pulley_inertia import PulleyInertia
from simulate.effects.rate_dependent_asymptotes import RateDependentAsymptotes
from simulate.effects.release_pose import ReleasePose
from simulate.effects.scale_error import ScaleError
from simulate.effects.sensor_lag import SensorLag
from simulate.effects.stribeck_friction import StribeckFriction
from simulate.effects.time_offset import TimeOffset
from simulate.effects.transition_zone import TransitionZone
from simulate.effects.viscous_friction import ViscousFriction
from simulate.model.effect import Effect

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
