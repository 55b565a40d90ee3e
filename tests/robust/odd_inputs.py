"""Good inputs of every kind, and what nobody means well: hostile files, odd values, tables and names of outputs."""

from __future__ import annotations

import contextlib
import copy
import datetime
import math
import os
import socket
import tomllib
from pathlib import Path

import numpy as np
import tomli_w

from measure.footage.writers import write_film
from simulate.loop import loop_force

ROOT = Path(__file__).resolve().parents[2]
DEMO = ROOT / "datasets" / "demo"
INPUTS = ("model.toml", "rig.toml", "loop.csv", "test.csv", "campaign.toml", "film.avi", "film.toml")


KEPT = ("model.toml", "rig.toml", "loop.csv", "campaign.toml", "film.toml")  # no result has their kinds: never written, read or not


def lay_out(folder):
    """A folder with one good input of each kind, small ones."""
    model = tomllib.loads((ROOT / "datasets" / "prototype.toml").read_text(encoding="utf-8"))
    model["simulation"] = {"duration_s": 0.7, "sample_rate_Hz": 200.0}
    (folder / "rig.toml").write_text(tomli_w.dumps(model))
    model["simulation"] = {"duration_s": 0.05, "sample_rate_Hz": 200.0}
    (folder / "model.toml").write_text(tomli_w.dumps(model))
    chance = np.random.default_rng(4)
    t = np.arange(400) / 200.0
    u = 0.25 + 0.04 * np.sin(2 * np.pi * t)
    f = loop_force(np.array([-0.25, 2.79, -0.3, 2.89, 400.0]), t, u, 0 * t, 0 * t, 2.8) + 2e-3 * chance.standard_normal(400)
    write_table(folder / "loop.csv", {"time_s": t, "elongation_m": u, "force_N": f})
    time = np.arange(40) * 0.004
    z = 0.252 + 2.0 * time**2 + 1e-4 * chance.standard_normal(40)
    write_table(folder / "test.csv", {"time_s": time, "z_m": z, "x_m": 1e-4 * chance.standard_normal(40)})
    (folder / "campaign.toml").write_text('[[run]]\nfile = "test.csv"\n[[run]]\nfile = "loop.csv"\nhold_out = true\n')
    write_film(folder / "film.avi", moving_pictures(chance))
    (folder / "film.toml").write_text("schema = 1\n[film]\nfps = 250.0\n")
    measured = "[marks]\nplace_px = [[31.0, 40.0]]\nsubset_px = 15\n[scale]\nmm_per_px = 0.5\n"
    (folder / "measured.toml").write_text((folder / "film.toml").read_text() + measured)
    film = '[[run]]\nfile = "film.avi"\nproject = "measured.toml"\nhold_out = true\n'
    (folder / "films.toml").write_text(f'{film}[[run]]\nfile = "test.csv"\n[[run]]\nfile = "loop.csv"\n')


def moving_pictures(chance):
    """Six pictures of one thing that rises before a still background."""
    still, thing = chance.integers(0, 255, (64, 64), dtype=np.uint8), chance.integers(0, 255, (31, 31), dtype=np.uint8)
    for k in range(6):
        picture = still.copy()
        picture[25 - 2 * k : 56 - 2 * k, 16:47] = thing
        yield picture


def write_table(path, columns):
    rows = zip(*columns.values(), strict=True)
    path.write_text(",".join(columns) + "\n" + "".join(",".join(map(repr, map(float, row))) + "\n" for row in rows))


TRACK = ["track-video", "film.avi", "--fps", "250", "--mm-per-px", "0.5", "--subset", "15", "--mark", "30,24"]
DESIGN = ["--free", "end_stop.damping_N_s_per_m=5..80", "--minimise", "worst:theta_z_deg", "--evaluations", "16", "--draws", "2"]
ENTRIES = {  # the words of a command, with HERE for the file that is tried
    "model of a deployment": ["simulate-deployment", "HERE", "-o", "out.csv"],
    "measured on a page": ["simulate-deployment", "model.toml", "-o", "out.csv", "--page", "p.html", "--measured", "HERE"],
    "effects": ["simulate-deployment", "model.toml", "-o", "out.csv", "--effects", "HERE"],
    "model of a sweep": ["sweep-deployments", "HERE", "-o", "out"],
    "loop": ["fit-actuator", "HERE", "-o", "out.toml"],
    "mapping": ["fit-actuator", "loop.csv", "-o", "out.toml", "--mapping", "HERE"],
    "model of a fit": ["fit-actuator", "loop.csv", "-o", "out.toml", "--model", "HERE"],
    "compared model": ["compare-model", "HERE", "test.csv", "--json", "out.json"],
    "compared": ["compare-model", "model.toml", "HERE", "--json", "out.json"],
    "explained model": ["explain-gap", "HERE", "test.csv", "-o", "out"],
    "explained": ["explain-gap", "model.toml", "HERE", "-o", "out"],
    "film": ["track-video", "HERE", "--fps", "250", "--mm-per-px", "1", "-o", "out.csv"],
    "project": [*TRACK, "--project", "HERE", "-o", "out.csv"],
    "mask": [*TRACK, "--mask", "HERE", "-o", "out.csv"],
    "controlled model": ["design-control", "HERE", "-o", "out.toml", "--draws", "16"],
    "controlled effects": ["design-control", "rig.toml", "-o", "out.toml", "--draws", "16", "--effects", "HERE"],
    "designed model": ["design-deployment", "HERE", *DESIGN, "-o", "out.toml"],
    "checked": ["unspool", "check", "HERE"],
    "catalogue of effects": ["unspool", "effects", "--effects", "HERE", "-o", "out.txt"],
    "campaign from raw files": ["unspool", "run", "HERE", "--model", "model.toml", "-o", "out"],
}
ENDINGS = ("", ".csv", ".toml", ".avi", ".txt", ".mraw", ".mat", ".png", ".h5", ".lvm", ".tdms", ".cih", ".py")


def hostile(chance, folder):
    """A file that is none of those that are expected."""
    kind = chance.choice(sorted(HOSTILE))
    path = folder / f"hostile{chance.choice(ENDINGS)}"
    HOSTILE[kind](path, chance)
    return path


def sparse(path, chance):
    with open(path, "wb") as file:
        file.truncate(chance.choice([10**7, 10**10, 10**12]))


def bound(path, chance):
    here = Path.cwd()
    os.chdir(path.parent)  # the name of a socket is short
    with contextlib.closing(socket.socket(socket.AF_UNIX)) as made:
        made.bind(path.name)
    os.chdir(here)


def nest(opening, closing, times):
    return (opening * times + closing * times).encode()


HOSTILE = {
    "nothing": lambda path, chance: path.write_bytes(b""),
    "one byte": lambda path, chance: path.write_bytes(chance.randbytes(1)),
    "zeros": lambda path, chance: path.write_bytes(bytes(10**5)),
    "sparse": sparse,
    "noise": lambda path, chance: path.write_bytes(chance.randbytes(chance.choice([10, 1000, 10**5]))),
    "marked": lambda path, chance: path.write_bytes(chance.choice(MAGIC) + chance.randbytes(chance.choice([0, 10, 5000]))),
    "deep toml": lambda path, chance: path.write_bytes(b"schema = 1\nx = " + nest("[", "]", chance.choice([50, 900, 20000]))),
    "deep table": lambda path, chance: path.write_bytes(b"schema = 1\nx = " + nest("{a=", "}", chance.choice([50, 900]))),
    "dotted": lambda path, chance: path.write_bytes(".".join(["a"] * chance.choice([40, 5000, 200000])).encode() + b" = 1\n"),
    "long number": lambda path, chance: path.write_bytes(b"schema = " + b"9" * chance.choice([30, 4000, 10**6]) + b"\n"),
    "deep json": lambda path, chance: path.write_bytes(nest("[", "]", 10**5)),
    "deep xml": lambda path, chance: path.write_bytes(b"<cih>" + b"<a>" * 10**5),
    "entities": lambda path, chance: path.write_bytes(b'<!DOCTYPE a [<!ENTITY b "c">]><cih>&b;</cih>'),
    "long line": lambda path, chance: path.write_bytes(b"time_s,z_m\n0," + b"1" * 2 * 10**5 + b"\n1,2\n"),
    "many columns": lambda path, chance: path.write_bytes(b",".join([b"1"] * 50000) + b"\n" + b",".join([b"2"] * 50000)),
    "header only": lambda path, chance: path.write_bytes(chance.choice([b"time_s,z_m", b"time_s,elongation_m,force_N\n", b"[[run]]"])),
    "utf-16": lambda path, chance: path.write_bytes("time_s,z_m\n0,1\n1,2\n".encode("utf-16")),
    "latin": lambda path, chance: path.write_bytes('name = "é"\nschema = 1\n'.encode("latin-1")),
    "escapes": lambda path, chance: path.write_bytes(b'schema = 1\n"\\u001b[2J\\u202e" = "\\u0007"\n'),
    "bad names": lambda path, chance: path.write_bytes(b'[[run]]\nfile = "a\\u0000b"\n[[run]]\nfile = "\\u001b[2J"\n'),
    "secret": lambda path, chance: path.write_bytes(b"root:x:0:0:SECRETSECRETSECRETSECRETSECRET:/root:/bin/sh\n" * 40),
    "folder": lambda path, chance: path.mkdir(),
    "pipe": lambda path, chance: os.mkfifo(path),
    "socket": bound,
    "device": lambda path, chance: path.symlink_to(chance.choice(["/dev/zero", "/dev/null", "/dev/stdin"])),
    "links in a circle": lambda path, chance: path.symlink_to(path.name),
    "link to nothing": lambda path, chance: path.symlink_to("\x1b[2Jnowhere"),
}
MAGIC = (b"\x89PNG\r\n\x1a\n", b"RIFF\x10\0\0\0AVI ", b"\x89HDF\r\n\x1a\n", b"MATLAB 5.0 MAT-file", b"TDSm", b"LabVIEW Measurement\t\n",
         b"II*\0", b"CI\x2c\0", b"\x80\x04", b"PK\x03\x04", b"\x1f\x8b", b"GIF89a", b"\x00\x00\x00 ftypisom", b"YUV4MPEG2 W9999999 H9 \n",
         b"#Camera Information Header\nImage Width : 1e99\n")  # fmt: skip
ODD = (True, False, "1", "", "1_0", math.nan, math.inf, -math.inf, -1, 0, 1e300, -1e300, 1e-300, 5e-324, 2**62, [], {}, [1], [[1, 2], "a"],
       datetime.date(2009, 1, 1), "\x1b[2J", "$\\frac{a$", "é" * 500, "../x", 1e6, {"a": {"b": 1}}, [True] * 6, ["0"] * 3)  # fmt: skip


def places_in(value, path=()):
    """Every place of a document, from the root down."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in inside:
        yield (*path, key)
        yield from places_in(inner, (*path, key))


def mutated(chance, document):
    """The document with one or two values that are odd, gone, doubled or under another key."""
    for _ in range(chance.choice([1, 1, 2])):
        *way, last = chance.choice(list(places_in(document)) or [("x",)])
        holder = document
        for key in way:
            holder = holder[key]
        how = chance.choice(["odd", "odd", "odd", "gone", "renamed", "scaled"])
        if last not in holder and isinstance(holder, dict):
            holder[last] = copy.deepcopy(chance.choice(ODD))
        elif how == "gone":
            del holder[last]
        elif how == "renamed" and isinstance(holder, dict):
            holder[f"{last}x"] = holder.pop(last)
        elif how == "scaled" and isinstance(holder[last], float):
            holder[last] *= chance.choice([-1.0, 1e3, 1e-3, 1e6, 1e12])
        else:
            holder[last] = copy.deepcopy(chance.choice(ODD))
    return document


def mutated_table(chance, text):
    """A table with odd cells, rows or columns."""
    header, *rows = [line.split(",") for line in text.splitlines()]
    for _ in range(chance.choice([1, 1, 2, 3])):
        place, row = chance.randrange(len(header)), chance.randrange(len(rows))
        how = chance.choice(["cell", "cell", "column", "scale", "constant", "cut", "double", "swap", "gap", "shift", "short", "header"])
        if how == "cell":
            rows[row] = [*rows[row][:place], chance.choice(CELLS), *rows[row][place + 1 :]]
        elif how == "column":
            rows = [[*cells[:place], chance.choice(CELLS), *cells[place + 1 :]] for cells in rows]
        elif how in ("scale", "constant", "shift"):
            factor, added = {"scale": (chance.choice(FACTORS), 0), "constant": (0, 1), "shift": (1, chance.choice(FACTORS))}[how]
            rows = [[_moved(cell, factor, added) if k == place else cell for k, cell in enumerate(cells)] for cells in rows]
        elif how == "cut":
            rows = rows[: chance.choice([0, 1, 2, 3, 5, 20])] or rows[:1]
        elif how == "double":
            rows.insert(row, rows[row])
        elif how == "swap":
            rows[row], rows[0] = rows[0], rows[row]
        elif how == "gap":
            rows = [*rows[:row], *([_moved(cells[0], 1, chance.choice([1.0, 1e3, 1e9])), *cells[1:]] for cells in rows[row:])]
        elif how == "short":
            rows[row] = rows[row][:-1]
        else:
            header[place] = chance.choice(["", "time_s", "sigma_z_m", "\x1b[2J", "x" * 10**5, "theta_z_rad", '"', "force (kN)"])
    return "\n".join(",".join(cells) for cells in [header, *rows]) + "\n"


def _moved(cell, factor, added):
    try:
        return repr(float(cell) * factor + added)
    except ValueError:
        return cell


CELLS = ("", "nan", "inf", "-inf", "1e999", "1_0", "1,5", "0x10", "٣", '"', "'", "=1+1", "1" * 300, "9" * 10**5, "\x1b[2J", "1e308",
         "5e-324", "true", "None", "1e", "--1", "\x00", "1e-300", " 3 ")  # fmt: skip
FACTORS = (-1.0, 1e3, 1e-3, 1e6, 1e-9, 1e300, 1e-300, 1e150)


OUTPUTS = {
    "track-video": (TRACK, ("--marks", "--json", "--pictures", "--overlay")),
    "fit-actuator": (["fit-actuator", "loop.csv"], ("--json", "--figure", "--page", "--save-mapping")),
    "simulate-deployment": (
        ["simulate-deployment", "model.toml"],
        ("--json", "--legs", "--energy", "--mjcf", "--page", "--figure", "--gravity-study"),
    ),
    "sweep-deployments": (["sweep-deployments", "model.toml", "--factor", "platform.mass_kg=+-1%"], ("--json", "--page")),
    "compare-model": (["compare-model", "model.toml", "campaign.toml"], ("--json", "--page")),
    "explain-gap": (["explain-gap", "model.toml", "campaign.toml"], ("--json",)),
    "design-control": (["design-control", "rig.toml", "--draws", "16"], ("--json", "--page")),
    "design-deployment": (["design-deployment", "rig.toml", *DESIGN], ("--json",)),
    "unspool": (["unspool", "check", "model.toml", "campaign.toml"], ("--json",)),
}
NAMES = (
    *("model.toml", "loop.csv", "test.csv", "campaign.toml", "film.avi", "hard.csv", "soft.csv", "loop", "sub", "outs", "", ".", "pipe"),
    *("out.csv", "out.png", "out.toml", "out.avi", "out.csv.provenance.json", "out\x1b[2J.json", "x" * 260, "sw.part", "sw"),
    *("no/out.csv", "sub/out.json", "link/out.csv", "/dev/null", "/dev/full", "/proc/self/out"),
)


def read_by(bench, words):
    """What a command may not write: its inputs, those that its campaign names, and what is no result."""
    named = [*KEPT, *words, *(("test.csv", "loop.csv") if "campaign.toml" in words else ())]
    return [bench / word for word in named if (bench / word).is_file()]


def around(bench):
    """Other names of the inputs, and things of the user that are in the way."""
    for folder in ("sub", "sw.part"):
        (bench / folder).mkdir()
    (bench / "sw.part" / "mine.txt").write_text("the user's")
    os.link(bench / "loop.csv", bench / "hard.csv")
    (bench / "soft.csv").symlink_to("test.csv")
    (bench / "loop").symlink_to("loop")
    (bench / "link").symlink_to("sub")
    os.mkfifo(bench / "pipe")
