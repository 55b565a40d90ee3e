"""What the commands say to people, word by word, of results that are made by hand."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import Any

import pytest

from simulate.commands import design_control, design_deployment, simulate_deployment, sweep_deployments

RUN: dict[str, Any] = {
    "duration_s": 1.0,
    "step_s": 5e-4,
    "diverged_at_s": None,
    "energy_closure": 2.3e-7,
    "time_to_full_height_s": 0.1444,
    "theta_z_deg": -3.4567,
    "legs_condition": {"largest": 12.34, "singular_theta_z_deg": {"stowed": (None, None), "deployed": (-90.4, 89.6)}},
    "step_error": {"whole_run": {"x_m": 1e-7, "z_m": 3e-6, "theta_x_rad": 1e-9, "theta_z_rad": 4e-5}},
    "warnings": ["leg 3 is odd"],
}


def of_a_run(**changed):
    return simulate_deployment._sentences({**RUN, **changed}, Path("out.csv")).splitlines()


def test_a_deployment_is_told_in_six_lines():
    assert of_a_run() == [
        "simulate  six legs, 1.00 s, step 0.5 ms   energy closes to 2e-07",
        "          full height after 0.144 s; theta_z at its largest -3.457 deg",
        "          condition of the legs at most 12.3; at full height they lose a direction at theta_z = -90 and +90 deg",
        "          exact to 0.003 mm, 0.002 deg",
        "          warning: leg 3 is odd",
        "          written to out.csv",
    ]


def test_a_deployment_that_diverged_or_never_arrives_says_so():
    lines = of_a_run(diverged_at_s=0.25, time_to_full_height_s=None, theta_z_deg=None, warnings=[])
    assert lines[0].endswith("diverged at 0.250 s; cells behind are empty")
    assert lines[1:] == [
        "          full height is not reached; theta_z at its largest none",
        "          condition of the legs at most 12.3; at full height they lose a direction at theta_z = -90 and +90 deg",
        "          nothing of it is exact",
        "          written to out.csv",
    ]


OFF = {"whole_run": {"z_m": float("inf"), "theta_z_rad": 0.0}}
UNKNOWN = [
    ({"step_error": None}, 3, "how exact was not computed: half the step takes too many steps"),
    ({"step_error": OFF}, 3, "how exact is not known: with half the step the run diverges"),
    ({"legs_condition": {"largest": None, "singular_theta_z_deg": {"deployed": (None, None)}}}, 2, "condition of the legs is infinite"),
    (
        {"legs_condition": {"largest": 2.0, "singular_theta_z_deg": {"deployed": (None, 45.0)}}},
        2,
        "condition of the legs at most 2; at full height they lose a direction at theta_z = +45 deg",
    ),
]


@pytest.mark.parametrize(("changed", "line", "words"), UNKNOWN)
def test_what_is_not_known_of_a_deployment_is_said(changed, line, words):
    assert of_a_run(**changed)[line] == f"          {words}"


def test_the_gravity_study_has_a_line_a_case():
    cases = [
        {"case": "g = 9.81 m/s2, 0.8 kg, 1 x force", "time_to_full_height_s": None, "highest_m": 0.2519},
        {"case": "free", "time_to_full_height_s": 0.2, "highest_m": 0.7},
    ]
    assert simulate_deployment._study_sentences(cases, Path("study")).splitlines() == [
        "gravity   the paper's study, Fig. 16",
        "          g = 9.81 m/s2, 0.8 kg, 1 x force: rises to 252 mm",
        "          free: full height after 0.200 s",
        "          written to study",
    ]


NO_TOLERANCE: dict[str, Any] = {"probability": 0.95, "stored_force_spread_N": {"5": None}, "simulated": {}, "adjust": None, "sort": None}
SWEEP: dict[str, Any] = {
    "runs": 4096,
    "diverged": 2,
    "failed_percent": 69.12,
    "failed_before_stop_percent": 31.26,
    "failed_interval_percent": (67.7, 70.51),
    "formula": "theta_z = 86.6 (A - C)",
    "fresh": {"runs": 256, "rms": 1.234, "rms_of_response": 98.7, "largest": 3.0},
    "factors": [{"letter": "A", "key": "platform.mass_kg"}, {"letter": "B", "key": "release.theta_rad[2]"}],
    "indices": None,
    "subset_simulation": None,
    "step": {"largest_error_deg": 0.0312, "sensitive_probes": 3, "probes": 32, "step_s": 2e-3},
    "tolerance": NO_TOLERANCE,
    "warnings": [],
}


def of_a_sweep(**changed):
    options = Namespace(failure_deg=30.0, output=Path("sweep"))
    return sweep_deployments._sentences({**SWEEP, **changed}, 12.34, options).splitlines()


def test_a_sweep_is_told_by_its_counts_its_step_and_its_formula():
    assert of_a_sweep() == [
        "sweep     4096 runs, 2 diverged, 12.3 s",
        "          steps up to 2 ms, theta_z good to 0.03 deg; 9 % of the runs are sensitive to the release",
        "          69.1 % beyond 30 deg (95 % interval 67.70 to 70.51)",
        "          31.3 % were before the first stop; the others turned in the rebound",
        "          theta_z = 86.6 (A - C)",
        "          on 256 fresh runs off by 1.23 (rms), the response itself is 98.7",
        "          written to sweep",
    ]


def test_runs_that_were_chosen_have_no_interval_and_a_regression_that_was_not_tried_no_line():
    lines = of_a_sweep(
        failed_interval_percent=None,
        fresh={"runs": 0, "rms": None},
        step={**SWEEP["step"], "largest_error_deg": None, "sensitive_probes": 32},
        warnings=["odd"],
    )
    assert lines[1] == "          steps up to 2 ms; 100 % of the runs are sensitive to the release"
    assert lines[2] == "          69.1 % beyond 30 deg"
    assert lines[4:] == ["          theta_z = 86.6 (A - C)", "          warning: odd", "          written to sweep"]


def rows(*values):
    return {letter: {"value": value, "interval": (value - 0.1, value + 0.1)} for letter, value in zip("AB", values, strict=True)}


def test_indices_stand_with_the_largest_first():
    sobol = {"method": "sobol", "indices": {"total": rows(0.25, 0.75), "first_order": rows(0.2, 0.5)}}
    assert of_a_sweep(indices=sobol)[6:9] == [
        "          share of the variance, with all it has to do with, and by itself, 95 % intervals:",
        "          B release.theta_rad[2]: 0.75 (0.65 to 0.85), 0.5 (0.4 to 0.6)",
        "          A platform.mass_kg: 0.25 (0.15 to 0.35), 0.2 (0.1 to 0.3)",
    ]
    morris = {"method": "morris", "indices": {"mean_size": rows(9.0, 3.0), "spread": rows(1.0, 2.0)}}
    assert of_a_sweep(indices=morris)[6] == "          mean size of its effect, and spread, 95 % intervals:"
    assert of_a_sweep(indices={"method": "sobol", "indices": None})[6].endswith("the response does not vary, or too few runs have one")


def test_a_rare_failure_has_its_probability_or_a_bound():
    found = {"probability": 1.23e-4, "interval": (5e-5, 3e-4), "reached": True, "runs": 5400}
    assert of_a_sweep(subset_simulation=found)[6] == (
        "          probability beyond 30 deg 0.00012 (95 % interval 5e-05 to 0.0003), by 5400 runs of a subset simulation"
    )
    never = {**found, "reached": False}
    assert "beyond 30 deg below 0.0003; never reached, by" in of_a_sweep(subset_simulation=never)[6]


def test_tolerances_are_told_with_what_was_simulated_and_what_to_do():
    tolerance = {
        "probability": 0.95,
        "stored_force_spread_N": {"5": 0.0028, "30": 0.017},
        "simulated": {"5": {"interval": (0.914, 0.963)}, "30": {"interval": (0.9, 0.95)}},
        "adjust": {"leg": 4, "by_N": -0.0123, "theta_z_before_deg": 12.34, "theta_z_after_deg": 0.4},
        "sort": {"order": [2, 1, 3, 4, 6, 5], "theta_z_after_deg": -1.26},
    }
    assert of_a_sweep(tolerance=tolerance)[6:10] == [
        "          stored forces within 0.0028 N (one sd) keep abs(theta_z) under 5 deg in 95 % of runs (simulated: 91 to 96 %)",
        "          stored forces within 0.017 N (one sd) keep abs(theta_z) under 30 deg in 95 % of runs (simulated: 90 to 95 %)",
        "          leg 4 by -0.012 N leaves 0.4 deg, 12.3 deg now",
        "          legs 2 1 3 4 6 5 in places 1 to 6 leave -1.3 deg",
    ]


def test_words_that_change_no_byte_are_no_part_of_the_provenance():
    words = [
        "rig.toml",
        "--workers",
        "3",
        "--runs=5",
        "--resume",
        "--dask=auto",
        "--quiet",
        "--dask",
        "tcp://a",
        "--workers=2",
        "--seed",
        "1",
    ]
    assert sweep_deployments._without_how(words) == ["rig.toml", "--runs=5", "--seed", "1"]


DESIGN: dict[str, Any] = {
    "verdict": "found",
    "evaluations": 400,
    "draws": 256,
    "fresh_draws": 1024,
    "free": [
        {"key": "end_stop.damping_N_s_per_m", "value": 12.3456789, "before": 22.6, "at_bound": None},
        {"key": "actuator.beta_per_m", "value": 100.0, "before": 400.0, "at_bound": "low"},
    ],
    "objective": {"measure": "mean:stop_force_N", "fresh": 12.3456, "before": 20.0},
    "limits": [
        {"measure": "p95:theta_z_deg", "fresh": 4.5678, "below": 5.0, "before": 9.0, "kept": True},
        {"measure": "highest_m", "fresh": 0.6, "above": 0.65, "before": 0.66, "kept": False},
    ],
}


def of_a_design(**changed):
    return design_deployment._sentences({**DESIGN, **changed}, Namespace(output="rig.toml"))


def test_a_design_is_told_with_what_was_before():
    assert of_a_design() == [
        "design    found; 400 candidates on 256 draws each",
        "          end_stop.damping_N_s_per_m 12.3457 (before 22.6)",
        "          actuator.beta_per_m 100 (before 400), at its low bound",
        "          mean:stop_force_N 12.35 on 1024 fresh draws (before 20)",
        "          p95:theta_z_deg 4.568 < 5: kept (before 9)",
        "          highest_m 0.6 > 0.65: NOT kept (before 0.66)",
        "          written to rig.toml",
    ]


def test_a_design_without_draws_and_one_that_keeps_no_limit_say_so():
    lines = of_a_design(draws=0, fresh_draws=0, limits=[], verdict="none-feasible")
    assert lines[0] == "design    no candidate keeps all limits; widen --free or the limits; 400 candidates on 1 draws each"
    assert lines[3] == "          mean:stop_force_N 12.35 on the model as it stands (before 20)"
    assert lines[-1] == "          nothing is written"
    assert "does not hold on fresh draws" in of_a_design(verdict="not-kept")[0]


KEPT = {"failures": 3, "angle_deg": 30.0, "upper_bound_percent": 0.0987, "certified": True, "probability": 0.999}
RIVAL = {
    "kept": [{"failed_percent": 55.55, "failed_before_stop_percent": 12.34}],
    "control_energy_J": [0.0, 1.234],
    "control_force_N": 2.345,
}
CERTIFICATE = {
    "kept": [KEPT, {**KEPT, "certified": False, "angle_deg": 5.0}],
    "control_force_N": 1.234,
    "control_energy_J": [-0.0123, 0.456],
}
CONTROL: dict[str, Any] = {
    "law": "synchronise",
    "controller": {"law": "synchronise", "stiffness_N_per_m": 123.456, "lag_s": 0.0, "delay_s": 0.002, "failure_s": 1.0},
    "confidence": 0.99,
    "verdict": "certified",
    "certificate": [{"stops": "halved", "draws": 4096, **CERTIFICATE}],
    "margins": [
        {"change": "delay_s times 2", "failed": [{"failed_percent": 0.0}]},
        {"change": "gains times 4", "failed": [{"failed_percent": 12.34}]},
    ],
    "without_control": [{**RIVAL, "stops": "halved"}, {**RIVAL, "stops": "as given"}, {**RIVAL, "stops": "doubled"}],
    "other_laws": [{**RIVAL, "law": "one-way"}],
}


def of_a_controller(**changed):
    options = Namespace(output="rig.toml", sample_rate=1000.0, delay=0.002, noise=0.0, lag=0.0, actuator="brake")
    return design_control._sentences({**CONTROL, **changed}, options)


def test_a_controller_is_told_with_its_certificate_its_margins_and_its_rivals():
    assert of_a_controller() == [
        "control   synchronise: stiffness_N_per_m 123.456",
        "          stops halved: 3 of 4096 beyond 30 deg, below 0.099 % by 99 %; certified for 0.999",
        "          stops halved: 3 of 4096 beyond 5 deg, below 0.099 % by 99 %; NOT certified for 0.999",
        "          1.23 N at most, -0.012 to 0.46 J",
        "          gains times 4: 12.3 % beyond",
        "          without control: 55.5 % beyond, 12.3 % before the first stop",
        "          one-way: 55.5 % beyond, 12.3 % before the first stop; 2.35 N, 1.2 J",
        "          written to rig.toml",
    ]


def test_a_controller_that_nothing_takes_beyond_the_angle_or_that_was_not_found_says_so():
    lines = of_a_controller(margins=CONTROL["margins"][:1], verdict="none-found")
    assert "no change of delay, noise, lag or gains that was tried, and no failed part, takes it beyond the angle" in lines[4]
    assert lines[-1] == "          no gains are good enough; nothing is written"
