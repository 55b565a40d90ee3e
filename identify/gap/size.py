"""How large a gap is, root mean square over the noise, spikes apart; and how large an effect must be to be found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.campaign.noise import high_frequency
from identify.criteria import HALF, SPIKE
from identify.estimation.fit import Block, Fitted, Posed
from identify.loops.interference import jumps
from identify.noise.noise_model import ChannelNoise
from measure.common.arrays import Array
from simulate.model.effect import Effect

_OUTLIER = 4.0  # scales of Student's t


def gap_size(parts: Iterable[Array]) -> float:
    """Root mean square of gaps, (n,) for each run and channel in units of the noise; single samples far beyond it do not count.

    A tracker or a converter that slips makes them, and a missing effect never does: it moves neighbours alike.
    """
    kept = np.concatenate([without_spikes(one) for one in parts])
    return float(np.sqrt(np.mean(kept**2)))


def without_spikes(gaps: Array) -> Array:
    """The gaps (n,) of a run and channel less the samples that stand off both neighbours by far more than the noise."""
    return gaps[jumps(gaps) <= SPIKE * max(1.0, high_frequency(gaps, np.ones(len(gaps))))]


@dataclass(frozen=True)
class NoiseOfChannel:
    """sigma : standard deviation in the channel's unit. rows : of the gap vector. over : sigma in units of that which the channel was taken
    to have. model : what whitens it."""

    run: str
    channel: str
    sigma: float
    outliers_percent: float
    rows: slice
    over: float
    model: ChannelNoise

    @property
    def lag1(self) -> float:
        """Correlation from sample to sample."""
        return self.model.lag1


def noise_of_channels(
    blocks: Sequence[Block], sigmas: Sequence[float], models: Sequence[ChannelNoise], left: Sequence[Array]
) -> tuple[NoiseOfChannel, ...]:
    """The noise of every run and channel under a hypothesis: what it leaves, outliers apart, root mean square, and how that remembers.

    Parameters
    ----------
    blocks : the channels of a gap vector. sigmas : the noise that each was taken to have, in its unit. models : what whitens each.
    left : innovations over their scales, (n,) of each.
    """
    made = []
    for block, sigma, noise, innovations in zip(blocks, sigmas, models, left, strict=True):
        far = np.abs(innovations) > _OUTLIER
        over = noise.scale * float(np.sqrt(np.mean(innovations[~far] ** 2)))
        outliers = 100.0 * float(np.mean(far))
        made.append(NoiseOfChannel(block.run, block.channel, over * sigma, outliers, block.rows, over, noise))
    return tuple(made)


def as_measured(noise: Sequence[NoiseOfChannel]) -> tuple[NoiseOfChannel, ...]:
    """The noise that the fast part of each channel shows, where what is left is no noise."""
    return tuple(replace(one, over=1.0) for one in noise)


def gap_left(*fits: Fitted[Posed]) -> float:
    """Root mean square of what fits leave, together, over the noise that the measurements were taken to have; spikes apart."""
    return gap_size(fit.part(block) for fit in fits for block in fit.problem.blocks)


def rms_over_noise(fit: Fitted[Posed], noise: Sequence[NoiseOfChannel]) -> float:
    """Root mean square of a fit's gap in units of the estimated noise, spikes apart."""
    return gap_size(fit.gaps[one.rows] / one.over for one in noise)


def noise_over_stated(noise: Sequence[NoiseOfChannel], apart: Sequence[Fitted[Posed]]) -> float:
    """Noise of runs that took no part over what their tables were taken to have, at least one: that of the same channels elsewhere."""
    channels = {block.channel for fit in apart for block in fit.problem.blocks}
    return max(1.0, float(np.median([one.over for one in noise if one.channel in channels] or [1.0])))


def share_closed(before: Fitted[Posed], after: Fitted[Posed], noise: Sequence[NoiseOfChannel]) -> float:
    """Part of the excess over noise that goes, 0 to 1."""
    was, is_now = rms_over_noise(before, noise) ** 2, rms_over_noise(after, noise) ** 2
    excess = was - min(1.0, is_now)
    return float(np.clip((was - is_now) / excess, 0.0, 1.0)) if excess > 0.0 else 0.0


def halves(before: Fitted[Posed], after: Fitted[Posed]) -> bool:
    """Whether a fit leaves at most half of what another leaves beyond the noise, in squares."""
    return max(after.rms**2 - 1.0, 0.0) <= HALF * max(before.rms**2 - 1.0, 0.0)


@dataclass(frozen=True)
class DetectionLimit:
    """What could have been seen of one effect.

    sizes : for each parameter, alone, the smallest size that would be found nine times out of ten, in its unit, whatever the
    effect's shape (a frequency, a time constant) of those from which a search starts. easiest : the same for the shape that shows
    most. NaN where the measurements do not show it within its bounds, or base and releases can do the same.
    """

    effect: Effect
    sizes: Mapping[str, float]
    easiest: Mapping[str, float]
