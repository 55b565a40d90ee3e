"""What a sweep varies and how: factors with two levels, and the designs that combine them.

Coded levels run from -1 (low) to +1 (high). A design hands out its runs in pieces, so a million of them need no more
memory than a few.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from measure.errors import InputError
from measure.tables import Array

from .model import LEGS, Model, value_of, with_value

LETTERS = "ABCDEFGHJKLMNOPQRSTUVWXYZ"  # no I, as in the paper's Table 1
MOST_FULL_FACTORS = 20
_SPREAD = re.compile(r"^(?:\+-|\+/-|±)(?P<size>[0-9.eE+-]+)(?P<percent>%?)$")
_RANGE = re.compile(r"^(?P<low>[-+0-9.eE]+)\.\.(?P<high>[-+0-9.eE]+)$")

# What belongs together: a factor on the first moves the others of the same leg by as much.
_TOGETHER = {"actuator.b_l_N": ("actuator.b_u_N", "actuator.initial_force_N")}


@dataclass(frozen=True)
class Factor:
    """A value of the model that a sweep varies between two levels.

    The stored force of a leg is one thing: a factor on `actuator.b_l_N[i]` moves b_l, b_u and the initial force of that
    leg by the same amount. Any other key, a_l among them, moves alone.
    """

    letter: str
    key: str
    low: float
    high: float

    def applied(self, model: Model, coded: float) -> Model:
        """The model with this factor at a coded level."""
        value = (self.low + self.high) / 2 + coded * (self.high - self.low) / 2
        shift = value - value_of(model, self.key)
        name, bracket, index = self.key.partition("[")
        for other in _TOGETHER.get(name, ()):
            model = _shifted(model, other + bracket + index, shift)
        return with_value(model, self.key, value)


def _shifted(model: Model, key: str, shift: float) -> Model:
    current = getattr(model.actuator, key.split(".")[1]) if "[" not in key else None
    if isinstance(current, tuple):
        return with_value(model, key, tuple(v + shift for v in current))
    return with_value(model, key, value_of(model, key) + shift)


def paper_factors(model: Model) -> list[Factor]:
    """The paper's 12 factors: stored force and slope of each leg at +-10 %, letters A to M without I, leg by leg."""
    keys = [f"actuator.{name}[{leg}]" for leg in range(LEGS) for name in ("b_l_N", "a_l_N_per_m")]
    return [factor_of(model, f"{key}=+-10%", letter) for key, letter in zip(keys, LETTERS, strict=False)]


def factors_of(model: Model, words: Sequence[str]) -> list[Factor]:
    """The factors of `--factor`, or the paper's where none is given.

    Raises
    ------
    InputError
        A key that is no number of the model, a spread that cannot be read, a key named twice, too many factors.
    """
    if not words:
        return paper_factors(model)
    if len(words) > len(LETTERS):
        raise InputError(f"{len(words)} factors; at most {len(LETTERS)} have a letter.")
    made = [factor_of(model, word, letter) for word, letter in zip(words, LETTERS, strict=False)]
    keys = [factor.key for factor in made]
    if len(set(keys)) < len(keys):
        double = next(key for key in keys if keys.count(key) > 1)
        raise InputError(f"--factor {double} is given twice; keep one.")
    return made


def factor_of(model: Model, word: str, letter: str) -> Factor:
    """A factor from `KEY=+-10%`, `KEY=+-0.02` or `KEY=2.6..3.0`."""
    key, _, levels = (part.strip() for part in word.partition("="))
    try:
        value = value_of(model, key)
    except KeyError as error:
        raise InputError(
            f"--factor {word}: {error.args[0]} is no number of the model. Name one as in the model file, such as actuator.b_l_N[0]."
        ) from error
    low, high = _levels(value, levels, word)
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise InputError(f"--factor {word}: its levels are {low:g} and {high:g}; give two different ones, as +-0.02 or 2.6..3.0.")
    return Factor(letter, key, low, high)


def _levels(value: float, levels: str, word: str) -> tuple[float, float]:
    spread, between = _SPREAD.match(levels), _RANGE.match(levels)
    try:
        if spread:
            size = float(spread["size"]) * (abs(value) / 100 if spread["percent"] else 1.0)
            return value - size, value + size
        if between:
            return float(between["low"]), float(between["high"])
    except ValueError:
        pass
    raise InputError(f"--factor {word}: levels are written +-10%, +-0.02 or 2.6..3.0; found {levels!r}.")


@dataclass(frozen=True)
class Design:
    """Coded levels of all runs, handed out in pieces: `piece(first, last)` is (last - first, factors).

    basic : two-level designs only, the number of factors that run through all combinations; the others follow them.
    words : two-level designs only, the column of each factor as a bit mask of the basic ones.
    """

    kind: str
    runs: int
    factors: int
    piece: Callable[[int, int], Array]
    basic: int = 0
    words: tuple[int, ...] = ()


def design_of(kind: str, factors: int, runs: int | None, seed: int) -> Design:
    """A design by its name.

    Raises
    ------
    InputError
        A number of runs that the design cannot have.
    """
    if kind in ("full", "fractional"):
        return _two_level(kind, factors, runs)
    count = 1024 if runs is None else runs
    if count < 1:
        raise InputError(f"--runs {count}: at least one run is needed.")
    if kind == "random":
        return Design(kind, count, factors, lambda first, last: _random(first, last, factors, seed))
    table = _sampled(kind, count, factors, seed)
    return Design(kind, count, factors, lambda first, last: table[first:last])


def _two_level(kind: str, factors: int, runs: int | None) -> Design:
    if kind == "full":
        if factors > MOST_FULL_FACTORS:
            raise InputError(f"a full design of {factors} factors has 2^{factors} runs; take --design fractional or sobol.")
        if runs not in (None, 1 << factors):
            raise InputError(f"--runs {runs}: the full design of {factors} factors has {1 << factors} runs; leave --runs out.")
        words = tuple(1 << i for i in range(factors))
    else:
        basic = _basic_factors(factors, runs)
        words = _generators(factors, basic)
    basic = max(word.bit_length() for word in words)
    return Design(kind, 1 << basic, factors, lambda first, last: _signs(first, last, words), basic, words)


def _basic_factors(factors: int, runs: int | None) -> int:
    """Runs as a power of two; by default the least in which no two factors' interactions coincide with another pair's."""
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
    candidates = sorted(range(1, 1 << basic), key=lambda word: (-word.bit_count(), word))
    for word in candidates:
        if len(chosen) == factors:
            break
        if word in chosen or (odd and word.bit_count() % 2 == 0):
            continue
        if not pairs or _pairs_apart([*chosen, word]):
            chosen.append(word)
    if len(chosen) < factors:
        raise InputError("too few runs")
    return tuple(chosen)


def _pairs_apart(words: Sequence[int]) -> bool:
    """Whether all main effects and pairwise interactions have columns of their own."""
    columns = list(words) + [a ^ b for i, a in enumerate(words) for b in words[:i]]
    return 0 not in columns and len(set(columns)) == len(columns)


def _signs(first: int, last: int, words: Sequence[int]) -> Array:
    """Coded levels of runs first to last: bit i of the run is basic factor i, clear for low; a word is the product of its bits."""
    runs = np.arange(first, last, dtype=np.int64)
    return np.column_stack([np.where(np.bitwise_count(runs & word) % 2 == word.bit_count() % 2, 1.0, -1.0) for word in words])


_BLOCK = 1024


def _random(first: int, last: int, factors: int, seed: int) -> Array:
    """Uniform levels; run i has the same ones whatever the pieces are."""
    blocks = [
        np.random.default_rng([seed, block]).uniform(-1.0, 1.0, (_BLOCK, factors)) for block in range(first // _BLOCK, -(-last // _BLOCK))
    ]
    return np.concatenate(blocks)[first % _BLOCK : first % _BLOCK + last - first]


def _sampled(kind: str, runs: int, factors: int, seed: int) -> Array:
    from scipy.stats import qmc

    sampler = qmc.LatinHypercube(factors, rng=seed) if kind == "latin-hypercube" else qmc.Sobol(factors, rng=seed)
    if kind == "sobol" and runs & (runs - 1):
        raise InputError(f"--runs {runs}: a Sobol sample keeps its balance in a power of two of runs; take {1 << runs.bit_length()}.")
    return 2.0 * sampler.random(runs) - 1.0
