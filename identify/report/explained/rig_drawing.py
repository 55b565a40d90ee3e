"""The rig drawn with the part on which an effect acts, as SVG: from the model's own geometry, as the camera sees it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from simulate.model.effect import Effect
from simulate.model.model import Model

_WIDE, _MARGIN = 320.0, 20.0

PARTS = {"leg": "legs", "joints": "joints", "platform": "platform", "measurement": "camera"}
_OF_NAMES = {
    "pulley-inertia": "cable", "pulley-friction": "cable", "cable-pendulum": "cable", "gravity-imbalance": "cable",
    "counterweight-inertia": "cable", "handrail-contact": "rails", "base-excitation": "base", "flexible-base": "base",
    "end-stop-dissipation": "stops", "stop-stiffness": "stops", "leg-disparity": "legs", "stored-force-per-run": "legs",
    "platform-mass": "platform", "platform-inertia": "platform", "geometry-error": "joints", "release-pose": "platform",
    "sensor-lag": "cell", "force-offset": "cell", "sensor-filter": "cell",
}  # fmt: skip


@dataclass(frozen=True)
class Stroke:
    """A line or a row of points of the drawing. part : of the rig. path : SVG."""

    part: str
    path: str


@dataclass(frozen=True)
class RigDrawing:
    """A drawing. acting : the parts on which the effects act. words : the same for those who do not see it."""

    width: float
    height: float
    strokes: tuple[Stroke, ...]
    acting: frozenset[str]
    words: str


def part_of(effect: Effect) -> str:
    """The part of the rig on which an effect acts."""
    return _OF_NAMES.get(effect.name, PARTS.get(effect.acts_on, "platform"))


def rig_drawing(model: Model, effects: Iterable[Effect]) -> RigDrawing | None:
    """The rig from the front, half deployed, with what acts marked; none of a model without geometry.

    Parameters
    ----------
    effects : whose parts are marked.
    """
    if model.geometry is None:
        return None
    g = model.geometry
    height = 0.6 * g.deployed_height_m
    base = [(p[0], p[2]) for p in g.base_joints_m]
    joints = [(p[0], p[2] + height) for p in g.platform_joints_m]
    reach = max(abs(x) for x, _ in base)
    place = _placed(reach, 1.5 * height)
    strokes = [
        Stroke("base", _line([(-1.1 * reach, 0.0), (1.1 * reach, 0.0)], place)),
        *(Stroke("legs", _line([a, b], place)) for a, b in zip(base, joints, strict=True)),
        *(Stroke("joints", _dot(point, place)) for point in (*base, *joints)),
        Stroke("platform", _line([min(joints), max(joints)], place)),
        Stroke("cable", _line([(0.0, height), (0.0, 1.45 * height)], place)),
        Stroke("cable", _line([(-0.08 * reach, 1.45 * height), (0.08 * reach, 1.45 * height)], place)),
        *(Stroke("stops", _line([(s * 0.35 * reach, 1.2 * height), (s * 0.55 * reach, 1.2 * height)], place)) for s in (-1, 1)),
        *(Stroke("rails", _line([(s * 0.3 * reach, 0.5 * height), (s * 0.3 * reach, 1.3 * height)], place)) for s in (-1, 1)),
        Stroke("camera", _box((0.85 * reach, 1.2 * height), 0.14 * reach, 0.12 * height, place)),
        Stroke("cell", _box((-0.95 * reach, 0.22 * height), 0.1 * reach, 0.14 * height, place)),
    ]
    acting = frozenset(part_of(effect) for effect in effects)
    kept = [one for one in strokes if one.part in acting or one.part not in ("cable", "stops", "rails", "camera", "cell")]
    words = f"The rig {model.name} from the front, half deployed; marked: {', '.join(sorted(acting)) or 'nothing'}."
    return RigDrawing(_WIDE, round(place.high, 1), tuple(kept), acting, words)


Point = tuple[float, float]


@dataclass(frozen=True)
class _Place:
    """Where a point of the rig stands in the drawing."""

    scale: float
    high: float

    def __call__(self, point: Point) -> Point:
        return _WIDE / 2 + self.scale * point[0], self.high - _MARGIN - self.scale * point[1]


def _placed(reach: float, height: float) -> _Place:
    scale = (_WIDE / 2 - _MARGIN) / (1.1 * reach or 1.0)
    return _Place(scale, scale * height + 2 * _MARGIN)


def _line(points: Sequence[Point], place: _Place) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in map(place, points))


def _dot(point: Point, place: _Place) -> str:
    x, y = place(point)
    return f"M{x - 3:.1f} {y:.1f}a3 3 0 1 0 6 0a3 3 0 1 0 -6 0"


def _box(corner: Point, width: float, height: float, place: _Place) -> str:
    x, y = corner
    return _line([(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)], place)
