"""Makes everything in this folder: `python datasets/make_datasets.py [FOLDER]`. Same seed, same bytes.

    prototype.toml          the rig of the paper as far as it can be inferred (infer_prototype.py), every value labelled
    demo/rig.toml           the rig of the demonstration, as its engineer knows it
    demo/loops/*.csv        six loops of one of its actuators
    demo/film.avi           a deployment, filmed;  demo/film.toml  camera and marks
    demo/deployment-2.csv   another one, from a greater height
    demo/deployment-3.csv   another one with ballast, to be held out
    demo/campaign.toml      the list of runs

In the demonstration one effect acts that rig.toml does not know. It is drawn and sized here, and nothing else knows it.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from identify.estimation.observation import RunRelease, View, observe, released
from measure.common.output import write_text
from measure.geometry.film_project import write_project
from measure.synthetic.made_film import deployment_scene, project_for, render
from measure.tables.loop import Loop, write_loop
from measure.tables.trajectory import Trajectory, write_trajectory
from simulate.deployment.deploy import deploy
from simulate.effects import HubInertia, ViscousFriction
from simulate.files.model_file import write_model
from simulate.loop import loop_force
from simulate.model.effect import Effect
from simulate.model.model import (
    Actuator,
    EndStop,
    Geometry,
    Gravity,
    Model,
    Nuisance,
    Platform,
    Simulation,
    with_value,
)

SEED = 2009
FPS = 250.0
FRAMES = 150
HIDDEN = HubInertia(0.01)
WAIT_S = 0.02  # the camera runs before the platform is let go

FORCE_SIGMA_N = 2.0e-3
LASER_SIGMA_M = 1.0e-5
CAMERA_SIGMA_M, CAMERA_SIGMA_RAD = 4.0e-6, 6.0e-5

PROTOTYPE_HEAD = """\
# The tape-spring hexapod of Aridon et al., J. Mech. Des. 131 (2009) 021003, as far as its paper tells.
#
# printed in the paper   platform.mass_kg, geometry.stowed_height_m and deployed_height_m (652 mm deployed, 400 mm of stroke),
#                        actuator.b_l_N (centre of 2.51 to 3.07 N), b_u_N (0.1 N above), initial_force_N,
#                        gravity.mass_factor (counterweight), simulation (1 s at 1 kHz)
# inferred, not measured geometry.base_joints_m and platform_joints_m, platform.inertia_kg_m2, end_stop.stiffness_N_per_m and
#                        damping_N_s_per_m, hub-inertia, viscous-friction: searched by infer_prototype.py, so that the model gives
#                        back the main effects, the triple terms and the time to full height that are printed
# assumed                actuator.a_l_N_per_m, a_u_N_per_m and beta_per_m, end_stop.smoothing_m, platform.centre_of_mass_m, release:
#                        without influence on what is printed
"""


def ring(radius_m: float, angles_deg: np.ndarray) -> tuple[tuple[float, float, float], ...]:
    """Six joints on a circle, rounded to a micrometre."""
    a = np.radians(angles_deg)
    return tuple((round(float(radius_m * np.cos(x)), 6), round(float(radius_m * np.sin(x)), 6), 0.0) for x in a)


def hexapod(base_radius_m: float, base_deg: float, platform_radius_m: float, platform_deg: float) -> Geometry:
    """Three pairs of legs, each pair mirrored in a vertical plane, turned by a third against each other; heights as printed."""
    third = 120.0 * np.arange(3)
    base = np.column_stack([third + base_deg, third + 120.0 - base_deg]).ravel()
    joints = np.column_stack([third + 60.0 - platform_deg, third + 60.0 + platform_deg]).ravel()
    return Geometry(ring(base_radius_m, base), ring(platform_radius_m, joints), 0.252, 0.652)  # type: ignore[arg-type]


def prototype() -> Model:
    """The inferred rig of the paper: what infer_prototype.py finds, rounded."""
    return Model(
        Actuator(-0.0374, 2.79, -0.0374, 2.89, 400.0, 2.987),
        name="prototype",
        platform=Platform(0.8, (0.0054, 0.0054, 0.00297)),
        geometry=hexapod(0.5396, 57.0, 0.030, 54.3),
        end_stop=EndStop(3500.0, 22.6, 1e-3),
        gravity=Gravity(0.0, 2.0),
        effects=(HubInertia(0.487), ViscousFriction(0.513)),
    )


def rig() -> Model:
    """The demonstration's rig: light spools, no grease, firm stops; its law is not known yet, only guessed."""
    return Model(
        Actuator(0.0, 2.8, 0.0, 2.9, 300.0, 2.8),
        name="demonstration rig",
        platform=Platform(0.8, (0.001516, 0.001516, 0.003164)),
        geometry=hexapod(0.53402, 41.401, 0.06527, 59.459),
        end_stop=EndStop(4000.0, 40.0, 1e-3),
        simulation=Simulation(0.6),
        nuisance=Nuisance(3e-4, 5e-4, 4e-3),
    )


def truth(hidden: Effect | None = HIDDEN) -> Model:
    """What the demonstration's data are made with."""
    law = Actuator(-0.12, 2.79, -0.10, 2.89, 400.0, 2.987)
    model = replace(rig(), actuator=law, simulation=Simulation(0.62, 2000.0, 2e-5))
    return model if hidden is None else model.with_effect(hidden)


def own_release(chance: np.random.Generator) -> RunRelease:
    """Where and when a run is let go, as the model file says that it may differ."""
    spread = rig().nuisance
    position, theta = chance.normal(0.0, spread.release_position_m, 3), chance.normal(0.0, spread.release_theta_rad, 3)
    return RunRelease(tuple(position.tolist()), tuple(theta.tolist()), float(chance.normal(0.0, spread.release_instant_s)))


def loop_of(model: Model, frequency_Hz: float, amplitude_m: float, chance: np.random.Generator) -> Loop:
    """Three cycles of a shaker test, 1000 samples: laser and load cell with their noise. Exact between two of 20000 points."""
    time = np.linspace(0.0, 3.0 / frequency_Hz, 20_001)
    w = 2 * np.pi * frequency_Hz
    u = 0.1 + amplitude_m * np.sin(w * time)
    law = model.actuator
    lines = np.array([law.a_l_N_per_m, law.b_l_N, law.a_u_N_per_m, law.b_u_N, law.beta_per_m])
    force = loop_force(lines, time, u, amplitude_m * w * np.cos(w * time), -amplitude_m * w**2 * np.sin(w * time), 2.84, model.effects)
    kept = slice(None, None, 20)
    noisy_u = u[kept] + chance.normal(0.0, LASER_SIGMA_M, len(u[kept]))
    noisy_force = force[kept] + chance.normal(0.0, FORCE_SIGMA_N, len(u[kept]))
    return Loop(np.round(time[kept], 7), np.round(noisy_u, 7), np.round(noisy_force, 5))


def seen_of(model: Model, release: RunRelease, chance: np.random.Generator) -> Trajectory:
    """A deployment as an earlier film gave it: x, z and roll in the rig's own axes, with the camera's noise."""
    time = np.arange(FRAMES) / FPS
    shown = observe(View(model, time, release))
    noise = {"x_m": CAMERA_SIGMA_M, "z_m": CAMERA_SIGMA_M, "theta_y_rad": CAMERA_SIGMA_RAD}
    channels = {name: np.round(shown[name] + chance.normal(0.0, sigma, FRAMES), 8) for name, sigma in noise.items()}
    return Trajectory(time, channels, {name: np.full(FRAMES, sigma) for name, sigma in noise.items()})


def film_motion(model: Model, release: RunRelease) -> Trajectory:
    """All six channels at 2 kHz from before the release on, for the camera; no spline reaches over the instant of release."""
    run = deploy(released(model, release))
    waits = np.arange(-round((WAIT_S + release.instant_s) * 2000.0), 0) / 2000.0
    channels = {name: np.concatenate([np.full(len(waits), values[0]), values]) for name, values in run.channels.items()}
    return Trajectory(np.concatenate([waits, run.time_s]) - waits[0], channels)


def make(folder: Path, hidden: Effect | None = HIDDEN) -> None:
    """Write all files; without a hidden effect they are what the rig's own model says, and its noise."""
    chance = np.random.default_rng(SEED)
    demo = folder / "demo"
    (demo / "loops").mkdir(parents=True, exist_ok=True)
    write_model(prototype(), folder / "prototype.toml")
    write_text(folder / "prototype.toml", PROTOTYPE_HEAD + (folder / "prototype.toml").read_text())
    write_model(rig(), demo / "rig.toml")
    model = truth(hidden)
    for frequency in (0.2, 1.0, 3.0):
        for amplitude in (0.010, 0.040):
            name = f"loop-{frequency:g}Hz-{2e3 * amplitude:g}mm.csv"
            write_loop(loop_of(model, frequency, amplitude, chance), demo / "loops" / name)
    make_film(model, own_release(chance), demo)
    higher = with_value(model, "geometry.stowed_height_m", 0.30)
    write_trajectory(seen_of(higher, own_release(chance), chance), demo / "deployment-2.csv")
    heavier = with_value(model, "platform.mass_kg", 1.0)
    write_trajectory(seen_of(heavier, own_release(chance), chance), demo / "deployment-3.csv")
    write_text(demo / "campaign.toml", CAMPAIGN)


def make_film(model: Model, release: RunRelease, demo: Path) -> None:
    """The film and the project file that a careful engineer would write for it."""
    scene = deployment_scene()
    render(film_motion(model, release), scene, demo / "film.avi", fps=FPS, seed=SEED, frames=FRAMES)
    write_project(project_for(scene, FPS, start_height_m=0.252), demo / "film.toml")


CAMPAIGN = """\
# The runs of the demonstration. The film's trajectory is put beside this list by the demonstration itself.

[[run]]
file = "film.csv"

[[run]]
file = "deployment-2.csv"
[run.model]
geometry.stowed_height_m = 0.30

[[run]]
file = "deployment-3.csv"
hold_out = true
[run.model]
platform.mass_kg = 1.0
""" + "".join(
    f'\n[[run]]\nfile = "loops/loop-{frequency}Hz-{stroke}mm.csv"\n' for frequency in ("0.2", "1", "3") for stroke in ("20", "80")
)


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
