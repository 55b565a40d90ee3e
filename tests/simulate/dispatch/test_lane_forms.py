"""Formulas for runs side by side are compiled once in a clone, not once in every process, and never in vain."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import pytest

from simulate.dispatch import lane_forms
from simulate.dispatch.lane_forms import form_for_all

SHOWN = """
from simulate.dispatch.lane_forms import form_for_all
from simulate.effects import CATALOGUE
asked = [("viscous-friction", "leg_force"), ("hub-inertia", "leg_mass"), ("curved-asymptotes", "leg_asymptotes")]
formulas = {(name, kind): getattr(CATALOGUE[name], kind) for name, kind in asked}
forms = {key: form_for_all(formula, key[1]) for key, formula in formulas.items()}
print(len(forms), *sorted(":".join(key) for key, form in forms.items() if not form.cache_hits))
"""


def compiled_anew() -> list[str]:
    """How many forms were asked for, and those that a new process has to compile."""
    return subprocess.run([sys.executable, "-c", SHOWN], capture_output=True, text=True, check=True).stdout.split()


def test_what_one_process_has_compiled_the_next_one_finds():
    compiled_anew()
    count, *missing = compiled_anew()
    assert int(count) == 3
    assert missing == []


def test_a_formula_with_a_branch_is_given_up_before_it_is_compiled(monkeypatch):
    def branched(u: float, p: Any) -> float:
        return p[0] if u > 0.1 else 0.0

    monkeypatch.setattr(lane_forms, "_kept", lambda *given: pytest.fail("it was compiled"))
    assert form_for_all(branched, "leg_mass") is None
