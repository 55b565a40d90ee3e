"""The numbers of the rig stand in its MJCF where MuJoCo reads them; that it then moves as here is tested with MuJoCo itself."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from simulate.deployment.mujoco_export import mjcf_of
from simulate.effects import HubInertia, PlatformMass, ViscousFriction
from simulate.model.model import Gravity


def numbers(element, name):
    return [float(word) for word in element.get(name, "").split()]


@pytest.fixture
def rig(lopsided):
    return replace(lopsided, name='a "rig" & more', gravity=Gravity(0.5, 1.6), effects=(HubInertia(0.21), ViscousFriction(0.07)))


@pytest.fixture
def world(rig):
    return ElementTree.fromstring(mjcf_of(rig))


def test_the_platform_stands_at_its_release_with_the_mass_that_moves(rig, world):
    body, inertial = world.find("worldbody/body"), world.find("worldbody/body/inertial")
    assert numbers(body, "pos") == pytest.approx(np.add(rig.release.position_m, [0.0, 0.0, rig.geometry.stowed_height_m]))
    turned = Rotation.from_quat(numbers(body, "quat"), scalar_first=True)
    assert turned.as_rotvec() == pytest.approx(rig.release.theta_rad)
    assert numbers(inertial, "pos") == pytest.approx(rig.platform.centre_of_mass_m)
    assert numbers(inertial, "mass") == pytest.approx([0.8 * 1.6])
    assert numbers(inertial, "diaginertia") == pytest.approx(1.6 * np.array(rig.platform.inertia_kg_m2))


def test_the_weight_is_that_of_the_platform_without_its_counterweight(rig, world):
    gravity = numbers(world.find("option"), "gravity")
    mass = numbers(world.find("worldbody/body/inertial"), "mass")[0]
    assert [mass * g for g in gravity] == pytest.approx([0.0, 0.0, -rig.platform.mass_kg * rig.gravity.acceleration_m_per_s2])


def test_each_leg_is_a_tendon_between_its_own_joints_with_its_hub_its_friction_and_its_motor(rig, world):
    base = {site.get("name"): numbers(site, "pos") for site in world.findall("worldbody/site")}
    joints = {site.get("name"): numbers(site, "pos") for site in world.findall("worldbody/body/site")}
    tendons = world.findall("tendon/spatial")
    assert len(base) == len(joints) == len(tendons) == 6
    for k, tendon in enumerate(tendons):
        below, above = (site.get("site") for site in tendon.findall("site"))
        assert base[below] == list(rig.geometry.base_joints_m[k])
        assert joints[above] == list(rig.geometry.platform_joints_m[k])
        assert numbers(tendon, "armature") == [0.21]
        assert numbers(tendon, "damping") == [0.07]
    names = [f"leg_{k + 1}" for k in range(6)]
    assert [tendon.get("name") for tendon in tendons] == names
    assert [(motor.get("name"), motor.get("tendon")) for motor in world.findall("actuator/motor")] == list(zip(names, names, strict=True))
    assert world.get("model") == rig.name


def test_what_effects_make_of_the_rig_is_exported(rig):
    heavier = ElementTree.fromstring(mjcf_of(rig.with_effect(PlatformMass(0.1))))
    assert numbers(heavier.find("worldbody/body/inertial"), "mass") == pytest.approx([0.9 * 1.6])
