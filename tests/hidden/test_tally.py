"""Scores: what counts as right, as wrong, as abstaining, and that a rate carries its interval."""

from __future__ import annotations

from typing import Any

import pytest
from board.further import Split
from board.running import Answer
from board.scoring import Scored, score
from board.specs import Spec
from board.tally import Rate, confusion, headline, single


def sealed(*names: str, alike: tuple[str, ...] = (), multiple: float = 3.0, outside: bool = False) -> dict[str, Any]:
    kinds = {0: "none", 1: "effect"}
    effects = [
        {"name": name, "values": {"f": 1.0}, "sizes": ["f"], "identifiable": True, "multiple": multiple, "class": list(alike)}
        for name in names
    ]
    return {"expected": "unknown" if outside else kinds.get(len(names), "several"), "effects": effects}


def answered(verdict: str, *findings: tuple[str, ...], ci: tuple[float, float] = (0.9, 1.1), status: int = 0) -> Answer:
    effects = [{"name": f[0], "equivalents": list(f[1:]), "parameters": {"f": {"value": 1.0, "ci95": list(ci)}}} for f in findings]
    return Answer("t", "m", "v", status, 1.0, {"verdict": verdict, "effects": effects})


def row(truth: dict[str, Any], answer: Answer, hidden: tuple[str, ...] = ("a",), size: float = 3.0) -> Scored:
    return score(Spec(hidden, size), answer, truth)


def test_the_true_effect_named_or_listed_is_class_correct_and_only_named_it_is_first():
    named, listed = row(sealed("a"), answered("named", ("a",))), row(sealed("a"), answered("class", ("b", "a")))
    assert named.class_correct
    assert named.top_one
    assert listed.class_correct
    assert not listed.top_one
    assert not listed.wrong


def test_a_name_beside_the_truth_is_wrong_even_where_the_data_cannot_tell_it_apart():
    found = row(sealed("a", alike=("b",)), answered("named", ("b",)))
    assert found.wrong
    assert not found.beyond_class
    assert row(sealed("a", alike=("b",)), answered("named", ("c",))).beyond_class


def test_a_right_name_with_a_wrong_one_beside_it_is_not_correct():
    assert not row(sealed("a"), answered("several", ("a",), ("c",))).class_correct
    assert row(sealed("a", "b"), answered("several", ("b",), ("a",)), ("a", "b")).class_correct
    assert not row(sealed("a", "b"), answered("named", ("a",)), ("a", "b")).class_correct


def test_saying_nothing_is_neither_right_nor_wrong():
    for verdict in ("no-gap", "unknown"):
        found = row(sealed("a"), answered(verdict))
        assert [found.class_correct, found.wrong, found.names] == [False] * 3


def test_intervals_count_for_the_true_effect_only():
    assert (row(sealed("a"), answered("named", ("a",))).inside, row(sealed("a"), answered("named", ("a",), ci=(1.2, 1.4))).inside) == (1, 0)
    assert row(sealed("a"), answered("named", ("c",))).intervals == 0


def test_a_process_that_fails_is_counted_and_not_dropped():
    found = row(sealed("a"), Answer("t", "m", "v", 2, 1.0, {"error": "no"}))
    assert found.verdict == "failed"
    assert headline([found])[-1].hits == 1
    assert single([found]) == [found]


def test_an_effect_cut_short_by_its_bounds_does_not_count_for_its_size():
    assert single([row(sealed("a", multiple=1.4), answered("named", ("a",)))]) == []


def test_a_rate_of_none_in_twenty_may_still_be_seventeen_per_cent():
    # 1 - 0.025 ** (1 / 20), the exact binomial bound
    assert Rate("r", 0, 20).interval == pytest.approx((0.0, 1.0 - 0.025 ** (1 / 20)))


def test_confusion_says_who_was_taken_for_whom():
    rows = [row(sealed("a"), answered("named", ("a",))), row(sealed("a"), answered("named", ("b",))), row(sealed("a"), answered("no-gap"))]
    assert confusion(rows) == {"a": {"a": 1, "b": 1, "no-gap": 1}}


@pytest.mark.parametrize(
    ("after", "smaller", "split", "settled"),
    [
        (("a", "b", "c"), False, False, False),
        (("a", "b"), True, True, False),
        (("b", "a", "d"), True, False, False),  # one has gone and another has come
        (("a",), True, True, True),
        (("b",), False, False, False),  # the truth has gone
    ],
)
def test_a_class_is_split_where_something_else_than_the_truth_goes_and_nothing_comes(after, smaller, split, settled):
    before = row(sealed("a"), answered("class", ("a", "b", "c")))
    done = Split(before.spec, before, row(sealed("a"), answered("named" if len(after) == 1 else "class", after)), 1.0)
    assert (done.smaller, done.split, done.settled) == (smaller, split, settled)
