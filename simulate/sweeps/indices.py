"""How much each factor has to do with a response: Sobol indices, Morris's elementary effects. This is the one module that knows SALib.

Sobol: of the variance of the response, the share that a factor answers for by itself (first order), and with all that it
has to do with (total). Morris: by how much a step of a factor moves the response, on average of its size, and how that step's effect
differs from place to place. Sources: Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018; Campolongo et al. 2007,
doi:10.1016/j.envsoft.2006.10.004.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from importlib.util import find_spec
from typing import Any

import numpy as np

from measure.common.arrays import Array
from measure.common.errors import InputError
from simulate.sweeps.limits import INDICES

KINDS = dict(zip(INDICES, ("saltelli", "morris"), strict=True))
"""Design of a sweep by the method that it serves."""
CONFIDENCE = 0.95
_BLOCKS = {"saltelli": 512, "morris": 64}
_LEVELS = 4  # of Morris's grid
_RESAMPLES = 200
_FEWEST = 8  # blocks from which an interval can be had


def runs_of_block(kind: str, factors: int) -> int:
    """Runs that belong together: two samples and one run a factor between them, or a walk of one step a factor."""
    return factors + 2 if kind == "saltelli" else factors + 1


def runs_of(kind: str, factors: int, runs: int | None) -> int:
    """Runs of whole blocks, as many as fit; of Sobol's a power of two.

    Raises
    ------
    InputError
        The library is not installed, or too few runs for an interval.
    """
    if find_spec("SALib") is None:
        raise InputError('--indices: the library SALib is not installed. Install the extra: pip install "unspool[indices]".')
    block = runs_of_block(kind, factors)
    blocks = _BLOCKS[kind] if runs is None else runs // block
    if blocks < _FEWEST:
        raise InputError(f"--runs {runs}: indices of {factors} factors take blocks of {block} runs, at least {_FEWEST * block} in all.")
    return block * (1 << (blocks.bit_length() - 1) if kind == "saltelli" else blocks)


@lru_cache(maxsize=2)
def levels_of(kind: str, runs: int, factors: int, seed: int) -> Array:
    """(runs, factors) levels from -1 to 1, evenly spread; a design of this kind has to be made as a whole."""
    blocks, problem = runs // runs_of_block(kind, factors), _problem(factors)
    rng = np.random.default_rng(seed)
    if kind == "saltelli":
        from SALib.sample import sobol

        return np.asarray(sobol.sample(problem, blocks, calc_second_order=False, seed=rng))
    from SALib.sample import morris

    return np.asarray(morris.sample(problem, blocks, num_levels=_LEVELS, seed=rng))


def indices_of(kind: str, letters: Sequence[str], levels: Array, values: Array, seed: int = 0) -> dict[str, Any]:
    """Indices with their intervals, and how they have come to rest.

    Parameters
    ----------
    kind : "saltelli" or "morris". levels : (runs, factors) as `levels_of` gave them. values : (runs,) the response, NaN where a run has
        none; the whole block of such a run is left out.

    Returns
    -------
    `indices` by name and letter, each with value and interval; `convergence`, the same of the first half, quarter ... of the blocks;
    blocks, and how many were left out. No indices where too few blocks are left or the response does not vary.
    """
    size = runs_of_block(kind, len(letters))
    good = np.isfinite(values.reshape(-1, size)).all(axis=1)
    levels, values = (part.reshape(-1, size, *part.shape[1:])[good] for part in (levels, values))
    analyse = _sobol if kind == "saltelli" else _morris
    found: dict[str, Any] = {"method": _METHODS[kind], "confidence": CONFIDENCE, "blocks": len(values), "left_out": int(np.sum(~good))}
    if len(values) < _FEWEST or np.ptp(values) == 0.0:
        return {**found, "indices": None, "convergence": []}
    counts = [len(values) >> halving for halving in range(6) if len(values) >> halving >= _FEWEST]
    steps = [_rows(analyse, letters, levels[:count], values[:count], seed) for count in counts]
    rest = [{"runs": count * size, "indices": step} for count, step in zip(counts[::-1], steps[::-1], strict=True)]
    return {**found, "indices": steps[0], "convergence": rest}


Analysis = Callable[[Array, Array, int], dict[str, tuple[Array, Array]]]
_METHODS = {design: method for method, design in KINDS.items()}


def _rows(analyse: Analysis, letters: Sequence[str], levels: Array, values: Array, seed: int) -> dict[str, Any]:
    found = analyse(levels.reshape(-1, len(letters)), values.ravel(), seed)
    return {
        name: {
            letter: {"value": float(value), "interval": [float(value - half), float(value + half)]}
            for letter, value, half in zip(letters, sizes, halves, strict=True)
        }
        for name, (sizes, halves) in found.items()
    }


def _sobol(levels: Array, values: Array, seed: int) -> dict[str, tuple[Array, Array]]:
    from SALib.analyze import sobol

    options = {"num_resamples": _RESAMPLES, "conf_level": CONFIDENCE, "seed": np.random.default_rng(seed)}
    found = sobol.analyze(_problem(levels.shape[1]), values, calc_second_order=False, **options)
    return {"first_order": (found["S1"], found["S1_conf"]), "total": (found["ST"], found["ST_conf"])}


def _morris(levels: Array, values: Array, seed: int) -> dict[str, tuple[Array, Array]]:
    """SALib's elementary effects are per range of a factor; the interval is of the mean of their sizes."""
    from SALib.analyze import morris

    options = {"num_resamples": _RESAMPLES, "conf_level": CONFIDENCE, "num_levels": _LEVELS, "seed": np.random.default_rng(seed)}
    found = morris.analyze(_problem(levels.shape[1]), levels, values, **options)
    walks = len(values) // (levels.shape[1] + 1)
    quantile = 1.959963984540054
    size, spread = np.asarray(found["mu_star"], float), np.asarray(found["sigma"], float)
    return {
        "mean_size": (size, np.asarray(found["mu_star_conf"], float)),
        "mean": (np.asarray(found["mu"], float), quantile * spread / np.sqrt(walks)),
        "spread": (spread, quantile * spread / np.sqrt(2.0 * max(walks - 1, 1))),
    }


def _problem(factors: int) -> dict[str, Any]:
    return {"num_vars": factors, "names": [str(i) for i in range(factors)], "bounds": [[-1.0, 1.0]] * factors}
