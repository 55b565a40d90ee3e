"""Containers of films (avi, mp4, mov, mkv ...): what they are by their first bytes, and what they promise before decoding."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import av
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.common.limits import limited

HEAD_BYTES = 400
"""First bytes of a file from which its kind is recognised; two packets of a transport stream."""

_LOCAL_ONLY = {"protocol_whitelist": "file"}
_STRICT = {"err_detect": "crccheck+bitstream+buffer+explode"}


def is_container(head: bytes) -> bool:
    """Whether a file that begins with these bytes (400 are enough) is a film in a container that is read."""
    return bool(_format(head))


_MARKS = (
    (0, b"\x1aE\xdf\xa3", "matroska"), (0, b"GIF8", "gif"), (0, b"YUV4MPEG2", "yuv4mpegpipe"), (0, b"\0\0\1\xba", "mpeg"),
    (0, b"0&\xb2u\x8ef\xcf\x11", "asf"), (4, b"ftyp", "mov"), (4, b"moov", "mov"), (4, b"mdat", "mov"), (4, b"wide", "mov"),
    (0, b"\0\0\0\1\x67", "h264"), (0, b"\0\0\0\1\x09", "h264"), (0, b"\0\0\0\1\x40\1", "hevc"),
)  # fmt: skip
"""Where a mark stands in a file, the mark, and FFmpeg's name of the container."""


def _format(head: bytes) -> str:
    """FFmpeg's name of the container; no other is tried, so that no file can pass itself off as a playlist."""
    if head[:4] == b"RIFF" and head[8:12] == b"AVI ":
        return "avi"
    for start, packet in ((0, 188), (4, 192)):
        if len(head) > start + packet and all(byte == 0x47 for byte in head[start::packet]):
            return "mpegts"
    return next((name for at, mark, name in _MARKS if head[at : at + len(mark)] == mark), "")


@contextmanager
def opened(path: Path) -> Iterator[tuple[InputContainer, av.VideoStream]]:
    """Open a container and its first film; local files only, and PyAV leaves standard error alone.

    Parameters
    ----------
    path : Path

    Returns
    -------
    context manager of (InputContainer, VideoStream)

    Raises
    ------
    InputError
        It holds no film, or one that cannot be decoded.
    """
    with open(path, "rb") as file:
        form = _format(file.read(HEAD_BYTES))
    with limited(path):
        container = _container(str(path.resolve()), form)
    with container:
        if not container.streams.video:
            raise InputError(f"{path}: holds no film, only {len(container.streams.get())} streams of other kinds. Name the film.")
        stream = container.streams.video[0]
        if stream.codec_context is None:  # which the types do not know
            raise InputError(
                f"{path}: FFmpeg has no decoder for its pictures, or the name of their code is damaged. Convert or copy the film again."
            )
        stream.thread_type = "AUTO"
        stream.codec_context.options = _STRICT
        yield container, stream


def _container(name: str, form: str) -> InputContainer:
    """PyAV before 19 must be asked to accept damaged text in the head of a file; later ones do."""
    if int(av.__version__.split(".")[0]) < 19:
        return av.open(name, format=form, options=_LOCAL_ONLY, metadata_errors="replace")
    return av.open(name, format=form, options=_LOCAL_ONLY)


@dataclass(frozen=True)
class Promise:
    """How many pictures a container should hold: counted in its head, or by how long the film lasts; 0 where it is not known."""

    counted: int = 0
    by_duration: int = 0


def promised(container: InputContainer, stream: av.VideoStream) -> Promise:
    """Number of pictures by the head of an opened container and its film."""
    if stream.frames:
        return Promise(counted=stream.frames)
    rate = float(stream.average_rate or 0.0)
    if stream.duration and stream.time_base:
        return Promise(by_duration=round(stream.duration * float(stream.time_base) * rate))
    return Promise(by_duration=round((container.duration or 0) / av.time_base * rate))


@dataclass(frozen=True)
class Packets:
    """The stamps of a film's pictures in order, how many there are, and how many more an edit list cuts away."""

    stamps: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    count: int = 0
    cut_away: int = 0


def read_packets(path: Path) -> Packets:
    """Go through a container without decoding.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Packets
        Without stamps where one picture has none, two have the same, or the container breaks off.
    """
    stamps: list[int] = []
    count, cut_away, complete = 0, 0, True
    with opened(path) as (container, stream):
        try:
            for packet in container.demux(stream):
                if not packet.size:
                    continue
                cut_away += packet.is_discard
                count += not packet.is_discard
                if packet.pts is None:
                    complete = False
                elif not packet.is_discard:
                    stamps.append(packet.pts)
        except FFmpegError:
            complete = False
    unique = np.unique(np.array(stamps, np.int64))
    distinct = complete and len(unique) == len(stamps)
    return Packets(unique if distinct else unique[:0], count, cut_away)
