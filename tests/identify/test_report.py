"""The page of an explanation says what the result says, in words that cannot be misread."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from identify.campaign import read_campaign
from identify.evidence import p_words
from identify.explain import explain
from identify.report import report_html
from simulate.model_file import read_model

DEMO = Path(__file__).resolve().parents[2] / "datasets" / "demo"


def test_loops_alone_are_told_to_add_a_plain_deployment_and_every_test_its_runs():
    """A shaker cannot tell a heavy hub from heavy legs."""
    found = explain(read_model(DEMO / "rig.toml"), read_campaign(sorted((DEMO / "loops").glob("*.csv"))))
    first, *others = found.next_tests
    assert first.condition.words == "a deployment as the model describes it"
    assert not any("film" in test.condition.words for test in others)
    thrice = replace(found, next_tests=(replace(first, runs=3), *others))
    rows = re.findall(r'<td>(a (?:deployment|loop)[^<]*)<td class="n">(\d+)', report_html(thrice, "loops", {}))
    assert rows == [(test.condition.words, str(test.runs)) for test in thrice.next_tests]


def test_a_probability_too_small_for_a_float_is_not_called_nought():
    assert p_words(0.0) == "p < 1e-300"
    assert p_words(8.14e-87) == "p = 8.1e-87"
    assert p_words(0.25) == "p = 0.25"
