"""What chance alone does, against what is known of Gaussian noise; and which effect stands first in spite of it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import chi2

from identify.estimation.fit import Fit
from identify.selection.candidate_fits import Candidate
from identify.selection.comparison import best_first
from identify.selection.gap_test import Gain, Signature
from identify.selection.null_hypothesis import (
    chance_of_lead,
    chance_of_likeness,
    family,
    gained_by,
    inflation,
    noise_like,
)
from simulate.effects import CentreOfMassOffset, LegDisparity

N = 512


def fit_of(gaps: np.ndarray, jacobian: np.ndarray) -> Fit:
    """A fit of one channel of one run, without a simulation behind it."""
    block = SimpleNamespace(run="run", channel="z_m", rows=slice(0, len(gaps)), samples=np.arange(len(gaps)))
    problem: Any = SimpleNamespace(blocks=(block,), measured=len(gaps), first_effect=1)
    return Fit(problem, np.zeros(jacobian.shape[1]), gaps, jacobian, True)


def waves(*turns: int) -> np.ndarray:
    """Unit columns (N, k) of so many half turns each, perpendicular to one another."""
    at = (np.arange(N) + 0.5) / N
    return np.stack([np.cos(np.pi * k * at) * np.sqrt(2 / N) for k in turns], axis=1)


def fitted(data: np.ndarray, columns: np.ndarray) -> Fit:
    """The least-squares fit of columns to data: gaps are data minus model."""
    return fit_of(data - columns @ (columns.T @ data), -columns)


def test_redrawn_noise_is_as_loud_as_the_noise_that_is_left():
    gaps = 3.0 * np.random.default_rng(1).normal(size=N)
    drawn = noise_like(fit_of(gaps, waves(1)))
    assert np.std(drawn) == pytest.approx(3.0, rel=0.1)
    assert np.array_equal(drawn, noise_like(fit_of(gaps, waves(1))))


def test_slow_noise_is_redrawn_slow():
    chance = np.random.default_rng(2)
    slow = waves(*range(1, 9)) @ chance.normal(size=8) * 40.0
    drawn = noise_like(fit_of(slow + chance.normal(size=N), waves(1)))
    power = np.mean((waves(*range(1, 400)).T @ drawn) ** 2, axis=1)
    assert power[:7].mean() > 100.0 * power[200:].mean()
    assert power[200:].mean() == pytest.approx(1.0, rel=0.25)


def test_an_effect_gains_chi_squared_from_white_noise_and_more_from_slow_noise():
    chance = np.random.default_rng(3)
    white = fit_of(chance.normal(size=N), np.hstack([waves(3), waves(5)]))
    assert inflation(white, 1, noise_like(white)) == pytest.approx(1.0, abs=0.5)
    slow = fit_of(chance.normal(size=N) + waves(*range(1, 9)) @ chance.normal(size=8) * 20.0, np.hstack([waves(3), waves(5)]))
    assert inflation(slow, 1, noise_like(slow)) > 20.0


@pytest.mark.parametrize("effects", [1, 5, 20])
def test_as_many_looks_as_effects_that_have_nothing_in_common(effects):
    noise = np.random.default_rng(4).normal(size=(N, 4000))
    own = [Signature(waves(k), np.array([0]), 0.0) for k in range(1, effects + 1)]
    assert family(own, noise).tests == pytest.approx(effects, rel=0.15)
    same = [Signature(waves(1), np.array([0]), 0.0)] * effects
    assert family(same, noise).tests == pytest.approx(1.0, rel=0.1)


def test_the_best_of_many_looks_is_found_in_noise_as_often_as_said():
    chance = np.random.default_rng(5)
    signatures = [Signature(waves(k), np.array([0]), 0.0) for k in range(1, 11)]
    tests = family(signatures, chance.normal(size=(N, 4000)))
    found = 0
    for _ in range(400):
        noise = chance.normal(size=(N, 1))
        gained = max(float(gained_by(s.columns, noise)[0]) for s in signatures)
        found += tests.p_value(float(chi2.sf(gained, 1))) < 0.05
    assert 0.02 < found / 400 < 0.09


def test_a_true_rival_is_excluded_no_more_often_than_said():
    """Two effects with signatures 30 deg apart; the truth is the rival, and it is excluded where it is led by chance."""
    a = waves(2)
    b = np.cos(np.pi / 6) * waves(2) + np.sin(np.pi / 6) * waves(9)
    chance = np.random.default_rng(6)
    led, excluded = 0, 0
    for _ in range(300):
        data = 2.5 * b[:, 0] + chance.normal(size=N)
        best, rival = sorted((fitted(data, a), fitted(data, b)), key=lambda fit: fit.cost)
        if np.allclose(rival.jacobian, -b):
            led += 1
            excluded += chance_of_lead(best, rival, chance.normal(size=(N, 200))) < 0.05
    assert led > 20
    assert excluded <= 0.08 * 300  # two standard deviations of chance above one in twenty


def test_a_wrong_rival_is_excluded_where_the_effect_is_large():
    a = waves(2)
    b = np.cos(np.pi / 6) * waves(2) + np.sin(np.pi / 6) * waves(9)
    chance = np.random.default_rng(7)
    data = 20.0 * a[:, 0] + chance.normal(size=N)
    assert chance_of_lead(fitted(data, a), fitted(data, b), chance.normal(size=(N, 500))) < 0.01


BASE, ALONE, OTHERS = waves(1), waves(2), waves(4, 6, 8)


def rivals(data: np.ndarray, many: np.ndarray) -> tuple[Fit, Fit, Fit]:
    """Fits of the base, of the base with one column, and of the base with many."""
    others = np.linalg.lstsq(np.hstack([BASE, many]), data, rcond=None)[0]
    with_many = fit_of(data - np.hstack([BASE, many]) @ others, -np.hstack([BASE, many]))
    return fitted(data, BASE), fitted(data, np.hstack([BASE, ALONE])), with_many


@pytest.mark.parametrize("strength", [60.0, 400.0])
def test_a_true_effect_of_many_parameters_looks_so_like_a_plain_one_as_often_as_said(strength):
    """Its parameters point anywhere; in one case of ten its chance is below a tenth, whatever its strength."""
    chance, many = np.random.default_rng(8), np.hstack([ALONE, OTHERS])
    said = []
    for _ in range(300):
        way = many @ chance.normal(size=4)
        data = np.sqrt(strength) * way / np.linalg.norm(way) + chance.normal(size=N)
        said.append(chance_of_likeness(*rivals(data, many), slack=0.0))
    assert np.mean(np.array(said) < 0.1) == pytest.approx(0.1, abs=0.05)


def test_an_effect_that_could_have_been_anything_is_no_rival_of_the_plain_one_that_is_true():
    chance, many = np.random.default_rng(9), np.hstack([ALONE, OTHERS])
    said = [chance_of_likeness(*rivals(20.0 * ALONE[:, 0] + chance.normal(size=N), many), slack=1.0) for _ in range(50)]
    assert np.mean(np.array(said) < 0.01) > 0.9


def test_parameters_that_hardly_show_are_not_held_against_a_rival():
    """Of four parameters one shows, and what it shows is what the plain effect shows."""
    chance, many = np.random.default_rng(10), np.hstack([ALONE, 1e-3 * OTHERS])
    said = [chance_of_likeness(*rivals(20.0 * ALONE[:, 0] + chance.normal(size=N), many), slack=1.0) for _ in range(50)]
    assert np.min(said) > 0.01


def test_an_effect_speaks_with_the_parameters_that_show():
    columns = np.hstack([BASE, 100.0 * ALONE, 100.0 * ALONE, OTHERS[:, :1], 1e-3 * OTHERS[:, 1:2], 5.0 * BASE])
    assert fit_of(np.zeros(N), columns).effective_parameters == pytest.approx(1.0 + 0.5, abs=1e-3)


PLAIN, FURTHER = 1e3 * waves(2, 4), 1e3 * waves(6, 8, 10)
MANY = np.hstack([PLAIN, FURTHER])


def fitted_beside_base(data: np.ndarray, columns: np.ndarray) -> Fit:
    whole = np.hstack([BASE, columns])
    return fit_of(data - whole @ np.linalg.lstsq(whole, data, rcond=None)[0], -whole)


def candidate(effect: Any, fit: Fit) -> Candidate:
    return Candidate(effect, fit, Gain(0.0, 0, 1.0, 0.0), Signature(np.empty((N, 0)), np.empty(0, dtype=np.intp), 0.0))


def share_first(name: str, signal: np.ndarray, draws: int = 300) -> float:
    chance = np.random.default_rng(11)
    first = []
    for _ in range(draws):
        data = signal + chance.normal(size=N)
        tried = [
            candidate(CentreOfMassOffset(), fitted_beside_base(data, PLAIN)),
            candidate(LegDisparity(), fitted_beside_base(data, MANY)),
        ]
        first.append(best_first(fitted_beside_base(data, np.empty((N, 0))), tried)[0].name)
    return float(np.mean([found == name for found in first]))


@pytest.mark.parametrize("strength", [30.0, 150.0, 5000.0])
def test_a_plain_effect_that_is_true_stands_before_one_that_imitates_it(strength):
    assert share_first("centre-of-mass-offset", np.sqrt(strength) * waves(2)[:, 0]) > 0.95


def test_an_effect_with_many_numbers_stands_first_where_a_plain_one_leaves_what_a_test_on_the_rest_would_find():
    """What is left for the three numbers that the plain one lacks is more than a test at p = 1e-3 on them finds half of the time."""
    assert share_first("leg-disparity", np.sqrt(60.0) * waves(2)[:, 0] + np.sqrt(18.0) * waves(8)[:, 0]) > 0.8
