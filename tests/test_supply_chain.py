"""What the project stands on is written down as it is: pinned, hashed, licensed, and listed in the wheel."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
CHAIN = ROOT / "supply-chain"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BILL = json.loads((CHAIN / "unspool.cdx.json").read_text(encoding="utf-8"))


def pinned(file):
    """Versions by name, and the hashes of each."""
    text = file.read_text(encoding="utf-8").replace("\\\n", " ")
    rows = [re.fullmatch(r"([\w.-]+)==(\S+)((?:\s+--hash=sha256:[0-9a-f]{64})*)\s*", line) for line in text.splitlines()]
    assert all(rows), "lines of another kind, such as addresses"
    return {canonicalize_name(row[1]): (row[2], row[3].split()) for row in rows if row}


def test_every_pinned_version_has_the_hashes_of_its_files():
    versions, hashed = pinned(ROOT / "constraints.txt"), pinned(CHAIN / "constraints-hashes.txt")
    assert {name: version for name, (version, _) in versions.items()} == {name: version for name, (version, _) in hashed.items()}
    assert all(hashes for _, hashes in hashed.values())


def test_the_bill_lists_all_that_an_installation_needs_in_the_pinned_versions():
    versions = {name: version for name, (version, _) in pinned(ROOT / "constraints.txt").items()}
    listed = {component["name"]: component["version"] for component in BILL["components"]}
    declared = [*PROJECT["dependencies"], *(line for extra in PROJECT["optional-dependencies"].values() for line in extra)]
    assert {canonicalize_name(Requirement(line).name) for line in declared} <= set(listed)
    assert listed == {name: versions[name] for name in listed}
    assert (BILL["bomFormat"], BILL["metadata"]["component"]["version"]) == ("CycloneDX", PROJECT["version"])
    assert "timestamp" not in BILL["metadata"]


def test_every_reference_of_the_bill_leads_to_one_of_its_components():
    inside = [inner for component in BILL["components"] for inner in component.get("components", ())]
    references = [component["bom-ref"] for component in (BILL["metadata"]["component"], *BILL["components"], *inside)]
    assert len(references) == len(set(references))
    used = {reference for row in BILL["dependencies"] for reference in (row["ref"], *row["dependsOn"])}
    assert used <= set(references)


def test_every_licence_is_known_those_inside_the_film_decoders_wheel_too():
    page = (CHAIN / "licences.md").read_text(encoding="utf-8")
    assert "not known" not in page
    assert "not said" not in page
    row = next(line for line in page.splitlines() if line.startswith("| av |"))
    assert all(name in row for name in ("libavcodec (LGPL", "libx264 (GPL", "libdav1d"))
    assert {component["name"] for component in BILL["components"]} == set(re.findall(r"^\| ([a-z][\w.-]*) \| \d", page, re.M))
