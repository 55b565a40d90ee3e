"""What a controller is to the rest of the program: a law with its gains, what it sees, what it acts by, and what of it has failed.

A controller is a frozen dataclass in a file of its own, checked by pydantic, and stands in a model as the table `[controller]`. Its law is
one plain static function, compiled for the kernel like the formulas of effects.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.model.rig import CHECKED, LEGS, NotNegative, Positive, Rig

MOST_PENDING = 60
"""Commands that may be under way at a time: a delay has at most so many sample periods."""

LegOrNone = Annotated[int, Field(ge=0, le=LEGS)]


class Law:
    """The compiled formula of a controller, none by default (a plain class, so that it is not taken for a gain)."""

    command: Any = None


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class Controller(Law):
    """What acts on the legs beside their force law, and what of it has failed.

    Subclasses name their `law`, add gains, and define

        command(t, u, v, turn, memory, p, out)

    which writes six forces in N, positive pushes the platform away, into `out`. u, v are elongation (m) and speed (m/s) of the six legs as
    the controller knows them, turn is theta_z (rad) and its rate from a camera, zero without one, memory are 16 numbers that the law keeps
    from sample to sample, and p its gains in the order of their declaration, behind them what `constants_of` gave.
    """

    law: ClassVar[str]
    passive: ClassVar[bool] = True
    constants: ClassVar[int] = 0

    brake_speed_m_per_s: Positive = 0.01
    """speed at which the dry friction of a brake has set in: it follows tanh(v / this)"""
    failed_brake: LegOrNone = 0
    """leg, 1 to 6, whose actuator has failed; 0: none has"""
    stuck_force_N: NotNegative = 0.0
    """force by which the failed one brakes all the time; 0: it does nothing"""
    failure_s: NotNegative = 0.0
    """time after the release from which what has failed has failed"""

    @classmethod
    def gains(cls) -> tuple[str, ...]:
        """Names of the law's own gains, in the order in which its formula finds them."""
        shared = set(Controller.__dataclass_fields__) | set(SampledController.__dataclass_fields__)
        return tuple(name for name in cls.__dataclass_fields__ if name not in shared)

    def flat(self) -> Array:
        """What the kernel reads, in the order of `simulate.kernel.layout`: what all controllers share, then the gains."""
        return np.array([*self._shared(), *(float(getattr(self, name)) for name in self.gains())])

    def _shared(self) -> list[float]:
        failed = [float(self.failed_brake), self.stuck_force_N, self.failure_s]
        return [1.0, *failed, self.brake_speed_m_per_s, self.coupled_mass_kg(), *[0.0] * 13]

    def reseeded(self, by: int) -> Controller:
        """The same with another noise, where it has any."""
        del by
        return self

    def coupled_mass_kg(self) -> float:
        """Mass that moves with the mean elongation of the six legs, kg: what couples them has inertia."""
        return 0.0

    def constants_of(self, model: Rig) -> tuple[float, ...]:
        """What the law needs to know of the base model; most need nothing."""
        del model
        return ()

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """Spring and damper of one leg as the law makes them, N/m and N s/m; the step of integration follows them."""
        del model
        return 0.0, 0.0

    def dry_friction(self) -> tuple[float, float]:
        """Largest dry friction along one leg, N, and the speed at which it has set in, m/s: legs near rest ask for shorter steps."""
        return 0.0, self.brake_speed_m_per_s

    def table(self) -> dict[str, Any]:
        """The table `[controller]` of a model file."""
        return {"law": self.law, **{key: value for key, value in asdict(self).items() if value is not None}}


@dataclass(frozen=True, config=CHECKED, kw_only=True)
class SampledController(Controller):
    """A controller that sees, computes and acts: sensors, a law, brakes or motors. Without a rate it is ideal: at once and exact."""

    passive: ClassVar[bool] = False

    force_limit_N: Positive
    """largest force of one actuator"""
    actuator: Literal["brake", "motor"] = "brake"
    """brake: takes energy out only; motor: pushes and pulls"""
    lag_s: NotNegative = 0.0
    """time constant by which the actuator's force follows its command"""
    sample_rate_Hz: Positive | None = None
    """how often sensors are read and the law is computed; absent: all the time"""
    delay_s: NotNegative = 0.0
    """from reading the sensors to the command at the actuator; in a single deployment it ends with the next step of integration"""
    sensor: Literal["elongation", "camera"] = "elongation"
    """elongation: of each leg; camera: theta_z, from which follow the elongations as far as they come from the rotation"""
    sensor_noise_m: NotNegative = 0.0
    """noise of an elongation sensor, one standard deviation, each reading by itself"""
    sensor_step_m: NotNegative = 0.0
    """step to which an elongation is rounded; 0: none"""
    sensor_noise_rad: NotNegative = 0.0
    """noise of the camera's theta_z, one standard deviation"""
    sensor_step_rad: NotNegative = 0.0
    """step to which theta_z is rounded; 0: none"""
    observer_Hz: Positive | None = None
    """bandwidth of the observer that makes position and speed of the readings; absent: reading, and difference of two readings"""
    failed_sensor: LegOrNone = 0
    """leg, 1 to 6, whose sensor has failed and shows the last reading on; 0: none; of a camera 1"""
    seed: Annotated[int, Field(ge=0, le=2**24)] = 0
    """of the noise; in a sweep each run has one of its own"""

    @model_validator(mode="after")
    def _can_be(self) -> SampledController:
        if self.sample_rate_Hz is None:
            given = [name for name in _NEED_A_RATE if getattr(self, name)]
            if given:
                raise ValueError(f"{', '.join(given)}: a controller without sample_rate_Hz acts at once and exactly; give the rate")
        elif self.delay_s * self.sample_rate_Hz > MOST_PENDING:
            raise ValueError(f"delay_s is {self.delay_s * self.sample_rate_Hz:.0f} sample periods; at most {MOST_PENDING} can be")
        if self.sample_rate_Hz is not None and self.observer_Hz is not None and self.observer_Hz > self.sample_rate_Hz / 2:
            raise ValueError("observer_Hz is above half of sample_rate_Hz")
        return self

    def stiffness(self, model: Rig) -> tuple[float, float]:
        """Spring and damper of an ideal law, if its gains have the usual names.

        What is sampled is held from step to step, so its gains ask for no shorter step.
        """
        del model
        ideal = self.sample_rate_Hz is None
        spring, damper = (getattr(self, name, 0.0) if ideal else 0.0 for name in ("stiffness_N_per_m", "damping_N_s_per_m"))
        return spring, damper

    def dry_friction(self) -> tuple[float, float]:
        """That of the brakes."""
        return self.force_limit_N if self.actuator == "brake" else 0.0, self.brake_speed_m_per_s

    def reseeded(self, by: int) -> SampledController:
        """The same with another noise."""
        return replace(self, seed=self.seed + by)

    def _shared(self) -> list[float]:
        head = super()._shared()[:6]
        sensor = [self.sensor_noise_m, self.sensor_step_m, float(self.sensor == "camera"), self.sensor_noise_rad, self.sensor_step_rad]
        actuator = [self.force_limit_N, float(self.actuator == "motor")]
        timing = [self.sample_rate_Hz or 0.0, self.delay_s, self.lag_s]
        return [0.0, *head[1:], *timing, *sensor, self.observer_Hz or 0.0, *actuator, float(self.failed_sensor), float(self.seed)]


_NEED_A_RATE = (
    "delay_s", "lag_s", "sensor_noise_m", "sensor_step_m", "sensor_noise_rad", "sensor_step_rad", "observer_Hz", "failed_sensor",
)  # fmt: skip

Laws = Mapping[str, type[Controller]]


def laws_among(namespace: Mapping[str, Any]) -> list[type[Controller]]:
    """The laws among the names of a module, in the order in which they stand there: those that have a name of their own."""
    kinds = [value for value in namespace.values() if isinstance(value, type) and issubclass(value, Controller)]
    return [kind for kind in kinds if isinstance(getattr(kind, "law", None), str)]


def require_law(kind: type[Controller]) -> type[Controller]:
    """The kind itself, if it can be compiled.

    Raises
    ------
    InputError
        It has no formula.
    """
    if kind.command is None:
        raise InputError(f'law "{kind.law}": defines no command(t, u, v, turn, memory, p, out). Add it as a static method.')
    return kind
