"""A Gaussian process on what is left, over time and the conditions of a run: it closes the gap and names nothing."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from identify.estimation.problem import Fit

from .asking import Asked, Said, answer, held_fit

Array = np.ndarray
_MOST = 600  # samples of a channel; the cost grows with their third power


def main(arguments: Sequence[str]) -> int:
    """Takes the words of explain-gap."""
    return answer(arguments, think)


def think(asked: Asked) -> Said:
    """One process for each channel; the held-out runs are foretold by it."""
    learned = {channel: _learned(*rows) for channel, rows in _rows(asked.before).items()}
    left = []
    for run in asked.held:
        for channel, (x, gap) in _rows(held_fit(asked, run, asked.before)).items():
            left.append(gap - learned[channel].predict(x) if channel in learned else gap)
    held_out = float(np.sqrt(np.mean(np.concatenate(left) ** 2))) if left else None
    return Said((), verdict="names-nothing", held_out=held_out)


def _rows(fit: Fit) -> dict[str, tuple[Array, Array]]:
    """For each channel: time, start height and mass (or elongation, speed and frequency of a loop) and the gap over the noise."""
    found: dict[str, list[tuple[Array, Array]]] = {}
    films = {film.run.name: film for film in fit.problem.films}
    loops = {loop.run.name: loop for loop in fit.problem.loops}
    for block in fit.problem.blocks:
        if block.run in films:
            model, t = films[block.run].model, films[block.run].time_s[block.samples]
            height = 0.0 if model.geometry is None else model.geometry.stowed_height_m
            x = np.column_stack([t / 0.05, np.full(len(t), height / 0.05), np.full(len(t), model.platform.mass_kg / 0.2)])
        else:
            d = loops[block.run].data
            x = np.column_stack([d.elongation_m[d.used] / 0.01, d.speed_m_per_s[d.used] / 0.1, np.full(d.used.sum(), d.frequency_Hz)])
        found.setdefault(block.channel, []).append((x, fit.part(block)))
    return {channel: (np.concatenate([x for x, _ in parts]), np.concatenate([g for _, g in parts])) for channel, parts in found.items()}


def _learned(x: Array, gap: Array) -> Any:
    kept = np.linspace(0, len(gap) - 1, min(len(gap), _MOST)).astype(int)
    size = max(float(np.var(gap)), 1e-6)
    lengths: Any = [1.0, 3.0, 3.0]  # scikit-learn's annotations know of one only
    kernel = ConstantKernel(size, (1e-6 * size, 1e3 * size)) * RBF(lengths, (1e-2, 1e3)) + WhiteKernel(1.0, (1e-2, 1e2))
    return GaussianProcessRegressor(kernel, random_state=0).fit(x[kept], gap[kept])
