"""The film behind a trajectory is found by the note beside the table, and only while it is there."""

import shutil
from pathlib import Path

import pytest

from identify.campaign.run import Run
from identify.report.explained.films_seen import frame_of
from measure import read_trajectory
from measure.common.output import provenance, write_provenance

DEMO = Path(__file__).resolve().parents[4] / "datasets" / "demo"


@pytest.fixture
def run(tmp_path: Path) -> Run:
    for name in ("film.avi", "film.toml"):
        shutil.copy(DEMO / name, tmp_path / name)
    table = tmp_path / "film.csv"
    shutil.copy(DEMO / "deployment-2.csv", table)
    return Run(read_trajectory(table), name="film.csv", path=table)


def test_a_table_with_its_note_leads_to_the_film(run):
    assert run.path is not None
    assert frame_of([run]) is None, "no note yet"
    folder = run.path.parent
    write_provenance(run.path, provenance([folder / "film.avi", folder / "film.toml"]))
    found = frame_of([run])
    assert found is not None
    assert found[0] == "film.csv"
    assert len(found[1].marks) == 6
    (folder / "film.avi").unlink()
    assert frame_of([run]) is None, "the film has gone"
