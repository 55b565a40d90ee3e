"""Formulas for runs side by side are compiled once in a clone, not once in every process."""

from __future__ import annotations

import subprocess
import sys

SHOWN = """
from simulate.dispatch.lane_forms import lanes_form
from simulate.effects import CATALOGUE
kinds = ("leg_force", "leg_mass", "strip_elongation", "leg_asymptotes", "leg_transverse")
formulas = {(name, kind): getattr(effect, kind) for name, effect in CATALOGUE.items() for kind in kinds}
forms = {key: lanes_form(formula, key[1]) for key, formula in formulas.items() if formula}
print(len(forms), *sorted(":".join(key) for key, form in forms.items() if form is not None and not form.cache_hits))
"""


def compiled_anew() -> list[str]:
    """How many forms there are in the catalogue, and those that a new process has to compile."""
    return subprocess.run([sys.executable, "-c", SHOWN], capture_output=True, text=True, check=True).stdout.split()


def test_what_one_process_has_compiled_the_next_one_finds():
    compiled_anew()
    count, *missing = compiled_anew()
    assert int(count) > 10
    assert missing == []
