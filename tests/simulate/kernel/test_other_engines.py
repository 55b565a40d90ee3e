"""The platform in other engines: MuJoCo, legs as tendons, and DOP853; law, stops and effects driven from outside.

Every formula stands here a second time, in NumPy, so that a wrong one cannot agree with itself.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import erf

from measure.common.errors import InputError
from simulate import effects as known
from simulate.control.synchronise import Synchronise
from simulate.deployment.deploy import deploy, deploy_checked
from simulate.deployment.mujoco_export import mjcf_of, require_expressed
from simulate.effects import AirDrag
from simulate.model.model import EndStop, Release, Simulation, per_leg

try:
    import mujoco as found
except ImportError:
    found = None
mujoco: Any = found
with_mujoco = pytest.mark.skipif(mujoco is None, reason="MuJoCo is not installed: it comes with make test")


def random_rig(prototype, seed):
    """The prototype with everything that both engines can express drawn anew, every effect that can among it."""
    rng = np.random.default_rng(seed)
    law, g = prototype.actuator, prototype.geometry

    def near(values, spread):
        return tuple(tuple(row) for row in np.asarray(values) + rng.uniform(-spread, spread, np.shape(values)))

    def size(low, high):
        return float(rng.uniform(low, high))

    b = rng.uniform(2.8, 2.84, 6)
    acting = (
        known.HubInertia(size(0.1, 0.8)),
        known.ViscousFriction(size(0.02, 0.2)),
        known.PowerLawFriction(size(0.02, 0.2), size(1.5, 2.5)),
        known.StribeckFriction(size(0.005, 0.02), size(0.1, 0.3)),
        known.TransitionZone(size(0.05, 0.2), size(0.03, 0.1)),
        known.ForceRelaxation(size(0.01, 0.05), size(0.1, 1.0)),
        known.CurvedAsymptotes(size(-1.0, 1.0), size(-2.0, 2.0)),
        known.RateDependentAsymptotes(b_l=(size(-0.1, 0.0), 0.02), b_u=(size(0.0, 0.1), 0.02)),
        known.LegDisparity(tuple(rng.uniform(-0.01, 0.01, 6))),
        known.EndStopDissipation(size(0.0, 5.0)),
        known.CentreOfMassOffset(tuple(rng.uniform(-0.003, 0.003, 3))),
        known.GravityImbalance(size(-0.2, 0.2)),
        known.PulleyFriction(size(0.02, 0.1)),
        known.CablePendulum(size(20.0, 60.0)),
        known.AirDrag(size(0.05, 0.2)),
        known.HandrailContact(0.002, size(100.0, 500.0)),
        known.BaseExcitation(size(0.1, 0.5), size(3.0, 20.0), size(0.0, 3.0), (0.6, 0.0, 0.8)),
        known.ReleasePose(tuple(rng.uniform(-0.002, 0.002, 3)), tuple(rng.uniform(-0.01, 0.01, 3)), (0.0,) * 3),
    )
    return replace(
        prototype,
        geometry=replace(g, base_joints_m=near(g.base_joints_m, 0.02), platform_joints_m=near(g.platform_joints_m, 0.005)),
        platform=replace(prototype.platform, inertia_kg_m2=tuple(rng.uniform(0.003, 0.005, 3))),
        actuator=replace(law, b_l_N=tuple(b), b_u_N=tuple(b + 0.1), initial_force_N=tuple(b + rng.uniform(0, 0.2, 6))),
        end_stop=EndStop(3000.0, 10.0, 1e-3),
        gravity=replace(prototype.gravity, acceleration_m_per_s2=size(-0.3, 0.3)),
        release=Release(theta_rad=tuple(rng.uniform(-0.01, 0.01, 3))),
        effects=acting,
        simulation=Simulation(0.9, 100.0, 1e-4),
    )


class Driven:
    """What the six motors and the hand at the centre of mass do, written down anew; `length` is that of the legs at the release."""

    def __init__(self, model, length):
        self.model, self.at = model, model.adjusted()
        g, law = self.at.geometry, self.at.actuator
        base = np.asarray(g.base_joints_m)
        self.stowed, full = (np.linalg.norm(np.add(g.platform_joints_m, (0, 0, h)) - base, axis=1) for h in (0.252, 0.652))
        self.stroke = full - self.stowed
        self.lines = [per_leg(v) for v in (law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N)]
        self.beta, self.force = per_leg(law.beta_per_m), per_leg(law.initial_force_N)
        self.before = length - self.stowed
        self.lowest = np.minimum(self.before, 0.0)
        self.moving = self.at.platform.mass_kg * self.at.gravity.mass_factor

    def of(self, kind):
        return self.model.effect(kind)

    def asymptotes(self, u, v):
        a_l, b_l, a_u, b_u = self.lines
        curved, rate = self.of(known.CurvedAsymptotes), self.of(known.RateDependentAsymptotes)
        bend = curved.quadratic_N_per_m2 * u**2 + curved.cubic_N_per_m3 * u**3
        lower = a_l * u + b_l + bend + rate.b_l[0] * np.abs(v) + rate.b_l[1] * v**2
        return lower, a_u * u + b_u + bend + rate.b_u[0] * np.abs(v) + rate.b_u[1] * v**2

    def hysteretic(self, u, v):
        """dR/du = beta (h - R) uncoiling, beta (R - h) coiling, h straight over the short way since the last step."""
        way = u - self.before
        h0, h1 = (np.where(way > 0, *self.asymptotes(at, v)) for at in (self.before, u))
        x = self.beta * np.abs(way)
        slope = np.divide(h1 - h0, x, out=np.zeros(6), where=x > 0)
        return h1 - slope + (self.force - h0 + slope) * np.exp(-x)

    def along_the_legs(self, force, u, v, t):
        zone, relaxed = self.of(known.TransitionZone), self.of(known.ForceRelaxation)
        power, dry = self.of(known.PowerLawFriction), self.of(known.StribeckFriction)
        total = force * (1 - relaxed.fraction * (1 - np.exp(-t / relaxed.time_s)))
        total -= zone.force_N * np.exp(-np.maximum(u, 0.0) / zone.length_m)
        total -= power.coefficient * np.sign(v) * np.abs(v) ** power.exponent
        total -= dry.force_N * np.tanh(v / 2e-3) * np.exp(-((v / dry.speed_m_per_s) ** 2))
        stop = self.at.end_stop
        over, under = np.maximum(u - self.stroke, 0.0), np.maximum(self.lowest - u, 0.0)
        spring = stop.stiffness_N_per_m * (under - over) - stop.damping_N_s_per_m * v
        return total + spring * erf((over + under) / stop.smoothing_m)

    def at_the_centre(self, place, velocity, t):
        rails, shaken = self.of(known.HandrailContact), self.of(known.BaseExcitation)
        speed = np.linalg.norm(velocity)
        force = -self.of(known.AirDrag).coefficient_kg_per_m * speed * velocity
        force[2] += self.of(known.GravityImbalance).force_N - self.of(known.PulleyFriction).force_N * np.tanh(velocity[2] / 2e-3)
        force[:2] -= self.of(known.CablePendulum).stiffness_N_per_m * place[:2]
        swing = np.sin(2 * np.pi * shaken.frequency_Hz * t + shaken.phase_rad)
        force -= self.moving * shaken.acceleration_m_per_s2 * swing * np.array(shaken.axis)
        off = np.hypot(*place[:2])
        push = rails.stiffness_N_per_m * max(off - rails.clearance_m, 0.0)
        force -= 0.2 * push * velocity / np.sqrt(speed**2 + 0.005**2)
        force[:2] -= push * place[:2] / max(off, 1e-12)
        return force

    def __call__(self, engine, data):
        u, v = data.ten_length - self.stowed, data.ten_velocity
        data.ctrl[:] = self.along_the_legs(self.hysteretic(u, v), u, v, data.time)
        velocity = np.empty(6)  # angular, linear, of the centre of mass
        mujoco.mj_objectVelocity(engine, data, mujoco.mjtObj.mjOBJ_BODY, 1, velocity, 0)
        data.xfrc_applied[1, :3] = self.at_the_centre(data.xipos[1], velocity[3:], data.time)


class Braked(Driven):
    """The same with brakes that keep the legs together: F = -s clip(s (k (u - mean u) + d (v - mean v)), 0, limit), s = tanh(v / v_0)."""

    def along_the_legs(self, force, u, v, t):
        c, side = self.model.controller, np.tanh(v / self.model.controller.brake_speed_m_per_s)
        ahead = c.stiffness_N_per_m * (u - u.mean()) + c.damping_N_s_per_m * (v - v.mean())
        brakes = -side * np.clip(side * ahead, 0.0, c.force_limit_N)
        return super().along_the_legs(force, u, v, t) + brakes


def played_in_mujoco(model, samples, drive=Driven):
    """Position and quaternion of the platform frame at our samples, from MuJoCo's RK4."""
    engine = mujoco.MjModel.from_xml_string(mjcf_of(replace(model, controller=None)))
    data = mujoco.MjData(engine)
    mujoco.mj_forward(engine, data)
    driven, poses = drive(model, data.ten_length), []
    mujoco.set_mjcb_control(driven)
    try:
        for step in range(100 * (samples - 1) + 1):
            if step % 100 == 0:
                poses.append(data.qpos.copy())
            mujoco.mj_step(engine, data)
            mujoco.mj_fwdPosition(engine, data)
            mujoco.mj_fwdVelocity(engine, data)
            u = data.ten_length - driven.stowed
            driven.force, driven.before = driven.hysteretic(u, data.ten_velocity), u.copy()
    finally:
        mujoco.set_mjcb_control(None)
    return np.array(poses)


@with_mujoco
@pytest.mark.parametrize("seed", [pytest.param(seed, marks=pytest.mark.calibrate if seed else pytest.mark.slow) for seed in range(10)])
def test_elevation_and_theta_z_agree_with_mujoco_up_to_full_height_with_every_effect_both_can_express(prototype, seed):
    model = random_rig(prototype, seed)
    run = deploy(model)
    assert run.time_to_full_height_s is not None
    samples = round(100 * run.time_to_full_height_s) + 1
    poses = played_in_mujoco(model, samples)
    assert np.max(np.abs(poses[:, 2] - run.channels["z_m"][:samples])) < 1e-5
    theta_z = np.unwrap(2 * np.arctan2(poses[:, 6], poses[:, 3]))
    assert np.max(np.abs(np.degrees(theta_z - run.channels["theta_z_rad"][:samples]))) < 0.01
    assert np.max(np.abs(np.degrees(theta_z))) > 1.0, "nothing turned, nothing was tested"


@with_mujoco
@pytest.mark.calibrate
@pytest.mark.parametrize("seed", range(5))
def test_synchronised_brakes_hold_the_platform_in_mujoco_as_here_up_to_full_height(prototype, seed):
    rig = random_rig(prototype, seed)
    free = replace(rig, effects=tuple(effect for effect in rig.effects if not isinstance(effect, known.StribeckFriction)))
    model = replace(free, controller=Synchronise(stiffness_N_per_m=1000.0, damping_N_s_per_m=20.0, force_limit_N=1.0))
    run = deploy(model)
    assert run.time_to_full_height_s is not None
    samples = round(100 * run.time_to_full_height_s) + 1
    poses = played_in_mujoco(model, samples, Braked)
    theta_z, held = np.unwrap(2 * np.arctan2(poses[:, 6], poses[:, 3])), run.channels["theta_z_rad"][:samples]
    assert np.max(np.abs(poses[:, 2] - run.channels["z_m"][:samples])) < 1e-5
    assert np.max(np.abs(np.degrees(theta_z - held))) < 0.02
    assert np.max(np.abs(deploy(free).channels["theta_z_rad"][:samples] - held)) > np.radians(0.5), "the brakes did something"


@pytest.mark.slow
def test_each_of_these_effects_is_felt_far_beyond_that_agreement(prototype):
    models = [random_rig(prototype, seed) for seed in range(3)]
    whole = [deploy(model) for model in models]
    for k, effect in enumerate(models[0].effects):
        changed = []
        for model, run in zip(models, whole, strict=True):
            less = deploy(replace(model, effects=tuple(e for e in model.effects if e.name != effect.name)))
            until = round(100 * (run.time_to_full_height_s or 0.0)) + 1
            z, turn = (np.max(np.abs(less.channels[c][:until] - run.channels[c][:until])) for c in ("z_m", "theta_z_rad"))
            changed.append(z > 1e-4 or np.degrees(turn) > 0.1)
        # the stop is met before full height by some of the rigs only
        assert any(changed) or effect.name == "end-stop-dissipation", (k, effect.name)


class OnPaper:
    """Newton and Euler in world axes with the hysteretic force as a state: position, rotation matrix, velocity, spin, six R."""

    def __init__(self, model):
        self.model, self.at = model, model.adjusted()
        g, body, factor = self.at.geometry, self.at.platform, self.at.gravity.mass_factor
        self.base, self.centre = np.asarray(g.base_joints_m), np.asarray(body.centre_of_mass_m)
        self.joints = np.asarray(g.platform_joints_m) - self.centre
        self.inertia = np.diag(body.inertia_kg_m2) * factor
        self.mass = body.mass_kg * factor * np.ones(3)
        light = model.effect(known.CounterweightInertia).lateral_mass_factor
        self.mass[:2], self.inertia = self.mass[:2] * light, self.inertia * light
        self.mass[2] += model.effect(known.PulleyInertia).mass_kg
        self.weight = -body.mass_kg * self.at.gravity.acceleration_m_per_s2
        self.driven = Driven(model, np.linalg.norm(self.legs(self.start())[0], axis=1))

    def start(self):
        r, g = self.at.release, self.at.geometry
        rotation = Rotation.from_rotvec(r.theta_rad).as_matrix()
        place = np.array([0.0, 0.0, g.stowed_height_m]) + r.position_m + rotation @ self.centre
        return np.concatenate([place, rotation.ravel(), np.zeros(6), per_leg(self.at.actuator.initial_force_N)])

    def legs(self, y):
        arms = self.joints @ y[3:12].reshape(3, 3).T
        return y[:3] + arms - self.base, arms

    def __call__(self, t, y):
        place, rotation, velocity, spin, force = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:]
        legs, arms = self.legs(y)
        length = np.linalg.norm(legs, axis=1)
        axis = legs / length[:, None]
        moving = velocity + np.cross(spin, arms)
        v, u = np.einsum("ij,ij->i", axis, moving), length - self.driven.stowed
        hub, viscous = (self.model.effect(kind).flat()[0] for kind in (known.HubInertia, known.ViscousFriction))
        turning = np.einsum("ij,ij->i", axis, np.cross(spin, np.cross(spin, arms))) + (np.sum(moving**2, axis=1) - v**2) / length
        push = self.driven.along_the_legs(force, u, v, t) - viscous * v - hub * turning
        jacobian = np.hstack([axis, np.cross(arms, axis)])
        turned = rotation @ self.inertia @ rotation.T
        matrix = hub * jacobian.T @ jacobian
        matrix[:3, :3] += np.diag(self.mass)
        matrix[3:, 3:] += turned
        right = jacobian.T @ push
        right[:3] += self.driven.at_the_centre(place, velocity, t) + np.array([0.0, 0.0, self.weight])
        right[3:] -= np.cross(spin, turned @ spin)
        cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
        lower, upper = self.driven.asymptotes(u, v)
        rate = self.driven.beta * np.where(v > 0, v * (lower - force), v * (force - upper))
        return np.concatenate([velocity, (cross @ rotation).ravel(), np.linalg.solve(matrix, right), rate])


def on_paper(model, time_s):
    """Position of the platform frame (n, 3) and theta_z (n,) from DOP853."""
    platform = OnPaper(model)
    solved = solve_ivp(platform, (0.0, time_s[-1]), platform.start(), method="DOP853", t_eval=time_s, rtol=1e-10, atol=1e-12)
    rotations = solved.y[3:12].T.reshape(-1, 3, 3)
    w, z = Rotation.from_matrix(rotations).as_quat(canonical=True, scalar_first=True)[:, [0, 3]].T
    return solved.y[:3].T - rotations @ platform.centre, np.unwrap(2 * np.arctan2(z, w))


def require_agreement(model):
    """Our error is what the run itself states, but for what DOP853 leaves at kinks."""
    run = deploy_checked(model)
    place, theta_z = on_paper(model, run.time_s)
    assert run.step_error is not None
    stated = run.step_error.whole
    for k, name in enumerate(("x_m", "y_m", "z_m")):
        assert np.max(np.abs(place[:, k] - run.channels[name])) <= 1.1 * stated[name] + 1e-8, name
    assert np.max(np.abs(theta_z - run.channels["theta_z_rad"])) <= 1.1 * stated["theta_z_rad"] + 1e-7


ALONE = (
    *("hub-inertia", "viscous-friction", "power-law-friction", "stribeck-friction", "transition-zone", "force-relaxation"),
    *("curved-asymptotes", "rate-dependent-asymptotes", "leg-disparity", "end-stop-dissipation", "centre-of-mass-offset"),
    *("gravity-imbalance", "pulley-friction", "cable-pendulum", "air-drag", "handrail-contact", "base-excitation", "release-pose"),
    *("pulley-inertia", "counterweight-inertia"),
)


@pytest.mark.calibrate
@pytest.mark.parametrize("name", ALONE)
def test_with_each_effect_alone_dop853_agrees_within_the_stated_error(prototype, name):
    rig = random_rig(prototype, 3)
    more = {"pulley-inertia": known.PulleyInertia(0.2), "counterweight-inertia": known.CounterweightInertia(0.6)}
    acting = (*(effect for effect in rig.effects if effect.name in (name, "release-pose")), *([more[name]] if name in more else []))
    require_agreement(replace(rig, effects=acting, simulation=Simulation(0.25, 100.0)))


@pytest.mark.parametrize("seed", [pytest.param(0, marks=pytest.mark.slow), pytest.param(1, marks=pytest.mark.calibrate)])
def test_with_all_effects_at_once_dop853_agrees_within_the_stated_error_over_stops_and_rebound(prototype, seed):
    require_agreement(replace(random_rig(prototype, seed), simulation=Simulation(0.8, 100.0)))


def test_an_effect_that_mjcf_cannot_express_is_refused_and_not_left_out(lopsided):
    require_expressed(lopsided)
    with pytest.raises(InputError, match="air-drag"):
        require_expressed(lopsided.with_effect(AirDrag(0.1)))


def test_an_inertia_that_no_body_has_is_refused(prototype):
    flat = replace(prototype, platform=replace(prototype.platform, inertia_kg_m2=(0.0015, 0.0015, 0.0032)))
    with pytest.raises(InputError, match=r"0\.0032 is above the sum"):
        require_expressed(flat)
    require_expressed(prototype)
