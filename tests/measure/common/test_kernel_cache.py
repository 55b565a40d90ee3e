"""Compiled kernels on disk never outlive the sources they were made from."""

from __future__ import annotations

import subprocess
import sys

import pytest

from measure.common.kernel_cache import discard_stale


@pytest.fixture
def package(tmp_path):
    """A folder with a source and a kept kernel, both as if they had just been made."""
    (tmp_path / "law.py").write_text("force = 1\n")
    discard_stale(tmp_path)
    for name in ("law.branch-1.py311.nbi", "law.branch-1.py311.1.nbc", "law.cpython-311.pyc"):
        (tmp_path / "__pycache__" / name).write_bytes(b"kept")
    return tmp_path


def kernels(folder):
    return {path.suffix for path in (folder / "__pycache__").iterdir()} & {".nbi", ".nbc"}


def test_kernels_are_kept_while_their_sources_stand(package):
    discard_stale(package)
    assert kernels(package) == {".nbi", ".nbc"}


@pytest.mark.parametrize(("name", "text"), [("law.py", "force = 2\n"), ("neighbour.py", ""), ("law_2.py", "force = 1\n")])
def test_any_changed_or_added_source_throws_them_away(package, name, text):
    (package / name).write_text(text)
    discard_stale(package)
    assert not kernels(package)
    assert (package / "__pycache__" / "law.cpython-311.pyc").exists()


def test_a_source_taken_away_throws_them_away(package):
    (package / "law.py").rename(package / "renamed.py")
    discard_stale(package)
    assert not kernels(package)


def test_a_folder_that_keeps_no_kernels_is_left_alone(tmp_path):
    (tmp_path / "law.py").write_text("")
    (tmp_path / "__pycache__").write_text("a file where the folder would be")
    discard_stale(tmp_path)
    assert (tmp_path / "__pycache__").read_text() == "a file where the folder would be"


CALLER = "from numba import njit\nfrom callee import half\n\n@njit(cache=True)\ndef quarter(x):\n    return half(half(x))\n"
CALLEE = "from numba import njit\n\n@njit(cache=True)\ndef half(x):\n    return {factor} * x\n"


def quarter(folder, factor, *, first=""):
    """What a new process computes after the callee's source has been edited."""
    (folder / "callee.py").write_text(CALLEE.format(factor=factor))
    code = f"{first}\nfrom caller import quarter; print(quarter(8.0))"
    return float(subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, check=True).stdout)


@pytest.mark.slow
def test_an_edited_callee_in_another_file_is_what_runs(tmp_path):
    discard = "from pathlib import Path; from measure.common.kernel_cache import discard_stale; discard_stale(Path.cwd())"
    (tmp_path / "caller.py").write_text(CALLER)
    assert quarter(tmp_path, 0.5, first=discard) == 2.0
    # numba by itself goes on running the old code; when it no longer does, this module can go
    assert quarter(tmp_path, 0.25) == 2.0
    assert quarter(tmp_path, 0.25, first=discard) == 0.5
