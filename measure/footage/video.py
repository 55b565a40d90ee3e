"""Films in a container (avi, mp4, mov, mkv), decoded by FFmpeg through PyAV: grey values only, forward only.

PyAV says which pictures could not be decoded soundly, which OpenCV's reader fills in without a word.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np
from av.container import InputContainer
from av.error import FFmpegError
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.common.limits import limited
from measure.footage.footage import Footage, Picture, check_size

_LOCAL_ONLY = {"protocol_whitelist": "file"}
_STRICT = {"err_detect": "crccheck+bitstream+buffer+explode"}


def is_container(head: bytes) -> bool:
    """Whether a file that begins with these bytes is an avi, mp4, mov or mkv."""
    return bool(_format(head))


def _format(head: bytes) -> str:
    """FFmpeg's name of the container; no other is tried, so that no file can pass itself off as a playlist."""
    if head[:4] == b"RIFF" and head[8:12] == b"AVI ":
        return "avi"
    if head[4:8] in (b"ftyp", b"moov", b"mdat", b"wide"):
        return "mov"
    return "matroska" if head[:4] == b"\x1aE\xdf\xa3" else ""


@dataclass(frozen=True)
class VideoFile(Footage):
    """A film in a container. Its nominal rate is the player's, not the camera's, and is not used.

    stamps : (n,) when each picture is to be shown, in the container's own units and in order, which numbers the pictures; empty
    where the container does not tell them apart.
    """

    path: Path = Path()
    stamps: NDArray[np.int64] | None = None

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame, until the file ends; the next one is decoded while the last one is used.

        A picture that is damaged has no number, nor have those that are built on it, up to the next one that stands alone.
        """
        with ThreadPoolExecutor(1) as decoder:
            decoded = self._decoded()
            coming = decoder.submit(next, decoded, None)
            while (frame := coming.result()) is not None:
                coming = decoder.submit(next, decoded, None)
                yield frame

    def _decoded(self) -> Iterator[tuple[int, Picture]]:
        with _opened(self.path) as (container, stream):
            number, sound = -1, True
            for frame in _frames(self.path, container, stream):
                number = self._number(frame, number)
                if frame is None or frame.is_corrupt:
                    sound = False
                elif frame.key_frame:
                    sound = True
                if frame is not None and sound:
                    yield number, _grey(frame)

    def _number(self, frame: av.VideoFrame | None, last: int) -> int:
        """The place of a picture's stamp among all; the next number where that is unknown."""
        if frame is None or frame.pts is None or self.stamps is None or not len(self.stamps):
            return last + 1
        place = int(np.searchsorted(self.stamps, frame.pts))
        return place if place > last else last + 1


def open_video(path: Path) -> Footage:
    """Open a film in a container, go through its packets and decode one frame of it.

    Raises
    ------
    InputError
        It cannot be opened, or holds no frame that can be decoded.
    """
    try:
        with _opened(path) as (container, stream):
            check_size(path, stream.codec_context.width, stream.codec_context.height)
            promised = _promised(container, stream)
            first = next((frame for frame in _frames(path, container, stream) if frame is not None), None)
        stamps = _stamps(path)
    except FFmpegError:
        first, promised, stamps = None, 0, np.empty(0, np.int64)
    if first is None:
        raise InputError(
            f"{path}: begins like a film, but no frame of it can be decoded; it is cut or damaged. Copy it again from the camera."
        )
    grey = _grey(first)
    frames = max(promised, len(stamps), 1)
    return VideoFile(str(path), grey.shape[1], grey.shape[0], _bits(first), frames, path=path, stamps=stamps)


@contextmanager
def _opened(path: Path) -> Iterator[tuple[InputContainer, av.VideoStream]]:
    """The container and its first film; local files only, and PyAV leaves standard error alone."""
    with open(path, "rb") as file:
        form = _format(file.read(64))
    with limited(path):
        container = av.open(str(path.resolve()), format=form, options=_LOCAL_ONLY, metadata_errors="replace")
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


def _promised(container: InputContainer, stream: av.VideoStream) -> int:
    """How many pictures the head of the file says there are; some containers only know how long the film lasts."""
    if stream.frames:
        return stream.frames
    rate = stream.average_rate
    lasts = stream.duration * stream.time_base if stream.duration and stream.time_base else None
    if lasts is None and container.duration:
        lasts = container.duration / av.time_base
    return round(lasts * rate) if lasts and rate else 0


def _stamps(path: Path) -> NDArray[np.int64]:
    """The stamps of all packets in order, read without decoding; empty where one has none or two have the same."""
    stamps: list[int] = []
    with _opened(path) as (container, stream):
        try:
            for packet in container.demux(stream):
                if packet.size and packet.pts is None:
                    return np.empty(0, np.int64)
                stamps += [packet.pts] if packet.size and packet.pts is not None else []
        except FFmpegError:
            return np.empty(0, np.int64)
    unique = np.unique(np.array(stamps, np.int64))
    return unique if len(unique) == len(stamps) else np.empty(0, np.int64)


def _frames(path: Path, container: InputContainer, stream: av.VideoStream) -> Iterator[av.VideoFrame | None]:
    """Pictures as they are decoded; None for one that could not be. A container that breaks off ends the film."""
    packets = container.demux(stream)
    while True:
        with limited(path):
            try:
                packet = next(packets, None)
            except FFmpegError as error:
                _require_memory(error)
                return
            if packet is None:
                return
            try:
                decoded: list[av.VideoFrame | None] = [*packet.decode()]
            except FFmpegError as error:
                _require_memory(error)
                decoded = [None]
        yield from decoded


def _require_memory(error: FFmpegError) -> None:
    if isinstance(error, MemoryError):
        raise error


def _bits(frame: av.VideoFrame) -> int:
    return max(8, frame.format.components[0].bits) if _has_luma(frame) else 8


def _has_luma(frame: av.VideoFrame) -> bool:
    """Whether the first plane is brightness and nothing else."""
    first, *others = frame.format.components
    return _is_luma(frame) and first.bits >= 8 and all(other.plane != first.plane for other in others)


def _is_luma(frame: av.VideoFrame) -> bool:
    return not frame.format.is_rgb and not frame.format.has_palette


def _grey(frame: av.VideoFrame) -> Picture:
    """The luma plane, in its depth, or a colour picture made grey; upright, as the camera was held."""
    if _has_luma(frame):
        grey = _first_plane(frame)
    elif _is_luma(frame):
        grey = _first_plane(frame.reformat(format="yuv444p"))
    else:
        grey = cv2.cvtColor(frame.to_ndarray(format="bgr24"), cv2.COLOR_BGR2GRAY)
    return np.ascontiguousarray(np.rot90(grey, frame.rotation // 90))  # type: ignore[return-value]


def _first_plane(frame: av.VideoFrame) -> NDArray:
    plane = frame.planes[0]
    stored, native = (np.uint8, np.uint8) if _bits(frame) == 8 else (">u2" if frame.format.name.endswith("be") else "<u2", np.uint16)
    rows = np.frombuffer(memoryview(plane), np.uint8).reshape(-1, plane.line_size).view(stored)
    return rows[: frame.height, : frame.width].astype(native)
