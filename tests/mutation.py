"""How many faults the tests would catch: `python tests/mutation.py --places 10 --seed 1`.

Draws places in each package (a comparison turned round, a sign or a `not` dropped, + and - exchanged, a number or a truth value
changed), breaks one at a time in a copy of the project, and runs the quick tests that mirror the room and a few of the whole, then the
slow ones of the room. A place that no test notices survives and is printed with its line; some are no faults at all (a tolerance that is
a little larger, a colour).
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("measure", "simulate", "identify")
COPIED = (*PACKAGES, "tests", "datasets", "docs", "pyproject.toml", "constraints.txt", "README.md", "CONTRIBUTING.md", "Makefile", ".ci")
SMOKE = {
    "measure": ("tests/measure/commands",),
    "simulate": ("tests/simulate/test_law.py", "tests/simulate/commands", "tests/simulate/deployment"),
    "identify": ("tests/identify/commands", "tests/identify/actuator", "tests/identify/gap/test_compare.py"),
}
PATIENCE_S = 900  # of processor time for the tests of one place; who needs more hangs, and that is noticed
TURNED = {
    "<": ">=",
    "<=": ">",
    ">": "<=",
    ">=": "<",
    "==": "!=",
    "!=": "==",
    "is": "is not",
    "is not": "is",
    "in": "not in",
    "not in": "in",
}
CALM = {"OMP_WAIT_POLICY": "passive", "OPENBLAS_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": ""}


@dataclass(frozen=True)
class Place:
    """One fault: the bytes from begin to end of a file become others."""

    file: Path
    line: int
    begin: int
    end: int
    kind: str
    text: bytes

    def broken(self) -> bytes:
        source = (ROOT / self.file).read_bytes()
        return source[: self.begin] + self.text + source[self.end :]

    def shown(self) -> str:
        """The line as it is and as it becomes."""
        whole, changed = (ROOT / self.file).read_bytes(), self.broken()
        one, other = (text.decode().splitlines()[self.line - 1].strip() for text in (whole, changed))
        return f"{one}   ->   {other}"


class Places:
    """All places of one file."""

    def __init__(self, file: Path) -> None:
        self.file, self.source = file, (ROOT / file).read_bytes()
        lines = self.source.splitlines(keepends=True)
        self.starts = [sum(map(len, lines[:i])) for i in range(len(lines) + 1)]

    def __iter__(self) -> Iterator[Place]:
        yield from self._in(ast.parse(self.source))

    def _in(self, node: ast.AST) -> Iterator[Place]:
        for name, value in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list"):
                continue
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from self._of(child)
                    yield from self._in(child)

    def _of(self, node: ast.AST) -> Iterator[Place]:
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            yield from self._between(node.left, node.comparators[0], "comparison")
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub) and not _is_text(node):
            yield from self._between(node.left, node.right, "+ and -")
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            yield self._place(
                node, *self._span(node), "sign" if isinstance(node.op, ast.USub) else "not", b"(%s)" % self._text(node.operand)
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not self._appearance():
            yield self._place(node, *self._span(node), "number", _other(node.value))

    def _appearance(self) -> bool:
        return "plots" in self.file.stem or "page" in self.file.stem

    def _between(self, left: ast.expr, right: ast.expr, kind: str) -> Iterator[Place]:
        begin, end = self._span(left)[1], self._span(right)[0]
        sign = re.search(rb"\+|-|[<>=!]=|<|>|\b(?:is not|not in|is|in)\b", self.source[begin:end])
        if sign:
            found = sign.group().decode()
            other = {"+": "-", "-": "+"}.get(found) or TURNED[found]
            yield self._place(left, begin + sign.start(), begin + sign.end(), kind, other.encode())

    def _span(self, node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset

    def _text(self, node: ast.expr) -> bytes:
        begin, end = self._span(node)
        return self.source[begin:end]

    def _place(self, node: ast.expr, begin: int, end: int, kind: str, text: bytes) -> Place:
        return Place(self.file, self.source[:begin].count(b"\n") + 1, begin, end, kind, text)


def _is_text(node: ast.BinOp) -> bool:
    return any(
        isinstance(part, ast.JoinedStr) or (isinstance(part, ast.Constant) and isinstance(part.value, str)) for part in ast.walk(node)
    )


def _other(value: float) -> bytes:
    if isinstance(value, bool):
        return str(not value).encode()
    return str(value + 1).encode() if isinstance(value, int) else repr(value * 1.5 if value else 1.0).encode()


def drawn(package: str, places: int, seed: int) -> list[Place]:
    """So many places of a package: each file by its number of places."""
    files = [path.relative_to(ROOT) for path in sorted((ROOT / package).rglob("*.py"))]
    whole = [place for file in files for place in Places(file)]
    return random.Random(f"{package} {seed}").sample(whole, places)


def tests_of(file: Path) -> tuple[str, ...]:
    """The tests of this module, its mirroring room (the whole package's where there is none), and a few of the whole, in this order."""
    package, room = file.parts[0], Path("tests", *file.parts[:-1])
    mirror = room if len(file.parts) > 2 and (ROOT / room).is_dir() else Path("tests", package)
    own = sorted((ROOT / mirror).rglob(f"test_{file.stem}.py"))
    smoke = [name for name in SMOKE[package] if not Path(name).is_relative_to(mirror)]
    return (*(str(path.relative_to(ROOT)) for path in own), str(mirror), *smoke)


def ran(folder: Path, tests: tuple[str, ...], *options: str, kind: str = "not slow") -> subprocess.CompletedProcess[str]:
    """The quick ones among these tests, or the slow ones, in a folder."""
    command = [
        Path(sys.executable).with_name("pytest"),
        "-q",
        "-p",
        "no:xdist",
        "-p",
        "no:cacheprovider",
        "-m",
        kind,
        *options,
        *tests,
    ]

    def limited() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE_S, PATIENCE_S + 5))

    environment = {**os.environ, **CALM, "PYTHONPATH": str(folder)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False, preexec_fn=limited)


def failing(said: str) -> list[str]:
    """The tests that failed, from what pytest prints."""
    return re.findall(r"^(?:FAILED|ERROR) (\S+)", said, re.M)


class Copy:
    """A copy of the project in which one place at a time is broken; what fails there as it is, is left out."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in COPIED:
            source = ROOT / name
            if source.is_dir():
                shutil.copytree(source, folder / name)
            elif source.exists():
                shutil.copy2(source, folder / name)
        self.fail_anyway: set[str] = set()

    def noticed_by(self, place: Place) -> str:
        """The first test that fails because of the fault, or nothing."""
        return self._noticed_by(place, "not slow") or self._noticed_by(place, "slow")

    def _noticed_by(self, place: Place, kind: str) -> str:
        while True:
            found = self._broken(place, kind)
            if found.returncode in (0, 5):
                return ""
            if found.returncode < 0:
                return "does not come to an end"
            first = (failing(found.stdout) or [""])[0]
            if not first or ran(self.folder, (first,), kind=kind).returncode in (0, 5):
                return first or "nothing can be collected"
            self.fail_anyway.add(first)

    def _broken(self, place: Place, kind: str) -> subprocess.CompletedProcess[str]:
        """The tests of a place while it is broken, a few of the whole only quick ones; who fails as it is, is left out."""
        left_out = [word for test in sorted(self.fail_anyway) for word in ("--deselect" if "::" in test else "--ignore", test)]
        path = self.folder / place.file
        whole, stamp = path.read_bytes(), path.stat()
        path.write_bytes(place.broken())
        try:
            tests = tests_of(place.file)
            asked = tests if kind == "not slow" else tuple(name for name in tests if name not in SMOKE[place.file.parts[0]])
            return ran(self.folder, asked, "-x", *left_out, kind=kind)
        finally:
            path.write_bytes(whole)
            os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))


def main() -> int:
    """Print for each place whether a test notices it, and the shares."""
    asked = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    asked.add_argument("--places", type=int, default=10, metavar="N", help="in each package (default 10)")
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--package", action="append", choices=PACKAGES, help="repeatable; default all")
    given = asked.parse_args()
    with tempfile.TemporaryDirectory() as place:
        copy, lines = Copy(Path(place)), []
        for package in given.package or PACKAGES:
            caught = 0
            for fault in drawn(package, given.places, given.seed):
                test = copy.noticed_by(fault)
                caught += bool(test)
                print(f"{fault.file}:{fault.line}  {fault.kind}\n    {fault.shown()}\n    {test or 'SURVIVES'}", flush=True)
            lines.append(f"{package:<10s} {caught} of {given.places} noticed")
        print(*lines, *(f"fails as it is, and was left out: {test}" for test in sorted(copy.fail_anyway)), sep="\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
