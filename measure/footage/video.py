"""Films in a container (avi, mp4, mov, mkv ...), decoded by FFmpeg through PyAV: grey values only, forward only.

PyAV reports which pictures could not be decoded soundly; OpenCV's reader fills those in silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
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
from measure.footage.time_stamps import FrameClock, frame_clock

HEAD_BYTES = 400
"""First bytes of a file that tell what it is; two packets of a transport stream."""

_LOCAL_ONLY = {"protocol_whitelist": "file"}
_STRICT = {"err_detect": "crccheck+bitstream+buffer+explode"}
_NO_STAMPS = FrameClock(np.empty(0, np.int64), np.empty(0, np.int64))


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
        with _opened(self.path) as (container, stream):
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
        with _opened(path) as (container, stream):
            check_size(path, stream.codec_context.width, stream.codec_context.height)
            promised = _promised(container, stream)
            first = next((frame for frame in _frames(path, container, stream) if frame is not None), None)
        packets = _packets(path)
    except FFmpegError:
        first, promised, packets = None, Promise(), Packets()
    if first is None:
        raise InputError(
            f"{path}: begins like a film, but no frame of it can be decoded; it is cut or damaged. Copy it again from the camera."
        )
    grey, clock = _grey(first), frame_clock(packets.stamps)
    frames = max(promised.counted - packets.cut_away + clock.dropped, promised.by_duration, clock.frames, packets.count, 1)
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


@contextmanager
def _opened(path: Path) -> Iterator[tuple[InputContainer, av.VideoStream]]:
    """The container and its first film; local files only, and PyAV leaves standard error alone."""
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
    """PyAV before 19 must be asked to take damaged words in the head of a file; later ones do."""
    if int(av.__version__.split(".")[0]) < 19:
        return av.open(name, format=form, options=_LOCAL_ONLY, metadata_errors="replace")
    return av.open(name, format=form, options=_LOCAL_ONLY)


@dataclass(frozen=True)
class Promise:
    """How many pictures a container should hold: counted in its head, or by how long the film lasts; 0 where it is not known."""

    counted: int = 0
    by_duration: int = 0


def _promised(container: InputContainer, stream: av.VideoStream) -> Promise:
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


def _packets(path: Path) -> Packets:
    """Read without decoding; no stamps where one picture has none or two have the same."""
    stamps: list[int] = []
    count, cut_away, complete = 0, 0, True
    with _opened(path) as (container, stream):
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
