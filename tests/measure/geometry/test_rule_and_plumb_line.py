"""Pitch and plumb line of lines that are drawn by hand, and the lines that are none."""

from __future__ import annotations

import numpy as np
import pytest

from measure.common.errors import InputError
from measure.geometry.rule_and_plumb_line import pitch_along, plumb_line

ROWS, COLUMNS = 60, 300


def rule(pitch, thickness=1.0, noise=2.0, seed=0, every=2):
    """Dark marks across the picture, the first at 20 px; soft edges, exact everywhere."""
    x = np.arange(COLUMNS) - 20.0
    marks = sum(np.exp(-0.5 * ((x - n * pitch) / thickness) ** 2) * (1.0 + 0.3 * (n % every == 0)) for n in range(int(260 / pitch) + 1))
    grey = 190.0 - 90.0 * np.asarray(marks) + np.random.default_rng(seed).normal(0.0, noise, (ROWS, COLUMNS))
    return np.rint(grey).clip(0, 255).astype(np.uint8)


def waves(pitch):
    """A graduation without overtones, which would show at a place of their own where they are finer than two pixels."""
    grey = 130.0 + 60.0 * np.cos(2.0 * np.pi * np.arange(COLUMNS) / pitch)
    return np.rint(grey + np.random.default_rng(0).normal(0.0, 2.0, (ROWS, COLUMNS))).astype(np.uint8)


ALONG = (20.0, 30.0, 270.0, 30.0)


@pytest.mark.parametrize("turned", [lambda p, line: (p, line), lambda p, line: (p, (line[2], line[3], line[0], line[1]))])
@pytest.mark.parametrize("pitch", [5.37, 9.8, 15.25])
def test_a_pitch_is_the_same_whichever_way_the_line_is_drawn(pitch, turned):
    picture, line = turned(rule(pitch), ALONG)
    found, sigma = pitch_along(picture, line)
    assert found == pytest.approx(pitch, rel=5e-4)
    assert sigma < 0.01
    upright = pitch_along(picture.T.copy(), (line[1], line[0], line[3], line[2]))
    assert upright[0] == pytest.approx(found, rel=1e-6)


def test_a_slope_of_the_light_and_thin_marks_change_nothing():
    """Thin marks have overtones nearly as strong as the graduation."""
    lit = rule(12.3, thickness=0.6) * np.linspace(0.5, 1.0, COLUMNS)
    assert pitch_along(np.rint(lit).astype(np.uint8), ALONG)[0] == pytest.approx(12.3, rel=1e-3)


def test_over_many_rules_the_pitch_scatters_about_as_its_sigma_says():
    pitches = np.random.default_rng(1).uniform(5.0, 14.0, 40)
    ratios = [
        (found - pitch) / sigma for n, pitch in enumerate(pitches) for found, sigma in [pitch_along(rule(pitch, noise=6.0, seed=n), ALONG)]
    ]
    assert 0.4 < np.sqrt(np.mean(np.square(ratios))) < 1.6


def test_too_few_or_too_fine_divisions_are_no_graduation():
    with pytest.raises(InputError, match="no graduation"):
        pitch_along(rule(9.8), (20.0, 30.0, 80.0, 30.0))
    assert pitch_along(rule(9.8), (20.0, 30.0, 120.0, 30.0))[0] == pytest.approx(9.8, rel=5e-3)
    with pytest.raises(InputError, match="over 8 divisions at least, each 3 px or more"):
        pitch_along(waves(2.6), ALONG)
    assert pitch_along(waves(3.3), ALONG)[0] == pytest.approx(3.3, rel=2e-3)


def test_marks_at_random_are_no_graduation():
    x = np.arange(COLUMNS)
    places = np.cumsum(np.random.default_rng(3).uniform(4.0, 14.0, 30)) + 10.0
    grey = 190.0 - 120.0 * sum(np.exp(-0.5 * ((x - place) / 1.2) ** 2) for place in places)
    with pytest.raises(InputError, match=r"no graduation on the line"):
        pitch_along(np.tile(np.rint(grey).clip(0, 255).astype(np.uint8), (ROWS, 1)), ALONG)


def test_a_line_has_sixteen_pixels_within_the_picture():
    picture = rule(5.0)
    for line in ((0.0, 0.0, 299.0, 59.0), (0.0, 59.0, 299.0, 59.0), (299.0, 0.0, 299.0, 59.0)):
        for measure in (pitch_along, plumb_line):
            try:
                measure(picture, line)
            except InputError as error:
                assert "reaches out" not in str(error)  # noqa: PT017
    for line in ((-0.5, 0.0, 99.0, 9.0), (0.0, 0.0, 299.5, 9.0), (0.0, -0.5, 99.0, 9.0), (0.0, 0.0, 99.0, 59.5)):
        with pytest.raises(InputError, match="reaches out of the picture of 300 x 60 px"):
            pitch_along(picture, line)
    with pytest.raises(InputError, match=r"is 15.9 px long; give points at least 16 px apart"):
        pitch_along(picture, (20.0, 30.0, 35.9, 30.0))


def hanging(lean_deg, bright=False, width=0.8, noise=2.0, seed=0):
    """A line through the middle that leans clockwise from the vertical."""
    y, x = np.mgrid[:240, :90].astype(float)
    off = (x - 44.6) * np.cos(np.radians(lean_deg)) + (y - 120.0) * np.sin(np.radians(lean_deg))
    line = np.exp(-0.5 * (off / width) ** 2)
    grey = 60 + 150 * line if bright else 180 - 110 * line
    return np.rint(grey + np.random.default_rng(seed).normal(0.0, noise, x.shape)).clip(0, 255).astype(np.uint8)


@pytest.mark.parametrize("lean", [-1.8, 0.0, 1.1])
@pytest.mark.parametrize("bright", [True, False])
def test_up_is_where_the_line_hangs_from_whichever_point_is_named_first(lean, bright):
    picture = hanging(lean, bright)
    for line in ((44.0, 20.0, 45.0, 220.0), (45.0, 220.0, 44.0, 20.0)):
        up, sigma = plumb_line(picture, line)
        assert up == pytest.approx(lean, abs=0.03)
        assert 0.005 < sigma < 0.05


def test_a_longer_line_is_better_known():
    picture = hanging(0.5)
    long, short = (plumb_line(picture, (44.6, 120.0 - half, 44.6, 120.0 + half))[1] for half in (100.0, 25.0))
    assert 3.0 < short / long < 16.0


def test_what_crosses_the_line_is_left_out():
    picture = hanging(0.7)
    picture[60:75, 40:60] = 20
    picture[150:158, 30:50] = 250
    assert plumb_line(picture, (44.0, 20.0, 45.0, 220.0))[0] == pytest.approx(0.7, abs=0.05)


def test_a_line_must_stand_out_along_half_of_its_length_and_lie_within_eight_pixels():
    picture, blank = hanging(0.0), hanging(0.0, noise=2.0, seed=5)
    blank[:, :] = np.rint(180 + np.random.default_rng(0).normal(0.0, 2.0, blank.shape))
    for share, found in ((0.7, True), (0.3, False)):
        mixed = blank.copy()
        mixed[20 : 20 + int(200 * share)] = picture[20 : 20 + int(200 * share)]
        if found:
            assert plumb_line(mixed, (44.6, 20.0, 44.6, 220.0))[0] == pytest.approx(0.0, abs=0.1)
        else:
            with pytest.raises(InputError, match="no thin line within 8 px"):
                plumb_line(mixed, (44.6, 20.0, 44.6, 220.0))
    with pytest.raises(InputError, match="no thin line"):
        plumb_line(blank, (44.6, 20.0, 44.6, 220.0))
    assert plumb_line(picture, (38.0, 20.0, 38.0, 220.0))[0] == pytest.approx(0.0, abs=0.03)
    with pytest.raises(InputError, match="no thin line"):
        plumb_line(picture, (30.0, 20.0, 30.0, 220.0))
