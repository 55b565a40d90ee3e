"""Lines of text between the rows of a table: heads that are repeated above every block, blank lines, remarks at the end."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from measure.common.errors import InputError
from measure.tables.text_lines import TextLines

# A line that begins with a word; what stands for no number is none. A unit in brackets is a word.
_TEXT = re.compile(r"[\s\"'(\[#*<]*(?!(?:nan|inf|infinity)\b)[^\W\d_]", re.IGNORECASE)
_SHOWN = 12


def is_text(line: str) -> bool:
    """Whether a line is one of words and not of numbers; a blank one too."""
    return not line.strip() or _TEXT.match(line) is not None


def rows_only(lines: Sequence[str]) -> list[str]:
    """The lines of numbers; all of them where every one begins with a word, as a table with words in its first column does."""
    kept = [line for line in lines if not is_text(line)]
    return kept if len(kept) >= 2 else list(lines)


class Blocks:
    """The rows of a table that stands in blocks with text between them.

    numbers : the line of each row, counted from one. notes : the first lines of text between the blocks.

    Raises
    ------
    InputError
        While the rows are taken: a block whose columns are named otherwise.
    """

    def __init__(self, lines: TextLines, start: int, names: Sequence[str], split: Callable[[str], list[str]]) -> None:
        self.numbers: list[int] = []
        self.notes: list[str] = []
        self._lines, self._start, self._names, self._split = lines, start, list(names), split

    def rows(self, place: str) -> Iterator[list[str]]:
        """The lines of numbers, some thousands at a time."""
        number = self._start
        for block in self._lines.blocks(self._start):
            kept = []
            for line in block:
                number += 1
                if is_text(line):
                    self._take_text(line, f"{place}, line {number}")
                else:
                    kept.append(line)
                    self.numbers.append(number)
            if kept:
                yield kept

    def _take_text(self, line: str, place: str) -> None:
        if line.strip() and len(self.notes) < _SHOWN:
            self.notes.append(line)
        cells = self._split(line)
        known = set(self._names)
        if self._names and len(cells) == len(self._names) and cells != self._names and sum(cell in known for cell in cells) >= 2:
            raise InputError(f"{place}: the columns of this block are named otherwise than those of the first. Save one test in one file.")
