"""A commented TOML file holds what it was given, and all else as comments."""

from __future__ import annotations

import tomllib
from typing import Any

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
