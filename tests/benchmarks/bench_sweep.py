"""How long the full design of 4096 deployments takes here, beside other engines, and how exact it is.

    python tests/benchmarks/bench_sweep.py [model.toml]

All in one run, because speeds differ from machine to machine and from hour to hour: read the ratios. Times are processor
seconds of all threads together, which neighbours on the machine disturb least. Other engines do a part of the design and are
scaled up. MuJoCo runs its own C code on all cores (legs as tendons with armature and damping, RK4,
0.5 ms) with a constant force, without law, memory and stops: a floor of what it would need.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from scipy.integrate import solve_ivp

from simulate.control.eddy_damper import EddyDamper
from simulate.control.mechanical_link import MechanicalLink
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.effects import (
    CATALOGUE,
    AirDrag,
    Backlash,
    BaseExcitation,
    CablePendulum,
    CounterweightInertia,
    CurvedAsymptotes,
    EddyDamping,
    FlexibleBase,
    ForceRelaxation,
    GravityImbalance,
    HandrailContact,
    JointFriction,
    LegMass,
    PowerLawFriction,
    PulleyInertia,
    RateDependentAsymptotes,
    Ripple,
    SeriesPlay,
    StribeckFriction,
    TransitionZone,
)
from simulate.files.model_file import read_model
from simulate.model import responses
from simulate.model.control import Controller
from simulate.model.effect import Effect
from simulate.model.model import Model, per_leg
from simulate.sweeps.designs import design_of
from simulate.sweeps.factors import paper_factors
from simulate.sweeps.step_search import choose_step
from simulate.sweeps.sweep import Sweep, run_on

RUNS = 4096

# Effects so slight that the motion, and so the number of steps, stays what it is.
SLIGHT: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        GravityImbalance(1e-3), AirDrag(1e-3), CablePendulum(1e-3), HandrailContact(0.02, 1e-2), BaseExcitation(1e-4),
        CounterweightInertia(0.999), PulleyInertia(1e-4), EddyDamping(1e-4, 0.1), PowerLawFriction(1e-4, 2.0), StribeckFriction(1e-5, 0.05),
        TransitionZone(1e-4, 0.08), ForceRelaxation(1e-4, 0.3), Ripple(1e-5, 0.05), Backlash(1e-6), CurvedAsymptotes(1e-3, 1e-3),
        RateDependentAsymptotes(b_l=(1e-4, 0.0)), SeriesPlay(1e-6), LegMass(1e-4), JointFriction(1e-6, 1e-6), FlexibleBase(1e3, 5.0),
    )
}  # fmt: skip

_GAINS: dict[str, Any] = {"stiffness_N_per_m": 1000.0, "damping_N_s_per_m": 20.0}
CONTROLLERS: dict[str, Controller] = {
    "eddy-damper": EddyDamper(damping_N_s_per_m=5.0),
    "mechanical-link": MechanicalLink(**_GAINS),
    "synchronise, motors": Synchronise(**_GAINS, force_limit_N=1.0, actuator="motor"),
    "synchronise, brakes": Synchronise(**_GAINS, force_limit_N=1.0),
    "profile, brakes of 5 N": Profile(duration_s=1.0, **_GAINS, force_limit_N=5.0),
    "one-way, 10 N": OneWay(clutch_force_N=10.0),
    "brakes sampled at 1 kHz": Synchronise(**_GAINS, force_limit_N=1.0, sample_rate_Hz=1000.0),
    "and noise, delay, lag, observer": Synchronise(
        **_GAINS, force_limit_N=1.0, sample_rate_Hz=1000.0, sensor_noise_m=1e-4, delay_s=2e-3, lag_s=5e-3, observer_Hz=60.0
    ),
}


def seconds(work: Callable[[], object], times: int = 1) -> float:
    """Fewest processor seconds of some calls, all threads together."""
    shortest = np.inf
    for _ in range(times):
        started = time.process_time()
        work()
        shortest = min(shortest, time.process_time() - started)
    return float(shortest)


def full_design(model: Model) -> Sweep:
    """The paper's design."""
    return Sweep(model, tuple(paper_factors(model)), design_of("full", 12, None, 0))


def answers_of(sweep: Sweep) -> np.ndarray:
    """Largest signed theta_z of all runs, degrees."""
    parts = [answers for _, answers in run_on(sweep)]
    return np.degrees(np.concatenate(parts)[:, responses.THETA_Z])


def rk45_seconds(model: Model) -> float:
    """One run with solve_ivp RK45 at rtol 1e-6 and a right-hand side in NumPy, R as a state: what one would write."""
    from math import erf

    g, law = model.geometry, model.actuator
    assert g is not None
    base, joints = np.asarray(g.base_joints_m), np.asarray(g.platform_joints_m)
    stowed, full = (np.linalg.norm(np.add(joints, (0.0, 0.0, h)) - base, axis=1) for h in (g.stowed_height_m, g.deployed_height_m))
    mass = model.platform.mass_kg * model.gravity.mass_factor
    inertia = np.asarray(model.platform.inertia_kg_m2) * model.gravity.mass_factor
    hub, damping = (float(effect.flat()[0]) for effect in model.effects[:2])
    stop = model.end_stop
    lines = [per_leg(v) for v in (law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m)]

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        place, rotation, velocity, spin, force = y[:3], y[3:12].reshape(3, 3), y[12:15], y[15:18], y[18:]
        arms = joints @ rotation.T
        legs = place + arms - base
        length = np.linalg.norm(legs, axis=1)
        axis = legs / length[:, None]
        moving = velocity + np.cross(spin, arms)
        v = np.einsum("ij,ij->i", axis, moving)
        past = length - full
        eased = np.array([erf(max(p, 0.0) / stop.smoothing_m) for p in past])
        push = force - damping * v - (stop.stiffness_N_per_m * past + stop.damping_N_s_per_m * v) * eased
        bias = np.einsum("ij,ij->i", axis, np.cross(spin, np.cross(spin, arms))) + (np.sum(moving**2, axis=1) - v**2) / length
        jacobian = np.hstack([axis, np.cross(arms, axis)])
        turned = rotation @ np.diag(inertia) @ rotation.T
        matrix = hub * jacobian.T @ jacobian
        matrix[:3, :3] += mass * np.eye(3)
        matrix[3:, 3:] += turned
        right = jacobian.T @ (push - hub * bias)
        right[3:] -= np.cross(spin, turned @ spin)
        cross = np.array([[0, -spin[2], spin[1]], [spin[2], 0, -spin[0]], [-spin[1], spin[0], 0]])
        u = length - stowed
        a_l, b_l, a_u, b_u, beta = lines
        force_rate = beta * np.where(v > 0, v * (a_l * u + b_l - force), v * (force - a_u * u - b_u))
        return np.concatenate([velocity, (cross @ rotation).ravel(), np.linalg.solve(matrix, right), force_rate])

    start = np.concatenate([[0, 0, g.stowed_height_m], np.eye(3).ravel(), np.zeros(6), per_leg(law.initial_force_N)])
    return seconds(lambda: solve_ivp(rate, (0.0, 1.0), start, method="RK45", rtol=1e-6, atol=1e-9))


def mujoco_seconds(model: Model, runs: int) -> float | None:
    """So many runs of MuJoCo's own stepping on all cores, without law and stops, or None where it is not installed."""
    try:
        import mujoco
    except ImportError:
        return None
    import importlib

    rollout: Any = importlib.import_module("mujoco.rollout")
    mujoco = cast(Any, mujoco)

    from simulate.deployment.mujoco_export import mjcf_of

    small, _, _ = model.platform.inertia_kg_m2
    model = replace(model, platform=replace(model.platform, inertia_kg_m2=(small, small, 1.9 * small)))  # MuJoCo wants a possible body
    engine = mujoco.MjModel.from_xml_string(mjcf_of(model).replace('timestep="0.0001"', 'timestep="0.0005"'))
    threads = os.cpu_count() or 1
    memory = [mujoco.MjData(engine) for _ in range(threads)]
    mujoco.mj_forward(engine, memory[0])
    size = mujoco.mj_stateSize(engine, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    state = np.empty(size)
    mujoco.mj_getState(engine, memory[0], state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    starts, control = np.repeat(state[None], runs, axis=0), np.full((runs, 1000, 6), 2.79)
    with rollout.Rollout(nthread=threads) as pool:
        return 2 * seconds(lambda: pool.rollout(engine, memory, starts, control))  # half a second each: no stop is met


def main() -> None:
    """Print the table."""
    model = read_model(Path(sys.argv[1] if len(sys.argv) > 1 else "datasets/prototype.toml"))
    found = choose_step(full_design(model), 30.0)
    sweep = found.sweep
    ours = seconds(lambda: answers_of(sweep), 3)
    half = replace(sweep, longest_s=sweep.longest_s / 2)
    rk45, others = rk45_seconds(sweep.model_at(sweep.design.piece(1234, 1235)[0])) * RUNS, mujoco_seconds(model, 64)
    print(f"this project, {RUNS} runs, {1e3 * sweep.pace.frame:.3g} ms                  {ours:9.2f} s      1")
    print(f"the same with half the step                            {seconds(lambda: answers_of(half)):9.2f} s")
    print(f"solve_ivp RK45, rtol 1e-6, run by run (1 run scaled)   {rk45:9.2f} s {rk45 / ours:6.0f}")
    if others is not None:
        print(f"MuJoCo, C, all cores, no law, no stops (64 runs scaled) {others * RUNS / 64:8.2f} s {others * RUNS / 64 / ours:6.1f}")
    print_costs(sweep.model, ours)
    print_first_start()
    print("step tried on the design:", found.report)
    print_errors(model, sweep)
    for name, controller in CONTROLLERS.items():
        print(f"with a controller: {name}; ", end="")
        print_errors(model, full_design(replace(model, controller=controller)), 2)


def print_costs(model: Model, ours: float) -> None:
    """Cost over runs and over effects: a block of each, as a share of the whole design with the model's own effects."""
    for runs in (512, 1024, 2048):
        took = seconds(lambda runs=runs: full_design(model).responses(0, runs), 3)
        print(f"{runs} runs of them, for each run                          {took / ours * RUNS / runs:19.2f}")
    idle = tuple(kind() for name, kind in CATALOGUE.items() if name not in [effect.name for effect in model.effects])
    five = ("gravity-imbalance", "air-drag", "cable-pendulum", "power-law-friction", "transition-zone")
    print_ratio("whole catalogue, switched off", model, replace(model, effects=(*model.effects, *idle)))
    for n in range(1, len(five) + 1):
        acting = tuple(SLIGHT[name] for name in five[:n])
        print_ratio(f"{n} effects more", model, replace(model, effects=(*model.effects, *acting)))
    for name, effect in SLIGHT.items():
        print_ratio(f"with {name}", model, replace(model, effects=(*model.effects, effect)))
    for name, controller in CONTROLLERS.items():
        print_ratio(f"with a controller: {name}", model, replace(model, controller=controller))


def print_ratio(what: str, model: Model, other: Model, runs: int = 512) -> None:
    """Time of runs of the design with another model, as a share of the time with this one, by turns."""
    sweeps, took = [full_design(model), full_design(other)], [np.inf, np.inf]
    for sweep in sweeps:
        sweep.responses(0, 16)
    for _ in range(3):
        for i, sweep in enumerate(sweeps):
            took[i] = min(took[i], seconds(lambda sweep=sweep: sweep.responses(0, runs)))
    frames = "" if sweeps[1].pace[:2] == sweeps[0].pace[:2] else f"   steps up to {1e3 * sweeps[1].pace.frame:.2g} ms"
    print(f"{what:55}{took[1] / took[0]:19.2f}{frames}")


def print_first_start() -> None:
    """Seconds of the first deployment and the first sweep where no compiled kernel is kept."""
    code = (
        "import sys, time; from pathlib import Path; sys.path.insert(0, 'tests/benchmarks'); import bench_sweep as b\n"
        "from simulate.deployment.deploy import deploy\n"
        "model = b.read_model(Path('datasets/prototype.toml'))\n"
        "started = time.process_time(); deploy(model); one = time.process_time(); b.full_design(model).responses(0, 16)\n"
        "print(f'first start, one deployment {one - started:.1f} s, first sweep {time.process_time() - one:.1f} s of compilation')"
    )
    with tempfile.TemporaryDirectory() as kept:
        subprocess.run([sys.executable, "-c", code], env={**os.environ, "NUMBA_CACHE_DIR": kept}, check=True)


def print_errors(model: Model, sweep: Sweep, blocks: int = 8) -> None:
    """Error of theta_z against a sixteenth of the step, balanced stored forces (sum of signs zero) apart: they are unstable."""
    fine = replace(sweep, longest_s=sweep.longest_s / 16)
    runs = np.random.default_rng(0).permutation(RUNS // 64)[:blocks] * 64
    apart, balanced = [], []
    for first in runs:
        coded = sweep.design.piece(int(first), int(first) + 64)
        error = np.degrees(np.abs(sweep.responses(first, first + 64) - fine.responses(first, first + 64))[:, responses.THETA_Z])
        balanced.append(coded[:, ::2] @ (1, -1, 1, -1, 1, -1) == 0)
        apart.append(error)
    error, even = np.concatenate(apart), np.concatenate(balanced)
    print(f"error of theta_z, {len(error)} runs: largest {error[~even].max():.2g} deg; balanced ones {error[even].max():.2g} deg")


if __name__ == "__main__":
    main()
