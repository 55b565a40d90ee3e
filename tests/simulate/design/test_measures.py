"""Measures of a design are made of responses as their words say."""

import numpy as np
import pytest

from measure.common.errors import InputError
from simulate.design.measures import Limit, Measure, Scenarios
from simulate.model import responses

SCENARIOS = Scenarios(np.zeros((9, 1)), 6)  # the middle, six draws, two corners


def answered(theta_deg):
    answers = np.zeros((len(theta_deg), responses.COUNT))
    answers[:, responses.THETA_Z] = np.radians(theta_deg)
    answers[:, responses.DIVERGED] = np.nan
    return answers


TURNED = answered([5.0, 1.0, -2.0, 3.0, -4.0, 35.0, 6.0, 50.0, -60.0])


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("nominal:theta_z_deg", 5.0),
        ("mean:theta_z_deg", 51.0 / 6),
        ("worst:theta_z_deg", 60.0),
        ("p50:theta_z_deg", 3.5),
        ("spread:theta_z_deg", np.std([1.0, -2.0, 3.0, -4.0, 35.0, 6.0])),
        ("robust:theta_z_deg", 51.0 / 6 + 2 * np.std([1.0, 2.0, 3.0, 4.0, 35.0, 6.0])),
        ("failed_percent", 100.0 / 6),
    ],
)
def test_a_measure_is_what_its_name_says(text, value):
    assert Measure.of(text).value(TURNED, SCENARIOS, 30.0) == pytest.approx(value)
    assert str(Measure.of(text)) == text


@pytest.mark.parametrize("text", ["nominal:theta_z_deg", "mean:theta_z_deg", "worst:theta_z_deg", "p95:theta_z_deg"])
def test_a_run_that_diverged_is_infinitely_bad(text):
    answers = answered([1.0] * 9)
    answers[:7, responses.THETA_Z] = np.nan
    answers[:7, responses.DIVERGED] = 0.3
    assert Measure.of(text).value(answers, SCENARIOS, 30.0) == np.inf
    assert Measure.of("failed_percent").value(answers, SCENARIOS, 30.0) == 100.0


def test_a_limit_says_on_which_side_and_by_how_much_it_is_broken():
    below, above = Limit.of("worst:stop_force_N<60"), Limit.of("nominal:lateral_mm>2")
    assert (below.kept(59.0), below.kept(61.0), above.kept(3.0), above.kept(1.0)) == (True, False, True, False)
    assert below.excess(66.0) == pytest.approx(0.1)
    assert above.excess(1.0) == pytest.approx(0.5)
    negative, zero = Limit.of("mean:theta_z_deg>-4"), Limit.of("nominal:lateral_mm<0")
    assert negative.excess(-5.0) == pytest.approx(0.25)
    assert (zero.excess(3.0), zero.excess(-3.0)) == (3.0, -3.0), "in the unit itself where the limit is zero"
    assert [limit.kept(limit.limit) for limit in (below, above, zero)] == [True] * 3


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("worst", "no measure|no response"),
        ("best:theta_z_deg", "is no measure"),
        ("worst:theta_deg", "no response is named"),
        ("p5:theta_z_deg", "is no measure"),
        ("cost:theta_z_deg", "is no measure"),
    ],
)
def test_a_measure_that_is_none_is_refused(text, named):
    with pytest.raises(InputError, match=named):
        Measure.of(text)


@pytest.mark.parametrize("text", ["worst:theta_z_deg", "worst:theta_z_deg<", "worst:theta_z_deg<1e", "<3", "worst:theta_z_deg<=3"])
def test_a_limit_that_cannot_be_read_is_refused(text):
    with pytest.raises(InputError):
        Limit.of(text)
