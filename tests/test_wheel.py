"""What is installed is the three packages with all that they read, and nothing else."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = {"measure", "simulate", "identify"}


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Names in the wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", folder], cwd=ROOT, check=True, capture_output=True
    )
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        return set(archive.namelist())


def test_the_wheel_holds_the_three_packages_and_nothing_else(installed):
    folders = {name.partition("/")[0] for name in installed}
    assert {folder for folder in folders if not folder.endswith(".dist-info")} == ROOMS


def _files(folder, below=""):
    """Files of a folder, named as the wheel names them."""
    found = [path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    return {f"{below}{path.relative_to(folder).as_posix()}" for path in found}


def test_the_wheel_holds_every_file_that_the_packages_read(installed):
    of_packages = {name for room in ROOMS for name in _files(ROOT / room, f"{room}/")}
    shipped = _files(ROOT / "datasets" / "demo", "identify/shipped/demo/") | {"identify/shipped/prototype.toml"}
    assert {name for name in installed if ".dist-info" not in name} == of_packages | shipped


def test_the_wheel_carries_the_licence(installed):
    assert any(name.endswith("licenses/LICENSE") for name in installed)


def test_the_wheel_carries_the_bill_of_materials(installed):
    assert any(name.endswith(".dist-info/sboms/unspool.cdx.json") for name in installed)
