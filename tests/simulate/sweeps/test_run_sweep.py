"""The sweep as one call: the same digits as the command, frames with units."""

from dataclasses import replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate import Simulation, SweepResult, sweep
from simulate.commands import sweep_deployments
from simulate.files.model_file import write_model

FACTORS = ["actuator.stored_force_N[0]=+-10%", "platform.mass_kg=0.7..0.9"]


@pytest.fixture(scope="module")
def model(prototype_once):
    return replace(prototype_once, simulation=Simulation(0.2, 500.0))


@pytest.fixture(scope="module")
def result(model):
    return sweep(model, FACTORS, "random", runs=40, seed=3)


def test_the_call_and_the_command_give_the_same_digits(model, result, tmp_path):
    write_model(model, tmp_path / "rig.toml")
    words = [str(tmp_path / "rig.toml"), "--design", "random", "--runs", "40", "--seed", "3", "--quiet", "-o", str(tmp_path / "out")]
    for factor in FACTORS:
        words += ["--factor", factor]
    assert sweep_deployments.main(words) == 0
    written = np.genfromtxt(tmp_path / "out" / "responses.csv", delimiter=",", names=True)
    assert written["theta_z_deg"] == pytest.approx(result.to_frame()["theta_z_deg"].to_numpy(), rel=1e-9)


def test_a_stored_force_that_is_too_large_turns_the_platform_and_mass_slows_it(result):
    runs = result.to_frame()
    strong, heavy = runs["A"] > 0.5, runs["B"] > 0
    assert runs["theta_z_deg"][strong].abs().min() > runs["theta_z_deg"][runs["A"].abs() < 0.1].abs().max()
    assert runs["theta_z_deg"][strong & heavy].abs().mean() < runs["theta_z_deg"][strong & ~heavy].abs().mean()


def test_frames_carry_their_units_and_a_factor_named_N_is_no_newton(model, result):
    runs, terms = result.to_frame(), result.to_frame("coefficients")
    assert list(runs.columns[:3]) == ["A", "B", "theta_z_deg"]
    assert runs.attrs["units"]["stop_force_N"] == "N"
    assert runs.attrs["units"]["A"] == ""
    assert terms.attrs["units"]["coefficient_deg"] == "deg"
    assert terms["coefficient_deg"].abs().is_monotonic_decreasing
    many = sweep(
        model, [f"actuator.{name}[{leg}]=+-1%" for leg in range(6) for name in ("b_l_N", "a_l_N_per_m", "a_u_N_per_m")], "random", 4
    )
    assert many.to_frame().attrs["units"]["N"] == ""


def test_a_result_names_itself_in_a_line(result):
    assert isinstance(result, SweepResult)
    assert len(repr(result)) < 300
    assert "40 runs" in repr(result)


def test_a_design_or_a_response_that_does_not_exist_is_refused(model):
    with pytest.raises(InputError, match="sobol"):
        sweep(model, FACTORS, "best")
    with pytest.raises(InputError, match='did you mean "theta_z_deg"'):
        sweep(model, FACTORS, response="theta_deg")
