"""The methods that the tracking benchmark compares: each says where the mark of the reference picture is now."""

from __future__ import annotations

import cv2
import numpy as np
from tracking_scenes import MIDDLE, SUBSET

from measure.correlation.steepest_descent import AFFINE, TRANSLATION
from measure.correlation.tracking import mark_tracker

HALF = SUBSET // 2


def ours(warp, steps=1):
    """The tracker of `measure.correlation.mark_tracker`, as for a film. steps is for the caller: pictures on the way to the last."""

    def find(pictures):
        mark = mark_tracker(pictures[0], MIDDLE, MIDDLE, SUBSET, warp)
        seen = None
        for frame, picture in enumerate(pictures):
            seen = mark.observe(picture, frame)
        assert seen is not None
        return np.array([seen.x_px, seen.y_px]) - MIDDLE, np.sqrt(np.diag(seen.covariance_px2))

    return find


def _peak(pictures):
    patch = pictures[0][MIDDLE - HALF : MIDDLE + HALF + 1, MIDDLE - HALF : MIDDLE + HALF + 1]
    scores = cv2.matchTemplate(pictures[-1], patch, cv2.TM_CCOEFF_NORMED)
    row, column = np.unravel_index(int(scores[1:-1, 1:-1].argmax()), (scores.shape[0] - 2, scores.shape[1] - 2))
    return scores, row + 1, column + 1


def match_template(pictures):
    """Template matching and a parabola through three points along each axis."""
    scores, row, column = _peak(pictures)

    def vertex(a, b, c):
        return 0.5 * (a - c) / (a - 2 * b + c)

    x = column + vertex(*scores[row, column - 1 : column + 2].astype(float))
    y = row + vertex(*scores[row - 1 : row + 2, column].astype(float))
    return np.array([x, y]) + HALF - MIDDLE, None


def ecc(pictures):
    """cv2.findTransformECC, translation, Gaussian of 5, started at the template's peak."""
    _, row, column = _peak(pictures)
    patch = pictures[0][MIDDLE - HALF : MIDDLE + HALF + 1, MIDDLE - HALF : MIDDLE + HALF + 1]
    warp = np.array([[1, 0, column], [0, 1, row]], np.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-6)
    try:
        _, warp = cv2.findTransformECC(patch, pictures[-1], warp, cv2.MOTION_TRANSLATION, stop, None, 5)
    except cv2.error:
        return np.array([np.nan, np.nan]), None
    return warp[:, 2] + HALF - MIDDLE, None


def lucas_kanade():
    """pyidi's Lucas-Kanade, or None where pyidi is not installed."""
    try:
        from pyidi import LucasKanade, VideoReader
    except ImportError:
        return None

    def find(pictures):
        method = LucasKanade(VideoReader(np.ascontiguousarray(pictures), root="."))
        method.set_points(np.array([[MIDDLE, MIDDLE]]))
        method.configure(roi_size=(SUBSET, SUBSET), int_order=3, verbose=0, show_pbar=False)
        moved = method.get_displacements(autosave=False)[0, -1]
        return np.array([moved[1], moved[0]]), None

    return find


def methods():
    """All by name; the first two are this project's."""
    known = {"ours, translation": ours(TRANSLATION), "ours": ours(AFFINE), "template + parabola": match_template, "ECC": ecc}
    other = lucas_kanade()
    return {**known, "pyidi LK": other} if other is not None else known
