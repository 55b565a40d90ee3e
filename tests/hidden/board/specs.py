"""What a case is, before anything is simulated, and which cases make a board.

A case is a few words and a seed; everything else about it (the rig, the law, the releases, the noise) follows from the seed. The
order of a board is shuffled once, so that its first cases are a fair sample of all.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from simulate.effects import CATALOGUE

MASTER_SEED = 2009
GENERATION = 7  # counts up when cases are made in another way, so that old ones are not taken for new
SIZES = (1.0, 3.0, 10.0)
RUN_SETS = ("standard", "two-heights", "single", "loops")
OUTSIDE = ("gust", "coil-dents", "side-wind", "snag", "stage-drive")
MEASUREMENT = ("scale-error", "camera-roll", "time-offset", "sensor-lag", "force-offset", "sensor-filter", "lens-distortion")
IN_LOOPS = (
    *("hub-inertia", "viscous-friction", "power-law-friction", "stribeck-friction", "rate-dependent-asymptotes", "curved-asymptotes"),
    *("transition-zone", "force-relaxation", "backlash", "sensor-lag", "force-offset"),
    *("series-play", "eddy-damping", "ripple", "sensor-filter"),
)
PAIRS = (
    ("hub-inertia", "gravity-imbalance"),
    ("viscous-friction", "centre-of-mass-offset"),
    ("pulley-inertia", "leg-disparity"),
    ("scale-error", "air-drag"),
    ("camera-roll", "time-offset"),
    ("sensor-lag", "scale-error"),
    ("force-offset", "pulley-friction"),
    ("cable-pendulum", "curved-asymptotes"),
)
# Where no other engine can say it, the project's own kernel at a step 25 times finer does.
ONLY_IN_THE_KERNEL = ("joint-friction", "backlash", "series-play", "flexible-base")
NOT_IN_MUJOCO = (*ONLY_IN_THE_KERNEL, "leg-mass", "counterweight-inertia", "pulley-inertia")


# What the model file itself may have wrong is hidden by the board of model errors, not by an engine.
OF_THE_MODEL_FILE = ("platform-mass", "platform-inertia", "geometry-error", "stop-stiffness", "stored-force-per-run")
# Of a flexible base a heavier one shows less, so that it has no size that the runs can just detect.
NOT_HIDDEN = ("flexible-base", *OF_THE_MODEL_FILE)
HIDDEN = tuple(name for name in CATALOGUE if name not in NOT_HIDDEN)


@dataclass(frozen=True)
class Spec:
    """One case. hidden : names of what acts and is not in the model file. size : in multiples of what these runs can detect.

    noise : of the camera and the load cell. engine : what moves the platform. own_tare : whether each loop has a zero of its own.
    """

    hidden: tuple[str, ...]
    size: float = 3.0
    run_set: str = "standard"
    noise: str = "usual"
    engine: str = "kernel"
    seed: int = 0
    own_tare: bool = False

    @property
    def token(self) -> str:
        """A name for files that tells nothing."""
        return hashlib.sha256(f"{MASTER_SEED}.{GENERATION}{self}".encode()).hexdigest()[:12]

    @property
    def chance(self) -> np.random.Generator:
        """The case's own source of chance: the same for every size, so that sizes can be compared on the same rig."""
        words = f"{self.hidden}{self.run_set}{self.seed}".encode()
        return np.random.default_rng([MASTER_SEED, int.from_bytes(hashlib.sha256(words).digest()[:8], "big")])

    @property
    def words(self) -> set[str]:
        """What a case is called when some are chosen."""
        kind = {0: "no-effect", 1: "outside" if set(self.hidden) & set(OUTSIDE) else "one-effect"}.get(len(self.hidden), "several")
        tare = "own-tare" if self.own_tare else "one-tare"
        return {*(self.hidden or ("nothing",)), kind, f"{self.size:g}x", self.run_set, self.noise, self.engine, tare, f"seed-{self.seed}"}

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {**asdict(self), "hidden": list(self.hidden)}


def board(subset: str) -> list[Spec]:
    """All cases of a board, in an order of their own: fast, standard, full, or seeds with rigs of their own (`seed-7`, `seed-7,8`)."""
    if subset == "fast":
        return [replace(spec, engine=_engine(spec)) for spec in FAST]
    seeds = {"standard": range(1), "full": range(4)}.get(subset) or [int(number) for number in subset.removeprefix("seed-").split(",")]
    specs = list(dict.fromkeys(replace(spec, engine=_engine(spec)) for seed in seeds for spec in _with_seed(seed)))
    order = np.random.default_rng(MASTER_SEED).permutation(len(specs))
    return [specs[i] for i in order]


def _with_seed(seed: int) -> Iterator[Spec]:
    for i, name in enumerate(HIDDEN):
        noise = ("usual", "fine", "coarse")[(i + seed) % 3]
        yield from (Spec((name,), size, "standard", noise, seed=seed) for size in SIZES)
    yield from _elsewhere(seed)
    yield from (Spec((), run_set=run_set, seed=10 * seed + i) for run_set, n in _NOTHING for i in range(n))
    yield from (Spec((name,), size, seed=seed) for name in OUTSIDE for size in (3.0, 10.0))
    yield from (Spec(pair, 10.0, seed=seed) for pair in PAIRS)
    yield from (Spec((name,), 10.0, own_tare=True, seed=seed) for name in ("hub-inertia", "gravity-imbalance"))
    yield from (Spec((name,), 10.0, "standard", "film", seed=seed) for name in ("hub-inertia", "gravity-imbalance", "end-stop-dissipation"))


_NOTHING = (("standard", 10), ("two-heights", 3), ("single", 3), ("loops", 3))


def _elsewhere(seed: int) -> Iterator[Spec]:
    """The other run sets: each effect that can show there, once, at three times what is detectable."""
    for i, name in enumerate(HIDDEN):
        if name in IN_LOOPS:
            yield Spec((name,), 3.0, "loops", seed=seed)
        if name not in ("sensor-lag", "force-offset"):
            yield Spec((name,), 3.0, ("single", "two-heights")[(i + seed) % 2], seed=seed)


def _engine(spec: Spec) -> str:
    """Another engine than the fits use, but for a fifth of the cases and where no other can say it; films are of the kernel's motion."""
    if spec.noise == "film" or any(name in ONLY_IN_THE_KERNEL for name in spec.hidden):
        return "kernel"
    other = "ode" if any(name in NOT_IN_MUJOCO for name in spec.hidden) else "mujoco"
    return ("ode", other, "ode", other, "kernel")[int(spec.token, 16) % 5]


FAST = (
    Spec(("hub-inertia",), 10.0),
    Spec(("gravity-imbalance",), 3.0),
    Spec((), seed=1),
    Spec(("scale-error",), 3.0),
    Spec(("gust",), 10.0),
    Spec(("viscous-friction",), 3.0, "loops"),
    Spec(("leg-disparity",), 3.0, seed=1),
    Spec(("leg-disparity",), 10.0),
    Spec((), run_set="single", seed=2),
    Spec(("scale-error", "air-drag"), 10.0, seed=9),
    Spec(("hub-inertia",), 10.0, own_tare=True, seed=9),
)


def chosen(specs: Iterable[Spec], only: Iterable[str], cases: int | None, skip: int = 0) -> list[Spec]:
    """Of those that all the words of `only` fit, `cases` behind the first `skip`."""
    kept = [spec for spec in specs if spec.words.issuperset(only)][skip:]
    return kept if cases is None else kept[:cases]
