"""What runs beside the tests: processor time is held to its limits, and a calibration is drawn and written down."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from calibration import consistent

PLUGINS = Path(__file__).parent / "plugins"
CONFTEST = """
import processor_time
processor_time.PLAIN_S, processor_time.SLOW_S, processor_time.AGAIN = 0.2, 0.5, 1.0
pytest_plugins = ["calibration", "processor_time"]
"""
SETTINGS = "[pytest]\nmarkers =\n    slow\n    calibrate\n"


def ran(folder: Path, tests: str, *options: str) -> subprocess.CompletedProcess[str]:
    (folder / "conftest.py").write_text(CONFTEST)
    (folder / "pytest.ini").write_text(SETTINGS)
    (folder / "test_it.py").write_text(
        "import time\nimport pytest\n\ndef work(s):\n    end = time.process_time() + s\n    while time.process_time() < end: pass\n\n"
        + tests
    )
    command = [Path(sys.executable).with_name("pytest"), "-p", "no:cacheprovider", *options]
    paths = {"PYTHONPATH": str(PLUGINS), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    return subprocess.run(command, cwd=folder, env={**os.environ, **paths}, capture_output=True, text=True, check=False)


def test_a_test_that_works_too_long_fails_the_run_and_one_that_only_waits_does_not(tmp_path):
    waits = ran(tmp_path, "def test_waits(): time.sleep(0.6)\n@pytest.mark.slow\ndef test_slow(): work(0.3)\n", "--time-limits")
    assert waits.returncode == 0, waits.stdout
    works = ran(tmp_path, "def test_works(): work(1.0)\n", "--time-limits")
    assert works.returncode == 1
    assert re.search(r"test_it.py::test_works takes \d\.\d s of a quiet processor's time, alone too; at most 0.2 s.", works.stdout)


def test_a_test_that_takes_long_for_a_slow_machine_does_not_fail_the_run(tmp_path):
    """The fixed sum takes hundreds of times what it should, so that this machine counts as slow."""
    slow = "import processor_time\nprocessor_time.QUIET_S /= 300.0\n"
    works = ran(tmp_path, slow + "def test_works(): work(1.0)\n", "--time-limits")
    assert "limit 0.2 s  test_it.py::test_works" in works.stdout
    assert works.returncode == 0, works.stdout


def test_a_fixture_that_tests_share_is_not_counted_as_one_tests_own(tmp_path):
    shared = "@pytest.fixture(scope='module')\ndef dear(): work(0.4)\ndef test_one(dear): work(0.1)\ndef test_other(dear): pass\n"
    assert ran(tmp_path, shared, "--time-limits", "--processor-times", "t.json").returncode == 0
    found = json.loads((tmp_path / "t.json").read_text())
    assert found["tests"]["test_it.py::test_one"] == pytest.approx(0.1, abs=0.08)
    assert found["shared"]["test_it.py::dear"] == pytest.approx(0.4, abs=0.08)


CALIBRATES = """
@pytest.mark.calibrate
@pytest.mark.parametrize("case", range(40))
def test_case(case): pass

@pytest.mark.calibrate
def test_rate(share_of, calibration_seed, validation_table):
    validation_table("Rate", [{"draws": share_of(200), "seed": calibration_seed, "share": 0.5}], "of nothing")

def test_plain(): pass
"""


def test_a_share_of_a_calibration_is_drawn_by_its_seed_and_repeats_a_share(tmp_path):
    names = []
    for seed in ("7", "7", "8"):
        said = ran(tmp_path, CALIBRATES, "--calibrate", "--share", "0.1", "--seed", seed, "-v", "--validation", "pages").stdout
        assert f"seed {seed}, share 0.1" in said
        names.append(re.findall(r"test_case\[\d+\]", said))
    assert len(names[0]) == 4
    assert names[0] == names[1] != names[2]
    page = (tmp_path / "pages" / "it.md").read_text()
    assert "| draws | seed | share |" in page
    assert "| 20 | 8 | 0.5 |" in page
    assert re.search(r"from `test_it.py` on \d{4}-\d\d-\d\d, version .*, seed 8, a share of 0.1\.", page)


def test_what_calibrates_runs_only_where_it_is_asked_for(tmp_path):
    assert "1 passed, 41 deselected" in ran(tmp_path, CALIBRATES).stdout
    assert "41 passed, 1 deselected" in ran(tmp_path, CALIBRATES, "--calibrate").stdout
    assert "1 passed" in ran(tmp_path, CALIBRATES, "test_it.py::test_rate").stdout


def test_a_rate_is_called_too_low_only_where_chance_would_hardly_give_so_few():
    assert consistent(18, 20, 0.95)
    assert not consistent(15, 20, 0.95)
    assert not consistent(160, 200, 0.90, 0.99)
    assert consistent(0, 0, 0.9)


KINDS = """
@pytest.mark.calibrate
@pytest.mark.parametrize("kind", ["good", "bad"])
def test_kind(kind, validation_table):
    validation_table("Kinds", [{"kind": kind}])
    assert kind != "bad"
"""


def test_tables_of_one_title_become_one_with_the_rows_of_all(tmp_path):
    ran(tmp_path, KINDS, "--calibrate", "--validation", "pages")
    page = (tmp_path / "pages" / "it.md").read_text()
    assert page.count("## Kinds") == 1
    assert "| bad |\n| good |" in page
    assert "failed.**" in page
