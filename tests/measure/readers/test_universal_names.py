"""Functions of a universal file are told apart by their names, whatever library reads it."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from measure.readers.formats.universal_file import vectors


def test_two_functions_of_one_kind_are_two_vectors_and_one_of_another_keeps_its_name(monkeypatch):
    x = np.linspace(0.0, 1.0, 5)
    sets = [
        {"x": x, "data": k * x, "abscissa_spec_data_type": 17, "ordinate_spec_data_type": kind} for k, kind in ((1, 13), (2, 13), (3, 8))
    ]
    file = SimpleNamespace(get_set_types=lambda: [58, 58, 58], read_sets=lambda k: sets[k])
    monkeypatch.setitem(sys.modules, "pyuff", SimpleNamespace(UFF=lambda path: file))
    found = vectors(Path("made.uff"))
    assert list(found.values) == ["time", "force", "force (2)", "displacement"]
    assert np.array_equal(found.values["force (2)"], 2.0 * x)
    assert found.units["time"] == "s"
