"""The lines of a text, in blocks: a list of all of them would take several times the memory of the text."""

from __future__ import annotations

from collections.abc import Iterator

_CHARACTERS_AT_ONCE = 1 << 18


class TextLines:
    """The lines of a text without the blank ones at its end; every kind of line end counts as one.

    text : with "\\n" at the end of each line.
    """

    def __init__(self, text: str) -> None:
        self.text = text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
        self._end = self._end_of_last_filled_line()

    def __len__(self) -> int:
        return self.text.count("\n", 0, self._end) + 1 if self._end else 0

    def _end_of_last_filled_line(self) -> int:
        start = len(self.text)
        while start:
            start, end = max(start - _CHARACTERS_AT_ONCE, 0), start
            filled = start + len(self.text[start:end].rstrip())
            if filled > start:
                line_end = self.text.find("\n", filled)
                return line_end if line_end >= 0 else len(self.text)
        return 0

    def first(self) -> str:
        """The first line."""
        end = self.text.find("\n", 0, self._end)
        return self.text[: end if end >= 0 else self._end]

    def last(self, count: int) -> list[str]:
        """The last lines, at most `count`."""
        start = self._end
        for _ in range(count):
            start = self.text.rfind("\n", 0, start)
            if start < 0:
                break
        return self.text[start + 1 : self._end].split("\n") if self._end else []

    def blocks(self, skipped: int = 0) -> Iterator[list[str]]:
        """All lines but the first few, some thousands at a time."""
        start = 0
        for _ in range(skipped):
            start = self.text.find("\n", start, self._end) + 1 or self._end + 1
        while start < self._end:
            end = self.text.find("\n", start + _CHARACTERS_AT_ONCE, self._end)
            end = end if end >= 0 else self._end
            yield self.text[start:end].split("\n")
            start = end + 1
