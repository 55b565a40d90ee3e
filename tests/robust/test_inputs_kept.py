"""Whatever a command reads, in its own words or by a file that it reads, is refused as its output before any work."""

from __future__ import annotations

import shutil
from importlib import import_module

import pytest
from command_server import MAINS
from judging import tree
from odd_inputs import DESIGN, TRACK

OWN = """
from dataclasses import dataclass
from simulate.model.effect import LegEffect, parameter

@dataclass(frozen=True)
class Spring(LegEffect):
    name = "own-spring"
    stiffness_N_per_m: float = parameter(0.0, low=0.0, high=100.0, typical=1.0, doc="pulls the strip back")

    @staticmethod
    def leg_force(u, v, t, R, travel, p):
        return -p[0] * u
"""
MODEL = ("model.toml", "own.py")
RUNS = (*MODEL, "named.toml", "test.csv", "loop.csv", "map.toml", "list-model.toml")
LINES = (  # with OUT for the file that is tried as an output, and what is read
    ("fit-actuator loop.csv --model model.toml --mapping map.toml --effects own.py -o OUT", (*MODEL, "loop.csv", "map.toml")),
    ("fit-actuator loop.csv --model model.toml --mapping map.toml --effects own.py -o x.toml --json OUT", (*MODEL, "loop.csv", "map.toml")),
    ("fit-actuator loop.csv -o x.toml --save-mapping OUT", ("loop.csv",)),
    ("simulate-deployment model.toml --effects own.py --page x.html --measured test.csv -o OUT", (*MODEL, "test.csv")),
    ("simulate-deployment model.toml --effects own.py --page x.html --measured test.csv -o x.csv --json OUT", (*MODEL, "test.csv")),
    ("sweep-deployments model.toml --effects own.py -o sw --json OUT", MODEL),
    ("compare-model model.toml named.toml --effects own.py -o x.png --json OUT", RUNS),
    ("compare-model model.toml loop.csv --mapping map.toml -o x.png --json OUT", ("model.toml", "loop.csv", "map.toml")),
    ("explain-gap model.toml named.toml --effects own.py -o out --json OUT", RUNS),
    ("design-control rig.toml --effects own.py -o OUT", ("rig.toml", "own.py")),
    ("design-control rig.toml --effects own.py -o x.toml --json OUT", ("rig.toml", "own.py")),
    (f"design-deployment rig.toml --effects own.py {' '.join(DESIGN)} -o OUT", ("rig.toml", "own.py")),
    (f"{' '.join(TRACK)} --project film.toml --mask mask.png --model rig.toml -o OUT", ("film.avi", "film.toml", "rig.toml")),
    (f"{' '.join(TRACK)} --project film.toml --mask mask.png -o x.csv --json OUT", ("film.avi", "film.toml", "mask.png")),
    (f"{' '.join(TRACK)} --compare test.csv -o x.csv --json OUT", ("film.avi", "test.csv")),
    ("track-video notes.cih --mm-per-px 1 -o x.csv --json OUT", ("notes.cih", "notes.mraw")),
    ("unspool check named.toml model.toml --effects own.py --mapping map.toml --json OUT", RUNS),
    ("unspool effects --effects own.py -o OUT", ("own.py",)),
    ("unspool run named.toml --model model.toml --effects own.py -o out --json OUT", RUNS),
    ("unspool run named.toml --effects own.py -o out --json OUT", ("named.toml", "list-model.toml", "own.py")),
)
WRITERS = (  # lines with OUT for an output that is named as a file of the user that the command does not read
    "fit-actuator loop.csv -o OUT",
    *(f"fit-actuator loop.csv -o x.toml --{option} OUT" for option in ("json", "figure", "curve", "page", "save-mapping")),
    "simulate-deployment model.toml -o OUT",
    *(f"simulate-deployment model.toml -o x.csv --{option} OUT" for option in ("json", "legs", "energy", "mjcf", "page")),
    *(f"sweep-deployments model.toml -o sw --{option} OUT" for option in ("json", "page")),
    *(f"compare-model model.toml test.csv -o x.png --{option} OUT" for option in ("json", "page")),
    "explain-gap model.toml test.csv -o out --json OUT",
    "design-control rig.toml -o OUT",
    *(f"design-control rig.toml -o x.toml --{option} OUT" for option in ("json", "page")),
    f"design-deployment rig.toml {' '.join(DESIGN)} -o OUT",
    f"{' '.join(TRACK)} -o OUT",
    *(f"{' '.join(TRACK)} -o x.csv --{option} OUT" for option in ("marks", "json")),
    *(f"unspool {task} -o OUT" for task in ("check model.toml", "effects", "fmu model.toml", "completion")),
    *(f"unspool {task} --json OUT" for task in ("check model.toml", "effects", "fmu model.toml -o x.fmu")),
    "unspool run named.toml --model model.toml -o out --json OUT",
)
INTO_THE_FOLDER = (  # lines that would write a result into the folder of their inputs, under the name of one
    "explain-gap extended.toml test.csv -o .",
    "unspool run named.toml --model model.toml -o .",
)


@pytest.fixture
def named(bench, monkeypatch):
    """The bench, with a list that names a mapping and a model, effects, a mask, and a film in two files."""
    files = '[[run]]\nfile = "test.csv"\n[[run]]\nfile = "loop.csv"\nmapping = "map.toml"\nhold_out = true\n'
    (bench / "named.toml").write_text(f'model = "list-model.toml"\n{files}')
    (bench / "map.toml").write_text('[columns]\ntime = "time_s"\nelongation = "elongation_m"\nforce = "force_N"\n')
    (bench / "own.py").write_text(OWN)
    (bench / "mask.png").write_bytes(b"")
    size = "Total Frame : 6\nImage Width : 64\nImage Height : 64\nColor Bit : 8\nFile Format : MRaw\n"
    (bench / "notes.cih").write_text(f"#Camera Information Header\nRecord Rate(fps) : 1000\n{size}")
    (bench / "notes.mraw").write_bytes(bytes(6 * 64 * 64))
    for copy in ("list-model.toml", "extended.toml"):
        shutil.copy(bench / "model.toml", bench / copy)
    monkeypatch.chdir(bench)
    return bench


def refused(line, capsys):
    """What a command says when it ends with status 2."""
    name, *words = line.split()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", [name, *words])
        status = import_module(MAINS[name]).main(words)
    said = capsys.readouterr().err
    assert status == 2, said
    return said


@pytest.mark.parametrize(("line", "inputs"), LINES)
def test_what_a_command_reads_is_no_output(named, capsys, line, inputs):
    before = tree(named)
    for name in inputs:
        assert f"{name}: is an input" in refused(line.replace("OUT", name), capsys)
    assert tree(named) == before


@pytest.mark.parametrize("line", WRITERS)
def test_what_a_laboratory_keeps_is_no_output_either(named, capsys, line):
    """A model that no command has written, a list of runs, a loop, a film: `unspool run ... --json rig.toml` once took one away."""
    shutil.copy(named / "model.toml", named / "kept.toml")
    shutil.copy(named / "loop.csv", named / "kept.csv")
    shutil.copy(named / "film.avi", named / "kept.avi")
    before = tree(named)
    for name in ("kept.toml", "campaign.toml", "kept.csv", "kept.avi"):
        said = refused(line.replace("OUT", name), capsys)
        assert f"{name}: holds" in said or ".html" in said or ".png" in said, said  # an ending that such a result never has
    assert tree(named) == before


@pytest.mark.parametrize("line", INTO_THE_FOLDER)
def test_no_result_takes_the_name_of_an_input_in_its_folder(named, capsys, line):
    before = tree(named)
    assert "is an input" in refused(line, capsys)
    assert tree(named) == before
