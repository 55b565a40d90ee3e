"""The project file of a film (TOML): all that turns its pictures into metres, enough to repeat a run.

The classes below are the schema of the file: sections, keys, units and ranges. `json_schema` gives it to editors.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from measure.common.errors import InputError, clipped, nearest
from measure.common.inputs import read_toml
from measure.common.output import write_text

# Numbers are written as numbers: no true, no "1.0".
Number = Annotated[float, Field(strict=True)]
Whole = Annotated[int, Field(strict=True)]
Positive = Annotated[Number, Field(gt=0, allow_inf_nan=False)]
NotNegative = Annotated[Number, Field(ge=0, allow_inf_nan=False)]
Sigma = NotNegative
Pixels = Annotated[Number, Field(gt=-1e9, lt=1e9)]
Point = tuple[Pixels, Pixels]
Line = tuple[Pixels, Pixels, Pixels, Pixels]
KnownLength = tuple[Pixels, Pixels, Pixels, Pixels, Positive]


def _key(default: Any, description: str, **limits: Any) -> Any:
    return Field(default=default, description=description, **limits)


class Section(BaseModel):
    """A section of the file; it cannot be changed, and knows no other keys than its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Film(Section):
    """The film and its clock."""

    file: str | None = _key(None, "film file, or folder of numbered pictures; relative to the project file")
    fps: Positive | None = _key(None, "capture rate that the camera was set to, frames per second")
    exposure_s: Positive | None = _key(None, "exposure time, s; fast marks are blurred by it")
    from_s: NotNegative | None = _key(None, "film time from which on the film is used, s; it is zero at the first frame of the film")
    to_s: NotNegative | None = _key(None, "film time up to which the film is used, s")
    fields: bool = _key(False, "whether an interlaced film is split into its fields, each a picture of its own", strict=True)


class MarkList(Section):
    """The marks in the first frame."""

    place_px: tuple[Point, ...] = _key((), "reference points [x, y], px; without them marks are found")
    subset_px: Whole = _key(31, "side of the subset that is compared, odd, px", ge=9, le=301)
    mask: str | None = _key(None, "picture as large as the film's, white where marks are in the first frame; relative to the project file")
    warp: Literal["translation", "euclidean", "affine"] = _key("affine", "richest warp of a subset")


class Scale(Section):
    """Pictures to metres: the scale, given or measured in the first frame, and where up is."""

    mm_per_px: Positive | None = _key(None, "size of a pixel at the depth of the platform's origin, mm")
    from_px_mm: KnownLength | None = _key(None, "two points and the length between them: x1, y1, x2, y2 in px, length in mm")
    rule_px_mm: KnownLength | None = _key(None, "a line across the graduation of a rule: x1, y1, x2, y2 in px, pitch in mm")
    relative_sigma: Number = _key(0.0, "uncertainty of the scale, one standard deviation; common to all lengths of the film", ge=0, lt=1)
    point_sigma_px: Sigma = _key(0.5, "uncertainty of each coordinate of the two points, px")
    length_sigma_mm: Sigma = _key(0.0, "uncertainty of the length, mm")
    depth_mm: Number = _key(0.0, "how much farther from the camera than the platform's origin the length or rule is, mm")
    depth_sigma_mm: Sigma = _key(0.0, "uncertainty of depth_mm, mm")
    up_deg: Number = _key(0.0, "direction of up in the picture, clockwise from the picture's own, deg", ge=-360, le=360)
    plumb_px: Line | None = _key(None, "two points near a plumb line, x1, y1, x2, y2 in px; it shows where up is")


class PlatformSection(Section):
    """The platform in the first frame."""

    origin_px: Point | None = _key(None, "its origin, px; by default the mean of the marks")
    start_height_m: Number = _key(0.0, "height of its origin, m")
    radius_m: Positive | None = _key(None, "radius of the upright cylinder that carries the marks, m; absent: they lie in one plane")


class CameraSection(Section):
    """The camera in front of the rig."""

    distance_m: Positive | None = _key(
        None, "from the camera to the platform's origin, m; absent: no perspective, unless scale and focal length give it"
    )
    distance_sigma_m: Sigma = _key(0.0, "uncertainty of distance_m, m")
    principal_px: Point | None = _key(None, "where the optical axis meets the picture, px; by default its middle")
    focal_px: Positive | None = _key(None, "focal length of a calibration, px")
    focal_sigma_px: Sigma = _key(0.0, "uncertainty of focal_px, px")
    readout_s: NotNegative = _key(0.0, "time from reading the first row of the picture to reading the last one, s; 0: all rows at once")
    distortion: tuple[Number, ...] = _key((), "distortion k1, k2, p1, p2, k3 of a calibration", max_length=5)


class Project(Section):
    """Everything about one film: its clock, marks, scale, platform and camera.

    Examples
    --------
    >>> Project(film=Film(fps=250.0), scale=Scale(mm_per_px=0.5)).has_scale()
    True
    """

    schema_: Whole = _key(1, "version of this file format", alias="schema", ge=1, le=1)
    film: Film = Film()
    marks: MarkList = MarkList()
    scale: Scale = Scale()
    platform: PlatformSection = PlatformSection()
    camera: CameraSection = CameraSection()

    def has_scale(self) -> bool:
        """Whether the size of a pixel is given or can be measured."""
        measured = self.scale.mm_per_px or self.scale.from_px_mm or self.scale.rule_px_mm
        return bool(measured or (self.camera.focal_px and self.camera.distance_m))

    def __repr__(self) -> str:
        given = self.model_dump(by_alias=True, exclude_defaults=True)
        count = len(given.get("marks", {}).pop("place_px", ()))
        rest = ", ".join(
            f"{section}.{key}={value!r}" for section, keys in given.items() if isinstance(keys, dict) for key, value in keys.items()
        )
        text = f"Project({count} marks, {rest}" if rest else f"Project({count} marks"
        return (text if len(text) < 280 else text[:280] + " ...") + ")"

    __str__ = __repr__


def read_project(path: Path | str) -> Project:
    """Read a project file.

    Parameters
    ----------
    path : Path or str

    Returns
    -------
    Project

    Raises
    ------
    InputError
        No such file, not TOML; unknown keys and unusable values, all of them at once.
    """
    advice = "Mend the line, or remove the file and give the options again."
    return make_project(read_toml(Path(path), what="a project file (TOML)", advice=advice), str(path))


def make_project(table: dict[str, Any], name: str = "project") -> Project:
    """Make a project of the tables of a project file.

    Parameters
    ----------
    table : dict
        Sections by name.
    name : str
        Where they are from, for the message.

    Returns
    -------
    Project

    Raises
    ------
    InputError
        Unknown keys (with the nearest known one) and unusable values, all of them at once.
    """
    try:
        return Project.model_validate(table)
    except ValidationError as error:
        wrong = list(dict.fromkeys(_sentence(dict(one)) for one in error.errors()))
        raise InputError(f"{name}: " + "\n".join(wrong)) from None


def _sentence(error: dict[str, Any]) -> str:
    """What is wrong at one place of the file, what was found there, and what to do."""
    path = [str(part) for part in error["loc"]]
    if error["type"] == "extra_forbidden":
        known = [field.alias or name for name, field in _section(path[:-1]).model_fields.items()]
        return f'unknown key "{".".join(path)}"; {nearest(path[-1], known)}'
    found = error["input"]
    shown = "a section" if isinstance(found, dict) else clipped(repr(list(found) if isinstance(found, tuple) else found))
    return f"{_place(path)} {_requirement(error)}, found {shown}. Mend the value."


def _requirement(error: dict[str, Any]) -> str:
    """What the value should be."""
    if error["type"] == "missing":
        return "is missing"
    if error["type"] == "too_long":
        return f"should have at most {error['ctx']['max_length']} numbers"
    message = error["msg"].removeprefix("Input ").removesuffix(", unable to parse string as a number")
    return message[0].lower() + message[1:]


def _place(path: list[str]) -> str:
    """A key with the numbers of the entries in it, counted from one: `marks.place_px, entry 2, entry 1`."""
    keys = [part for part in path if not part.isdigit()]
    return ", entry ".join([".".join(keys), *(str(int(part) + 1) for part in path if part.isdigit())])


def _section(path: list[str]) -> type[BaseModel]:
    section: Any = Project
    for part in path:
        section = section.model_fields[part].annotation
    return section


def json_schema() -> dict[str, Any]:
    """The JSON Schema of the project file, for editors and for the reference."""
    return Project.model_json_schema(by_alias=True)


def project_text(project: Project) -> str:
    """The TOML of a project, without what was left open."""
    import tomli_w

    return tomli_w.dumps(project.model_dump(by_alias=True, exclude_none=True, mode="json"))


def write_project(project: Project, path: Path | str) -> None:
    """Write a project file, whole or not at all.

    Parameters
    ----------
    project : Project
    path : Path or str
    """
    write_text(Path(path), project_text(project))
