"""A part of a film, and a film of the fields of an interlaced one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from measure.common.errors import InputError
from measure.footage.footage import Footage, Picture
from measure.footage.integrity import Combing

_ON_THE_FRAME = 1e-6
"""Share of the step from frame to frame by which a limit in time may miss a frame; it is of rounding."""

_LOOKED_AT = 400
"""Frames that are looked at for the order of the fields."""


@dataclass(frozen=True)
class Part(Footage):
    """The frames of another film from `first` on, `frames` of them; the instants are those of the whole film."""

    whole: Footage | None = None

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Frame by frame, counted from the first of the part."""
        assert self.whole is not None
        for number, picture in self.whole.pictures():
            if number - self.first >= self.frames:
                return
            if number >= self.first:
                yield number - self.first, picture

    def times_s(self, count: int, fps: float) -> NDArray[np.float64]:
        """Instants of the first `count` frames of the part, s, from the first frame of the film."""
        assert self.whole is not None
        return self.whole.times_s(self.first + count, fps)[self.first :]


def part(footage: Footage, fps: float, from_s: float | None = None, to_s: float | None = None) -> Footage:
    """The part of a film between two instants, both included.

    Parameters
    ----------
    footage : Footage
    fps : float
        Capture rate, frames per second.
    from_s, to_s : float, optional
        Film time, s: counted from the first frame of the film.

    Returns
    -------
    Footage
        Its times stay those of the film.

    Raises
    ------
    InputError
        A limit outside of the film, the first after the last, fewer than two frames between them.
    """
    if from_s is None and to_s is None:
        return footage
    times = footage.times_s(footage.frames, fps)
    rounding = _ON_THE_FRAME / fps
    for option, limit in (("--from", from_s), ("--to", to_s)):
        if limit is not None and not -rounding <= limit <= times[-1] + rounding:
            raise InputError(
                f"{option} {limit:g}: is outside of the film. {footage.name} has {footage.frames} frames from 0 to {times[-1]:.6g} s "
                f"at {fps:g} frames/s; give seconds between these."
            )
    first_s, last_s = from_s if from_s is not None else 0.0, to_s if to_s is not None else times[-1]
    inside = np.flatnonzero((times >= first_s - rounding) & (times <= last_s + rounding))
    if len(inside) < 2:
        raise InputError(
            f"--from {first_s:g} --to {last_s:g}: {len(inside)} frames of {footage.name} are between them; a motion needs two at least. "
            "Give a later --to or an earlier --from."
        )
    first, count = int(inside[0]), len(inside)
    return Part(
        footage.name, footage.width, footage.height, footage.bits, count, footage.fps, footage.exposure_s, footage.remarks,
        first=footage.first + first, per_frame=footage.per_frame, whole=footage,
    )  # fmt: skip


@dataclass(frozen=True)
class Fields(Footage):
    """The fields of an interlaced film, each as a whole picture: its own rows, and between them rows interpolated from them.

    Attributes
    ----------
    whole : Footage
    top_first : bool
        Whether rows 0, 2, 4 ... were taken before rows 1, 3, 5 ...
    """

    whole: Footage | None = None
    top_first: bool = True

    def pictures(self) -> Iterator[tuple[int, Picture]]:
        """Field by field; a frame that is missing lacks both."""
        assert self.whole is not None
        for number, picture in self.whole.pictures():
            for k in (0, 1):
                yield 2 * number + k, field(picture, (k == 0) == self.top_first)


def field(picture: Picture, top: bool) -> Picture:
    """One field of a picture, in full height: the rows between its own are cubic means of four of them, (-1, 9, 9, -1) / 16.

    Parameters
    ----------
    picture : (height, width) array
    top : bool
        Rows 0, 2, 4 ..., or rows 1, 3, 5 ...

    Returns
    -------
    (height, width) array
        Of the same type of number.
    """
    own = 0 if top else 1
    rows = picture[own::2].astype(np.float32)
    before, after = np.pad(rows, ((2, 0), (0, 0)), "edge"), np.pad(rows, ((0, 2), (0, 0)), "edge")
    n = len(rows)
    between = (9.0 * (rows[:-1] + rows[1:]) - before[1:n] - after[2 : n + 1]) / 16.0
    made = picture.copy()
    made[own + 1 : own + 2 * n - 2 : 2] = np.clip(np.rint(between), 0, np.iinfo(picture.dtype).max)
    if own:
        made[0] = picture[1]
    if own + 2 * n - 1 < len(picture):
        made[own + 2 * n - 1] = picture[own + 2 * n - 2]
    return made


def fields(footage: Footage) -> Footage:
    """The fields of an interlaced film as pictures of their own, in the order in which they were taken.

    Parameters
    ----------
    footage : Footage

    Returns
    -------
    Footage
        Two pictures a frame, half the step apart; places on them are those on the film.

    Raises
    ------
    InputError
        The pictures are not those of an interlaced film, or too little moves for the order of the fields to be known.
    """
    combing = Combing()
    for number, picture in footage.pictures():
        combing.watch(picture)
        if number >= _LOOKED_AT:
            break
    if not combing.interlaced:
        raise InputError(
            f"--fields: {footage.name} is not interlaced: of {combing.moving} frames that move, {combing.combed} have rows of two "
            "instants. Leave --fields away."
        )
    steps = np.arange(float(footage.frames)) if footage.instants is None else footage.instants
    between = steps + 0.5 * np.diff(steps, append=2.0 * steps[-1] - steps[-2] if len(steps) > 1 else 1.0)
    instants = np.column_stack([steps, between]).ravel()
    remark = f"split into fields, {'top' if combing.top_first else 'bottom'} field first; rows between those of a field are interpolated"
    return Fields(
        footage.name, footage.width, footage.height, footage.bits, 2 * footage.frames, footage.fps, footage.exposure_s,
        (*footage.remarks, remark), instants, per_frame=2, whole=footage, top_first=combing.top_first,
    )  # fmt: skip
