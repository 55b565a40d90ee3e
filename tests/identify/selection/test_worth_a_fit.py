"""Which hypotheses that were only weighed are worth a fit: straight lines promise too little beside nothing, where a law has bent."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from identify.criteria import LOSES
from identify.selection.hypotheses import BUDGETS
from identify.selection.search import Search


def hypothesis(names, log_weight) -> Any:
    return SimpleNamespace(
        names=names, log_weight=log_weight, is_believable=True, fit=SimpleNamespace(rms=1.0), weighed=SimpleNamespace(leaves_noise=True)
    )


def promised(names, log_weight) -> Any:
    return SimpleNamespace(names=names, log_weight=log_weight, promise=object(), beside=None)


@pytest.mark.parametrize(
    ("foremost", "less", "is_worth"), [((), 0.9 * LOSES, True), ((), 1.1 * LOSES, False), (("hub-inertia",), 0.5, False)]
)
def test_a_name_promised_a_little_less_than_nothing_is_fitted_and_one_more_beside_a_name_is_not(foremost, less, is_worth):
    search = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    search.fitted = {(): hypothesis((), -100.0), foremost: hypothesis(foremost, -50.0)}
    one = promised(tuple(sorted((*foremost, "platform-mass"))), -50.0 - less)
    assert search._is_worth_a_fit(one) == is_worth
