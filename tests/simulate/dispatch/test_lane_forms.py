"""Formulas for runs side by side are compiled once in a clone, not once in every process."""

from __future__ import annotations

import subprocess
import sys

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
