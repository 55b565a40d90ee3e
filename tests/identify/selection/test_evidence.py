"""The evidence of hypotheses on small linear problems: quiet where nothing is, loud where something is, with intervals that hold."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from identify.gap.linear_pieces import Channel, Columns, Lines
from identify.noise import windows
from identify.noise.noise_model import spacing
from identify.noise.windows import Taken
from identify.selection.evidence import evidence

N = 400
TIME = np.linspace(0.0, 1.0, N)
BASE = 20.0 * np.column_stack([TIME**k for k in range(4)])
WAVE = 5.0 * np.sin(7.0 * TIME)[:, None]
BUMP = 5.0 * np.exp(-(((TIME - 0.5) / 0.1) ** 2))[:, None]


def coloured(chance, lag1):
    """Noise of unit innovations that remembers, heavy in its tails."""
    noise = chance.standard_t(5, size=N)
    for i in range(1, N):
        noise[i] += lag1 * noise[i - 1]
    return noise


def lines(gaps, errors=None):
    channel = Channel(slice(0, N), spacing(np.arange(N)))
    errors = np.empty((N, 0)) if errors is None else errors
    return Lines(gaps, BASE, errors, np.zeros(errors.shape[1]), np.zeros(4), 0.1 * np.eye(4), (channel,))


def drawn(chance, lag1=0.0, **amounts):
    shapes = {"wave": WAVE[:, 0], "bump": BUMP[:, 0]}
    return coloured(chance, lag1) + BASE @ chance.normal(size=4) + sum(amount * shapes[name] for name, amount in amounts.items())


@pytest.mark.parametrize("seed", range(5))
def test_what_is_added_to_the_gaps_is_answered_as_an_evidence_of_them_has_it(seed):
    """Base, an error within its tolerance and an effect; what of it none of these can do is left."""
    chance = np.random.default_rng(seed)
    at, own = lines(drawn(chance, 0.3, wave=1.0), BUMP), Columns.free(WAVE, 10.0)
    found = evidence(at, own)
    change = 0.1 * BASE @ chance.normal(size=4) + 0.3 * WAVE[:, 0] + 0.2 * BUMP[:, 0] + 0.1 * chance.normal(size=N)
    again = evidence(at.shifted(change), own, found.noise)
    moved = [getattr(again, name) - getattr(found, name) for name in ("step", "errors", "amounts")]
    deviation = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(found.answer_to(change) - np.concatenate(moved)) < 0.5 * deviation)
    assert np.max(np.abs(found.answer_to(change)) / deviation) > 2.0


@pytest.mark.parametrize("lag1", [0.0, 0.3, 0.6])
def test_nothing_is_more_likely_than_an_effect_where_there_is_only_noise_of_any_colour(lag1):
    chance, gains = np.random.default_rng(5), []
    for _ in range(30):
        at = lines(drawn(chance, lag1))
        gains.append(evidence(at, Columns.free(WAVE, 10.0)).log_z - evidence(at).log_z)
    assert max(gains) < 1.0
    assert np.mean(gains) < -2.0


@pytest.mark.parametrize("lag1", [0.0, 0.5])
def test_the_true_effect_has_the_largest_evidence_and_its_interval_holds(lag1):
    chance, inside = np.random.default_rng(6), []
    for _ in range(40):
        at = lines(drawn(chance, lag1, wave=1.0))
        true, other = (evidence(at, Columns.free(columns, 10.0)) for columns in (WAVE, BUMP))
        assert true.log_z > other.log_z + 3.0
        assert true.log_z > evidence(at).log_z + 2.0
        inside.append(abs(true.amounts[0] + 1.0) < 1.96 * np.sqrt(true.covariance[-1, -1]))
    assert np.mean(inside) > 0.85


@pytest.mark.parametrize("beyond", [1.0, 3.0])
def test_errors_beyond_their_tolerances_are_improbable_however_many_others_do_not_show(beyond):
    """Drawn from what is known of them beforehand, base and errors have any probability alike; ten that do not show count nothing."""
    chance, hidden, found = np.random.default_rng(8), 1e-3 * np.random.default_rng(9).normal(size=(N, 10)), []
    for _ in range(25):
        known = np.hstack([BASE, WAVE, BUMP]) @ (chance.normal(size=6) * np.array([10.0, 10.0, 10.0, 10.0, beyond, beyond]))
        found.append(evidence(lines(coloured(chance, 0.3) + known, np.hstack([WAVE, BUMP, hidden]))).prior_p)
    assert (0.35 < np.mean(found) < 0.65) == (beyond == 1.0)
    assert (np.mean(np.array(found) < 0.05) > 0.2) == (beyond > 1.0)


def test_of_a_part_only_what_is_determined_counts_but_at_least_one():
    """A wave that is far off is improbable by itself and hardly among much else; what does not show is as probable as it can be."""
    chance, hidden = np.random.default_rng(10), 1e-3 * np.random.default_rng(9).normal(size=(N, 10))
    found = evidence(
        lines(coloured(chance, 0.0) + np.hstack([BASE, WAVE]) @ np.array([10.0, -10.0, 5.0, 5.0, 2.5]), np.hstack([WAVE, hidden]))
    )
    of_wave, of_hidden = np.zeros(15), np.zeros(15)
    of_wave[4], of_hidden[5:] = 1.0, 1.0
    assert found.p_of(np.diag(of_wave)) < 0.05 < found.prior_p
    assert found.p_of(np.diag(of_hidden)) > 0.9


def test_the_colour_of_the_noise_is_found_under_the_right_hypothesis_and_not_under_a_wrong_one():
    at = lines(drawn(np.random.default_rng(7), wave=2.0))
    assert evidence(at, Columns.free(WAVE, 10.0)).noise[0].lag1 < 0.15
    assert evidence(at).noise[0].lag1 > 0.4


@pytest.mark.parametrize("seed", range(3))
def test_where_one_round_begins_with_the_noise_that_is_there_spikes_move_nothing(seed):
    """Each sample counts from the start as it does under that noise."""
    chance = np.random.default_rng(seed)
    gaps = drawn(chance, 0.5)
    gaps[chance.choice(N, 8, replace=False)] += 40.0
    whole = evidence(lines(gaps), rounds=30)
    there = replace(whole.lines, gaps=gaps + BASE @ whole.step, prior_gaps=0.1 * whole.step)
    again = evidence(there, start=whole.noise, rounds=1)
    assert again.log_likelihood == pytest.approx(whole.log_likelihood, abs=0.1)
    assert np.abs(again.step / np.sqrt(np.diag(whole.covariance))).max() < 0.1


def followed_noise(white):
    """Memory found, and the share of 95 % intervals that hold, where twelve slow parameters follow 150 samples of noise with a memory."""
    n, lag1 = 150, 0.7 if white == 0.0 else 0.8
    followed = 20.0 * np.cos(np.pi * np.arange(n)[:, None] * (np.arange(12) + 0.5) / n)
    chance, memories, off = np.random.default_rng(11), [], []
    for _ in range(60):
        noise = coloured(chance, lag1)[-n:]
        noise = noise + np.sqrt(white / (1.0 - white)) * np.std(noise) * chance.normal(size=n)
        channel = Channel(slice(0, n), spacing(np.arange(n)))
        at = Lines(noise, followed, np.empty((n, 0)), np.zeros(0), np.zeros(12), 0.01 * np.eye(12), (channel,))
        found = evidence(at)
        memories.append(found.noise[0].lag1)
        off.append(found.step / np.sqrt(np.diag(found.covariance)))
    return np.mean(memories), np.mean(np.abs(off) < 1.96)


FOLLOWED = [(True, 0.65, 0.90), (False, 0.51, 0.76)]


@pytest.mark.parametrize(("given_back", "memory", "share"), FOLLOWED)
def test_a_fit_that_follows_slow_noise_finds_its_memory_and_holds_its_intervals(monkeypatch, given_back, memory, share):
    """With what the fit takes from the noise given back, and without, which is too sure."""
    if not given_back:
        monkeypatch.setattr(Taken, "by", lambda columns, covariance, count: replace(Taken.nothing(len(columns)), count=count))
    found, held = followed_noise(white=0.0)
    assert found == pytest.approx(memory, abs=0.006)
    assert held == pytest.approx(share, abs=0.006)
    assert (abs(found - 0.7) < 0.06 and 0.88 < held < 0.99) == given_back


@pytest.mark.parametrize(("shares", "share"), [(windows._WHITE, 0.80), (np.zeros(1), 0.72)])
def test_intervals_in_noise_of_which_half_is_white_hold_better_with_both_parts_told_apart(monkeypatch, shares, share):
    """Than as noise with one memory."""
    monkeypatch.setattr(windows, "_WHITE", shares)
    for kept in (windows._newness, windows._newness_of, windows._unlikely):
        monkeypatch.setattr(windows, kept.__name__, cache(kept.__wrapped__))
    held = followed_noise(white=0.5)[1]
    assert held == pytest.approx(share, abs=0.006)


def test_a_tolerance_of_the_model_file_swallows_what_it_can_explain():
    """An effect that looks like an error of the model file has no evidence while the error is within its tolerance."""
    at = drawn(np.random.default_rng(8), wave=0.2)
    gained = [evidence(one, Columns.free(WAVE, 10.0)).log_z - evidence(one).log_z for one in (lines(at), lines(at, 0.3 * WAVE))]
    assert gained[1] < 0.0
    assert gained[1] < gained[0]


def test_a_sign_that_physics_excludes_takes_the_evidence_away():
    at = lines(drawn(np.random.default_rng(9), wave=1.0))
    free = Columns.free(WAVE, 10.0)
    bounds = {"up": (0.0, np.inf), "down": (-np.inf, 0.0)}
    held = {
        side: evidence(at, Columns(free.values, free.spread, free.at, np.array([low]), np.array([high]))).log_z
        for side, (low, high) in bounds.items()
    }
    assert held["down"] == pytest.approx(evidence(at, free).log_z + np.log(2.0), abs=0.01)
    assert held["up"] < evidence(at).log_z


def test_outliers_neither_make_an_effect_nor_hide_one():
    chance = np.random.default_rng(10)
    for amount in (0.0, 1.0):
        gaps = drawn(chance, wave=amount)
        gaps[chance.choice(N, 6)] += 40.0
        gain = evidence(lines(gaps), Columns.free(WAVE, 10.0)).log_z - evidence(lines(gaps)).log_z
        assert (gain > 3.0) == (amount > 0.0)


def test_a_channel_by_itself_is_weighed_as_two_halves_of_one():
    """Columns that do nothing in a channel are left out of it, and change nothing."""
    gaps = drawn(np.random.default_rng(11), wave=0.5)
    halves = [np.zeros((N, 4)), np.zeros((N, 4))]
    halves[0][: N // 2], halves[1][N // 2 :] = BASE[: N // 2], BASE[N // 2 :]
    channels = tuple(Channel(part, spacing(np.arange(N // 2))) for part in (slice(0, N // 2), slice(N // 2, N)))
    none, known = np.empty((N, 0)), 0.1 * np.eye(4)
    both = evidence(Lines(gaps, np.hstack(halves), none, np.empty(0), np.zeros(8), 0.1 * np.eye(8), channels))
    each = [
        evidence(
            Lines(gaps[part], BASE[part], none[part], np.empty(0), np.zeros(4), known, (Channel(slice(0, N // 2), channels[0].apart),))
        )
        for part in (slice(0, N // 2), slice(N // 2, N))
    ]
    assert both.log_z == pytest.approx(sum(one.log_z for one in each), abs=0.1)


def many(chance, count, low, high):
    """Columns of waves, each with a phase and a frequency of its own."""
    ways = zip(chance.uniform(low, high, count), chance.uniform(0.0, 7.0, count), strict=True)
    return np.column_stack([np.sin(speed * TIME + phase) for speed, phase in ways])


@pytest.mark.parametrize(("size", "free"), [(1e-3, 0), (30.0, 60)])
@pytest.mark.slow
def test_the_noise_is_as_loud_as_it_is_whatever_number_of_errors_is_allowed(size, free):
    """Errors that their tolerances hold take nothing from the residuals; those that the measurements determine do, one sample each."""
    chance, scales = np.random.default_rng(10), {"fewer": [], "more": []}
    for _ in range(25):
        gaps, errors = drawn(chance), size * many(chance, 60, 20.0, 600.0)
        scales["fewer"].append(evidence(lines(gaps)).noise[0].scale)
        scales["more"].append(evidence(lines(gaps, errors)).noise[0].scale)
    ratio = np.mean(scales["more"]) / np.mean(scales["fewer"])
    assert ratio == pytest.approx(1.0, abs=0.03 if free else 1e-4)
