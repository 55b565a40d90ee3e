"""Which cases the bench board has: 120 drawn from a seed, in four kinds.

nothing    a model file that is right within its tolerances
errors     a model file that is wrong by so much more that the runs show it, or a stored force that differs from run to run
effects    an effect of the catalogue at five times the detectable size
outside    a force that no catalogue holds
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from board.outside import KINDS as OUTSIDE
from board.specs import HIDDEN, IN_LOOPS, ONLY_IN_THE_KERNEL

KINDS = {"nothing": 40, "errors": 30, "effects": 30, "outside": 20}
ERRORS = ("platform-mass", "geometry-error", "platform-inertia", "stored-force-per-run", "stop-stiffness")
EFFECTS = tuple(name for name in HIDDEN if name not in ONLY_IN_THE_KERNEL)
ONLY_LOOPS = ("sensor-lag", "force-offset", "platform-mass")
RUN_SETS = {"loops": 0.6, "films": 0.25, "elevation": 0.15}
SHOWN_BY_ELEVATION = ("stored-force-per-run",)  # errors
GENERATION = 8  # counts up when cases are made in another way, so that old ones are not taken for new


@dataclass(frozen=True)
class Spec:
    """One case. hidden : what acts and is not in the model file, empty for nothing. runs : loops (and films), films, elevation."""

    kind: str
    hidden: str
    runs: str
    seed: int
    number: int

    @property
    def token(self) -> str:
        """A name for files that tells nothing."""
        return hashlib.sha256(f"bench.{GENERATION}{self}".encode()).hexdigest()[:12]

    @property
    def chance(self) -> np.random.Generator:
        """The case's own source of chance."""
        return np.random.default_rng([self.seed, int(self.token, 16)])

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def board(seed: int, share: float = 1.0) -> list[Spec]:
    """The cases of a seed, or a share of each kind; kinds mixed, so that the first ones are a fair sample of all."""
    chance = np.random.default_rng([seed, GENERATION])
    specs = [spec for kind, n in KINDS.items() for spec in list(_of_kind(kind, n, seed, chance))[: max(2, round(share * n))]]
    return [specs[i] for i in chance.permutation(len(specs))]


def _of_kind(kind: str, n: int, seed: int, chance: np.random.Generator) -> Iterator[Spec]:
    names = {"nothing": ("",), "errors": ERRORS, "effects": EFFECTS, "outside": tuple(OUTSIDE)}[kind]
    rounds = [chance.permutation(len(names)) for _ in range(-(-n // len(names)))]
    for number, i in enumerate(np.concatenate(rounds)[:n].tolist()):
        runs = str(chance.choice(list(RUN_SETS), p=list(RUN_SETS.values())))
        yield Spec(kind, names[i], _shown_by(kind, names[i], runs), seed, number)


def _shown_by(kind: str, name: str, runs: str) -> str:
    """Runs that can show what is hidden: a lag of the load cell and a wrong mass, which another law looks like up to the stops, need loops.

    Joints and inertias need more than the elevation.
    """
    if name in ONLY_LOOPS:
        return "loops"
    if runs == "elevation" and kind != "nothing" and name not in SHOWN_BY_ELEVATION:
        return "films" if name not in IN_LOOPS else "loops"
    return runs
