"""A commented TOML file holds what it was given, and all else as comments."""

from __future__ import annotations

import tomllib
from typing import Any, Literal

import pytest
from pydantic import BaseModel, Field

from measure.tables.toml_template import commented


class Run(BaseModel):
    file: str = Field(description="table of the run")
    hold_out: bool = Field(False, description="whether it takes no part")
    model: dict[str, Any] = Field({}, description="what was different")


class Campaign(BaseModel):
    name: str = Field(description="what it is called")
    fps: float = Field(250.0, gt=0, description="pictures a second")
    run: list[Run] = Field([], description="all runs")


ROWS = [{"file": "a.csv", "hold_out": True, "model": {"platform.mass_kg": 1.0}}, {"file": "b.csv", "model": {}}]


@pytest.mark.parametrize("document", [{"name": "bench"}, {"name": "bench", "fps": 500.0, "run": ROWS}])
def test_what_is_given_is_read_back(document):
    read = tomllib.loads(commented(Campaign.model_json_schema(), document))
    assert read.pop("name") == "bench"
    assert read.pop("fps", None) == document.get("fps")
    runs = read.pop("run", [])
    assert read == {}
    assert [(run["file"], run.get("hold_out")) for run in runs] == [(row["file"], row.get("hold_out")) for row in document.get("run", [])]
    if runs:
        assert runs[0]["model"] == {"platform": {"mass_kg": 1.0}}


def test_what_is_not_given_stands_there_as_a_comment_with_its_default():
    text = commented(Campaign.model_json_schema(), {"name": "bench"}, head="A bench.", schema_file="campaign.json")
    assert text.startswith("#:schema campaign.json\n# A bench.\n")
    assert "#fps = 250.0" in text
    assert "#[[run]]" in text
    assert "#file = " in text


class Bench(BaseModel):
    kind: Literal["loop", "film"] = Field("loop", description="what it is")
    line_px: tuple[float, float, float, float] = Field((0.0, 0.0, 1.0, 1.0), description="a line")
    places_px: tuple[tuple[float, float], ...] = Field((), description="places")
    schema_of: Literal[1] = Field(1, description="the form")
    share: float = Field(0.5, ge=0, le=1, description="a share")
    mass_kg: float = Field(1.0, gt=0, description="mass")
    angle_deg: float = Field(0.0, ge=-90, lt=90, description="an angle")
    depth_m: float = Field(1.0, lt=5, description="how deep, m")
    runs: int = Field(3, ge=1, description="how many")


def test_limits_units_and_defaults_are_said_in_words():
    assert [line for line in commented(Bench.model_json_schema(), {}).splitlines() if line.startswith("# ")] == [
        '# what it is; "loop" or "film"; default "loop"',
        "# a line; px; 4 values; default [0.0, 0.0, 1.0, 1.0]",
        "# places; px; absent unless given",
        "# the form; default 1",
        "# a share; 0 to 1; default 0.5",
        "# mass; kg; above 0; default 1.0",
        "# an angle; deg; -90 to 90; default 0.0",
        "# how deep, m; below 5; default 1.0",
        "# how many; at least 1; default 3",
    ]
