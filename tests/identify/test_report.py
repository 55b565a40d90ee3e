"""The page of an explanation says what the result says, in words that cannot be misread."""

from __future__ import annotations

import re
from dataclasses import replace

from identify.evidence import p_words
from identify.report import report_html


def test_the_page_gives_every_test_its_runs(shaken):
    first, *others = shaken.next_tests
    thrice = replace(shaken, next_tests=(replace(first, runs=3), *others))
    rows = re.findall(r'<td>(a (?:deployment|loop)[^<]*)<td class="n">(\d+)', report_html(thrice, "loops", {}))
    assert rows == [(test.condition.words, str(test.runs)) for test in thrice.next_tests]


def test_a_probability_too_small_for_a_float_is_not_called_nought():
    assert p_words(0.0) == "p < 1e-300"
    assert p_words(8.14e-87) == "p = 8.1e-87"
    assert p_words(0.25) == "p = 0.25"
