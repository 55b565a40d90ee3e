"""What an effect does to a loop and to a deployment, drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from measure.common.arrays import Array
from simulate import Model, Release, Simulation, deploy, loop_force, read_model
from simulate.model.effect import Effect
from simulate.model.rig import LEGS

_RIG = Path(__file__).resolve().parents[2] / "datasets" / "demo" / "rig.toml"
_LAW = np.array([0.0, 2.8, 0.0, 2.9, 300.0])
_GREY, _COLOUR = "0.65", "#b5402b"
_STROKE_M, _CENTRE_M = 0.04, 0.2
_NOTHING = 1e-12
_LISTED = 12


def draw_effect(kind: type[Effect], file: Path) -> str:
    """Draw the figure of an effect, and say what it shows.

    Parameters
    ----------
    kind : the effect; it is drawn at its noticeable size, within its bounds.
    file : where the figure goes (SVG).

    Returns
    -------
    Sentences that name the size and the panels.
    """
    effect = at_size(kind)
    panels = [_draw_loops] if kind.acts_on_shaker() else []
    changes = _changes(effect)
    moves = any(np.any(np.abs(change) > _NOTHING) for change in changes.values())
    panels += [_draw_positions, _draw_rotations] if moves else []
    figure = Figure(figsize=(3.0 * len(panels), 3.0), layout="constrained")
    for draw, ax in zip(panels, figure.subplots(1, len(panels), squeeze=False)[0], strict=True):
        draw(ax, effect, changes)
    figure.savefig(file, metadata={"Date": None})
    return _sentences(effect, shaken=kind.acts_on_shaker(), moves=moves)


def _sentences(effect: Effect, *, shaken: bool, moves: bool) -> str:
    sizes = [f"`{name} = {value:.3g}`" for name, value in zip(effect.flat_names(), effect.flat(), strict=True)]
    size = ", ".join(sizes if len(sizes) <= _LISTED else [*sizes[:2], "and so on"])
    loop = "A loop at 0.2 Hz and one at 3 Hz; grey without the effect. " if shaken else "A loop does not show it. "
    return f"Drawn with {size}. {loop}" + ("Then what it changes in a deployment." if moves else "A deployment does not show it.")


def at_size(kind: type[Effect]) -> Effect:
    """The effect at a size that is noticed, with the middle one of the shapes from which a search starts."""
    shapes = kind().starts()
    shape = shapes[len(shapes) // 2]
    shaped = [item.name for item in fields(kind) if item.metadata["starts"]]
    of_shape = [name.split("[")[0] in shaped for name in kind.flat_names()]
    step = np.where(of_shape, 0.0, kind.typical() * _alternating(kind))
    low, high = np.array(list(kind.bounds(rig()).values())).T
    up, down = (np.clip(shape.flat() + sign * step, low, high) for sign in (1.0, -1.0))
    return shape.with_flat(np.where(up == shape.flat(), down, up))


def _alternating(kind: type[Effect]) -> Array:
    """Signs of the entries of a vector: six legs that all change alike would not turn the platform."""
    signs = np.ones(len(kind.flat_names()))
    if len(signs) >= LEGS:
        signs[1::2] = -1.0
    return signs


@cache
def rig() -> Model:
    """The rig of the demonstration, released a little off its centre so that every channel moves."""
    release = Release(position_m=(0.001, 0.0, 0.0), theta_rad=(0.001, 0.002, 0.001))
    return replace(read_model(_RIG), release=release, simulation=Simulation(duration_s=0.6, sample_rate_Hz=500.0))


@cache
def _without() -> tuple[Array, Mapping[str, Array]]:
    run = deploy(rig())
    return run.time_s, run.channels


def _seen(effect: Effect) -> Mapping[str, Array]:
    """The channels of a deployment with the effect, as the camera shows them."""
    run = deploy(rig().with_effect(effect))
    true_s = effect.true_time(run.time_s)
    at = {name: np.interp(true_s, run.time_s, values) for name, values in run.channels.items()}
    return effect.observe(run.time_s, at)


def _changes(effect: Effect) -> Mapping[str, Array]:
    """With the effect minus without, of every channel of a deployment."""
    before, after = _without()[1], _seen(effect)
    return {name: after[name] - before[name] for name in before}


def _draw_positions(ax: Any, effect: Effect, changes: Mapping[str, Array]) -> None:
    del effect
    ax.plot(_without()[0], 1e3 * changes["z_m"], label="elevation z", color=_COLOUR)
    ax.plot(_without()[0], 1e3 * changes["x_m"], label="lateral x", color="0.3")
    _labelled(ax, "time, s", "change of position, mm")


def _draw_rotations(ax: Any, effect: Effect, changes: Mapping[str, Array]) -> None:
    del effect
    ax.plot(_without()[0], np.degrees(changes["theta_z_rad"]), label="theta_z", color=_COLOUR)
    ax.plot(_without()[0], np.degrees(changes["theta_y_rad"]), label="theta_y", color="0.3")
    _labelled(ax, "time, s", "change of rotation, deg")


def _draw_loops(ax: Any, effect: Effect, changes: Mapping[str, Array]) -> None:
    del changes
    for frequency_Hz, style in ((0.2, "--"), (3.0, "-")):
        ax.plot(*_loop(frequency_Hz, ()), style, color=_GREY, linewidth=1.0)
        ax.plot(*_loop(frequency_Hz, (effect,)), style, color=_COLOUR, label=f"{frequency_Hz:g} Hz", linewidth=1.0)
    _labelled(ax, "elongation, mm", "force, N")


def _labelled(ax: Any, x: str, y: str) -> None:
    ax.set(xlabel=x, ylabel=y)
    ax.legend(frameon=False, fontsize="small")


def _loop(frequency_Hz: float, effects: tuple[Effect, ...]) -> tuple[Array, Array]:
    """Elongation in mm and force in N of the last of three cycles, as the load cell shows it."""
    time_s = np.linspace(0.0, 3.0 / frequency_Hz, 1501)
    omega = 2.0 * np.pi * frequency_Hz
    u = _CENTRE_M + _STROKE_M / 2 * np.sin(omega * time_s)
    v, a = _STROKE_M / 2 * omega * np.cos(omega * time_s), -_STROKE_M / 2 * omega**2 * np.sin(omega * time_s)
    force = loop_force(_LAW, time_s, u, v, a, 2.85, effects)
    for effect in effects:
        force = effect.observe_force(time_s, u, force)
    return 1e3 * u[1000:], force[1000:]
