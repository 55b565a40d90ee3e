"""Rows that are read one after the other: a film by formula, every row of it at its own instant."""

from __future__ import annotations

import numpy as np
import pytest

from measure.correlation.tracking import track_marks
from measure.footage.footage import from_array
from measure.geometry.rolling_shutter import at_one_instant

FPS, ROWS = 50.0, 120
READOUT_S = 0.8 / FPS
PLACES = [(50.0, 30.0), (50.0, 80.0)]


def _way(t):
    """At rest, then ever faster: px."""
    moved = np.maximum(t - 0.06, 0.0)
    return 400.0 * moved**2, 150.0 * moved**2


@pytest.fixture(scope="module")
def marks():
    rng = np.random.default_rng(0)
    waves = rng.normal(0.0, 0.45, (60, 2))
    phases = rng.uniform(0.0, 2 * np.pi, 60)
    row, column = np.mgrid[:ROWS, :100].astype(float)
    stack = []
    for t in np.arange(16) / FPS:
        x, y = _way(t + (row[:, :1] / (ROWS - 1) - 0.5) * READOUT_S)
        u, v = column - x, row - y
        grey = 128.0 + 8.0 * np.sum([np.sin(a * u + b * v + p) for (a, b), p in zip(waves, phases, strict=True)], axis=0)
        stack.append(np.clip(np.rint(grey + rng.normal(0.0, 1.0, grey.shape)), 0, 255).astype(np.uint8))
    return track_marks(from_array(np.array(stack)), PLACES, FPS)


def _error(marks):
    x, y = _way(marks.time_s)
    truth = np.stack([x, y], axis=-1)[:, None] + np.array(PLACES)
    return np.abs(np.stack([marks.x_px, marks.y_px], axis=-1) - truth)[:-1]  # past its last position a mark is only continued


def test_marks_are_where_they_were_when_the_middle_row_was_read(marks):
    assert _error(marks).max() > 0.3
    assert _error(at_one_instant(marks, READOUT_S, ROWS)).max() < 0.05


def test_without_a_time_nothing_changes(marks):
    assert at_one_instant(marks, 0.0, ROWS) is marks


def test_standard_deviations_follow_and_gaps_stay_gaps(marks):
    status = marks.status.copy()
    status[6, 0] = "lost"
    from dataclasses import replace

    x, y = marks.x_px.copy(), marks.y_px.copy()
    x[6, 0] = y[6, 0] = np.nan
    found = at_one_instant(replace(marks, status=status, x_px=x, y_px=y), READOUT_S, ROWS)
    assert np.isnan(found.x_px[6, 0])
    assert np.isfinite(found.x_px[np.arange(16) != 6]).all()
    ratio = found.sigma_px[8:-1, 1] / marks.sigma_px[8:-1, 1]
    assert ((ratio > 0.6) & (ratio < 1.3)).all()
