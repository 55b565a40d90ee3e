"""A film with the result drawn into it: every mark's subset, status and residual of the rigid body."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from measure.common.output import replacing
from measure.correlation.marks import OK
from measure.film.status_colours import ENLARGED, RESIDUAL_COLOUR, STATUS_COLOURS
from measure.footage.footage import Footage, Picture

if TYPE_CHECKING:
    from measure.film.tracked import Tracked

_LEAST_HEIGHT = 480
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def overlaid(footage: Footage, tracked: Tracked) -> Iterator[NDArray[np.uint8]]:
    """Draw the result into the film, picture by picture.

    A frame that the film lacks is left out. The brightness is stretched once for the whole film.

    Parameters
    ----------
    footage : Footage
    tracked : Tracked

    Returns
    -------
    iterator of (height, width, 3) arrays of uint8
        Blue, green, red; small pictures are enlarged by a whole number.
    """
    brightest = 0.0
    for number, picture in footage.pictures():
        if number >= len(tracked.marks.time_s):
            return
        brightest = brightest or max(float(np.percentile(picture, 99.9)), 1.0)
        yield drawn(picture, tracked, number, brightest)


def drawn(picture: Picture, tracked: Tracked, frame: int, brightest: float) -> NDArray[np.uint8]:
    """Draw the marks into one picture.

    Parameters
    ----------
    picture : (height, width) array
    tracked : Tracked
    frame : int
    brightest : float
        Grey value that becomes white.

    Returns
    -------
    (height, width, 3) array of uint8
    """
    times = max(1, -(-_LEAST_HEIGHT // picture.shape[0]))
    canvas = _with_marks(picture, tracked, frame, brightest, times)
    for row, (text, colour) in enumerate(_captions(tracked, frame)):
        cv2.putText(canvas, text, (6, 18 + 16 * row), _FONT, 0.45, colour, 1, cv2.LINE_AA)
    return canvas.astype(np.uint8)


def write_first_frame(footage: Footage, tracked: Tracked, path: Path) -> Path:
    """Write the first frame with its marks (PNG), pixel for pixel: a place that is read in any viewer is the place on the film.

    Parameters
    ----------
    footage : Footage
    tracked : Tracked
    path : Path
        In a folder that exists.

    Returns
    -------
    Path
        The same.
    """
    picture = next(picture for _, picture in footage.pictures())
    drawn_on = _with_marks(picture, tracked, 0, max(float(np.percentile(picture, 99.9)), 1.0), 1)
    with replacing(path) as temporary:
        temporary.write_bytes(cv2.imencode(".png", drawn_on)[1].tobytes())
    return path


def _with_marks(picture: Picture, tracked: Tracked, frame: int, brightest: float, times: int) -> NDArray[np.uint8]:
    """The picture as many times as large, with the marks that are observed."""
    grey = np.clip(picture * (255.0 / brightest), 0, 255).astype(np.uint8)
    large = cv2.resize(grey, None, fx=times, fy=times, interpolation=cv2.INTER_NEAREST)
    canvas = cv2.cvtColor(large, cv2.COLOR_GRAY2BGR)
    for i in range(len(tracked.marks.names)):
        if tracked.marks.observed[frame, i]:
            _draw_mark(canvas, tracked, frame, i, times)
    return canvas.astype(np.uint8)


def _draw_mark(canvas: NDArray, tracked: Tracked, frame: int, i: int, times: int) -> None:
    x, y = tracked.marks.x_px[frame, i], tracked.marks.y_px[frame, i]
    half, colour = tracked.project.marks.subset_px / 2, _bgr(STATUS_COLOURS[OK])
    first, last = _at(x - half, y - half, times), _at(x + half, y + half, times)
    cv2.rectangle(canvas, first, last, colour, 1)
    cv2.putText(canvas, str(tracked.marks.names[i]), (first[0], first[1] - 3), _FONT, 0.4, colour, 1, cv2.LINE_AA)
    if tracked.fit is not None and tracked.fit.used[frame, i]:
        dx, dy = np.clip(ENLARGED * tracked.fit.residual_px[frame, i], -4 * half, 4 * half)
        cv2.arrowedLine(canvas, _at(x, y, times), _at(x + dx, y + dy, times), _bgr(RESIDUAL_COLOUR), 1, cv2.LINE_AA)


def _captions(tracked: Tracked, frame: int) -> list[tuple[str, tuple[int, int, int]]]:
    """Frame, time and residual, and the status of the marks that are not observed."""
    marks, fit = tracked.marks, tracked.fit
    white = (255, 255, 255)
    lines: list[tuple[str, tuple[int, int, int]]] = [(f"frame {marks.first + frame}  {marks.time_s[frame]:.4f} s", white)]
    if fit is not None and fit.used[frame].any():
        rms = np.sqrt(np.nanmean(fit.residual_px[frame][fit.used[frame]] ** 2))
        lines += [(f"residual {rms:.4f} px", white), (f"arrows: residuals x {ENLARGED:g}", _bgr(RESIDUAL_COLOUR))]
    for i in np.flatnonzero(~marks.observed[frame]).tolist():
        status = str(marks.status[frame, i])
        lines.append((f"{marks.names[i]} {status}", _bgr(STATUS_COLOURS[status])))
    return lines


def _at(x: float, y: float, times: int) -> tuple[int, int]:
    """A place of the film on the enlarged canvas, pixel centres at whole numbers."""
    return round((x + 0.5) * times - 0.5), round((y + 0.5) * times - 0.5)


def _bgr(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return blue, green, red
