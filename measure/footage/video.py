"""Films in a container (avi, mp4, mov, mkv ...), decoded by FFmpeg through PyAV: grey values only, forward only.

PyAV reports which pictures could not be decoded soundly; OpenCV's reader fills those in silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
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
from measure.footage.container import Packets, Promise, opened, promised, read_packets
from measure.footage.footage import Footage, Picture, check_size
from measure.footage.time_stamps import FrameClock, frame_clock

_ROUGH = 1.1
_NO_STAMPS = FrameClock(np.empty(0, np.int64), np.empty(0, np.int64))


@dataclass(frozen=True)
class VideoFile(Footage):
    """A film in a container. Its nominal rate is that of playing, not the camera's, and is not used.

    Attributes
    ----------
    path : Path
    clock : FrameClock
        Numbers of the frames by their time stamps; without stamps they are counted.
    """

    path: Path = Path()
    clock: FrameClock = _NO_STAMPS

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame, until the file ends; the next one is decoded while the last one is used.

        A damaged picture is left out, and so are those that are built on it, up to the next one that stands alone.
        """
        with ThreadPoolExecutor(1) as decoder:
            decoded = self._decoded()
            coming = decoder.submit(next, decoded, None)
            while (frame := coming.result()) is not None:
                coming = decoder.submit(next, decoded, None)
                yield frame

    def _decoded(self) -> Iterator[tuple[int, Picture]]:
        with opened(self.path) as (container, stream):
            number, sound = -1, True
            for frame in _frames(self.path, container, stream):
                number = self.clock.number(None if frame is None else frame.pts, number)
                if frame is None or frame.is_corrupt:
                    sound = False
                elif frame.key_frame:
                    sound = True
                if frame is not None and sound:
                    yield number, _grey(frame)


def open_video(path: Path) -> Footage:
    """Open a film in a container: go through its packets and decode its first frame.

    Frames that the camera dropped show in the time stamps; frames outside of an edit list are not part of the film.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    Footage

    Raises
    ------
    InputError
        It cannot be opened, or holds no frame that can be decoded.
    """
    try:
        with opened(path) as (container, stream):
            check_size(path, stream.codec_context.width, stream.codec_context.height)
            promise = promised(container, stream)
            first = next((frame for frame in _frames(path, container, stream) if frame is not None), None)
        packets = read_packets(path)
    except FFmpegError:
        first, promise, packets = None, Promise(), Packets()
    if first is None:
        raise InputError(
            f"{path}: begins like a film, but no frame of it can be decoded; it is cut or damaged. Copy it again from the camera."
        )
    grey, clock = _grey(first), frame_clock(packets.stamps)
    frames = max(promise.counted - packets.cut_away + clock.dropped, _by_duration(promise, clock), clock.frames, packets.count, 1)
    return VideoFile(
        str(path),
        grey.shape[1],
        grey.shape[0],
        _bits(first),
        frames,
        remarks=clock.remarks,
        instants=clock.instants,
        path=path,
        clock=clock,
    )


def _by_duration(promise: Promise, clock: FrameClock) -> int:
    """Frames by how long the film lasts; at a rate that varies that is a rough number, which only shows that much is missing."""
    rough = clock.instants is not None and promise.by_duration < _ROUGH * clock.frames
    return 0 if rough else promise.by_duration


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
