"""What was understood of a file of any kind, in sentences: the half of `unspool check` that is not about errors."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from identify.campaign.campaign_file import Campaign, ListedRun, is_film, read_list
from identify.campaign.plausible import require_measured, require_plausible
from identify.loops.prepare import prepare
from measure.common.errors import InputError
from measure.common.every_error import for_each
from measure.common.file_kinds import MAPPING, PROJECT, RUNS, kind_of_toml
from measure.geometry.film_project import Project, read_project
from measure.readers.column_mapping import ColumnMapping, read_mapping
from measure.readers.loop_file import read_loop_file
from measure.readers.measurement import read_measurement
from measure.tables.loop import Loop
from measure.tables.trajectory import Trajectory
from measure.tables.units import SI, unit_of
from simulate.files.model_file import read_document, read_model, with_changes
from simulate.kernel.step_size import grid
from simulate.model.effect import Catalogue
from simulate.model.model import Model, per_leg, stroke_of

Found = tuple[str, list[str]]


def understood(path: Path, mapping: ColumnMapping, catalogue: Catalogue, model: Model | None = None) -> Found:
    """The kind of a file, and sentences on what stands in it.

    Parameters
    ----------
    path : its kind is recognised by what stands in it.
    mapping : how loops are to be read that are not in the project's own columns.
    catalogue : effects that a model may have.
    model : what deployments are to be compared with, where it is known; a list of runs may name its own.

    Raises
    ------
    InputError
        Everything that is wrong with it and with the files that it names.
    """
    if is_film(path):
        return "film", _of_film(path)
    if path.suffix.lower() != ".toml":
        return _of_table(path, mapping, model)
    kind = kind_of_toml(read_document(path))
    if kind == RUNS:
        return "list of runs", _of_campaign(read_list(path), path.parent, mapping, catalogue, model)
    if kind == PROJECT:
        return "film project", _of_project(read_project(path), path.parent)
    if kind == MAPPING:
        return "columns of a bench", _of_mapping(read_mapping(path))
    return "model", _of_model(read_model(path, catalogue))


def _of_film(path: Path) -> list[str]:
    from measure.footage.formats import open_footage

    if not path.exists():
        raise InputError(f"{path}: no such film. Check the name.")
    footage = open_footage(path)
    rate = f"{footage.fps:g} frames/s" if footage.fps else "no rate of the camera's own: give fps"
    return [f"{footage.frames} frames, {footage.width} x {footage.height} px, {rate}"]


def _of_model(model: Model) -> list[str]:
    law, moved = model.actuator, model.moving_mass_kg
    lines = [f'"{model.name}": platform {model.platform.mass_kg:g} kg, with the counterweight {moved:g} kg moved']
    if model.geometry is None:
        lines.append("no geometry: good for loops; a deployment needs [geometry]")
    else:
        grid(model)  # refuses what takes more steps than anybody waits for
        strokes = stroke_of(model)
        lines.append(
            f"stroke of the legs {1e3 * strokes.min():.1f} to {1e3 * strokes.max():.1f} mm between heights "
            f"{model.geometry.stowed_height_m:g} and {model.geometry.deployed_height_m:g} m"
        )
    stored, upper = per_leg(law.b_l_N), per_leg(law.b_u_N)
    lines.append(f"force of a leg: {_span(stored)} N while uncoiling, {_span(upper)} N while coiling, at elongation 0")
    lines.append(f"an asymptote is approached within {_span(1e3 / per_leg(law.beta_per_m))} mm (1/beta)")
    effects = [f"{effect.name} ({', '.join(f'{v:g}' for v in effect.flat())})" for effect in model.effects]
    control = [] if model.controller is None else [f"controller: {model.controller.law}"]
    return [*lines, f"effects: {', '.join(effects) or 'none'}", *control]


def _span(values: Any) -> str:
    low, high = float(np.min(values)), float(np.max(values))
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"


def _of_project(project: Project, folder: Path) -> list[str]:
    scale = project.scale
    how = f"{scale.mm_per_px:g} mm/px" if scale.mm_per_px else "measured in the first frame" if project.has_scale() else "none: no metres"
    rate = f"{project.film.fps:g} frames/s" if project.film.fps else "rate from the film, if it carries the camera's own"
    marks = len(project.marks.place_px)
    lines = [f"{rate}; scale {how}; up {scale.up_deg:g} deg from the picture's own" if scale.plumb_px is None else f"{rate}; scale {how}"]
    lines.append(f"{marks or 'no'} marks given{'' if marks else ', they are found'}; subset {project.marks.subset_px} px")
    radius = project.platform.radius_m
    body = f"on a cylinder of {radius:g} m" if radius else "in one plane: no rotation about the vertical"
    lines.append(f"platform starts at a height of {project.platform.start_height_m:g} m; marks {body}")
    missing = [name for name in (project.film.file, project.marks.mask) if name and not (folder / name).exists()]
    if missing:
        raise InputError(f"{', '.join(missing)}: not there; names count from the folder of the project file.")
    return lines


def _of_mapping(mapping: ColumnMapping) -> list[str]:
    lines = []
    for quantity, unit in SI.items():
        given = mapping.columns.get(quantity)
        column = "found by its name" if given is None else f'column "{given}"'
        factor = unit_of(quantity, mapping.units[quantity]) if quantity in mapping.units else None
        lines.append(f"{quantity}: {column}, " + (f"1 {factor.text} = {factor.factor:g} {unit}" if factor else "unit from the header"))
    rest = [f"{name} {value}" for name, value in (("fields end with a", mapping.delimiter), ("decimal", mapping.decimal)) if value]
    axes = [f"{name} is {axis} of the file" for name, axis in (("up", mapping.up), ("across", mapping.across)) if axis]
    axes += [f"markers {', '.join(mapping.markers)}"] if mapping.markers else []
    return [*lines, *("; ".join(part) for part in (rest, axes) if part)]


def _of_table(path: Path, mapping: ColumnMapping, model: Model | None) -> Found:
    table = read_measurement(path, mapping)
    if isinstance(table, Trajectory):
        require_measured(str(path), table) if model is None else require_plausible(str(path), table, model)
        return "trajectory", _of_trajectory(table)
    return "loop", [*_reading(path, mapping), *_of_loop(table)]


def _reading(path: Path, mapping: ColumnMapping) -> list[str]:
    """How the columns of a laboratory's file were read."""
    try:
        how = read_loop_file(path, mapping)[1]
    except InputError:
        return []  # in the project's own columns, which need no mapping
    return [line.removeprefix(f"{path}: ").strip() for line in how.sentences()[:4]]


def _of_loop(table: Loop) -> list[str]:
    data = prepare(replace(table, time_s=table.time_s - table.time_s[0]))
    u, force = data.elongation_m[data.used], data.force_N[data.used]
    return [
        f"{len(table.time_s)} rows, {np.ptp(table.time_s):.4g} s: {data.frequency_Hz:.4g} Hz, amplitude {1e3 * data.amplitude_m:.3g} mm",
        f"elongation {1e3 * u.min():.4g} to {1e3 * u.max():.4g} mm, force {force.min():.4g} to {force.max():.4g} N",
        *table.remarks,
    ]


def _of_trajectory(table: Trajectory) -> list[str]:
    span = float(np.ptp(table.time_s))
    lines = [f"{len(table.time_s)} rows, {span:.4g} s, {(len(table.time_s) - 1) / span:.5g} rows/s"]
    for name, values in table.channels.items():
        seen, sigma = np.isfinite(values), table.sigma.get(name)
        noise = "" if sigma is None else f", sigma {np.nanmedian(sigma):.2g}"
        lines.append(f"{name} {np.nanmin(values):.4g} to {np.nanmax(values):.4g}{noise}, seen in {seen.sum()} rows")
    return lines


def _of_campaign(listed: Campaign, folder: Path, mapping: ColumnMapping, catalogue: Catalogue, model: Model | None) -> list[str]:
    if not listed.run:
        raise InputError('no [[run]] table; give one for each measurement, with file = "...".')
    checks: list[Any] = [lambda row=row: _of_run(row, folder, mapping, model) for row in listed.run]
    if model is None and listed.model is not None:
        own = folder / listed.model
        checks.insert(0, lambda: f"model {listed.model}: {_of_model(read_model(own, catalogue))[0]}")
        with suppress(InputError):  # it is said by the first check
            model = read_model(own, catalogue)
    return for_each(lambda check: check(), checks)


def _of_run(row: ListedRun, folder: Path, mapping: ColumnMapping, model: Model | None) -> str:
    model = None if model is None else with_changes(model, row.model, f"[[run]] {row.file}, model")
    held = ", held out" if row.hold_out else ""
    changes = f", {_changes(row.model)}{'' if model else ' (unchecked: no model is named)'}" if row.model else ""
    path = folder / row.file
    if row.is_film(folder):
        if not path.exists():
            raise InputError(f"{path}: no such film. Names count from the folder of the list.")
        project = f", {_of_project(read_project(folder / row.project), folder)[0]}" if row.project else ""
        return f"{row.file}: film{project}{changes}{held}"
    kind, lines = _of_table(path, row.reading(folder, mapping), model)
    said = next((line for line in lines if " rows, " in line and line[0].isdigit()), lines[0])
    return f"{row.file}: {kind}, {said}{changes}{held}"


def _changes(table: Mapping[str, Any], before: str = "") -> str:
    parts = [
        _changes(value, f"{before}{key}.") if isinstance(value, Mapping) else f"{before}{key} = {value}" for key, value in table.items()
    ]
    return ", ".join(parts)
