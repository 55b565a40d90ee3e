"""The table [controller] of a model file: all errors at once, what cannot be together, own laws; what is written is read again."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.control.catalogue import known_laws
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy
from simulate.files.model_file import model_from, read_model, write_model
from simulate.files.own_effects import catalogue_with
from simulate.files.schema import json_schema
from simulate.files.settings import with_settings
from simulate.model.model import Simulation, value_of, with_value

GAINS: dict[str, Any] = {"stiffness_N_per_m": 1000.0, "damping_N_s_per_m": 20.0, "force_limit_N": 1.0}
ACTUATOR = {"a_l_N_per_m": 0.0, "b_l_N": 2.8, "a_u_N_per_m": 0.0, "b_u_N": 2.9, "beta_per_m": 400.0, "initial_force_N": 2.8}


def model_with(controller):
    return model_from({"schema": 1, "actuator": ACTUATOR, "controller": controller}, "rig.toml")


def complaint(controller):
    with pytest.raises(InputError) as error:
        model_with(controller)
    return str(error.value)


def test_a_controller_that_is_written_is_read_again(tmp_path, prototype):
    given = Synchronise(**GAINS, sample_rate_Hz=1000.0, delay_s=0.002, lag_s=0.005, sensor_noise_m=1e-4, observer_Hz=40.0, seed=7)
    file = tmp_path / "rig.toml"
    write_model(replace(prototype, controller=given), file)
    assert read_model(file).controller == given
    write_model(prototype, file)
    assert read_model(file).controller is None
    assert "controller" not in file.read_text()


def test_everything_that_is_wrong_is_said_at_once():
    said = complaint(
        {"law": "synchronise", "stifness_N_per_m": 1.0, "damping_N_s_per_m": -1.0, "force_limit_N": True, "actuator": "muscle"}
    )
    for part in ('did you mean "stiffness_N_per_m"', "controller.damping_N_s_per_m", "controller.force_limit_N", "controller.actuator"):
        assert part in said


def test_an_unknown_law_is_answered_with_the_nearest():
    assert 'did you mean "synchronise"' in complaint({"law": "synchronize", **GAINS})
    assert "eddy-damper" in complaint(GAINS)
    assert "must be a table" in complaint(3.0)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"delay_s": 0.01}, "give the rate"),
        ({"sample_rate_Hz": 1000.0, "delay_s": 0.1}, "at most 60"),
        ({"sample_rate_Hz": 100.0, "observer_Hz": 80.0}, "above half"),
        ({"failed_brake": 7}, "failed_brake"),
    ],
)
def test_what_cannot_be_together_is_refused(keys, said):
    assert said in complaint({"law": "synchronise", **GAINS, **keys})


def test_a_gain_has_a_name_for_settings_and_factors():
    model = model_with({"law": "synchronise", **GAINS})
    assert value_of(with_value(model, "controller.force_limit_N", 2.0), "controller.force_limit_N") == 2.0
    changed: Any = with_settings(model, ["controller.seed=3", "controller.failed_brake=2", "controller.sample_rate_Hz=500"]).controller
    assert (changed.seed, changed.failed_brake, changed.sample_rate_Hz) == (3, 2, 500.0)


def test_the_schema_knows_every_law():
    from jsonschema import Draft202012Validator

    validator = Draft202012Validator(json_schema())
    good = {"schema": 1, "actuator": ACTUATOR, "controller": {"law": "synchronise", **GAINS}}
    assert not list(validator.iter_errors(good))
    assert list(validator.iter_errors({**good, "controller": {"law": "synchronise", "gain": 1.0}}))
    assert {one["properties"]["law"]["const"] for one in json_schema()["properties"]["controller"]["oneOf"]} == set(known_laws())


OWN = '''
"""An integral law: what a leg has been ahead by is remembered."""
from typing import Any, ClassVar

from pydantic.dataclasses import dataclass

from simulate import SampledController


@dataclass(frozen=True, kw_only=True)
class Integral(SampledController):
    """Each leg is held back by the sum of what it has been ahead by."""

    law: ClassVar[str] = "integral-{name}"
    gain_N_per_m: float
    """force for a metre, summed over the samples"""

    @staticmethod
    def command(t: float, u: Any, v: Any, turn: Any, memory: Any, p: Any, out: Any) -> None:
        """Forces, N."""
        mean = (u[0] + u[1] + u[2] + u[3] + u[4] + u[5]) / 6.0
        for leg in range(6):
            memory[leg] += u[leg] - mean
            out[leg] = -p[0] * memory[leg]
'''


def test_a_law_of_ones_own_joins_the_others_and_remembers(tmp_path, prototype):
    file = tmp_path / "mine.py"
    file.write_text(OWN.replace("{name}", tmp_path.name))
    catalogue_with([file])
    kind: Any = known_laws()[f"integral-{tmp_path.name}"]
    rig = replace(prototype, actuator=prototype.actuator.shifted((0.2, -0.2, 0.2, -0.2, 0.2, -0.2)), simulation=Simulation(0.4, 1000.0))
    held = deploy(replace(rig, controller=kind(gain_N_per_m=100.0, force_limit_N=1.0, sample_rate_Hz=1000.0)))
    assert np.max(np.abs(held.channels["theta_z_rad"])) < 0.3 * np.max(np.abs(deploy(rig).channels["theta_z_rad"]))


def test_a_file_without_effect_or_law_is_refused(tmp_path):
    file = tmp_path / "empty.py"
    file.write_text("x = 1\n")
    with pytest.raises(InputError, match="no effect and no law"):
        catalogue_with([file])
