"""The same input and seed give the same bytes: with other threads, in another folder, locale, time zone and width of the terminal."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import pytest
from command_server import MAINS
from judging import tree
from odd_inputs import ROOT, lay_out
from test_kills import COMMANDS as WHOLE
from test_kills import demonstration as _demonstration
from test_write_faults import COMMANDS as QUICK

pytestmark = pytest.mark.xdist_group("commands")
demonstration = _demonstration
HERE = {"NUMBA_NUM_THREADS": "1", "LC_ALL": "C.UTF-8", "TZ": "UTC", "PYTHONHASHSEED": "0", "COLUMNS": "80"}
THERE = {
    "NUMBA_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "LC_ALL": "tr_TR.UTF-8", "LANG": "de_DE.UTF-8", "TZ": "Pacific/Kiritimati",
    "PYTHONHASHSEED": "77", "COLUMNS": "40", "PYTHONUTF8": "0", "HOME": "/nowhere", "MPLBACKEND": "none",
}  # fmt: skip


def differing(one, other):
    """Files of which two runs have made something else, or only one has made."""
    return sorted(name for name in {*one, *other} if one.get(name) != other.get(name))


@pytest.mark.parametrize("name", sorted(QUICK))
def test_another_folder_locale_and_time_zone_change_no_byte(commands, tmp_path, name):
    found = []
    for folder, environment in (("one", HERE), ("another place, ü", THERE)):
        (tmp_path / folder).mkdir()
        lay_out(tmp_path / folder)
        elsewhere = {key: value for key, value in environment.items() if "THREADS" not in key and key != "PYTHONHASHSEED"}
        ended = commands.run(QUICK[name], tmp_path / folder, environment=elsewhere)
        assert ended.status in (0, 1), ended
        found.append((ended.out, tree(tmp_path / folder)))
    assert not differing(found[0][1], found[1][1])
    assert found[0][0] == found[1][0] or name == "sweep-deployments"  # which says how long it took


@pytest.mark.calibrate
@pytest.mark.parametrize("name", sorted(WHOLE))
def test_the_whole_work_with_other_threads_changes_no_byte(demonstration, tmp_path_factory, name):
    other = tmp_path_factory.mktemp("another place, ü") / "deeper"
    shutil.copytree(demonstration, other)
    code = f"import sys; from {MAINS[name]} import main; sys.exit(main(sys.argv[1:]))"
    for folder, environment in ((demonstration, HERE), (other, THERE)):
        run_in = {**os.environ, "PYTHONPATH": str(ROOT), **environment}
        ran = subprocess.run(
            [sys.executable, "-c", code, *WHOLE[name][1:]], cwd=folder, env=run_in, capture_output=True, text=True, check=False
        )
        assert ran.returncode in (0, 1), ran.stderr
    assert not differing(tree(demonstration), tree(other))
