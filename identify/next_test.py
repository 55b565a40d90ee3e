"""Which further test would split a class best: each is foreseen with the rivals' own fits, before anyone measures it.

The foremost effect makes the measurement, its rival is fitted to it along straight lines, with base, effects and the new
run's release free as far as everything measured before lets them; the most telling ones once more by full simulation.
What is left, in units of the noise, is what the test would show:

    delta^2 = min |g + J x|^2 + |R x|^2 + |release|^2

g the gap of the rival's model to the foremost one's, J its Jacobian and R the root of the information so far. The test moves
the lead by delta^2 +- 2 delta towards the one that is true. A lead excludes where it is above ten and above what the
other's truth would let it be once in a hundred times; either of the two may be the true one, as their leads so far and
their parameters say.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy import stats

from measure.tables import Loop, Trajectory
from simulate.model import Geometry, Model

from .campaign import Run
from .candidates import Candidate
from .fit import ROUGHLY, Fit, laid_out, solve
from .harmonic import harmonic_motion
from .loops import prepare
from .measured import Film, LoopRun
from .naming import RIVAL_P, STRONG_BIC
from .problem import Problem

_FURTHER = 0.2  # of the stroke that is left, above the start heights there are
_HEAVIER = 1.25
_OFF_CENTRE_M, _TILT_RAD, _TURN_RAD = (0.005, 0.02), (0.02, 0.06), (0.03, 0.1)
_FASTER, _WIDER = 2.0, 2.0
_FREE_LOOP = (1.0, 0.1, 1e-3, 1e-5)  # frequency in Hz, amplitude over the stroke, noise over the force and in m, where no loop was measured
_SAMPLES, _CYCLES = 400, 4
_FREE_FILM = (500.0, 1e-4, 5e-4)  # frames/s, noise in m and rad, where no film was taken
_CHECKED, _STEPS = 2, 8  # tests, the most telling ones, that are foreseen by full simulation
LIKELY = 0.5  # a test that splits off a rival less often than this is not worth being recommended


@dataclass(frozen=True)
class Condition:
    """What is done differently. changes : as in [run.model]; a loop has its frequency and amplitude instead."""

    words: str
    changes: Mapping[str, Any] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    longer: float = 1.0
    frequency_Hz: float = 0.0
    amplitude_m: float = 0.0


@dataclass(frozen=True)
class NextTest:
    """A test and how likely it would split the foremost effect from each of its rivals, by name."""

    condition: Condition
    chances: Mapping[str, float]


def next_tests(best: Fit, rivals: Sequence[Candidate]) -> tuple[NextTest, ...]:
    """Every test that can be foreseen with these runs, the most telling first."""
    problem = best.problem
    found = [_foreseen(best, rivals, condition, _along_lines) for condition in (*_deployments(problem), *_loops(problem))]
    checked: set[str] = set()
    while len(checked) < min(_CHECKED, len(found)):
        found.sort(key=lambda test: (-sum(test.chances.values()), test.condition.words))
        if found[0].condition.words in checked:
            break
        checked.add(found[0].condition.words)
        found[0] = _foreseen(best, rivals, found[0].condition, _by_fits)
    return tuple(sorted(found, key=lambda test: (-sum(test.chances.values()), test.condition.words)))


Shown = Callable[[Fit, Fit, Condition], tuple[float, float]]


def _foreseen(best: Fit, rivals: Sequence[Candidate], condition: Condition, shown: Shown) -> NextTest:
    return NextTest(condition, {rival.name: _chance(best, rival.fit, shown(best, rival.fit, condition)) for rival in rivals})


def _deployments(problem: Problem) -> list[Condition]:
    """Deployments that differ from those there are."""
    g = problem.model.geometry
    if g is None:
        return []
    models = [film.model for film in problem.films] or [problem.model]
    heights = [model.geometry.stowed_height_m for model in models if model.geometry is not None]
    masses = [model.platform.mass_kg for model in models]
    height = max(heights) + _FURTHER * (g.deployed_height_m - max(heights))
    ballast = max(masses) * _HEAVIER
    heavier = {"platform": {"mass_kg": ballast}}
    return [
        Condition(f"a deployment from a start height of {height:.3f} m", _at_height(height)),
        Condition(f"a deployment with a platform of {ballast:.2f} kg", heavier),
        Condition(f"a deployment from {height:.3f} m with a platform of {ballast:.2f} kg", {**_at_height(height), **heavier}),
        *(Condition(f"a deployment released {1e3 * x:.0f} mm off the centre", _released(position_m=[x, 0.0, 0.0])) for x in _OFF_CENTRE_M),
        *(Condition(f"a deployment released with a tilt of {tilt:g} rad", _released(theta_rad=[0.0, tilt, 0.0])) for tilt in _TILT_RAD),
        *(Condition(f"a deployment released turned by {turn:g} rad", _released(theta_rad=[0.0, 0.0, turn])) for turn in _TURN_RAD),
        Condition("a film twice as long, with the free bounce on the stops", longer=2.0),
        Condition("a film of the same deployment from the side", channels=("y_m", "z_m", "theta_x_rad")),
        Condition("a deployment with the legs moved on by a third of a turn", {"geometry": _third_of_a_turn(g)}),
    ]


def _released(**pose: list[float]) -> dict[str, Any]:
    return {"release": pose}


def _at_height(height_m: float) -> dict[str, Any]:
    return {"geometry": {"stowed_height_m": height_m}}


def _third_of_a_turn(g: Geometry) -> dict[str, Any]:
    """Each leg with its joints where the leg two places on had them."""
    return {key: [list(joint) for joint in (*joints[2:], *joints[:2])] for key, joints in _joints(g).items()}


def _joints(g: Geometry) -> dict[str, Any]:
    return {"base_joints_m": g.base_joints_m, "platform_joints_m": g.platform_joints_m}


def _loops(problem: Problem) -> list[Condition]:
    """Loops that differ from those there are; where there are none, a plain one."""
    if not problem.loops:
        stroke = (
            0.4 if problem.model.geometry is None else problem.model.geometry.deployed_height_m - problem.model.geometry.stowed_height_m
        )
        return [_loop(_FREE_LOOP[0], _FREE_LOOP[1] * stroke), _loop(3 * _FREE_LOOP[0], _FREE_LOOP[1] * stroke)]
    seen = [(loop.data.frequency_Hz, float(np.ptp(loop.data.elongation_m)) / 2) for loop in problem.loops]
    fastest, slowest = max(f for f, _ in seen), min(f for f, _ in seen)
    widest, narrowest = max(a for _, a in seen), min(a for _, a in seen)
    return [
        _loop(_FASTER * fastest, widest),
        _loop(_FASTER * fastest, narrowest),
        _loop(slowest, _WIDER * widest),
        _loop(fastest, _WIDER * widest),
    ]


def _loop(frequency_Hz: float, amplitude_m: float) -> Condition:
    words = f"a loop at {frequency_Hz:.3g} Hz with an amplitude of {1e3 * amplitude_m:.3g} mm"
    return Condition(words, frequency_Hz=frequency_Hz, amplitude_m=amplitude_m)


def _chance(best: Fit, rival: Fit, shown: tuple[float, float]) -> float:
    """How likely a test that shows so much tells the two apart, whichever is true."""
    before = float(np.sum(rival.free_of_knobs((best.gaps - rival.gaps)[:, None]) ** 2))
    return chance_of_split(rival.cost - best.cost, len(rival.q) - len(best.q), best.problem.measured, before, shown)


def chance_of_split(lead: float, more_knobs: int, samples: int, before: float, shown: tuple[float, float]) -> float:
    """How likely a further test excludes one of two effects, by the straight-line theory of the lead.

    Parameters
    ----------
    lead : of the foremost over its rival so far. more_knobs : that the rival has. samples : so many were measured.
    before, shown : delta^2 of what was measured; and of the test if the foremost is true, and if the rival is.
    """
    if_best, if_rival = (_excludes(side * lead, before, one) for side, one in zip((1.0, -1.0), shown, strict=True))
    odds = float(np.exp(-0.5 * np.clip(lead + more_knobs * np.log(samples), -100.0, 100.0)))
    return (if_best + odds * if_rival) / (1.0 + odds)


def _excludes(lead: float, before: float, shown: float) -> float:
    """How likely a test that shows so much brings the lead of the true effect to where it excludes the other."""
    spread = 2.0 * float(np.sqrt(shown)) + 1e-12
    whole = before + shown
    needed = max(STRONG_BIC, 2.0 * float(np.sqrt(whole)) * float(stats.norm.isf(RIVAL_P)) - whole)
    return float(stats.norm.cdf((lead + shown - needed) / spread))


def _along_lines(best: Fit, rival: Fit, condition: Condition) -> tuple[float, float]:
    """delta^2 of a further run along straight lines, taken for the same whichever is true."""
    shown = _shown(rival, _made(best, condition))
    return shown, shown


def _by_fits(best: Fit, rival: Fit, condition: Condition) -> tuple[float, float]:
    """delta^2 of a further run that either makes and the other is fitted to: one can often bend farther than the other."""
    return _shown_by_fit(rival, _made(best, condition)), _shown_by_fit(best, _made(rival, condition))


def _shown(rival: Fit, made: Problem) -> float:
    """delta^2 of a further run, along straight lines."""
    problem = replace(rival.problem.until(np.inf), films=made.films, loops=made.loops)
    q = laid_out(rival, problem)
    gaps, jacobian = problem.jacobian(q)
    gaps, jacobian = gaps[: problem.measured], jacobian[: problem.measured]
    own = np.arange(problem.first_nuisance, problem.first_effect)
    shared = np.setdiff1d(np.arange(len(q)), own)
    old = len(rival.q)
    kept = np.setdiff1d(np.arange(old), np.arange(rival.problem.first_nuisance, rival.problem.first_effect))
    stacked = np.zeros((len(gaps) + old + len(own), old + len(own)))
    stacked[: len(gaps), kept] = jacobian[:, shared]
    stacked[: len(gaps), old:] = jacobian[:, own]
    stacked[len(gaps) : len(gaps) + old, :old] = np.linalg.qr(rival.jacobian, mode="r")
    stacked[len(gaps) + old :, old:] = np.eye(len(own))
    right = np.concatenate([gaps, np.zeros(old + len(own))])
    step = np.linalg.lstsq(stacked, -right, rcond=1e-12)[0]
    return float(np.sum((right + stacked @ step) ** 2))


def _shown_by_fit(rival: Fit, made: Problem) -> float:
    """The same by fitting the rival to everything there is and the further run: a shape can bend farther than a straight line."""
    of = rival.problem.until(np.inf)
    problem = replace(of, films=(*of.films, *made.films), loops=(*of.loops, *made.loops))
    found = solve(problem, laid_out(rival, problem), most_steps=_STEPS, enough=ROUGHLY)
    return max(0.0, found.cost - rival.cost)


def _made(best: Fit, condition: Condition) -> Problem:
    """The further run as the foremost effect would make it, without noise."""
    return _loop_made(best, condition) if condition.frequency_Hz else _film_made(best, condition)


def _loop_made(best: Fit, condition: Condition) -> Problem:
    loop = _blank_loop(best.problem, condition)
    problem = replace(best.problem.until(np.inf), films=(), loops=(loop,))
    foreseen = -problem.with_exact_motion().gaps(laid_out(best, problem))
    force = loop.data.force_N.copy()
    force[loop.data.used] += foreseen[: problem.measured] * loop.data.force_sigma_N
    return replace(problem, loops=(replace(loop, data=replace(loop.data, force_N=force)),))


def _film_made(best: Fit, condition: Condition) -> Problem:
    film = _blank_film(best.problem, condition)
    problem = replace(best.problem.until(np.inf), films=(film,), loops=())
    foreseen = -problem.gaps(laid_out(best, problem))
    values = np.stack([film.values[i] + foreseen[block.rows] * film.sigma[i] for i, block in enumerate(problem.blocks)])
    return replace(problem, films=(replace(film, values=values),))


def _blank_film(problem: Problem, condition: Condition) -> Film:
    """A film like the first one, under another condition, that has seen nothing yet."""
    like = problem.films[0] if problem.films else _plain_film(problem.model)
    channels = condition.channels or like.channels
    step = float(np.median(np.diff(like.time_s)))
    time = like.time_s[0] + step * np.arange(round(condition.longer * len(like.time_s)))
    run = Run(Trajectory(time, {name: np.zeros(len(time)) for name in channels}), condition.changes, name="further")
    model = run.model(problem.model)
    sigma = np.array([_typical_sigma(problem.films or (like,), name) for name in channels])
    nominal = np.array([model.geometry.stowed_height_m if name == "z_m" and model.geometry else 0.0 for name in channels])
    zeroed = np.full(len(channels), bool(like.zeroed.any()))
    blank = np.zeros((len(channels), len(time)))
    return Film(run, model, time, channels, blank, blank + sigma[:, None], blank == 0.0, nominal, zeroed, like.expected_s)


def _plain_film(model: Model) -> Film:
    """A film as a first one would be, seen from the front and counted from its first frame."""
    rate, length, angle = _FREE_FILM
    time = np.arange(round(rate * model.simulation.duration_s)) / rate
    channels = ("x_m", "z_m", "theta_y_rad")
    sigma = np.outer([length, length, angle], np.ones(len(time)))
    run = Run(Trajectory(time, {name: np.zeros(len(time)) for name in channels}), name="further")
    return Film(run, model, time, channels, 0.0 * sigma, sigma, sigma > 0.0, np.zeros(3), np.ones(3, dtype=bool), 0.0)


def _typical_sigma(films: Sequence[Film], channel: str) -> float:
    """The noise of a channel of the same kind, a length or a rotation, in these films."""
    kind = channel.rpartition("_")[2]
    same = [film.sigma[i] for film in films for i, name in enumerate(film.channels) if name.endswith(kind)]
    lengths = [film.sigma[i] for film in films for i, name in enumerate(film.channels) if name.endswith("_m")]
    return float(np.nanmedian(np.concatenate(same or lengths)))


def _blank_loop(problem: Problem, condition: Condition) -> LoopRun:
    """A loop on a shaker that has seen no force yet; its first cycle does not count, for nobody knows with what force it will start."""
    time = np.linspace(0.0, _CYCLES / condition.frequency_Hz, _SAMPLES * _CYCLES + 1)
    middle = float(np.mean([np.mean(loop.data.elongation_m) for loop in problem.loops])) if problem.loops else condition.amplitude_m
    turn = 2 * np.pi * condition.frequency_Hz * time
    level = float(np.mean(problem.model.actuator.b_l_N))
    blank = Loop(time, middle + condition.amplitude_m * np.sin(turn), level * (1.0 + 0.01 * np.cos(turn)), name="further")
    data = prepare(blank)
    sigmas = [(loop.data.force_sigma_N, loop.data.elongation_sigma_m) for loop in problem.loops]
    force_sigma_N, sigma_m = np.median(sigmas, axis=0) if sigmas else (_FREE_LOOP[2] * abs(level), _FREE_LOOP[3])
    moved = harmonic_motion(time, blank.elongation_m, sigma_m)
    assert moved is not None
    used = data.used & (time > 1.0 / condition.frequency_Hz)
    foreseen = replace(data, force_sigma_N=float(force_sigma_N), motion_errors=moved[1], used=used)
    return LoopRun(Run(blank, name="further"), problem.model, foreseen)
