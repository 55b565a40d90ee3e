"""Follow docs/tutorial to the letter: the wheel in an empty folder with an environment of its own, then every line that is typed there.

    python tests/follow_tutorial.py --python newest              the newest Python that is found here, and the newest versions
    python tests/follow_tutorial.py --python oldest --lowest     the oldest one, and the lowest versions that pyproject.toml declares

Ends with status 1 at the first line that does not end as it should, or if the effect that is named is not the hidden one. With
`--write FILE` what was typed and printed is put there.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TUTORIAL = ROOT / "docs" / "tutorial" / "from-an-empty-folder.md"
HIDDEN, LOW, HIGH = "hub-inertia", 0.0098, 0.0102
SHOWN = 24  # lines of one command at most in the transcript


@dataclass(frozen=True)
class Typed:
    """A line of the tutorial, how it ended, what it printed, and how long it took."""

    line: str
    status: int
    wanted: int
    said: str
    seconds: float


def lines_of(tutorial: Path) -> Iterator[tuple[str, int]]:
    """Every line of the shell blocks with the exit status that it should end with."""
    for block in re.findall(r"^```sh\n(.*?)^```$", tutorial.read_text(encoding="utf-8"), re.M | re.S):
        for line in block.replace("\\\n", " ").splitlines():
            status = re.search(r"# exit status (\d+)$", line)
            yield line, int(status[1]) if status else 0


def found_python(wanted: str) -> str:
    """The newest or oldest Python from 3.11 on that works here, by name or below PYENV_ROOT; anything else is taken as it is."""
    if wanted not in ("newest", "oldest"):
        return wanted
    kept = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")).glob("versions/3.*/bin/python3")
    names = [shutil.which(f"python3.{minor}") or "" for minor in range(11, 20)]
    ages = {version: python for python in (*map(str, kept), *names) if (version := _version(python)) >= (3, 11)}
    return ages[max(ages) if wanted == "newest" else min(ages)]


def _version(python: str) -> tuple[int, ...]:
    """Version of a Python that can make environments; nothing where it cannot be run."""
    code = "import ensurepip, sys, venv; print(*sys.version_info[:2])"
    try:
        said = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ()
    return tuple(map(int, said.split()))


def built(folder: Path) -> Path:
    """The wheel of this checkout."""
    words = [sys.executable, "-m", "hatchling", "build", "--target", "wheel", "--directory", str(folder)]
    subprocess.run(words, cwd=ROOT, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def followed(python: str, wheel: Path, folder: Path, lowest: bool) -> Iterator[Typed]:
    """Type one line after the other, each in a new shell with the environment as `activate` leaves it."""
    tools = {**os.environ, "WHEEL": str(wheel), "OMP_WAIT_POLICY": "passive", "OPENBLAS_NUM_THREADS": "1"}
    tools.pop("PYTHONPATH", None)
    for line, wanted in lines_of(TUTORIAL):
        if line.startswith(". "):
            home = folder / Path(line[2:]).parent
            tools |= {"PATH": os.pathsep.join((str(home), tools["PATH"])), "VIRTUAL_ENV": str(home.parent)}
            continue
        began = time.monotonic()
        ran = subprocess.run(
            ["bash", "-c", _words(line, python, lowest)], cwd=folder, env=tools, capture_output=True, text=True, check=False
        )
        yield Typed(line, ran.returncode, wanted, ran.stdout + ran.stderr, time.monotonic() - began)


def _words(line: str, python: str, lowest: bool) -> str:
    """The line with the Python that is asked for; uv installs the lowest versions of what pyproject.toml asks for, and then the wheel."""
    if line.startswith("python3 "):
        return line.replace("python3", python, 1)
    if line.startswith("pip install") and lowest:
        lowest_ones = f"uv pip install --quiet --resolution lowest-direct -r {shlex.quote(str(ROOT / 'pyproject.toml'))}"
        return f'pip install --quiet uv && {lowest_ones} && uv pip install --quiet --no-deps "$WHEEL"'
    return line.replace("pip install", "pip install --quiet", 1)


def answer(folder: Path, results: str) -> str:
    """What was named, as a sentence; empty if it is the hidden effect with its size."""
    result = json.loads((folder / results / "result.json").read_text(encoding="utf-8"))
    found = {effect["name"]: effect["parameters"] for effect in result["effects"]}
    if result["verdict"] == "named" and list(found) == [HIDDEN] and LOW < found[HIDDEN]["mass_kg"]["value"] < HIGH:
        return ""
    return f"{results}: the verdict is {result['verdict']}, with {found}"


def versions(folder: Path) -> str:
    """Python and the libraries that were installed."""
    code = (
        "import platform; from importlib.metadata import version as v; print(f'Python {platform.python_version()}', "
        "*(f'{n} {v(n)}' for n in ('unspool', 'numpy', 'scipy', 'numba', 'opencv-python-headless', 'av', 'pydantic', 'lmfit')), sep=', ')"
    )
    return subprocess.run([folder / "env" / "bin" / "python", "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def transcript(rows: list[Typed], lowest: bool, work: Path, judged: str) -> str:
    """One run as Markdown: each line with its status and time, long outputs in short."""
    folder, used = work.parent, versions(work)
    parts = [f"## {'Lowest' if lowest else 'Newest'} versions, {used.split(',')[0]}", "", f"{used}.", ""]
    for row in rows:
        said = row.said.replace(str(folder), ".").replace(f"{ROOT}/", "")
        lines = [line for line in said.splitlines() if " trying " not in line and not line.startswith("WARNING: ")]  # of pip, on indexes
        middle = [f"... {len(lines) - SHOWN} more lines ..."] if len(lines) > SHOWN + 1 else []
        shown = [*lines[: SHOWN // 2], *middle, *lines[-SHOWN // 2 :]] if middle else lines
        parts += ["```text", f"$ {row.line}", *shown, f"[status {row.status}, {row.seconds:.1f} s]", "```", ""]
    parts.append(f"All of it took {sum(row.seconds for row in rows):.0f} s, compiling included. {judged}\n")
    return "\n".join(parts)


HEAD = """# From the wheel

The [tutorial](../tutorial/from-an-empty-folder.md), followed to the letter by `tests/follow_tutorial.py` in an empty folder with nothing
but the wheel. Lines that say which effect is tried are left out, long outputs are cut in their middle.

"""


def main() -> int:
    """Follow the tutorial with one Python."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--python", default="python3", help="the Python to make the environment with")
    parser.add_argument("--lowest", action="store_true", help="the lowest declared versions instead of the newest")
    parser.add_argument("--write", type=Path, help="add the transcript to this file; a new file gets a head")
    given = parser.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="unspool-tutorial-"))
    try:
        return _judged(given, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _judged(given: argparse.Namespace, folder: Path) -> int:
    wheel = built(Path(tempfile.mkdtemp(dir=folder)))
    work = folder / "empty"
    work.mkdir()
    rows = []
    for row in followed(found_python(given.python), wheel, work, given.lowest):
        rows.append(row)
        print(f"[{row.status}] {row.seconds:6.1f} s  {row.line}", flush=True)
        if row.status != row.wanted:
            print(row.said)
            return 1
    wrong = [said for results in ("explanation", "results") if (said := answer(work, results))]
    judged = " ".join(wrong) or f"Both times the hidden effect was named, {HIDDEN}, with its size."
    print(judged)
    if given.write is not None:
        before = given.write.read_text(encoding="utf-8") if given.write.exists() else HEAD
        given.write.write_text(f"{before}{transcript(rows, given.lowest, work, judged)}\n", encoding="utf-8")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
