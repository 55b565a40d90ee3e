"""The catalogue of effects. A new one is a file in this folder and a line in this list.

The order of the lines is the order of the catalogue: what is drawn or searched by seed depends on it, so add at the end.
"""

# ruff: isort: skip_file

from simulate.effects.hub_inertia import HubInertia as HubInertia
from simulate.effects.viscous_friction import ViscousFriction as ViscousFriction
from simulate.effects.power_law_friction import PowerLawFriction as PowerLawFriction
from simulate.effects.stribeck_friction import StribeckFriction as StribeckFriction
from simulate.effects.rate_dependent_asymptotes import RateDependentAsymptotes as RateDependentAsymptotes
from simulate.effects.curved_asymptotes import CurvedAsymptotes as CurvedAsymptotes
from simulate.effects.transition_zone import TransitionZone as TransitionZone
from simulate.effects.force_relaxation import ForceRelaxation as ForceRelaxation
from simulate.effects.backlash import Backlash as Backlash
from simulate.effects.leg_disparity import LegDisparity as LegDisparity
from simulate.effects.leg_mass import LegMass as LegMass
from simulate.effects.joint_friction import JointFriction as JointFriction
from simulate.effects.end_stop_dissipation import EndStopDissipation as EndStopDissipation
from simulate.effects.gravity_imbalance import GravityImbalance as GravityImbalance
from simulate.effects.counterweight_inertia import CounterweightInertia as CounterweightInertia
from simulate.effects.pulley_inertia import PulleyInertia as PulleyInertia
from simulate.effects.pulley_friction import PulleyFriction as PulleyFriction
from simulate.effects.cable_pendulum import CablePendulum as CablePendulum
from simulate.effects.air_drag import AirDrag as AirDrag
from simulate.effects.handrail_contact import HandrailContact as HandrailContact
from simulate.effects.base_excitation import BaseExcitation as BaseExcitation
from simulate.effects.centre_of_mass_offset import CentreOfMassOffset as CentreOfMassOffset
from simulate.effects.release_pose import ReleasePose as ReleasePose
from simulate.effects.scale_error import ScaleError as ScaleError
from simulate.effects.camera_roll import CameraRoll as CameraRoll
from simulate.effects.time_offset import TimeOffset as TimeOffset
from simulate.effects.sensor_lag import SensorLag as SensorLag
from simulate.effects.force_offset import ForceOffset as ForceOffset
from simulate.effects.series_play import SeriesPlay as SeriesPlay
from simulate.effects.eddy_damping import EddyDamping as EddyDamping
from simulate.effects.ripple import Ripple as Ripple
from simulate.effects.sensor_filter import SensorFilter as SensorFilter
from simulate.effects.lens_distortion import LensDistortion as LensDistortion
from simulate.effects.flexible_base import FlexibleBase as FlexibleBase
from simulate.effects.platform_mass import PlatformMass as PlatformMass
from simulate.effects.platform_inertia import PlatformInertia as PlatformInertia
from simulate.effects.geometry_error import GeometryError as GeometryError
from simulate.effects.stop_stiffness import StopStiffness as StopStiffness
from simulate.effects.stored_force_per_run import StoredForcePerRun as StoredForcePerRun
from simulate.model.effect import Catalogue, effects_among

CATALOGUE: Catalogue = {kind.name: kind for kind in effects_among(globals())}
