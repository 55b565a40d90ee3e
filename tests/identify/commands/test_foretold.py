"""A fit or an explanation that nobody waits for is refused before it begins, with what to give less of."""

from __future__ import annotations

from pathlib import Path

import pytest

from identify.commands import explain_gap, fit_actuator, foresight
from identify.selection import explain

DEMO = Path(__file__).resolve().parents[3] / "datasets" / "demo"
LOOP = sorted((DEMO / "loops").glob("*.csv"))[0]


def begun(*given, **named):
    raise AssertionError("begun")


@pytest.mark.parametrize(
    ("main", "words", "less"),
    [
        (fit_actuator.main, [LOOP, "-o", "fitted.toml"], "--no-suggest"),
        (explain_gap.main, [DEMO / "rig.toml", DEMO / "deployment-2.csv", "-o", "explained"], "--budget quick"),
    ],
)
def test_what_would_take_for_ever_is_refused_before_it_begins(monkeypatch, tmp_path, capsys, main, words, less):
    monkeypatch.setattr(foresight, "timed", lambda work: 1e12)
    monkeypatch.setattr(explain, "explain", begun)
    monkeypatch.chdir(tmp_path)
    assert main(list(map(str, words))) == 2
    said = capsys.readouterr().err
    assert "this would take for ever" in said
    assert less in said
    assert not list(tmp_path.iterdir())
