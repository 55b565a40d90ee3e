"""The page with the result: the film's pictures with marks and residuals under a slider, curves in step, quality, remarks, provenance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measure.common.output import json_text
from measure.film.status_colours import ENLARGED, RESIDUAL_COLOUR, STATUS_COLOURS
from measure.film.summary import VERDICTS
from measure.film.tracked import Tracked
from measure.film_pages.page import rendered
from measure.footage.footage import Footage
from measure.pages.picture import brightest, embedded, reduced, shown

_MOST_PICTURES = 120
_LARGEST_PX = 900
_QUALITY = 75
_MOST_BYTES = 12_000_000
"""What all pictures together may take in the page."""


def report_page(footage: Footage, tracked: Tracked, note: Mapping[str, Any]) -> str:
    """The page for one tracked film. The film is read once more.

    Parameters
    ----------
    footage : Footage
        That was tracked.
    tracked : Tracked
    note : mapping
        Provenance.

    Returns
    -------
    str
        HTML.
    """
    marks, summary = tracked.marks, tracked.summary
    data = {
        "width": footage.width, "height": footage.height, "subset": tracked.project.marks.subset_px, "first": marks.first,
        "time_s": marks.time_s, "names": marks.names, "x": marks.x_px.T, "y": marks.y_px.T, "status": marks.status.T,
        "sigma": marks.sigma_px.T, "residual": None if tracked.fit is None else _residuals(tracked),
        "enlarged": ENLARGED, "colours": STATUS_COLOURS, "residual_colour": RESIDUAL_COLOUR,
        "curves": _curves(tracked), "pictures": _pictures(footage, len(marks.time_s)),
    }  # fmt: skip
    return rendered(
        "report.html.j2",
        ("view.js", "report.js"),
        data,
        r=summary,
        words=VERDICTS[summary["verdict"]],
        note=json_text({key: value for key, value in note.items() if key != "noise"}),
        quality=_quality(tracked),
        noise=[_noise_row(one) for one in summary["noise"]],
        shown_pictures=len(data["pictures"]),
        channels=_channel_rows(summary),
        num=_number,
    )


def _pictures(footage: Footage, frames: int) -> list[dict[str, Any]]:
    """Pictures spread over the film, smaller where the film has large ones or many."""
    wanted = set(np.rint(np.linspace(0, frames - 1, min(frames, _MOST_PICTURES))).astype(int).tolist())
    white, found, taken = 0.0, [], 0
    for number, picture in footage.pictures():
        white = white or brightest(picture)
        if number in wanted and taken < _MOST_BYTES:
            found.append({"frame": number, "src": embedded(reduced(shown(picture, white), _LARGEST_PX), _QUALITY)})
            taken += len(found[-1]["src"])
    return found


def _residuals(tracked: Tracked) -> NDArray[np.float64]:
    """(marks, frames, 2): how far each mark is from the rigid body, px; NaN where it was not used."""
    assert tracked.fit is not None
    return np.where(tracked.fit.used[..., None], tracked.fit.residual_px, np.nan).transpose(1, 0, 2)


def _curves(tracked: Tracked) -> list[dict[str, Any]]:
    """What is drawn against time: the channels, and the misfit of the marks."""
    table, curves = tracked.trajectory, []
    for channel, values in ({} if table is None else table.channels).items():
        factor, unit = _unit(channel)
        sigma = table.sigma.get(channel) if table is not None else None
        band = None if sigma is None else 2.0 * factor * sigma
        curves.append({"label": f"{channel.rsplit('_', 1)[0]}, {unit}", "values": factor * values, "band": band})
    if tracked.fit is not None:
        squares = np.where(tracked.fit.used[..., None], tracked.fit.residual_px, np.nan) ** 2
        seen = np.asarray(tracked.fit.used).any(axis=1).reshape(-1)
        rms = np.full(len(seen), np.nan)
        rms[seen] = np.sqrt(np.nanmean(squares[seen], axis=(1, 2)))
        curves.append({"label": "residual of the marks, px", "values": rms, "band": None})
    else:
        curves += [
            {"label": f"{name}: {axis}, px", "values": values[:, i], "band": None}
            for i, name in enumerate(tracked.marks.names)
            for axis, values in (("x", tracked.marks.x_px), ("y", tracked.marks.y_px))
        ]
    return curves


def _unit(channel: str) -> tuple[float, str]:
    return (1e3, "mm") if channel.endswith("_m") else (float(np.degrees(1.0)), "deg")


def _quality(tracked: Tracked) -> list[dict[str, Any]]:
    """A row for each mark."""
    zncc = np.where(tracked.marks.observed, tracked.marks.zncc, np.nan)
    return [
        {**mark, "zncc": float(np.nanmin(zncc[:, i])) if np.isfinite(zncc[:, i]).any() else None}
        for i, mark in enumerate(tracked.summary["marks"])
    ]


def _channel_rows(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    platform, rows = summary["platform"], []
    for channel, extent in (platform["range"] if platform else {}).items():
        factor, unit = _unit(channel)
        sigma = platform["median_sigma"].get(channel)
        values = {key: None if value is None else factor * value for key, value in (("range", extent), ("sigma", sigma))}
        rows.append({"name": channel.rsplit("_", 1)[0], "unit": unit, **values})
    return rows


def _noise_row(one: Mapping[str, Any]) -> dict[str, Any]:
    factor, unit = _unit(one["channel"])
    name = one["channel"].rsplit("_", 1)[0]
    return {**one, "name": name, "unit": unit, "sigma": factor * one["sigma"], "stated_sigma": factor * one["stated_sigma"]}


def _number(value: float | None) -> str:
    """A number with three digits, a dash where there is none."""
    return "–" if value is None or not np.isfinite(value) else f"{value:.3g}"
