"""Noise that is drawn by counting, for runs side by side: the same number for the same place, whatever the step and the neighbours.

Who calls it imports `lane_functions`, by which logarithm and cosine are known.
"""

from __future__ import annotations

import math
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from simulate.dispatch.lanes import Lanes

# Of the generator splitmix64 (Steele, Lea, Flood, 2014).
_GOLDEN, _MIX_A, _MIX_B = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB


@intrinsic
def _uniform(typingctx: Any, seed: Any, sample: Any, place: Any) -> Any:
    """A number between 0 and 1, neither of them, for one of 16 places of a sample, by splitmix64 of seed, sample and place."""
    del typingctx

    def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        del context, signature
        whole, number = ir.VectorType(ir.IntType(64), seed.n), ir.VectorType(ir.DoubleType(), seed.n)

        def all_lanes(value: int) -> Any:
            return ir.Constant(whole, [value] * seed.n)

        def mixed(z: Any, shift: int) -> Any:
            return builder.xor(z, builder.lshr(z, all_lanes(shift)))

        runs, samples = (builder.fptoui(value, whole) for value in given[:2])
        empty = ir.Constant(whole, ir.Undefined)
        one = builder.insert_element(empty, given[2], ir.Constant(ir.IntType(32), 0))
        places = builder.shuffle_vector(one, empty, ir.Constant(ir.VectorType(ir.IntType(32), seed.n), [0] * seed.n))
        counted = builder.add(builder.shl(runs, all_lanes(28)), builder.shl(samples, all_lanes(4)))
        z = builder.mul(builder.add(builder.add(counted, places), all_lanes(1)), all_lanes(_GOLDEN))
        z = builder.mul(mixed(z, 30), all_lanes(_MIX_A))
        z = mixed(builder.mul(mixed(z, 27), all_lanes(_MIX_B)), 31)
        drawn = builder.sitofp(builder.lshr(z, all_lanes(11)), number)
        half, unit = (ir.Constant(number, [value] * seed.n) for value in (0.5, 2.0**-53))
        return builder.fmul(builder.fadd(drawn, half), unit)

    return seed(seed, sample, types.int64), generate


uniform: Any = _uniform


@njit(cache=True, error_model="numpy", forceinline=True)
def normal(seed: Lanes, sample: Lanes, channel: int) -> Lanes:
    """Standard normal numbers for a sample of one of eight channels (Box and Muller), the same at every call."""
    radius = math.sqrt(-2.0 * math.log(uniform(seed, sample, 2 * channel)))
    return radius * math.cos(2.0 * math.pi * uniform(seed, sample, 2 * channel + 1))
