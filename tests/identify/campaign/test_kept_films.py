"""A film of a list is measured once, and again only when it or its project has changed."""

from __future__ import annotations

import json

import pytest

from identify.campaign.campaign_file import ListedRun
from identify.campaign.kept_films import is_current, kept, sources_of, table_of
from measure.common.errors import InputError
from measure.common.output import sha256


@pytest.fixture
def row(tmp_path):
    """A listed film with its project, both there, and a trajectory that was made from them."""
    made = ListedRun(file="films/test1.avi", project="film.toml")
    (tmp_path / "films").mkdir()
    (tmp_path / "films" / "test1.avi").write_bytes(b"RIFF")
    (tmp_path / "film.toml").write_text("schema = 1\n")
    table = table_of(made, tmp_path)
    table.parent.mkdir()
    table.write_text("time_s,z_m\n")
    inputs = [{"file": str(path), "sha256": sha256(path)} for path in sources_of(made, tmp_path)]
    table.with_name(f"{table.name}.provenance.json").write_text(json.dumps({"inputs": inputs}))
    return made


def test_what_was_measured_is_kept_beside_the_list_under_a_name_of_its_own(row, tmp_path):
    assert kept(row, tmp_path) == tmp_path / "measured" / "films-test1.csv"


@pytest.mark.parametrize("changed", ["films/test1.avi", "film.toml"])
def test_a_film_or_project_that_changed_must_be_measured_again(row, tmp_path, changed):
    (tmp_path / changed).write_text("other")
    assert not is_current(table_of(row, tmp_path), sources_of(row, tmp_path))
    with pytest.raises(InputError, match=r"test1\.avi: is a film, and must be measured first.*unspool run"):
        kept(row, tmp_path)


def test_a_table_without_its_note_counts_for_nothing(row, tmp_path):
    table_of(row, tmp_path).with_name("films-test1.csv.provenance.json").unlink()
    with pytest.raises(InputError, match="must be measured first"):
        kept(row, tmp_path)
