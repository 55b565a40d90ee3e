"""What a result says in words."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from identify.report.result import _likelier, _or_nothing


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ({"no-gap": 0.9, "platform-mass": 0.1}, ""),
        ({"platform-mass": 0.62, "no-gap": 0.33}, "; platform-mass would explain it too and is likelier (0.62 to 0.33), but not sure"),
        ({"unknown": 0.6, "no-gap": 0.3}, "; a force without a name would explain it too and is likelier (0.60 to 0.30), but not sure"),
        ({"geometry-error": 0.9, "no-gap": 0.02}, ""),
        ({}, ""),
    ],
)
def test_where_nothing_is_not_excluded_but_less_likely_the_likelier_name_is_said(weights, said):
    """Joints that were fitted and came out within their tolerances are said with these."""
    problem = SimpleNamespace(effects=(SimpleNamespace(name="geometry-error"),))
    found: Any = SimpleNamespace(weights=weights, after=SimpleNamespace(problem=problem))
    assert _likelier(found) == said


@pytest.mark.parametrize(
    ("verdict", "nothing", "said"),
    [("class", 0.068, ", or nothing at all (0.07)"), ("class", 0.04, ""), ("named", 0.02, ""), ("partly", 0.3, "")],
)
def test_a_class_that_cannot_exclude_nothing_says_so(verdict, nothing, said):
    found: Any = SimpleNamespace(verdict=verdict, weights={"platform-mass": 1.0 - nothing, "no-gap": nothing})
    assert _or_nothing(found) == said
