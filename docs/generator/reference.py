"""The generated part of the reference, all of it: what Sphinx asks for before it reads any page."""

from __future__ import annotations

import shutil
from pathlib import Path

from generator import front_doors, levels, model_file
from generator.catalogue import write_catalogue


def write_reference(folder: Path) -> None:
    """Write all generated pages into a folder, in place of what was there.

    Parameters
    ----------
    folder : it holds nothing but generated pages and is not kept in the repository.
    """
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for package in front_doors.PACKAGES:
        (folder / f"{package}.md").write_text(front_doors.page(package), encoding="utf-8")
    (folder / "model-file.md").write_text(model_file.page(), encoding="utf-8")
    (folder / "levels.md").write_text(levels.page(), encoding="utf-8")
    write_catalogue(folder / "effects")
