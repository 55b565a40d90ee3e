"""How large a gap is: root mean square over the noise of what is no spike."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from identify.campaign.noise import high_frequency
from identify.criteria import SPIKE
from identify.loops.interference import jumps
from measure.common.arrays import Array


def gap_size(parts: Iterable[Array]) -> float:
    """Root mean square of gaps, (n,) for each run and channel in units of the noise; single samples far beyond it do not count.

    A tracker or a converter that slips makes them, and a missing effect never does: it moves neighbours alike.
    """
    kept = np.concatenate([without_spikes(one) for one in parts])
    return float(np.sqrt(np.mean(kept**2)))


def without_spikes(gaps: Array) -> Array:
    """The gaps (n,) of a run and channel less the samples that stand off both neighbours by far more than the noise."""
    return gaps[jumps(gaps) <= SPIKE * max(1.0, high_frequency(gaps, np.ones(len(gaps))))]
