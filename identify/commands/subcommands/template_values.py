"""The values that stand in the templates of `unspool init`."""

from __future__ import annotations

from typing import Any

from identify.commands.subcommands.shipped import shipped

Document = dict[str, Any]

BENCH: Document = {
    "columns": {"time": "t", "elongation": "Position", "force": "Load"},
    "units": {"time": "s", "elongation": "mm", "force": "mN"},
    "delimiter": "semicolon",
    "decimal": "comma",
}
_FILM: Document = {
    "schema": 1,
    "film": {"fps": 250.0},
    "marks": {"subset_px": 31},
    "scale": {"mm_per_px": 0.5, "up_deg": 0.0},
    "platform": {"start_height_m": 0.252},
}
_CAMPAIGN: Document = {
    "model": "model.toml",
    "run": [
        {"file": "test1.avi", "project": "film.toml"},
        {"file": "test2.csv", "model": {"platform": {"mass_kg": 1.0}}, "hold_out": True},
        {"file": "loop-1Hz.csv", "mapping": "bench.toml"},
    ],
}


def values_like(like: str) -> dict[str, Document]:
    """The tables of the four files, by the name of the file.

    Parameters
    ----------
    like : prototype or demo.
    """
    from simulate.files.model_file import read_document

    if like == "prototype":
        return {"model": read_document(shipped("prototype.toml")), "film": _FILM, "bench": BENCH, "campaign": _CAMPAIGN}
    demo = shipped("demo")
    runs = read_document(demo / "campaign.toml")["run"]
    campaign = {"model": "model.toml", "run": [_raw(row) for row in runs]}
    return {"model": read_document(demo / "rig.toml"), "film": read_document(demo / "film.toml"), "bench": BENCH, "campaign": campaign}


def _raw(row: Document) -> Document:
    """A run as `unspool demo --raw` writes its file: the film instead of its trajectory, a loop as the bench writes it."""
    file = row["file"]
    if file == "film.csv":
        return {"file": "film.avi", "project": "film.toml", **{key: value for key, value in row.items() if key != "file"}}
    return {**row, "mapping": "bench.toml"} if "loop" in file else row
