"""The base is looked for again from where a name has led, also where loud noise hides how far off it is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from identify.selection import search, weighing
from identify.selection.hypotheses import BUDGETS
from identify.selection.search import Search


def stand(rms, leaves_noise, names=()) -> Any:
    problem = SimpleNamespace(first_effect=2)
    fit = SimpleNamespace(rms=rms, q=np.array([0.1, 0.2, 0.3]), problem=problem)
    both = SimpleNamespace(is_exact=False, within=object())
    within = SimpleNamespace(errors_by_key={("platform-inertia", 0): 0.5})
    exact = SimpleNamespace(given="the model file", fit=fit)
    return SimpleNamespace(fit=fit, both=both, within=within, exact=exact, leaves_noise=leaves_noise, names=set(names))


@pytest.mark.parametrize(
    ("rms", "leaves_noise", "is_elsewhere", "is_tried"),
    [(3.4, True, False, True), (3.4, False, False, True), (1.05, True, False, False), (1.05, False, False, True), (1.05, True, True, True)],
)
def test_a_base_that_is_far_off_is_led_by_what_a_name_has_found(monkeypatch, rms, leaves_noise, is_elsewhere, is_tried):
    tried = []
    monkeypatch.setattr(search, "weighed_within", lambda given, q, errors: tried.append((given, q.tolist(), errors)))
    monkeypatch.setattr(weighing, "sizes_in_tolerances", lambda fit, name: {(name, 0): -1.0})
    one = Search({}, lambda names: 0.0, BUDGETS["normal"], lambda text: None)
    monkeypatch.setattr(one, "_keep", lambda names, found: None)
    one.fitted = {(): SimpleNamespace(weighed=stand(rms, leaves_noise), fit=stand(rms, leaves_noise).fit)}  # type: ignore[dict-item]
    one._base_again(stand(1.03, True, ("end-stop-dissipation",)), is_elsewhere)
    expected = ("the model file", [0.1, 0.2], {("platform-inertia", 0): 0.5, ("end-stop-dissipation", 0): -1.0})
    assert tried == ([expected] if is_tried else [])
