"""Plain text of docstrings as reStructuredText.

In plain text an indented block is a formula and `a |b|` is an absolute value. Both would mean something else to Sphinx, so formulas
become literal blocks and the signs that mean something are escaped. Parameters are written `name : what it is`, in one line.
"""

from __future__ import annotations

import re
from itertools import groupby, pairwise

_ENTRY = re.compile(r"([a-z]\w*(?:, [a-z]\w*)*) : ")
_SECTIONS = ("Parameters", "Returns", "Raises", "Attributes", "Yields", "Notes", "References", "Examples")


def restructured(lines: list[str]) -> list[str]:
    """A whole docstring: prose first, then its numpydoc sections."""
    start = _start_of_sections(lines)
    return [*prose(lines[:start]), *sections(lines[start:])]


def entries(paragraph: list[str]) -> list[str]:
    """A paragraph such as `step_s : s. samples : (n,) of the run.` as a list with a row for each name; others as they are."""
    text = " ".join(paragraph)
    if not _ENTRY.match(text):
        return [escaped(line) for line in paragraph]
    parts = re.split(r"(?<=[.;]) (?=" + _ENTRY.pattern + ")", text)
    rows = (_ENTRY.match(part) for part in parts)
    return [f"- ``{row[1]}``: {escaped(part[row.end() :])}" for part, row in zip(parts, rows, strict=True) if row]


def prose(lines: list[str]) -> list[str]:
    """Paragraphs with their signs escaped, indented blocks as literal ones, names with what they are as lists."""
    made: list[str] = []
    for indented, block in groupby(lines, lambda line: line.startswith("    ")):
        body = list(block)
        made += ["", "::", "", *body, ""] if indented else [line for part in _paragraphs(body) for line in [*entries(part), ""]]
    return made


def _paragraphs(lines: list[str]) -> list[list[str]]:
    return [list(block) for empty, block in groupby(lines, lambda line: not line.strip()) if not empty]


def sections(lines: list[str]) -> list[str]:
    """Parameters, Returns and Raises with the description of each entry below its name, as numpydoc has it."""
    made: list[str] = []
    for line, below in pairwise([*lines, ""]):
        entry = re.match(r"(\w[\w, ]*?) : (.*)$", line)
        if entry and _is_type(entry[2], below):
            made.append(f"{entry[1]} : {escaped(entry[2])}")
        elif entry:
            made += [entry[1], "    " + escaped(entry[2])]
        elif line in _SECTIONS or re.fullmatch(r"-+", line):
            made.append(line)
        else:
            made.append(escaped(line))
    return _returns_below_their_name(made)


def _is_type(text: str, below: str) -> bool:
    """Whether a type stands behind a name, with the description in the line below, or the description itself."""
    return not text.endswith((".", ";", ",")) and bool(re.match(r"\s+[A-Z`(]", below))


def escaped(line: str) -> str:
    """A line with the signs escaped that mean something to Sphinx, but for what stands in backquotes."""
    parts = re.split(r"(``[^`]*``|`[^`]*`)", line)
    return "".join(re.sub(r"([*|\\])|(?<=\w)_(?!\w)", lambda m: "\\" + m[0], p) if i % 2 == 0 else p for i, p in enumerate(parts))


def _start_of_sections(lines: list[str]) -> int:
    for i in range(len(lines) - 1):
        if lines[i] in _SECTIONS and re.fullmatch(r"-{3,}", lines[i + 1]):
            return i
    return len(lines)


def _returns_below_their_name(lines: list[str]) -> list[str]:
    """A sentence straight below `Returns` is a description and not a type: numpydoc would print it in italics."""
    if "Returns" not in lines:
        return lines
    first = lines.index("Returns") + 2
    last = next((i for i in range(first, len(lines)) if i + 1 < len(lines) and re.fullmatch(r"-{3,}", lines[i + 1])), len(lines))
    body = [line for line in lines[first:last] if line.strip()]
    plain = body and not any(line.startswith("    ") for line in body)
    moved = ["result", *("    " + line for line in body), ""] if plain else lines[first:last]
    return [*lines[:first], *moved, *lines[last:]]
