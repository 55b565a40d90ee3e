"""How many independent samples a residual is worth."""

from __future__ import annotations

import numpy as np

from measure.common.arrays import Array


def effective_number(residual: Array) -> float:
    """Effective sample size of a residual: n / (1 + 2 sum of its autocorrelations).

    The sum runs while the sum of two neighbouring autocorrelations is positive (Geyer 1992, initial positive sequence), so
    that noise far out does not count. White noise is worth all its samples, a slow drift a handful.
    """
    n = len(residual)
    centred = residual - residual.mean()
    power = float(centred @ centred)
    if n < 4 or power == 0.0:
        return float(n)
    spectrum = np.fft.rfft(centred, 2 * n)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[:n] / power
    pairs = correlation[: n - n % 2].reshape(-1, 2).sum(axis=1)
    end = int(np.argmax(pairs <= 0.0)) if np.any(pairs <= 0.0) else len(pairs)
    return float(np.clip(n / (2.0 * pairs[:end].sum() - 1.0), 1.0, n))
