"""Files as laboratories leave them, one for each thing that was met: each ends in the right law, or in one sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identify.commands.fit_actuator import main
from simulate.loop import loop_force

LINES = np.array([-0.25, 2.79, -0.3, 2.89, 400.0])
RATE = 200.0
HALF_HEIGHT = (0.1 - 0.05 * 0.25) / 2.0


class Record:
    """A test of 5.3 cycles at 1 Hz, 40 mm to each side of 250 mm, with the noise of laser and load cell."""

    def __init__(self, u=None, t=None, lines=LINES):
        self.t = np.arange(1060) / RATE if t is None else t
        self.u = 0.25 + 0.04 * np.sin(2 * np.pi * self.t) if u is None else u
        chance = np.random.default_rng(6)
        self.f = loop_force(lines, self.t, self.u, 0 * self.t, 0 * self.t, 2.8) + 2e-3 * chance.standard_normal(len(self.t))
        self.u = self.u + 1e-5 * chance.standard_normal(len(self.t))

    def taken(self, rows):
        self.t, self.u, self.f = self.t[rows], self.u[rows], self.f[rows]
        return self


def text(header, *columns, delimiter=",", decimal=".", digits=7):
    rows = [delimiter.join(f"{x:.{digits}f}".replace(".", decimal) for x in row) for row in zip(*columns, strict=True)]
    return "\n".join([*([header] if header else []), *rows]) + "\n"


def own(record):
    return text("time_s,elongation_m,force_N", record.t, record.u, record.f)


R = Record()
NUMBERED = ["--column", "time=1", "--column", "elongation=2", "--column", "force=3"]
UNITS = ["--unit", "time=s", "--unit", "elongation=mm", "--unit", "force=N"]
IDLE = np.concatenate([np.full(400, 0.25), Record().u, np.full(300, 0.25 + 0.04 * np.sin(2 * np.pi * 5.295))])
JITTERED = np.concatenate([[0.0], 0.28 + np.cumsum(np.random.default_rng(2).uniform(0.003, 0.008, 1059))])
SHUFFLED = np.concatenate([np.arange(500, 1060), np.arange(500)])
DRIFTING = 0.25 + 0.04 * np.sin(2 * np.pi * R.t) + 0.62 * 0.08 * R.t / R.t[-1]
RAMPS = 0.25 + 0.04 * (4 * np.abs((R.t * 0.45 + 0.25) % 1 - 0.5) - 1)
ROUGH = Record()
ROUGH.u = np.round(ROUGH.u / 5e-6) * 5e-6

QUOTED = "\n".join(
    ",".join(f'"{cell}"' for cell in line.split(";"))
    for line in text("time_s;elongation_m;force_N", R.t, R.u, R.f, delimiter=";", decimal=",").splitlines()
)

RIGHT: dict[str, Any] = {
    "tabs in a .csv, no header": (text("", R.t, R.u * 1e3, R.f, delimiter="\t"), [*NUMBERED, *UNITS]),
    "one row of units": (text("time,elongation,force\ns,mm,kN", R.t, R.u * 1e3, R.f / 1e3, digits=9), []),
    "two rows below the names": (text("time\telongation\tforce\ns\tmm\tN\n(abs)\t(abs)\t(tared)", R.t, R.u * 1e3, R.f, delimiter="\t"), []),
    "a byte order mark": ("\ufeff" + own(R), []),
    "two bytes a letter": (own(R).encode("utf-16"), []),
    "another encoding": (("Prüfstand\n" + own(R)).encode("cp1252"), []),
    "semicolons and decimal commas": (text("time_s;elongation_mm;force_N", R.t, R.u * 1e3, R.f, delimiter=";", decimal=","), []),
    "quoted numbers with decimal commas between commas": (QUOTED, []),
    "a trailing comma and an empty first column": ("\n".join(f",{line}," for line in own(R).splitlines()), []),
    "force before elongation": (text("force_N,elongation_m,time_s", R.f, R.u, R.t), []),
    "force in kip": (text("time_s,elongation_m,force_kip", R.t, R.u, R.f / 4448.2216152605, digits=11), []),
    "force in uN": (text("time_s,elongation_m,force_uN", R.t, R.u, R.f * 1e6), []),
    "volts": (text("time_s,elongation_m,force", R.t, R.u, R.f / 50.0, digits=9), ["--unit", "force=V*50"]),
    "position not tared": (own(Record(R.u - 0.36, lines=LINES + np.array([0, -0.09, 0, -0.108, 0]))), []),
    "force with an offset of 140 N": (text("time_s,elongation_m,force_N", R.t, R.u, R.f + 140.0), []),
    "elongation counted the other way": (text("time_s,elongation_m,force_N", R.t, -R.u, R.f), []),
    "force counted the other way": (text("time_s,elongation_m,force_N", R.t, R.u, -R.f), []),
    "a first step of 280 ms, then jitter": (own(Record(0.25 + 0.04 * np.sin(2 * np.pi * JITTERED), JITTERED)), []),
    "only a sample period": (text("elongation_m,force_N", R.u, R.f), ["--sample-period", "0.005"]),
    "idle seconds": (own(Record(IDLE, np.arange(len(IDLE)) / RATE)), []),
    "rows in the wrong order": (own(Record().taken(SHUFFLED)), []),
    "doubled rows": (own(R) + own(Record().taken(slice(900, 1060))).partition("\n")[2], []),
    "a mean that drifts by 62 % of the stroke": (own(Record(DRIFTING)), []),
    "ramps with two full cycles": (own(Record(RAMPS)), []),
    "steps of 5 um": (own(ROUGH), []),
}
SAID = {
    "elongation counted the other way": "counted the other way round",
    "force counted the other way": "the force's sign was turned",
    "a first step of 280 ms, then jitter": "no samples for 0.28",
    "idle seconds": "nothing moves",
    "rows in the wrong order": "the rows were sorted by time",
    "doubled rows": "they are the same and count once",
    "ramps with two full cycles": "full cycle",
}


def written(folder: Path, content: str | bytes, name="bench.csv") -> str:
    raw = content if isinstance(content, bytes) else content.encode()
    (folder / name).write_bytes(raw)
    return str(folder / name)


@pytest.mark.parametrize("case", RIGHT)
def test_an_odd_file_gives_the_law_that_is_in_it(case, tmp_path, capsys):
    content, options = RIGHT[case]
    out = tmp_path / "r.json"
    status = main([written(tmp_path, content), *options, "--json", str(out)])
    said = capsys.readouterr()
    assert status == 0, said.err + said.out
    result = json.loads(out.read_text())
    assert result["half_height_N"] == pytest.approx(HALF_HEIGHT, abs=2.5e-3)
    assert result["parameters"]["beta_per_m"]["value"] == pytest.approx(400.0, rel=0.1)
    assert SAID.get(case, "") in said.out


TWO_TESTS = own(R) + text("", R.t, 0.5 - R.u[::-1], R.f)
REFUSED = {
    "two clocks": (text("time_s,time_ms,elongation_m,force_N", R.t, R.t * 1.02e3, R.u, R.f), "2 columns for the time"),
    "two tests in one file": (TWO_TESTS, "there are two recordings in the file"),
    "a short header": (text("time_s,elongation_m", R.t, R.u, R.f), "2 names stand above 3 columns"),
    "a cut last line": (own(R).rstrip()[:-12], "cells where the other rows have 3"),
    "a point or a thousand": (
        text("time_s\telongation_um\tforce_N", 1 + R.t, 40 + R.u, R.f, delimiter="\t", decimal=",", digits=3),
        "decimal",
    ),
    "pounds of an unknown kind": (text("time_s,elongation_m,force_lb", R.t, R.u, R.f), "no column for the force|which unit"),
    "one branch": (own(Record(0.1 + 0.01 * R.t)), "never turns"),
    "a force that is dead": (text("time_s,elongation_m,force_N", R.t, R.u, 0 * R.f), "force_N is 0 in every row"),
    "no such thing as a table": ("the load cell was not connected\n" * 30, "no table of numbers"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_file_that_cannot_be_read_in_one_way_ends_in_one_sentence_and_nothing_written(case, tmp_path, capsys):
    content, sentence = REFUSED[case]
    path = written(tmp_path, content)
    assert main([path, "--json", str(tmp_path / "r.json"), "-o", str(tmp_path / "a.toml")]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"fit-actuator: error: {path}")
    assert any(part in said for part in sentence.split("|")), said
    assert len(list(tmp_path.iterdir())) == 1


def test_a_stale_frequency_and_an_amplitude_that_was_not_reached_are_said(tmp_path, capsys):
    path = written(tmp_path, "f = 1.5\nA = 50 mm\n" + own(R), "test_60mm.csv")
    assert main([path]) == 0
    said = capsys.readouterr().out
    assert "a note in it says 1.5 Hz, the signal 1 Hz" in said
    assert "a note in it says 50 mm, the signal shows an amplitude of 40 mm" in said
    assert "its name says 60 mm" in said
    honest = written(tmp_path, "f = 1\nA = 40 mm\n" + own(R), "test_80mm_1Hz.csv")  # 80 mm from end to end
    assert main([honest]) == 0
    assert " says " not in capsys.readouterr().out


def test_the_same_file_under_two_names_counts_once(tmp_path, capsys):
    assert main([written(tmp_path, own(R), "a.csv"), written(tmp_path, own(R), "b.csv")]) == 0
    assert "is the same file as" in capsys.readouterr().out


def test_conditions_that_stand_only_in_file_names_become_covariates(tmp_path):
    paths = []
    for pressure in (1, 3, 5):
        record = Record()
        paths.append(
            written(tmp_path, text("time_s,elongation_m,force_N", record.t, record.u, record.f + 0.5 * pressure), f"K_{pressure}bar.csv")
        )
    out = tmp_path / "r.json"
    pattern = ["--name-pattern", "K_{pressure_bar}bar"]
    assert main([*paths, *pattern, "--covariate", "pressure_bar", "--json", str(out), "--quiet"]) == 0
    result = json.loads(out.read_text())
    assert result["covariate"]["N_per_unit"] == pytest.approx(0.5, abs=2e-3)
    assert [row["conditions"] for row in result["loops"]] == [{"pressure_bar": 1.0}, {"pressure_bar": 3.0}, {"pressure_bar": 5.0}]
    assert main([written(tmp_path, own(R), "other.csv"), *pattern]) == 2
