"""The examples of docs/film.md run."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from measure.project import make_project

DOCS = (Path(__file__).resolve().parents[2] / "docs" / "film.md").read_text(encoding="utf-8")


def _blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", DOCS, re.S)


def test_the_project_file_shown_is_one():
    import tomllib

    assert make_project(tomllib.loads(_blocks("toml")[0])).platform.radius_m == 0.07


def test_the_example_shows_the_rotation_it_was_given():
    namespace: dict = {}
    exec(_blocks("python")[0], namespace)
    assert np.abs(namespace["tracked"].trajectory.channels["theta_z_rad"] - 5.0 * np.arange(6) / 250).max() < 1e-3


def test_every_option_named_in_the_docs_exists():
    from measure.commands.track_video import options

    known = {name for action in options()._actions for name in action.option_strings}
    assert set(re.findall(r"(--[a-z][a-z-]+)", DOCS)) <= known
