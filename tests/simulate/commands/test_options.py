"""What options of the commands take, to the ends of their ranges, and what is asked for where none is given."""

from __future__ import annotations

from typing import Any

import pytest

from measure.common.errors import InputError
from simulate.commands import design_control, design_deployment, simulate_deployment, sweep_deployments
from simulate.control.task import Requirement
from simulate.control.uncertainty import Uncertainty
from simulate.sweeps.limits import FEWEST_RARE

NEED = {design_deployment: ["--minimise", "cost"]}


def parsed(command: Any, *words):
    return command._parser().parse_args(["rig.toml", *NEED.get(command, []), *words])


def takes(command, option, value):
    try:
        parsed(command, f"{option}={value}")
    except (InputError, SystemExit):
        return False
    return True


ENDS = [
    (design_control, "--angle", [1e-9, 400.0], [0.0, -30.0]),
    (design_control, "--probability", [0.5, 0.999999], [0.49, 1.0]),
    (design_control, "--force-limit", [1e-3, 1e3], [0.0, -1.0]),
    (design_control, "--sample-rate", [1e-3, 1e6], [0.0, -1.0]),
    (design_control, "--delay", [0.0, 1.0], [-1e-9]),
    (design_control, "--lag", [0.0, 1.0], [-1e-9]),
    (design_control, "--noise", [0.0, 1.0], [-1e-9]),
    (design_control, "--disparity", [0.0, 90.0], [-0.1, 90.1]),
    (design_control, "--confidence", [0.5, 0.9999], [0.49, 0.99991]),
    (design_control, "--draws", [16, 200_000], [15, 200_001, 16.5]),
    (design_control, "--seed", [0, 2**31], [-1, 2**31 + 1]),
    (design_control, "--actuator", ["brake", "motor"], ["spring"]),
    (design_deployment, "--failure-deg", [1e-9], [0.0]),
    (design_deployment, "--draws", [1, 65_536], [0, 65_537]),
    (design_deployment, "--evaluations", [16, 1_000_000], [15, 1_000_001]),
    (design_deployment, "--seed", [0, 2**31], [-1, 2**31 + 1]),
    (sweep_deployments, "--rare", [FEWEST_RARE, 1_000_000], [FEWEST_RARE - 1, 1_000_001]),
    (sweep_deployments, "--runs", [1, 10_000_000], [0, 10_000_001]),
    (sweep_deployments, "--failure-deg", [1e-9], [0.0]),
    (sweep_deployments, "--tolerance-deg", [1e-9], [0.0]),
    (sweep_deployments, "--probability", [0.001, 0.999], [0.0009, 0.9991]),
    (sweep_deployments, "--seed", [0, 10**18 - 1], [-1, 10**18]),
    (sweep_deployments, "--workers", [1, 100_000], [0, 100_001]),
    (sweep_deployments, "--indices", ["sobol", "morris"], ["anova"]),
]


@pytest.mark.parametrize(("command", "option", "good", "bad"), ENDS, ids=[f"{row[0].NAME} {row[1]}" for row in ENDS])
def test_an_option_takes_what_can_be_and_nothing_beyond(command, option, good, bad):
    assert [value for value in good if not takes(command, option, value)] == []
    assert [value for value in bad if takes(command, option, value)] == []


def test_a_controller_is_asked_for_with_the_sensors_and_the_rig_that_were_given(prototype):
    options = parsed(design_control)
    task = design_control._task(prototype, options, design_control._requirements(options))
    assert task.requirements == (Requirement(30.0, 0.999),)
    assert (task.law, task.most_force_N, task.confidence, task.draws, task.seed) == ("synchronise", 1.5, 0.95, None, 0)
    sensed = {"sample_rate_Hz": 1000.0, "delay_s": 0.002, "lag_s": 0.005, "sensor_noise_m": 1e-4}
    assert task.fixed == {**sensed, "actuator": "brake"}
    assert task.uncertainty == Uncertainty(0.1, 0.001, 0.002, 0.0003)
    words = [
        "--angle=10",
        "--probability=0.9",
        "--angle=30",
        "--probability=0.99",
        "--disparity=7",
        "--force-limit=2",
        "--draws=50",
        "--seed=3",
    ]
    options = parsed(design_control, *words)
    task = design_control._task(prototype, options, design_control._requirements(options))
    assert task.requirements == (Requirement(10.0, 0.9), Requirement(30.0, 0.99))
    assert (task.uncertainty.disparity, task.most_force_N, task.draws, task.seed) == (pytest.approx(0.07), 2.0, 50, 3)


def test_a_design_tries_each_of_some_hundred_candidates_on_some_draws():
    options = parsed(design_deployment)
    assert (options.draws, options.evaluations, options.seed, options.failure_deg) == (64, 400, 0, 30.0)


def test_a_sweep_counts_the_papers_failure_and_tolerances_for_nineteen_of_twenty_runs():
    options = parsed(sweep_deployments)
    assert (options.response, options.failure_deg, options.probability, options.seed) == ("theta_z_deg", 30.0, 0.95, 0)
    assert (options.rare, options.indices, options.runs, options.workers, options.resume) == (None, None, None, None, False)


def test_a_figure_has_one_of_three_endings_and_a_measurement_needs_a_page():
    for words, good in (
        (["--figure", "f.PDF"], True), (["--figure", "f.svg"], True), (["--figure", "f.jpg"], False),
        (["--measured", "m.csv"], False), (["--measured", "m.csv", "--page", "p.html"], True), ([], True),
    ):  # fmt: skip
        options = parsed(simulate_deployment, *words)
        if good:
            simulate_deployment._require_consistent(options)
        else:
            with pytest.raises(InputError):
                simulate_deployment._require_consistent(options)
