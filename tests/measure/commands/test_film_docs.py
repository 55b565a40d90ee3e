"""What docs/how-to/track-video.md says of files and options is so; that its examples run is tested with those of all documents."""

from __future__ import annotations

import re
from pathlib import Path

from measure.geometry.film_project import make_project

DOCS = (Path(__file__).resolve().parents[3] / "docs" / "how-to" / "track-video.md").read_text(encoding="utf-8")


def _blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", DOCS, re.S)


def test_the_project_file_shown_is_one():
    import tomllib

    assert make_project(tomllib.loads(_blocks("toml")[0])).platform.radius_m == 0.07


def test_every_option_named_in_the_docs_exists():
    from measure.commands.track_video import options

    known = {name for action in options()._actions for name in action.option_strings}
    assert set(re.findall(r"(--[a-z][a-z-]+)", DOCS)) <= known
