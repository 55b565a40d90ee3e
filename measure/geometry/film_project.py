"""The project file of a film: everything that turns its pictures into metres, in TOML, enough to repeat a run."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from measure.common.errors import InputError, nearest
from measure.common.output import write_text

Positive = Field(default=None, gt=0, allow_inf_nan=False)
Point = tuple[float, float]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Film(_Section):
    """The film and its clock. file : relative to the project file. fps : capture rate, frames per second."""

    file: str | None = None
    fps: float | None = Positive
    exposure_s: float | None = Positive


class MarkList(_Section):
    """The marks in the first frame. place_px : reference points; none means that they are found. subset_px : odd.
    mask : a picture as large as the film's, relative to the project file, white where marks are in the first frame.
    """

    place_px: tuple[Point, ...] = ()
    subset_px: int = 31
    mask: str | None = None
    warp: str = Field(default="affine", pattern="^(translation|euclidean|affine)$")


class Scale(_Section):
    """Picture to metres. mm_per_px : at the depth of the platform's origin. relative_sigma : its uncertainty, one
    standard deviation; it is common to all lengths of the film and is no part of the sigmas of the single frames.
    up_deg : direction of up in the picture, clockwise from the picture's own.

    Or measured in the first frame: from_px_mm : two points and their distance, length_sigma_mm of it, point_sigma_px of each
    coordinate. rule_px_mm : a line across the graduation of a rule, and its pitch. depth_mm : how much farther from the camera than
    the platform's origin that length or rule is, and its sigma. plumb_px : two points near a plumb line, which then says where up is.
    """

    mm_per_px: float | None = Positive
    from_px_mm: tuple[float, float, float, float, float] | None = None
    rule_px_mm: tuple[float, float, float, float, float] | None = None
    relative_sigma: float = Field(default=0.0, ge=0, lt=1)
    point_sigma_px: float = Field(default=0.5, ge=0)
    length_sigma_mm: float = Field(default=0.0, ge=0)
    depth_mm: float = 0.0
    depth_sigma_mm: float = Field(default=0.0, ge=0)
    up_deg: float = 0.0
    plumb_px: tuple[float, float, float, float] | None = None


class PlatformSection(_Section):
    """The platform. origin_px : its origin in the first frame, by default the mean of the marks. start_height_m : the
    origin's height then. radius_m : of the cylinder that carries the marks; absent means that they lie in one plane.
    """

    origin_px: Point | None = None
    start_height_m: float = 0.0
    radius_m: float | None = Positive


class CameraSection(_Section):
    """The camera. distance_m : to the platform's origin; absent means no perspective, unless scale and focal length give it.
    principal_px : where the optical axis meets the picture. focal_px, distortion (k1, k2, p1, p2, k3) : of a calibration.
    """

    distance_m: float | None = Positive
    distance_sigma_m: float = Field(default=0.0, ge=0)
    principal_px: Point | None = None
    focal_px: float | None = Positive
    focal_sigma_px: float = Field(default=0.0, ge=0)
    distortion: tuple[float, ...] = Field(default=(), max_length=5)


class Project(_Section):
    """Everything about one film."""

    schema_: int = Field(default=1, alias="schema", ge=1, le=1)
    film: Film = Film()
    marks: MarkList = MarkList()
    scale: Scale = Scale()
    platform: PlatformSection = PlatformSection()
    camera: CameraSection = CameraSection()

    def has_scale(self) -> bool:
        """Whether anything says how large a pixel is."""
        measured = self.scale.mm_per_px or self.scale.from_px_mm or self.scale.rule_px_mm
        return bool(measured or (self.camera.focal_px and self.camera.distance_m))


def read_project(path: Path) -> Project:
    """Read a project file.

    Raises
    ------
    InputError
        Not TOML, an unknown key, a value of the wrong kind.
    """
    from measure.common.command_line import existing_file

    existing_file(path, what="a project file (TOML)")
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is not TOML ({error}). Mend the line, or remove the file and give the options again.") from error
    return make_project(table, str(path))


def make_project(table: dict[str, Any], name: str = "project") -> Project:
    """A project from its tables, refused in one sentence where a key or value is wrong."""
    try:
        return Project.model_validate(table)
    except ValidationError as error:
        raise InputError(f"{name}: {_sentence(error)}") from None


def _sentence(error: ValidationError) -> str:
    first = error.errors()[0]
    place = ".".join(str(part) for part in first["loc"])
    if first["type"] != "extra_forbidden":
        return f"{place}: {first['msg'][0].lower()}{first['msg'][1:]}, found {first['input']!r}. Mend the value."
    section: Any = Project
    for part in first["loc"][:-1]:
        section = section.model_fields[str(part)].annotation
    return f'unknown key "{place}"; {nearest(str(first["loc"][-1]), [f.alias or n for n, f in section.model_fields.items()])}'


def project_text(project: Project) -> str:
    """The TOML of a project, without what was left open."""
    import tomli_w

    return tomli_w.dumps(project.model_dump(by_alias=True, exclude_none=True, mode="json"))


def write_project(project: Project, path: Path) -> None:
    """Write a project file, whole or not at all."""
    write_text(path, project_text(project))
