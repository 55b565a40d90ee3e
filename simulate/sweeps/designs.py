"""How a sweep combines its factors: the coded levels of every run.

A design is plain data and hands out its runs in pieces, so a million of them need no more memory than a few, and any process
that has the design makes the same levels.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.sweeps.indices import KINDS, levels_of, runs_of
from simulate.sweeps.limits import FARTHEST, MOST_FULL_FACTORS

_MORRIS_QUANTILES = 0.95  # a walk of Morris goes to the ends of a range; of a normal spread that is where 95 % lie within


@dataclass(frozen=True)
class Design:
    """Coded levels of all runs, handed out in pieces.

    seed : of sampled designs. normal : places of the factors with a normal spread.
    basic : two-level designs only, the number of factors that run through all combinations; the others follow them.
    columns : two-level designs only, the column of each factor as a bit mask of the basic ones (its generator).
    """

    kind: str
    runs: int
    factors: int
    seed: int = 0
    normal: tuple[int, ...] = ()
    basic: int = 0
    columns: tuple[int, ...] = ()

    def piece(self, first: int, last: int) -> Array:
        """(last - first, factors) coded levels of runs first to last."""
        if self.basic:
            return _signs(first, last, self.columns)
        levels = _SAMPLED[self.kind](first, last, self)
        within = _MORRIS_QUANTILES if self.kind == KINDS["morris"] else 1.0
        for place in self.normal:
            levels[:, place] = _normal_levels(within * levels[:, place])
        return levels


def _normal_levels(even: Array) -> Array:
    """Standard normal levels from even ones in -1 to 1, ending at six standard deviations."""
    from scipy.special import ndtri

    return np.clip(ndtri((even + 1.0) / 2.0), -FARTHEST, FARTHEST)


def design_of(kind: str, factors: int, runs: int | None, seed: int, normal: Sequence[int] = ()) -> Design:
    """A design by its name; `normal` are the places of the factors with a normal spread.

    Raises
    ------
    InputError
        A number of runs that the design cannot have.
    """
    if kind in ("full", "fractional"):
        return _two_level(kind, factors, runs)
    if kind in KINDS.values():
        return Design(kind, runs_of(kind, factors, runs), factors, seed, tuple(normal))
    count = 1024 if runs is None else runs
    if count < 1:
        raise InputError(f"--runs {count}: at least one run is needed.")
    if kind == "sobol" and count & (count - 1):
        raise InputError(f"--runs {count}: a Sobol sample keeps its balance in a power of two of runs; take {1 << count.bit_length()}.")
    return Design(kind, count, factors, seed, tuple(normal))


def _two_level(kind: str, factors: int, runs: int | None) -> Design:
    if kind == "full":
        if factors > MOST_FULL_FACTORS:
            raise InputError(f"a full design of {factors} factors has 2^{factors} runs; take --design fractional or sobol.")
        if runs not in (None, 1 << factors):
            raise InputError(f"--runs {runs}: the full design of {factors} factors has {1 << factors} runs; leave --runs out.")
        columns = tuple(1 << i for i in range(factors))
    else:
        basic = _basic_factors(factors, runs)
        columns = _generators(factors, basic)
    basic = max(column.bit_length() for column in columns)
    return Design(kind, 1 << basic, factors, basic=basic, columns=columns)


def _basic_factors(factors: int, runs: int | None) -> int:
    """Runs as a power of two; by default the least in which a greedy choice keeps every two factors' interaction apart from the others."""
    if runs is None:
        return next(basic for basic in range(1, factors + 1) if _resolution_five(factors, basic))
    basic = runs.bit_length() - 1
    if runs != 1 << basic or not factors < runs <= 1 << factors:
        raise InputError(f"--runs {runs}: a fractional design of {factors} factors has a power of two of runs above {factors}.")
    return basic


def _resolution_five(factors: int, basic: int) -> bool:
    try:
        _greedy(factors, basic, pairs=True)
    except InputError:
        return False
    return True


def _generators(factors: int, basic: int) -> tuple[int, ...]:
    """Columns of the factors: pairs kept apart where possible (resolution V), else mains clear of pairs (IV), else mains apart (III)."""
    for pairs, odd in ((True, False), (False, True), (False, False)):
        try:
            return _greedy(factors, basic, pairs=pairs, odd=odd)
        except InputError:
            continue
    raise InputError(f"{factors} factors do not fit into {1 << basic} runs.")


def _greedy(factors: int, basic: int, *, pairs: bool, odd: bool = False) -> tuple[int, ...]:
    chosen = [1 << i for i in range(min(basic, factors))]
    candidates = sorted(range(1, 1 << basic), key=lambda column: (-column.bit_count(), column))
    for column in candidates:
        if len(chosen) == factors:
            break
        if column in chosen or (odd and column.bit_count() % 2 == 0):
            continue
        if not pairs or _pairs_apart([*chosen, column]):
            chosen.append(column)
    if len(chosen) < factors:
        raise InputError("too few runs")
    return tuple(chosen)


def _pairs_apart(mains: Sequence[int]) -> bool:
    """Whether all main effects and pairwise interactions have columns of their own."""
    columns = list(mains) + [a ^ b for i, a in enumerate(mains) for b in mains[:i]]
    return 0 not in columns and len(set(columns)) == len(columns)


def _signs(first: int, last: int, columns: Sequence[int]) -> Array:
    """Coded levels of runs first to last: bit i of the run is basic factor i, clear for low; a column is the product of its bits."""
    runs = np.arange(first, last, dtype=np.int64)
    return np.column_stack([np.where(np.bitwise_count(runs & mask) % 2 == mask.bit_count() % 2, 1.0, -1.0) for mask in columns])


_BLOCK = 1024


def _random(first: int, last: int, design: Design) -> Array:
    """Even levels; run i has the same ones whatever the pieces are."""
    blocks = range(first // _BLOCK, -(-last // _BLOCK))
    drawn = [np.random.default_rng([design.seed, block]).uniform(-1.0, 1.0, (_BLOCK, design.factors)) for block in blocks]
    return np.concatenate(drawn)[first % _BLOCK : first % _BLOCK + last - first]


def _sobol(first: int, last: int, design: Design) -> Array:
    """Scrambled Sobol points; the sequence is wound forward to the piece."""
    from scipy.stats import qmc

    sampler = qmc.Sobol(design.factors, rng=design.seed)
    block = 1 << (last - first - 1).bit_length()  # asked for fewer than a power of two it warns, and would be right to at the start
    return 2.0 * sampler.fast_forward(first).random(block)[: last - first] - 1.0 if first else 2.0 * sampler.random(block)[:last] - 1.0


def _latin_hypercube(first: int, last: int, design: Design) -> Array:
    return _hypercube(design.runs, design.factors, design.seed)[first:last].copy()


@lru_cache(maxsize=2)
def _hypercube(runs: int, factors: int, seed: int) -> Array:
    """All levels at once: each factor is cut into as many strata as there are runs, so none can be had by itself."""
    from scipy.stats import qmc

    return 2.0 * qmc.LatinHypercube(factors, rng=seed).random(runs) - 1.0


def _for_indices(first: int, last: int, design: Design) -> Array:
    return levels_of(design.kind, design.runs, design.factors, design.seed)[first:last].copy()


_SAMPLED = {
    "random": _random,
    "sobol": _sobol,
    "latin-hypercube": _latin_hypercube,
    **dict.fromkeys(KINDS.values(), _for_indices),
}
