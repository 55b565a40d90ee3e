"""The channels of a record looked at before anything is fitted: what is wrong with each, and what is done about it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.criteria import COARSE_STEP, LONGEST_STROKE_M, MOST_SPIKES
from identify.loops.differentiation import noise_of
from identify.loops.interference import Hum, hum_of, spikes_of
from identify.loops.loop_data import Fault
from identify.loops.piled_samples import at_limits, at_rest, steps_of
from measure.common.arrays import Array
from measure.tables.loop import Loop


@dataclass(frozen=True)
class Checked:
    """A record's force as far as it can be trusted.

    force_N : (n,) without hum. sound : (n,) samples whose force is neither cut off nor a spike. noise_N : one standard deviation of the
    samples that are sound. step_N : the step of the converter where the noise does not cover it, else zero.
    """

    force_N: Array
    sound: NDArray[np.bool_]
    noise_N: float
    step_N: float
    faults: tuple[Fault, ...]


def checked(loop: Loop) -> Checked:
    """Look for hum, saturation, spikes and steps in the force, and for saturation and a strange unit in the elongation."""
    hum = hum_of(loop.time_s, loop.force_N)
    cut = at_limits(loop.time_s, loop.force_N)
    force = loop.force_N - hum.force_N if hum else loop.force_N
    noise = _noise(loop.time_s[~cut], force[~cut], loop, force)
    step = steps_of(loop.force_N[~cut])
    step = step if step > COARSE_STEP * noise else 0.0
    spikes = spikes_of(force, max(noise, step)) & ~cut
    few = bool(np.count_nonzero(spikes) <= MOST_SPIKES * len(spikes))
    found = [
        *([_hum(loop.name, hum)] if hum else []),
        *([_cut(loop, cut)] if np.any(cut) else []),
        *([_spikes(loop.name, spikes, few=few, noise_N=noise)] if np.any(spikes) else []),
        *([_steps(loop.name, step)] if step else []),
        *_of_elongation(loop),
    ]
    return Checked(force, ~(cut | (spikes & few)), noise, step, tuple(found))


def _noise(time_s: Array, force_N: Array, loop: Loop, whole: Array) -> float:
    """Of the samples that are not cut off; of all, where hardly any are left."""
    return noise_of(time_s, force_N) if len(force_N) >= len(whole) // 4 else noise_of(loop.time_s, whole)


def _hum(name: str, hum: Hum) -> Fault:
    said = f"a hum of {hum.frequency_Hz:.4g} Hz and {1e3 * hum.amplitude_N:.3g} mN is in the force; it was taken out"
    return Fault("hum", "force", name, "modelled", hum.amplitude_N, said)


def _cut(loop: Loop, cut: NDArray[np.bool_]) -> Fault:
    ends = [end for end, value in (("upper", loop.force_N.max()), ("lower", loop.force_N.min())) if np.any(cut & (loop.force_N == value))]
    limit = float(loop.force_N.max() if "upper" in ends else loop.force_N.min())
    said = (
        f"the force channel is saturated at its {' and '.join(ends)} end ({limit:.5g} N): "
        f"{100.0 * cut.mean():.0f} % of the samples are cut off or beside the limit, and were left out"
    )
    return Fault("saturated", "force", loop.name, "left out", limit, said)


def _spikes(name: str, spikes: NDArray[np.bool_], *, few: bool, noise_N: float) -> Fault:
    done = "they were left out" if few else "they are too many to leave out: try --robust"
    said = f"{np.count_nonzero(spikes)} samples of the force are spikes, single and far beyond the noise of {noise_N:.2g} N; {done}"
    return Fault("spikes", "force", name, "left out" if few else "named", float(np.count_nonzero(spikes)), said)


def _steps(name: str, step: float) -> Fault:
    said = f"the force comes in steps of {1e3 * step:.4g} mN, which the noise does not cover; the intervals are wider for it"
    return Fault("quantised", "force", name, "widened", step, said)


def _of_elongation(loop: Loop) -> list[Fault]:
    found, stroke = [], float(np.ptp(loop.elongation_m))
    cut = at_limits(loop.time_s, loop.elongation_m)
    if np.any(cut) and not at_rest(loop.elongation_m, loop.force_N):
        said = (
            f"the elongation channel is saturated: {100.0 * cut.mean():.0f} % of the samples are cut off or beside the limit, so that the "
            "turning points were not seen, and they tell beta. Move the gauge or shorten the stroke, and record again"
        )
        found.append(Fault("saturated", "elongation", loop.name, "refused", float(cut.mean()), said))
    if stroke > LONGEST_STROKE_M:
        said = f"the elongation spans {stroke:.4g} m, farther than any shaker moves. Check its unit: --unit elongation=mm"
        found.append(Fault("unit", "elongation", loop.name, "named", stroke, said))
    return found


def dwell_fault(name: str, seconds: float, count: int) -> Fault:
    """What is said of dwells."""
    said = (
        f"the drive dwells {count} times at a turning point, {seconds:.3g} s in the median; nothing moves there, whatever the gauge shows"
    )
    return Fault("dwells", "elongation", name, "modelled", seconds, said)
