"""Tables that show no noise, as a simulation writes them, given the noise of a fine instrument.

Every test asks whether a gap is more than noise. Two simulations of one rig differ by micrometres behind the stops, for their steps do,
and a table is rounded: without any noise that is a gap of a thousand noises, and an effect would be named for it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from identify.campaign.noise import lacking, lacking_in_force
from identify.campaign.run import Run
from measure.common.arrays import Array
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory


@dataclass(frozen=True)
class AddedNoise:
    """One standard deviation of the noise that a run's channel was given, in the channel's unit."""

    run: str
    channel: str
    sigma: float


def with_noise_where_none(runs: Iterable[Run]) -> tuple[tuple[Run, ...], tuple[AddedNoise, ...]]:
    """The runs, tables without noise given some, and what was given to whom.

    The draws follow from what a channel holds and from nothing else, so that an answer hangs neither on the order of the runs nor on
    a seed.
    """
    done, added = [], []
    for run in runs:
        noisy, own = _with_noise(run)
        done.append(noisy)
        added += own
    return tuple(done), tuple(added)


def _with_noise(run: Run) -> tuple[Run, list[AddedNoise]]:
    if isinstance(run.table, Loop):
        sigma = lacking_in_force(run.table.time_s, run.table.force_N)
        force = _shaken(run.table.force_N, "force_N", sigma)
        added = {"force_N": sigma}
        table: Loop | Trajectory = replace(run.table, force_N=force)
    else:
        own = run.table.sigma  # whoever says how sure a channel is has measured it
        added = {name: 0.0 if name in own else lacking(name, values) for name, values in run.table.channels.items()}
        table = replace(run.table, channels={name: _shaken(values, name, added[name]) for name, values in run.table.channels.items()})
    given = [AddedNoise(run.name, name, sigma) for name, sigma in added.items() if sigma > 0.0]
    return (replace(run, table=table) if given else run), given


def _shaken(values: Array, name: str, sigma: float) -> Array:
    if sigma == 0.0:
        return values
    digest = hashlib.sha256(name.encode() + np.ascontiguousarray(values).tobytes()).digest()
    chance = np.random.default_rng(int.from_bytes(digest[:8], "big"))
    return values + sigma * chance.standard_normal(len(values))
