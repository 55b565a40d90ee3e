"""Rigs that no workshop builds are refused where a model is read; what is odd and can be stands in the result as a warning."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.deployment.deploy import deploy, deploy_checked
from simulate.effects import EndStopDissipation, PlatformMass
from simulate.files.model_file import document_of, model_from
from simulate.kernel.step_size import grid
from simulate.law import restoring_force
from simulate.model.model import Geometry, Simulation, with_value
from simulate.model.possible import _RANGES, condition_at, impossible, warnings_of
from simulate.model.rig import stroke_of


def read_back(model):
    return model_from(document_of(model), "rig.toml")


def turned_inertia(chance):
    """Principal inertias of a body of random point masses: those that can be."""
    points, masses = chance.normal(size=(6, 3)), chance.uniform(0.1, 1.0, 6)
    centred = points - np.average(points, axis=0, weights=masses)
    tensor = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, centred, strict=True))
    return tuple(float(v) for v in np.linalg.eigvalsh(tensor))


@pytest.mark.parametrize("seed", range(20))
def test_the_inertia_of_every_body_is_taken_and_that_of_none_is_refused(prototype, seed):
    chance = np.random.default_rng(seed)
    inertia = chance.permutation(turned_inertia(chance))
    assert not impossible(replace(prototype, platform=replace(prototype.platform, inertia_kg_m2=tuple(inertia.tolist()))))
    place = int(np.argmax(inertia))
    inertia[place] = (inertia.sum() - inertia[place]) * chance.uniform(1.15, 5.0)
    wrong = replace(prototype, platform=replace(prototype.platform, inertia_kg_m2=tuple(inertia.tolist())))
    with pytest.raises(InputError, match=r"no rigid body is like that"):
        read_back(wrong)


def test_inertia_that_measuring_may_explain_is_a_warning_of_the_result(prototype):
    a, b, _ = prototype.platform.inertia_kg_m2
    near = replace(prototype, platform=replace(prototype.platform, inertia_kg_m2=(a, b, 1.04 * (a + b))))
    assert any("no rigid body" in said for said in deploy(read_back(near)).summary["warnings"])


def moved(model, **changes):
    assert model.geometry is not None
    return replace(model, geometry=Geometry(**{**asdict(model.geometry), **changes}))


@pytest.mark.parametrize("seed", range(5))
def test_joints_on_one_spot_or_in_one_line_are_refused_wherever_the_line_lies(prototype, seed):
    chance = np.random.default_rng(seed)
    along, spot = chance.normal(size=3) * 0.1, 0.01 * chance.normal(size=3)
    line = tuple(tuple((spot + share * along).tolist()) for share in chance.uniform(-1, 1, 6))
    for joints, words in ((line, "in one line"), (6 * (tuple(spot.tolist()),), "on one spot")):
        with pytest.raises(InputError, match=words):
            read_back(moved(prototype, platform_joints_m=joints))


def test_two_legs_between_the_same_joints_are_one_leg(prototype):
    base, platform = (list(joints) for joints in (prototype.geometry.base_joints_m, prototype.geometry.platform_joints_m))
    base[4], platform[4] = base[1], platform[1]
    with pytest.raises(InputError, match="legs 2 and 5 have the same two joints"):
        read_back(moved(prototype, base_joints_m=tuple(base), platform_joints_m=tuple(platform)))


def test_a_platform_below_its_base_is_refused(prototype):
    with pytest.raises(InputError, match="z points up"):
        read_back(moved(prototype, stowed_height_m=-0.652, deployed_height_m=-0.252))


def test_a_stop_that_is_never_reached_is_refused(prototype):
    base = tuple((x, y, 0.5 if leg == 3 else -0.2) for leg, (x, y, _) in enumerate(prototype.geometry.base_joints_m))
    with pytest.raises(InputError, match="leg 4 does not grow"):
        read_back(moved(prototype, base_joints_m=base))


@pytest.mark.parametrize("wide", [True, False])
def test_legs_that_lose_a_direction_are_a_warning_with_the_height_and_the_condition_number(prototype, wide):
    ring = [(np.cos(a), np.sin(a), 0.0) for a in np.arange(6) * np.pi / 3]
    base, platform = ([tuple(float(r * v) for v in row) for row in ring] for r in ((0.5, 0.3) if wide else (0.3, 0.3)))
    aligned = moved(prototype, base_joints_m=tuple(base), platform_joints_m=tuple(platform))
    (said,) = warnings_of(read_back(aligned))  # all legs lie in planes through the axis: nothing resists theta_z
    assert "lose a direction" in said
    assert "condition number" in said
    assert not warnings_of(prototype)


def test_the_condition_number_does_not_depend_on_the_size_of_the_rig(prototype):
    base, platform = (
        tuple(tuple(10 * v for v in row) for row in joints)
        for joints in (prototype.geometry.base_joints_m, prototype.geometry.platform_joints_m)
    )
    sizes = {"base_joints_m": base, "platform_joints_m": platform, "stowed_height_m": 2.52, "deployed_height_m": 6.52}
    larger = moved(prototype, **sizes)
    assert condition_at(larger, 4.0) == pytest.approx(condition_at(prototype, 0.4))


def test_a_loop_that_makes_energy_is_a_warning_and_rising_lines_that_only_seem_to_cross_are_none(prototype):
    crossed = with_value(prototype, "actuator.b_l_N[2]", 3.2)
    assert [said for said in warnings_of(crossed) if "leg 3" in said and "makes" in said]
    rising = replace(
        prototype, actuator=replace(prototype.actuator, a_l_N_per_m=20.0, a_u_N_per_m=20.0, b_l_N=0.05, b_u_N=0.0, beta_per_m=100.0)
    )
    assert not warnings_of(rising)  # its branches are h_u - h_l + (a_u + a_l) / beta = 0.35 N apart


def test_a_run_that_diverged_is_not_exact(prototype):
    hard = replace(prototype, end_stop=replace(prototype.end_stop, stiffness_N_per_m=2e9), simulation=Simulation(1.0, 250.0, 4e-3))
    run = deploy_checked(hard)
    assert run.diverged_at_s is not None
    assert run.step_error is not None
    assert not run.step_error.fine
    assert any("diverged" in said for said in run.summary["warnings"])


@pytest.mark.parametrize(
    ("table", "key", "value", "words"),
    [
        ("platform", "mass_kg", True, "platform.mass_kg"),
        ("platform", "mass_kg", "0.8", "platform.mass_kg"),
        ("platform", "mass_kg", 1e300, "platform.mass_kg: 1e[+]300 is not between"),
        ("actuator", "b_l_N", [2.8, True, 2.8, 2.8, 2.8, 2.8], "actuator.b_l_N"),
        ("actuator", "b_l_N", float("nan"), "actuator.b_l_N"),
        ("actuator", "beta_per_m", 1e-300, "actuator.beta_per_m"),
        ("nuisance", "release_position_m", 1e300, "nuisance.release_position_m"),
        ("release", "angular_velocity_rad_per_s", [0.0, 0.0, 1e6], "release.angular_velocity_rad_per_s"),
        ("simulation", "step_s", 2.0, "simulation.step_s"),
    ],
)
def test_a_value_that_is_no_number_of_a_rig_is_refused_by_its_key(prototype, table, key, value, words):
    document = document_of(prototype)
    document[table][key] = value
    with pytest.raises(InputError, match=words):
        model_from(document, "rig.toml")


@pytest.mark.parametrize("value", [True, "0.1", [0.1, True, 0.1], ["0.1", 0.1, 0.1], "0.1, 0.1, 0.1", {"a": 1}])
def test_a_parameter_of_an_effect_is_a_number_too(prototype, value):
    document = document_of(prototype)
    document["effect"] = [{"name": "release-pose", "theta_rad": value}]
    with pytest.raises(InputError, match="theta_rad"):
        model_from(document, "rig.toml")


@pytest.mark.parametrize(
    "rows", [[1, 2], ["hub-inertia"], [{"name": 1}], [{"name": ["hub-inertia"]}], [[]], "hub-inertia", {"name": "hub-inertia"}]
)
def test_effects_that_are_no_tables_are_refused_in_a_sentence(prototype, rows):
    document = document_of(prototype)
    document["effect"] = rows
    with pytest.raises(InputError, match="effect"):
        model_from(document, "rig.toml")


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"end_stop.stiffness_N_per_m": 1e12}, "end_stop.stiffness_N_per_m"),
        ({"end_stop.damping_N_s_per_m": 1e7}, "end_stop.damping_N_s_per_m"),
        ({"simulation.duration_s": 1e5}, "simulation.duration_s"),
        ({"simulation.step_s": 1e-9}, "simulation.step_s"),
    ],
)
def test_a_run_that_nobody_waits_for_is_refused_with_the_key_to_change(prototype, changes, key):
    model = replace(prototype, simulation=Simulation(1.0, 1000.0, 1e-4 if "simulation.step_s" in changes else None))
    for name, value in changes.items():
        model = with_value(model, name, value)
    with pytest.raises(InputError, match=key.replace(".", "[.]")):
        deploy(model)


def test_a_name_that_fills_a_page_is_refused(prototype):
    with pytest.raises(InputError, match="name: has 1000 characters"):
        read_back(replace(prototype, name="x" * 1000))


def test_a_platform_that_is_deployed_below_its_stowed_height_is_refused(prototype):
    document = document_of(prototype)
    document["geometry"]["deployed_height_m"] = document["geometry"]["stowed_height_m"]
    with pytest.raises(InputError, match="deployed_height_m must be above"):
        model_from(document, "rig.toml")


def test_a_step_that_is_longer_than_the_run_is_refused(prototype):
    with pytest.raises(InputError, match=r"simulation.step_s: 0.5 s is longer than duration_s, 0.1 s"):
        read_back(replace(prototype, simulation=Simulation(0.1, 1000.0, 0.5)))


def test_more_samples_than_fit_into_memory_are_refused(prototype):
    with pytest.raises(InputError, match=r"3e\+06 samples; at most 2e\+06 are kept"):
        grid(replace(prototype, simulation=Simulation(1.0, 3e6)))


@pytest.mark.parametrize("kind", [PlatformMass, EndStopDissipation])
def test_an_effect_cannot_take_away_more_than_there_is(prototype, kind):
    with pytest.raises(InputError, match=r"with the model's effects, .*is not between"):
        read_back(prototype.with_effect(kind(-100.0)))
    assert read_back(prototype.with_effect(kind(-0.1))).effects


INERTIA = [(1.0, False, False), (1.0 + 1e-5, False, True), (1.099, False, True), (1.101, True, False)]


@pytest.mark.parametrize(("share", "refused", "warned"), INERTIA)
def test_the_largest_inertia_may_miss_the_sum_of_the_others_by_a_tenth(prototype, share, refused, warned):
    body = replace(prototype, platform=replace(prototype.platform, inertia_kg_m2=(0.004, share * 0.011, 0.007)))
    assert bool(impossible(body)) == refused
    assert any("though measured ones" in said for said in warnings_of(body)) == (warned or refused)


@pytest.mark.parametrize(
    ("key", "least", "most"),
    [
        ("platform.mass_kg", 1e-6, 1e6),  # from a milligram to a thousand tonnes
        ("release.position_m[1]", -1e3, 1e3),  # a kilometre
        ("release.theta_rad[0]", -6.3, 6.3),  # a turn
        ("nuisance.release_theta_rad", 0.0, 3.2),  # half a turn
        ("gravity.mass_factor", 1e-3, 1e3),
        ("end_stop.smoothing_m", 1e-9, 1.0),
    ],
)
def test_a_number_that_no_rig_has_is_refused_with_the_range_it_missed(prototype, key, least, most):
    for value, beyond in ((least, least - 0.01 * abs(least)), (most, most + 0.01 * most)):
        assert not impossible(with_value(prototype, key, value))
        if beyond != value and (beyond >= 0.0 or least < 0.0):
            (said,) = impossible(with_value(prototype, key, beyond))
            assert f"is not between {least:g} and {most:g}" in said
            assert said.startswith(key.partition("[")[0] + ": ")


def test_everything_that_is_out_of_range_is_said_at_once(prototype):
    wrong = with_value(with_value(prototype, "platform.mass_kg", 1e7), "actuator.b_l_N[3]", -1e7)
    assert [said.partition(":")[0] for said in impossible(wrong)] == ["platform.mass_kg", "actuator.b_l_N"]
    assert impossible(None) == []


def test_a_loop_makes_the_energy_that_its_two_branches_enclose(prototype):
    """By the force along both branches, many fadings of beta long: what uncoiling gives beyond what coiling takes."""
    law = replace(prototype.actuator, a_l_N_per_m=-0.5, b_l_N=2.9, a_u_N_per_m=0.3, b_u_N=2.7, beta_per_m=900.0)
    rig = replace(prototype, actuator=law)
    (stroke,) = set(np.round(stroke_of(rig), 12))
    u = np.linspace(0.0, stroke, 200_001)
    out = restoring_force(u, 0.0, 2.9, -0.5, 2.9, 900.0)
    back = restoring_force(u, stroke, out[-1], 0.3, 2.7, 900.0)
    out = restoring_force(u, 0.0, back[0], -0.5, 2.9, 900.0)
    made = np.trapezoid(out - back, u)
    said = [line for line in warnings_of(rig) if "makes" in line]
    assert len(said) == 6
    assert float(said[0].split("makes ")[1].split(" J")[0]) == pytest.approx(made, rel=0.02)


def test_the_height_of_the_platform_is_that_of_its_joints_above_those_of_the_base(prototype):
    lifted = tuple((x, y, z + 0.3) for x, y, z in prototype.geometry.base_joints_m)
    (said, *_) = impossible(moved(prototype, base_joints_m=lifted))
    assert f"puts the platform's joints {0.3 - prototype.geometry.stowed_height_m:.3g} m below" in said
    assert not impossible(moved(prototype, base_joints_m=tuple((x, y, z + 0.05) for x, y, z in prototype.geometry.base_joints_m)))


@pytest.mark.parametrize(("off_rad", "words"), [(1e-3, ""), (1e-4, "hold one direction badly"), (1e-5, "lose a direction")])
def test_a_direction_that_is_held_badly_is_a_milder_warning(prototype, off_rad, words):
    """Legs that stand beside the planes through the axis by a little, to and fro; the warning has the worst height."""
    angles = np.arctan2(*np.asarray(prototype.geometry.base_joints_m)[:, 1::-1].T) + off_rad * np.array([1, -1] * 3)
    joints = np.column_stack([0.3 * np.cos(angles), 0.3 * np.sin(angles), np.zeros(6)])
    rig = moved(prototype, platform_joints_m=tuple(map(tuple, joints.tolist())))
    heights = np.linspace(prototype.geometry.stowed_height_m, prototype.geometry.deployed_height_m, 21)
    conditions = [condition_at(rig, height) for height in heights]
    numbers = f"at a height of 0.652 m: condition number {max(conditions):.2g}, {min(conditions):.2g} at best along the path"
    assert warnings_of(rig) == ([f"the legs {words} {numbers}"] if words else [])


def test_a_longest_name_is_two_hundred_letters(prototype):
    assert not impossible(replace(prototype, name="x" * 200))
    assert impossible(replace(prototype, name="x" * 201)) == ["name: has 201 characters; give it at most 200."]


TURNS = {"release.theta_rad": 2.0 * np.pi, "nuisance.release_theta_rad": np.pi}


@pytest.mark.parametrize("key", _RANGES)
def test_ranges_are_powers_of_ten_that_go_as_far_either_way_or_begin_at_zero_where_a_model_may(prototype, key):
    """They keep out what no workshop builds, so none of them is finer than that; an angle goes to a whole turn or to half of one."""
    low, high = _RANGES[key]
    ends = {abs(end) for end in (low, high) if end != 0.0}
    if key in TURNS:
        assert all(turn < end < 1.02 * turn for end, turn in zip(ends, [TURNS[key]], strict=True))
    else:
        assert all(np.log10(end) == round(np.log10(end)) for end in ends)
    assert low == -high or low == 0.0 or 0.0 < low < 1e-5 * high
    if low >= 0.0:
        zero = taken(lambda: with_value(prototype, key, 0.0))
        assert (zero is not None) == (low == 0.0), "above zero where the model itself refuses zero: a mass, a step"


def taken(made):
    try:
        return made()
    except (KeyError, ValueError):
        return None
