"""Pixels of 10 and 12 bit that share bytes, taken apart."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


@njit(cache=True, nogil=True)
def unpack_12(packed: NDArray[np.uint8], count: int) -> NDArray[np.uint16]:
    """Two pixels in three bytes, the high bits first: AAAAAAAA AAAABBBB BBBBBBBB."""
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
    """Four pixels in five bytes, the high bits first; count is a multiple of four."""
    made = np.empty(count, np.uint16)
    for i in range(count // 4):
        bits = np.uint64(0)
        for j in range(5):
            bits = (bits << np.uint64(8)) | np.uint64(packed[5 * i + j])
        for j in range(4):
            made[4 * i + j] = np.uint16((bits >> np.uint64(30 - 10 * j)) & np.uint64(1023))
    return made


def unpack(packed: NDArray[np.uint8], bits: int, width: int, height: int) -> NDArray[np.uint8 | np.uint16]:
    """A picture from its bytes: 8, packed 10, packed 12 or 16 bit (little-endian)."""
    if bits == 8:
        return packed.reshape(height, width)
    if bits == 16:
        return packed.view("<u2").reshape(height, width)
    kernel = {10: unpack_10, 12: unpack_12}[bits]
    return kernel(packed, width * height).reshape(height, width)
