"""The compiled platform against a right-hand side written again, in NumPy, with the hysteretic force as a state."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import erf

from simulate.deployment import deploy
from simulate.model import Simulation


class PlatformInBodyAxes:
    """Newton and Euler about the centre of mass, rotation matrix and body rates as state, R by its differential equation."""

    def __init__(self, model, hub_mass, damping):
        g = model.geometry
        self.base = np.asarray(g.base_joints_m)
        self.joints = np.asarray(g.platform_joints_m) - model.platform.centre_of_mass_m
        on_stowed = np.add(g.platform_joints_m, (0.0, 0.0, g.stowed_height_m)) - self.base
        self.stowed = np.linalg.norm(on_stowed, axis=1)
        self.mass = model.platform.mass_kg * model.gravity.mass_factor
        self.inertia = np.diag(model.platform.inertia_kg_m2) * model.gravity.mass_factor
        self.hub_mass, self.damping, self.law = hub_mass, damping, model.actuator
        self.model = model
        self.full = np.linalg.norm(np.add(g.platform_joints_m, (0.0, 0.0, g.deployed_height_m)) - self.base, axis=1) - self.stowed
        place, rotation = self.start()[:3], self.start()[3:12].reshape(3, 3)
        self.lowest = np.minimum(np.linalg.norm(place + self.joints @ rotation.T - self.base, axis=1) - self.stowed, 0.0)

    def start(self):
        r, g = self.model.release, self.model.geometry
        rotation = Rotation.from_rotvec(r.theta_rad).as_matrix()
        arm = rotation @ self.model.platform.centre_of_mass_m
        place = np.array([0.0, 0.0, g.stowed_height_m]) + r.position_m + arm
        velocity = np.asarray(r.velocity_m_per_s) + np.cross(r.angular_velocity_rad_per_s, arm)
        spin = rotation.T @ np.asarray(r.angular_velocity_rad_per_s)
        return np.concatenate([place, rotation.ravel(), velocity, spin, self.law.initial_force_N])

    def __call__(self, t, y):
        del t
        place, rotation, velocity, spin, force = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:]
        arms = self.joints @ rotation.T
        spin_world = rotation @ spin
        legs = place + arms - self.base
        length = np.linalg.norm(legs, axis=1)
        axis = legs / length[:, None]
        joint_velocity = velocity + np.cross(spin_world, arms)
        rate = np.einsum("ij,ij->i", axis, joint_velocity)
        axis_rate = (joint_velocity - rate[:, None] * axis) / length[:, None]
        # l'' = jacobian @ (linear, body angular acceleration) + rest
        jacobian = np.hstack([axis, np.cross(self.joints, axis @ rotation)])
        centripetal = np.cross(spin_world, np.cross(spin_world, arms))
        rest = np.einsum("ij,ij->i", axis_rate, joint_velocity) + np.einsum("ij,ij->i", axis, centripetal)
        pushed = force - self.damping * rate - self.hub_mass * rest + self.stops(length - self.stowed, rate)
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = self.mass * np.eye(3)
        matrix[3:, 3:] = self.inertia
        matrix += self.hub_mass * jacobian.T @ jacobian
        right = jacobian.T @ pushed
        right[3:] -= np.cross(spin, self.inertia @ spin)
        acceleration = np.linalg.solve(matrix, right)
        cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
        return np.concatenate(
            [velocity, (rotation @ cross).ravel(), acceleration[:3], acceleration[3:], self.force_rate(length - self.stowed, rate, force)]
        )

    def stops(self, u, rate):
        stop = self.model.end_stop
        over, under = np.maximum(u - self.full, 0.0), np.maximum(self.lowest - u, 0.0)
        spring = stop.stiffness_N_per_m * (under - over) - stop.damping_N_s_per_m * rate
        return spring * erf((over + under) / stop.smoothing_m)

    def force_rate(self, u, rate, force):
        law = self.law
        lower = np.asarray(law.a_l_N_per_m) * u + law.b_l_N
        upper = np.asarray(law.a_u_N_per_m) * u + law.b_u_N
        return np.asarray(law.beta_per_m) * np.where(rate > 0, rate * (lower - force), rate * (force - upper))


@pytest.mark.parametrize("moving", [False, True])
def test_deployment_up_to_the_stops_agrees_with_dop853(lopsided, moving):
    # without velocity at the release every leg uncoils throughout; with it some legs reverse, and a fixed step
    # that runs across a reversal is of lower order there
    still = replace(lopsided.release, velocity_m_per_s=(0.0,) * 3, angular_velocity_rad_per_s=(0.0,) * 3)
    model = replace(lopsided, release=lopsided.release if moving else still, simulation=Simulation(0.25, 200.0, 1e-4))
    run = deploy(model)
    full = np.linalg.norm(np.add(lopsided.geometry.platform_joints_m, (0.0, 0.0, 0.652)) - lopsided.geometry.base_joints_m, axis=1)
    platform = PlatformInBodyAxes(model, hub_mass=0.2, damping=0.05)
    assert np.all(run.elongation_m < full - platform.stowed)
    solved = solve_ivp(platform, (0.0, 0.25), platform.start(), method="DOP853", t_eval=run.time_s, rtol=1e-10, atol=1e-12)
    centre = np.asarray(model.platform.centre_of_mass_m)
    rotations = np.moveaxis(solved.y[3:12].reshape(3, 3, -1), -1, 0)
    place = solved.y[:3].T - rotations @ centre
    quaternion = run.samples[:, 3:7]
    ours = Rotation.from_quat(quaternion, scalar_first=True)
    apart = (ours * Rotation.from_matrix(rotations).inv()).magnitude()
    ours_place = np.column_stack([run.channels[name] for name in ("x_m", "y_m", "z_m")])
    bound = 1e-6 if moving else 1e-9
    assert np.max(np.abs(ours_place - place)) < bound
    assert np.max(apart) < bound
    assert np.max(np.abs(run.channels["theta_z_rad"])) > 0.1, "nothing turned, nothing was tested"
