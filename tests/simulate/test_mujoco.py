"""The platform in another engine: MuJoCo, legs as tendons, the same force law driven from outside."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from measure.errors import InputError
from simulate.deployment import deploy
from simulate.effects import AirDrag, HubInertia, ViscousFriction
from simulate.law import restoring_force
from simulate.mjcf import mjcf_of, require_expressed
from simulate.model import Release, Simulation, per_leg

mujoco: Any = pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install mujoco")


def random_rig(lopsided, seed):
    """The lopsided rig with everything that both engines can express drawn anew."""
    rng = np.random.default_rng(seed)
    law, g = lopsided.actuator, lopsided.geometry

    def near(values, spread):
        return tuple(tuple(row) for row in np.asarray(values) + rng.uniform(-spread, spread, np.shape(values)))

    b = rng.uniform(2.6, 3.0, 6)
    return replace(
        lopsided,
        geometry=replace(g, base_joints_m=near(g.base_joints_m, 0.03), platform_joints_m=near(g.platform_joints_m, 0.02)),
        platform=replace(lopsided.platform, inertia_kg_m2=tuple(rng.uniform(0.004, 0.009, 3))),
        actuator=replace(law, b_l_N=tuple(b), b_u_N=tuple(b + 0.1), initial_force_N=tuple(b + rng.uniform(0, 0.2, 6))),
        gravity=replace(lopsided.gravity, acceleration_m_per_s2=float(rng.uniform(-1, 1))),
        release=Release(theta_rad=tuple(rng.uniform(-0.1, 0.1, 3))),
        effects=(HubInertia(float(rng.uniform(0, 0.8))), ViscousFriction(float(rng.uniform(0, 0.3)))),
        simulation=Simulation(0.25, 100.0, 1e-4),
    )


def played_in_mujoco(model):
    """Position and quaternion of the platform frame at our samples, from MuJoCo's RK4."""
    engine = mujoco.MjModel.from_xml_string(mjcf_of(model))
    data = mujoco.MjData(engine)
    law, g = model.actuator, model.geometry
    stowed = np.linalg.norm(np.add(g.platform_joints_m, (0, 0, g.stowed_height_m)) - np.asarray(g.base_joints_m), axis=1)
    lines = [per_leg(v) for v in (law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m)]
    mujoco.mj_forward(engine, data)
    memory = {"u": data.ten_length - stowed, "force": per_leg(law.initial_force_N)}

    def force(u):
        made = []
        for leg, (a_l, b_l, a_u, b_u, beta) in enumerate(zip(*lines, strict=True)):
            a, b = (a_l, b_l) if u[leg] > memory["u"][leg] else (a_u, b_u)
            made.append(float(restoring_force(u[leg], memory["u"][leg], memory["force"][leg], a, b, beta)))
        return np.array(made)

    def drive(_, at):
        at.ctrl[:] = force(at.ten_length - stowed)

    poses = []
    mujoco.set_mjcb_control(drive)
    try:
        for step in range(2501):
            if step % 100 == 0:
                poses.append(data.qpos.copy())
            mujoco.mj_step(engine, data)
            mujoco.mj_fwdPosition(engine, data)
            u = data.ten_length - stowed
            memory["force"], memory["u"] = force(u), u.copy()
    finally:
        mujoco.set_mjcb_control(None)
    return np.array(poses)


@pytest.mark.parametrize("seed", range(3))
def test_elevation_and_theta_z_agree_with_mujoco_up_to_the_stops(lopsided, seed):
    model = random_rig(lopsided, seed)
    run = deploy(model)
    assert min(run.work_J["by_stops"]) == 0, "the stops are not in the other engine"
    poses = played_in_mujoco(model)
    assert np.max(np.abs(poses[:, 2] - run.channels["z_m"])) < 1e-8
    theta_z = np.unwrap(2 * np.arctan2(poses[:, 6], poses[:, 3]))
    assert np.max(np.abs(np.degrees(theta_z - run.channels["theta_z_rad"]))) < 1e-5
    assert np.ptp(run.channels["z_m"]) > 0.05


def test_an_effect_that_mjcf_cannot_express_is_refused_and_not_left_out(lopsided):
    require_expressed(lopsided)
    with pytest.raises(InputError, match="air-drag"):
        require_expressed(lopsided.with_effect(AirDrag(0.1)))


def test_an_inertia_that_no_body_has_is_refused(prototype):
    # the inferred prototype: 0.003164 about z, twice 0.001516 about the others
    with pytest.raises(InputError, match=r"0\.003164 is above the sum"):
        require_expressed(prototype)
