"""The reference of the levels that decide something: each constant of every `criteria.py`, with the reason that stands below it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

_HEAD = """# Levels that decide

Every level that decides a verdict, a status or a refusal stands in a file `criteria.py`, with its derivation, the calibration run that
set it, or the reason in words. This page is written from these files.
"""


@dataclass(frozen=True)
class Level:
    """A constant: its name or names, its value as it stands in the source, and the reason below it."""

    name: str
    value: str
    reason: str


def page() -> str:
    """The page as MyST Markdown: a table for each file."""
    parts = [_HEAD]
    for file in criteria_files():
        rows = [f"| `{level.name}` | `{level.value}` | {_cell(level.reason)} |" for level in levels_of(file)]
        parts.append(
            "\n".join([f"## `{file.relative_to(ROOT).as_posix()}`", "", "| level | value | reason |", "| --- | --- | --- |", *rows, ""])
        )
    return "\n".join(parts)


def criteria_files() -> list[Path]:
    """All files of levels in the three packages."""
    return sorted(file for package in ("measure", "simulate", "identify") for file in (ROOT / package).rglob("criteria.py"))


def levels_of(file: Path) -> Iterator[Level]:
    """The constants of a file in their order; a reason is the text that stands straight below a constant."""
    body = ast.parse(file.read_text(encoding="utf-8")).body
    for here, below in zip(body, [*body[1:], None], strict=True):
        if isinstance(here, ast.Assign | ast.AnnAssign) and here.value is not None:
            targets = here.targets if isinstance(here, ast.Assign) else [here.target]
            yield Level(", ".join(ast.unparse(target).strip("()") for target in targets), ast.unparse(here.value), _text(below))


def _text(node: ast.stmt | None) -> str:
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    return node.value.value if is_text else ""  # type: ignore[union-attr]


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "\\<").replace("*", "\\*")
