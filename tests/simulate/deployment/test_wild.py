"""However wild a model is within its types, nothing is wrong in silence, nothing hangs, and no file holds a number that is none."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from measure.common.errors import InputError
from simulate.commands import simulate_deployment, sweep_deployments
from simulate.deployment.deploy import deploy, deploy_checked
from simulate.effects import CATALOGUE
from simulate.files.model_file import write_model
from simulate.model.model import Simulation, with_value

KEYS = (
    *("platform.mass_kg", "platform.inertia_kg_m2[2]", "end_stop.stiffness_N_per_m", "end_stop.damping_N_s_per_m", "end_stop.smoothing_m"),
    *("gravity.acceleration_m_per_s2", "gravity.mass_factor", "actuator.beta_per_m", "actuator.b_l_N[3]", "actuator.a_u_N_per_m"),
    *(
        "actuator.initial_force_N",
        "geometry.stowed_height_m",
        "geometry.deployed_height_m",
        "release.position_m[0]",
        "release.theta_rad[1]",
    ),
    *("release.velocity_m_per_s[2]", "simulation.sample_rate_Hz", "simulation.duration_s"),
)
NUMBER = st.floats(-1e100, 1e100) | st.sampled_from([0.0, 1e-300, 5e-324, -1e-12, 1.0, -1.0])


@st.composite
def effect(draw):
    kind = draw(st.sampled_from(sorted(CATALOGUE.values(), key=lambda kind: kind.name)))
    ends = [draw(st.sampled_from([low, high]) | st.floats(low, high)) for low, high in kind.bounds().values()]
    return kind().with_flat(np.array(ends))


@st.composite
def changes(draw):
    return draw(st.lists(st.tuples(st.sampled_from(KEYS), NUMBER), min_size=1, max_size=4)), draw(st.lists(effect(), max_size=3))


wild = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])


def made_wild(prototype, drawn):
    """The model, or None where its own checks refuse it. A step is given, so that stiffness costs no time."""
    model = replace(prototype, simulation=Simulation(0.05, 200.0, 1e-3))
    try:
        for key, value in drawn[0]:
            model = with_value(model, key, value)
    except ValueError:
        return None
    for acting in drawn[1]:
        model = model.with_effect(acting)
    return model


@wild
@given(changes())
def test_a_wild_model_is_refused_in_a_sentence_or_gives_numbers_up_to_where_it_says_it_diverged(prototype, drawn):
    model = made_wild(prototype, drawn)
    if model is None or model.simulation.duration_s / (model.simulation.step_s or 1.0) > 1e5:
        return
    try:
        run = deploy(model)
    except InputError:
        return
    good = len(run.time_s) if run.diverged_at_s is None else int(np.searchsorted(run.time_s, run.diverged_at_s))
    assert np.all(np.isfinite(run.samples[:good]))
    assert np.all(np.isnan(run.samples[good:]))


@wild
@given(changes())
def test_the_error_of_a_wild_run_is_a_number_or_infinite_and_never_none_without_a_reason(prototype, drawn):
    model = made_wild(prototype, drawn)
    if model is None or model.simulation.duration_s > 1.0 or model.simulation.sample_rate_Hz > 1e4:
        return
    try:
        error = deploy_checked(model).step_error
    except InputError:
        return
    assert error is not None
    assert not any(np.isnan(value) for value in error.whole.values())


@pytest.mark.parametrize("setting", ["simulation.duration_s=1e9", "simulation.sample_rate_Hz=1e12", "end_stop.stiffness_N_per_m=1e300"])
def test_what_would_take_for_ever_or_all_memory_is_refused_at_once(tmp_path, prototype, monkeypatch, capsys, setting):
    monkeypatch.chdir(tmp_path)
    write_model(prototype, tmp_path / "m.toml")
    for command in (simulate_deployment, sweep_deployments):
        assert command.main(["m.toml", "--set", setting]) == 2
        assert 'model "prototype"' in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["m.toml"]


def test_a_sweep_whose_every_run_diverges_says_so_in_valid_json_with_nothing_averaged(tmp_path, prototype, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_model(prototype, tmp_path / "m.toml")
    wild = ["--set", "simulation.step_s=0.004", "--set", "simulation.sample_rate_Hz=250", "--set", "end_stop.stiffness_N_per_m=1e12"]
    factors = ["--factor", "platform.mass_kg=+-1%", "--factor", "actuator.stored_force_N[0]=+-1%"]
    words = ["m.toml", *wild, *factors, "--json", "s.json", "--quiet"]
    assert sweep_deployments.main(words) == 1
    report = json.loads((tmp_path / "s.json").read_text(), parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert report["diverged"] == 4
    assert report["failed_percent"] is None
    assert report["coefficients"] == {}
