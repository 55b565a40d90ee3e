"""The paper's gravity study: what lifts the platform, and how fast (Aridon 2009, Fig. 16)."""

import json
from dataclasses import replace

import numpy as np
import pytest

from simulate.commands import simulate_deployment
from simulate.deployment.gravity_study import gravity_study
from simulate.files.model_file import write_model
from simulate.model.model import Rate


@pytest.fixture(scope="module")
def cases(prototype_once):
    return {(c.gravity.acceleration_m_per_s2, c.gravity.mass_factor, c.times_the_force): c.run for c in gravity_study(prototype_once)}


def test_the_real_force_leaves_the_platform_on_its_lower_stops_and_four_times_it_lifts(cases):
    assert np.ptp(cases[9.81, 1.0, 1].channels["z_m"]) < 5e-3
    assert cases[9.81, 1.0, 4].time_to_full_height_s is not None


def test_without_weight_half_the_mass_is_faster_and_the_weight_costs_time(cases):
    for times in (1, 4):
        assert cases[0.0, 1.0, times].time_to_full_height_s < cases[0.0, 2.0, times].time_to_full_height_s
    assert cases[9.81, 1.0, 4].time_to_full_height_s > cases[0.0, 1.0, 4].time_to_full_height_s


def test_four_times_the_force_accelerates_four_times_at_the_release(cases):
    # before friction tells: z'' = sum of the vertical forces over what moves
    slow, fast = (cases[0.0, 2.0, times].samples[5, 9] for times in (1, 4))
    assert fast == pytest.approx(4 * slow, rel=0.01)


def test_asymptotes_that_follow_the_speed_are_scaled_too(prototype):
    rate = Rate("speed_m_per_s", b_l=(2.79, -0.1), b_u=(2.89, 0.1))
    brief = replace(prototype.simulation, duration_s=0.1)
    model = replace(prototype, actuator=replace(prototype.actuator, rate=rate), simulation=brief)
    law = gravity_study(model)[-1].run.model.actuator
    assert law.rate is not None
    assert law.rate.b_l == pytest.approx((11.16, -0.4))


def test_the_study_is_one_option_of_the_command(tmp_path, prototype, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_model(prototype, tmp_path / "prototype.toml")
    assert simulate_deployment.main(["prototype.toml", "--gravity-study", "study", "--json", "r.json"]) == 0
    assert capsys.readouterr().out.count("x force: ") == 6
    header, *rows = (tmp_path / "study" / "elevation.csv").read_text().splitlines()
    assert header.split(",")[:2] == ["time_s", "z_g9.81_0.8kg_1x_m"]
    assert len(rows) == 1001
    assert (tmp_path / "study" / "gravity.png").read_bytes().startswith(b"\x89PNG")
    study = json.loads((tmp_path / "r.json").read_text())["gravity_study"]
    assert [case["time_to_full_height_s"] is None for case in study] == [True, False, False, False, False, False]
    assert simulate_deployment.main(["prototype.toml", "--gravity-study", "r.json"]) == 2
