"""Unpack pixels of 10 and 12 bit that share bytes."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def unpack_12(packed: NDArray[np.uint8], count: int) -> NDArray[np.uint16]:
    """Unpack two pixels from each three bytes, high bits first: AAAAAAAA AAAABBBB BBBBBBBB.

    Parameters
    ----------
    packed : array of uint8
    count : int
        Number of pixels.

    Returns
    -------
    (count,) array of uint16
    """
    made = np.empty(count, np.uint16)
    for i in range(count // 2):
        a, b, c = np.uint16(packed[3 * i]), np.uint16(packed[3 * i + 1]), np.uint16(packed[3 * i + 2])
        made[2 * i] = (a << 4) | (b >> 4)
        made[2 * i + 1] = ((b & 15) << 8) | c
    if count % 2:
        last = 3 * (count // 2)
        made[count - 1] = (np.uint16(packed[last]) << 4) | (np.uint16(packed[last + 1]) >> 4)
    return made


@njit(cache=True, nogil=True)
def unpack_10(packed: NDArray[np.uint8], count: int) -> NDArray[np.uint16]:
    """Unpack four pixels from each five bytes, high bits first.

    Parameters
    ----------
    packed : array of uint8
    count : int
        Number of pixels, a multiple of four.

    Returns
    -------
    (count,) array of uint16
    """
    made = np.empty(count, np.uint16)
    for i in range(count // 4):
        bits = np.uint64(0)
        for j in range(5):
            bits = (bits << np.uint64(8)) | np.uint64(packed[5 * i + j])
        for j in range(4):
            made[4 * i + j] = np.uint16((bits >> np.uint64(30 - 10 * j)) & np.uint64(1023))
    return made


def unpack(packed: NDArray[np.uint8], bits: int, width: int, height: int) -> NDArray[np.uint8 | np.uint16]:
    """Make a picture of its bytes.

    Parameters
    ----------
    packed : array of uint8
    bits : int
        8, 10 (packed), 12 (packed) or 16 (little-endian).
    width, height : int
        px.

    Returns
    -------
    (height, width) array of uint8 or uint16
    """
    if bits == 8:
        return packed.reshape(height, width)
    if bits == 16:
        return packed.view("<u2").reshape(height, width)
    kernel = {10: unpack_10, 12: unpack_12}[bits]
    return kernel(packed, width * height).reshape(height, width)
