"""The summary of a tracked film: numbers and a verdict for other programs, and lines for people."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from measure.correlation.marks import MISSING, OK, Marks
from measure.film.noise import noise_table
from measure.film.one_body import moves
from measure.film.smoothing import instants, smooth
from measure.footage.footage import Footage
from measure.footage.integrity import IntegrityCheck
from measure.tables.trajectory import CHANNELS, Trajectory

if TYPE_CHECKING:
    from measure.film.dispersion import Dispersion
    from measure.film.one_body import Body
    from measure.geometry.film_project import Project
    from measure.geometry.rigid_body import Fit
    from measure.geometry.scale import PictureScale

_NOT_RIGID_PX = 0.1
"""Misfit of the marks in px, below which it is of the lens or the light, and the widened standard deviations hold it."""

_SEEN_SHARE = 0.5
"""Share of the sightings that must be there for a body to be known by its marks."""

_FEWEST_FOR_INSTANTS = 8

_CLEAR_SIGMAS = 3.0
"""Standard deviations above zero from which a correlation of the noise is said to people."""

_GEOMETRY = (
    "the marks do not move as one rigid body under this geometry, and the sigmas are widened for it; "
    "give radius_m, distance_m and origin_px in the project file, or check them"
)

VERDICTS = {
    "ok": "ok",
    "lost": "the platform is not observed in every frame; those rows are empty",
    "still": "nothing moves: no mark leaves its place by more than noise",
    "few-marks": "most of the marks are lost; name others with --mark X,Y",
    "not-rigid": "the marks do not move as one rigid body; check the geometry, or name the marks of the platform with --mark X,Y",
    "several-bodies": "another body moves, with nearly as many marks; name those of the platform with --mark X,Y",
    "incomplete": "the film is incomplete: frames that it should have are missing or cannot be read; the others are written",
}


def summarise(
    footage: Footage,
    project: Project,
    scale: PictureScale | None,
    body: Body,
    fit: Fit | None,
    table: Trajectory | None,
    check: IntegrityCheck,
) -> dict[str, Any]:
    """The result in numbers, with a verdict.

    Parameters
    ----------
    footage, project, scale, body, fit, table
        The film and what was made of it; scale, fit and table are None without a scale.
    check : IntegrityCheck
        After the film has gone through it.

    Returns
    -------
    dict
        What `track-video --json` writes.
    """
    marks = body.marks
    read = int((marks.status != MISSING).any(axis=1).sum())
    return {
        "verdict": _verdict(footage, body, fit, read),
        "film": {
            "file": footage.name, "frames": footage.frames, "frames_read": read, "fps": project.film.fps, "width_px": footage.width,
            "height_px": footage.height, "bits": footage.bits, "first_frame": footage.first,
            "from_s": float(marks.time_s[0]), "to_s": float(marks.time_s[-1]), "remarks": [*footage.remarks, *check.remarks],
        },
        "marks": [_mark_summary(marks, fit, i) for i in range(len(marks.names))],
        "left_out": [dataclasses.asdict(one) for one in body.left_out],
        "subset_px": project.marks.subset_px,
        "sigma_px": marks.median_sigma_px if marks.observed.any() else None,
        "scale": {"mm_per_px": None, "relative_sigma": None} if scale is None else {**scale.summary(), "note": _NOTE},
        "platform": None if fit is None or table is None else _platform_summary(fit, table),
        "noise": noise_table(table),
    }  # fmt: skip


_NOTE = "relative_sigma is common to all lengths of the film; it is not contained in the sigmas of the frames"


def _verdict(footage: Footage, body: Body, fit: Fit | None, read: int) -> str:
    marks = body.marks
    if read < footage.frames:
        return "incomplete"
    if not moves(marks).any():
        return "still"
    posed = fit.has_pose if fit is not None else marks.observed.any(axis=1)
    if not posed.all():
        return "lost"
    if marks.observed.mean() < _SEEN_SHARE or body.lost > len(marks.names):
        return "few-marks"
    if fit is not None and _astray(fit):
        return "not-rigid"
    return "several-bodies" if body.rivals else "ok"


def _astray(fit: Fit) -> bool:
    """Whether the marks fit the body worse than their own standard deviations and a small error of the lens allow."""
    residual = fit.mark_residual_px
    return not fit.is_rigid and bool(np.nanmedian(residual) > _NOT_RIGID_PX)


def _mark_summary(marks: Marks, fit: Fit | None, i: int) -> dict[str, Any]:
    statuses, counts = np.unique(marks.status[:, i], return_counts=True)
    residual = None
    if fit is not None and fit.used[:, i].any():
        residual = float(np.sqrt(np.mean(fit.residual_px[fit.used[:, i], i] ** 2)))
    return {
        "name": marks.names[i],
        "x_px": float(marks.reference_px[i, 0]),
        "y_px": float(marks.reference_px[i, 1]),
        "frames": {str(status): int(count) for status, count in zip(statuses, counts, strict=True)},
        "first_not_ok": _first_not_ok(marks, i),
        "sigma_px": float(np.nanmedian(marks.sigma_px[:, i])) if marks.observed[:, i].any() else None,
        "rigid_residual_px": residual,
    }


def _first_not_ok(marks: Marks, i: int) -> int | None:
    bad = np.flatnonzero(marks.status[:, i] != OK)
    return marks.first + int(bad[0]) if len(bad) else None


def _platform_summary(fit: Fit, table: Trajectory) -> dict[str, Any]:
    return {
        "channels": list(fit.free),
        "frames_with_pose": int(fit.has_pose.sum()),
        "widened": float(np.median(fit.widened)),
        "rough": dict(zip(fit.free, map(float, fit.rough), strict=True)),
        "remarks": [_GEOMETRY] if not fit.is_rigid else [],
        "range": {c: _range(table.channels[c]) for c in CHANNELS if c in table.channels},
        "instants": _instants(table),
        "median_sigma": {c: float(np.nanmedian(s)) if np.isfinite(s).any() else None for c, s in table.sigma.items()},
    }


def _instants(table: Trajectory) -> dict[str, float | None]:
    z, sigma = table.channels["z_m"], table.sigma["z_m"]
    if np.isfinite(z).sum() < _FEWEST_FOR_INSTANTS:
        return {}
    return dataclasses.asdict(instants(smooth(table.time_s, z, sigma)))


def _range(values: np.ndarray) -> float | None:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if len(finite) else None


def lines_for_people(result: dict[str, Any]) -> list[str]:
    """The summary for people, one line for each thing.

    Parameters
    ----------
    result : dict
        From `summarise`.

    Returns
    -------
    list of str
    """
    film, marks, platform = result["film"], result["marks"], result["platform"]
    lines = [
        f"film      {film['frames_read']} of {film['frames']} frames, {film['width_px']} x {film['height_px']} px, {film['bits']} bit, "
        f"{film['fps']:g} frames/s{_part(film)}",
        *(f"          {remark}" for remark in film["remarks"]),
        f"marks     {len(marks)} of subset {result['subset_px']} px",
        *(_mark_line(mark) for mark in marks if list(mark["frames"]) != ["ok"]),
        *_left_out_lines(result["left_out"]),
        *_scale_lines(result["scale"], result["sigma_px"]),
    ]
    if platform is not None:
        lines.append("platform  " + ", ".join(_channel(c, r, platform["median_sigma"][c]) for c, r in platform["range"].items()))
        lines += [f"          {remark}" for remark in platform["remarks"]]
    lines += _noise_lines(result["noise"])
    return [*lines, f"verdict   {VERDICTS[result['verdict']]}"]


def _part(film: dict[str, Any]) -> str:
    """Which part of the film it is, where it does not begin at the first frame."""
    return f", from {film['from_s']:.6g} to {film['to_s']:.6g} s" if film["first_frame"] else ""


def _left_out_lines(left_out: list[dict[str, Any]]) -> list[str]:
    """One line for each reason."""
    places: dict[str, list[str]] = {}
    for one in left_out:
        places.setdefault(one["reason"], []).append(f"{one['x_px']:.0f},{one['y_px']:.0f}")
    return [f"left out  {' '.join(at[:6])}{' ...' if len(at) > 6 else ''}: {reason}" for reason, at in places.items()]


def _scale_lines(scale: dict[str, Any], sigma_px: float | None) -> list[str]:
    lines, mm_per_px = [], scale["mm_per_px"]
    if sigma_px is not None:
        millimetres = "" if mm_per_px is None else f"   {sigma_px * mm_per_px:.4f} mm"
        lines.append(f"sigma     {sigma_px:.4f} px{millimetres} per mark and frame")
    if mm_per_px is not None and (scale["relative_sigma"] or scale["said"] != "given"):
        lines.append(f"scale     {mm_per_px:.5g} mm/px +- {100 * scale['relative_sigma']:.2g} % ({scale['said']})")
    if mm_per_px is not None and scale["up_sigma_deg"]:
        lines.append(f"up        {scale['up_deg']:.3f} +- {scale['up_sigma_deg']:.3f} deg by the plumb line")
    return lines


def _mark_line(mark: dict[str, Any]) -> str:
    counts = ", ".join(f"{count} {word}" for word, count in mark["frames"].items())
    return f"          {mark['name']} at {mark['x_px']:.1f},{mark['y_px']:.1f}: {counts}; first not ok in frame {mark['first_not_ok']}"


def _noise_lines(noise: list[dict[str, Any]]) -> list[str]:
    """Channels whose noise is clearly kept from frame to frame."""
    kept = [one for one in noise if one["lag1"] > _CLEAR_SIGMAS * one["lag1_sigma"]]
    if not kept:
        return []
    listed = ", ".join(f"{one['channel'].rsplit('_', 1)[0]} {one['lag1']:.2f} +- {one['lag1_sigma']:.2f}" for one in kept)
    return [f"noise     correlated from frame to frame: {listed}"]


def _unit(channel: str) -> tuple[float, str]:
    return (1e3, "mm") if channel.endswith("_m") else (float(np.degrees(1.0)), "deg")


def _channel(channel: str, extent: float | None, sigma: float | None) -> str:
    factor, unit = _unit(channel)
    if extent is None or sigma is None:
        return f"{channel.rsplit('_', 1)[0]} not observed"
    return f"{channel.rsplit('_', 1)[0]} moves {factor * extent:.2f} +- {factor * sigma:.3f} {unit}"


def dispersion_lines(compared: Sequence[Dispersion]) -> list[str]:
    """How much this film and others differ, one line for each.

    Parameters
    ----------
    compared : sequence of Dispersion

    Returns
    -------
    list of str
    """
    lines = []
    for found in compared:
        parts = []
        for channel, difference in found.channels.items():
            numbers, (factor, unit) = difference.summary(), _unit(channel)
            percent = f" ({numbers['rms_percent']:.1f} %)" if channel == "z_m" and numbers["rms_percent"] is not None else ""
            parts.append(f"{channel.rsplit('_', 1)[0]} {factor * (numbers['rms'] or 0.0):.3g} {unit}{percent}")
        lines.append(f"disperses {', '.join(parts)} rms from {found.name}, {1e3 * found.shift_s:+.2f} ms apart")
    return lines
