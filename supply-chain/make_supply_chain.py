"""What the project stands on, written down: hashes of every pinned file, licences, and a software bill of materials (CycloneDX).

Run by `make pins`, in the environment that constraints.txt describes:

    python supply-chain/make_supply_chain.py

It writes beside itself

    constraints-hashes.txt   SHA-256 of every file of every pinned version, for `pip install --require-hashes`; no index address
    unspool.cdx.json         what an installation with all extras holds, the libraries inside wheels included; goes into the wheel
    licences.md              the same as a table, with the licences

The hashes come from the index that the user's installer asks, through uv; the rest from what is installed here. Libraries inside wheels are
those of the platform that it was run on.
"""

from __future__ import annotations

import importlib
import json
import re
import subprocess
import sys
import uuid
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
NAME = "unspool"
OLDEST_PYTHON = "3.11.9"  # of which a library asks for a later patch than the first

# Licences of libraries inside wheels, by how their files begin; from their own sources. What is not here is shown as not known.
BUNDLED = {
    "libavif": "BSD-2-Clause", "libav": "LGPL-3.0-or-later", "libsw": "LGPL-3.0-or-later", "libx264": "GPL-2.0-or-later",
    "libx265": "GPL-2.0-or-later",
    "libSvtAv1Enc": "BSD-3-Clause-Clear", "libdav1d": "BSD-2-Clause", "libaom": "BSD-2-Clause", "libvpx": "BSD-3-Clause",
    "libmp3lame": "LGPL-2.0-or-later", "libopencore": "Apache-2.0", "libopus": "BSD-3-Clause", "libwebp": "BSD-3-Clause",
    "libsharpyuv": "BSD-3-Clause", "libgnutls": "LGPL-2.1-or-later", "libnettle": "LGPL-3.0-or-later OR GPL-2.0-or-later",
    "libhogweed": "LGPL-3.0-or-later OR GPL-2.0-or-later", "libgmp": "LGPL-3.0-or-later OR GPL-2.0-or-later",
    "libunistring": "LGPL-3.0-or-later OR GPL-2.0-or-later", "libasound": "LGPL-2.1-or-later", "libdrm": "MIT", "libvpl": "MIT",
    "libxcb": "X11", "libXau": "X11", "libzstd": "BSD-3-Clause", "libpng": "libpng-2.0", "libcrypto": "OpenSSL", "libssl": "OpenSSL",
    "libgfortran": "GPL-3.0-or-later WITH GCC-exception-3.1", "libquadmath": "LGPL-2.1-or-later", "libopenblas": "BSD-3-Clause",
    "libscipy_openblas": "BSD-3-Clause", "libgomp": "GPL-3.0-or-later WITH GCC-exception-3.1", "libaec": "BSD-2-Clause",
    "libsz": "BSD-2-Clause", "libhdf5": "BSD-3-Clause", "libbrotli": "MIT", "libfreetype": "FTL", "libharfbuzz": "MIT",
    "libjpeg": "IJG AND BSD-3-Clause", "liblcms2": "MIT", "liblzma": "0BSD", "libopenjp2": "BSD-2-Clause", "libtiff": "libtiff",
}  # fmt: skip
CLASSIFIERS = {
    "MIT License": "MIT", "BSD License": "BSD-3-Clause", "Apache Software License": "Apache-2.0",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0", "ISC License (ISCL)": "ISC",
}  # fmt: skip


HEAD = """# Licences

unspool is BSD-3-Clause. What an installation with all extras needs, as `make pins` found it. The project hands none of it on: each comes
from its own makers. A library inside a wheel is named with its licence; on other platforms others may be inside.

The film decoder of PyAV is FFmpeg (libavcodec {version}), by its own word under the "{licence}". Its wheel also carries x264
and x265, which are under the GPL; unspool reads films with it and writes none, so these two encoders are never called. Whoever hands an
installation on as a whole hands them on too, and has to keep to the GPL.

| library | version | licence | inside its wheel |
| --- | --- | --- | --- |
"""


@dataclass(frozen=True)
class Part:
    """An installed library: name, version, licence, what it needs, and the libraries inside its wheel."""

    name: str
    version: str
    licence: str
    needs: tuple[str, ...]
    inside: tuple[tuple[str, str, str], ...]


def part_of(name: str, extras: tuple[str, ...] = ()) -> Part:
    """The library of a name, as it is installed here."""
    found = metadata.distribution(name)
    needs = sorted({canonicalize_name(needed.name) for needed in _needed(found, extras)} - {"editables"})  # of the way it is installed here
    return Part(canonicalize_name(found.metadata["Name"]), found.version, _licence(found), tuple(needs), tuple(sorted(set(_inside(found)))))


def _needed(found: metadata.Distribution, extras: tuple[str, ...]) -> Iterator[Requirement]:
    for line in found.requires or ():
        needed = Requirement(line)
        if needed.marker is None or any(needed.marker.evaluate({"extra": extra}) for extra in ("", *extras)):
            yield needed


def _licence(found: metadata.Distribution) -> str:
    """By the name that SPDX gives it; where the library names none, that of its classifier."""
    if said := _said(found, "License-Expression"):
        return said
    classed = [line.rpartition(" :: ")[2] for line in found.metadata.get_all("Classifier") or () if line.startswith("License")]
    known = [CLASSIFIERS[one] for one in classed if one in CLASSIFIERS]
    free = _said(found, "License").strip()
    return known[0] if known else free if free and len(free) < 40 else "not said"


def _said(found: metadata.Distribution, key: str) -> str:
    return str(found.metadata[key]) if key in found.metadata else ""


def _inside(found: metadata.Distribution) -> Iterator[tuple[str, str, str]]:
    """Shared libraries of others in a wheel: name, version, licence."""
    for file in found.files or ():
        folder, name = file.parts[0], file.parts[-1]
        match = re.match(r"(lib.+?)-?(?:[-_][0-9a-f]{8})+(?:\.so)?\.?([\w.]*?)(?:\.so)?$", name)
        if folder.endswith(".libs") and match:
            stem = match[1]
            yield stem, match[2] or "not said", next((licence for start, licence in BUNDLED.items() if stem.startswith(start)), "not known")


def closure() -> list[Part]:
    """The project with all its extras, and everything that these need."""
    extras = tuple(metadata.metadata(NAME).get_all("Provides-Extra") or ())
    waiting, found = [(NAME, extras)], dict[str, Part]()
    while waiting:
        name, wanted = waiting.pop()
        if canonicalize_name(name) in found:
            continue
        part = part_of(name, wanted)
        found[part.name] = part
        waiting += [(needed, ()) for needed in part.needs]
    return [found[name] for name in sorted(found)]


def bill(parts: list[Part]) -> dict[str, object]:
    """The bill of materials; it holds no time, and its number is made of its content, so the same versions give the same bytes."""
    root = next(part for part in parts if part.name == NAME)
    others = [part for part in parts if part is not root]
    content = {
        "metadata": {"component": _component(root)},
        "components": [_component(part) for part in others],
        "dependencies": [{"ref": _ref(part), "dependsOn": [_ref(p) for p in parts if p.name in part.needs]} for part in parts],
    }
    number = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(content, sort_keys=True))
    return {"bomFormat": "CycloneDX", "specVersion": "1.5", "serialNumber": f"urn:uuid:{number}", "version": 1, **content}


def _ref(part: Part) -> str:
    return f"pkg:pypi/{part.name}@{part.version}"


def _component(part: Part) -> dict[str, object]:
    made: dict[str, object] = {
        "type": "application" if part.name == NAME else "library",
        "bom-ref": _ref(part),
        "name": part.name,
        "version": part.version,
        "purl": _ref(part),
        "licenses": _licences(part.licence),
    }
    inside = [
        {"type": "library", "bom-ref": f"{_ref(part)}#{name}-{version}", "name": name, "version": version, "licenses": _licences(licence)}
        for name, version, licence in part.inside
    ]
    return made | ({"components": inside} if inside else {})


def _licences(said: str) -> list[dict[str, object]]:
    is_expression = re.fullmatch(r"[\w.+-]+( (AND|OR|WITH) [\w.+-]+)*", said) is not None and said != "BSD"
    return [{"expression": said}] if is_expression else [{"license": {"name": said}}]


def page(parts: list[Part]) -> str:
    """The licences as a table."""
    decoder = importlib.import_module("av._core").library_meta["libavcodec"]
    rows = [f"| {part.name} | {part.version} | {part.licence} | {_bundle(part)} |" for part in parts if part.name != NAME]
    return HEAD.format(version=".".join(map(str, decoder["version"])), licence=decoder["license"]) + "\n".join(rows) + "\n"


def _bundle(part: Part) -> str:
    return ", ".join(f"{name} ({licence})" for name, licence in dict.fromkeys((name, licence) for name, _, licence in part.inside))


def write_hashes(target: Path) -> None:
    """SHA-256 of every file of every pinned version, by the index that the user's installer asks."""
    options = ["--no-deps", "--generate-hashes", "--no-annotate", "--no-header", "--quiet", "--python-version", OLDEST_PYTHON]
    subprocess.run([sys.executable, "-m", "uv", "pip", "compile", *options, ROOT / "constraints.txt", "--output-file", target], check=True)


def write_all() -> None:
    """The three files."""
    write_hashes(HERE / "constraints-hashes.txt")
    parts = closure()
    (HERE / "unspool.cdx.json").write_text(json.dumps(bill(parts), indent=1) + "\n", encoding="utf-8")
    (HERE / "licences.md").write_text(page(parts), encoding="utf-8")


if __name__ == "__main__":
    write_all()
