"""Pictures of a film for a page, each as an address that holds it."""

from __future__ import annotations

import base64

import numpy as np
from numpy.typing import NDArray


def brightest(picture: NDArray) -> float:
    """The grey value that is shown white: that of all but the brightest thousandth of the pixels."""
    return max(float(np.percentile(picture, 99.9)), 1.0)


def shown(picture: NDArray, white: float) -> NDArray[np.uint8]:
    """Grey values for a screen, 0 to 255."""
    return np.clip(np.rint(picture * (255.0 / white)), 0, 255).astype(np.uint8)


def embedded(picture: NDArray[np.uint8], quality: int | None = None) -> str:
    """A picture as an address that holds the picture itself: JPEG of a quality, or PNG, which loses nothing.

    Parameters
    ----------
    picture : (height, width) or (height, width, 3) array of uint8
        Grey, or blue, green, red.
    quality : int, optional
        1 to 100.
    """
    import cv2

    kind, how = ("png", []) if quality is None else ("jpeg", [cv2.IMWRITE_JPEG_QUALITY, quality])
    return f"data:image/{kind};base64," + base64.b64encode(cv2.imencode(f".{kind}", picture, how)[1].tobytes()).decode()


def reduced(picture: NDArray[np.uint8], largest: int) -> NDArray[np.uint8]:
    """A picture whose larger side is at most `largest` px."""
    import cv2

    times = largest / max(picture.shape[:2])
    return picture if times >= 1.0 else cv2.resize(picture, None, fx=times, fy=times, interpolation=cv2.INTER_AREA).astype(np.uint8)
