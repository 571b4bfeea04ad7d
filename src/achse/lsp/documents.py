"""Documents: texts as the client has them, with its positions.

A client counts columns in the units of the position encoding, UTF-16 unless both agree on
another; achse counts characters. Lines end with LF, CRLF or CR and with nothing else.

Source: Language Server Protocol 3.17, Text Documents.
"""

import re
from bisect import bisect_right
from collections.abc import Iterable
from functools import cached_property
from itertools import pairwise
from pathlib import Path

from lsprotocol import types

_BREAK = re.compile(r"\r\n|\n|\r")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")

LARGEST = 1 << 24
"""Most characters of a document that is checked, and most bytes of a file that is read."""


class Encoding:
    """The units that a client counts columns in."""

    def __init__(self, kind: types.PositionEncodingKind | str = "utf-16") -> None:
        self.kind = str(kind.value if isinstance(kind, types.PositionEncodingKind) else kind)

    def units(self, text: str) -> int:
        """Return the length of a text."""
        if self.kind == "utf-32" or text.isascii():
            return len(text)
        if self.kind == "utf-8":
            return len(text.encode("utf-8", "surrogatepass"))
        return len(text) + sum(sign > "\uffff" for sign in text)

    def index(self, text: str, units: int) -> int:
        """Return the number of characters in the first units of a text; a position inside of a
        character is that before it."""
        if self.kind == "utf-32" or text.isascii():
            return max(0, min(units, len(text)))
        so_far = 0
        for index, sign in enumerate(text):
            so_far += self.units(sign)
            if so_far > units:
                return index
        return len(text)


class Document:
    """A text with its version and the places of its lines."""

    def __init__(
        self, text: str, encoding: Encoding | None = None, version: int | None = None
    ) -> None:
        self.text = text
        self.encoding = encoding or Encoding()
        self.version = version

    @cached_property
    def _starts(self) -> list[int]:
        return [0, *(line_break.end() for line_break in _BREAK.finditer(self.text))]

    @property
    def line_count(self) -> int:
        """Number of lines; a text that ends with a line break has an empty one behind it."""
        return len(self._starts)

    def line(self, number: int) -> str:
        """Return a line, from 0, without its end; an empty one behind the last."""
        if not 0 <= number < len(self._starts):
            return ""
        last = self._starts[number + 1] if number + 1 < len(self._starts) else len(self.text)
        return self.text[self._starts[number] : last].rstrip("\r\n")

    def offset_at(self, position: types.Position) -> int:
        """Return the offset of a position; one outside of the text is the nearest inside."""
        if position.line < 0:
            return 0
        if position.line >= len(self._starts):
            return len(self.text)
        line = self.line(position.line)
        return self._starts[position.line] + self.encoding.index(line, max(position.character, 0))

    def position_at(self, offset: int) -> types.Position:
        offset = max(0, min(offset, len(self.text)))
        line = bisect_right(self._starts, offset) - 1
        return types.Position(line, self.encoding.units(self.text[self._starts[line] : offset]))

    def place_of(self, position: types.Position) -> tuple[int, int]:
        """Return the line and the column in characters of a position, both from 1."""
        line = self.line(position.line)
        return position.line + 1, self.encoding.index(line, max(position.character, 0)) + 1

    def position_of(self, line: int, column: int) -> types.Position:
        """Return the position of a line and a column in characters, both from 1."""
        text = self.line(line - 1)[: max(column - 1, 0)]
        return types.Position(max(line - 1, 0), self.encoding.units(text))

    def text_of(self, place: types.Range) -> str:
        return self.text[self.offset_at(place.start) : self.offset_at(place.end)]

    def edit(self, edits: Iterable[tuple[types.Range | None, str]]) -> None:
        """Replace ranges, or all without one, one after the other.

        A replacement everywhere has thousands of edits: each moves lines, not the whole text.
        """
        lines: list[str] | None = None
        for place, text in edits:
            if place is None:
                self.text, lines = text, None
                continue
            lines = _lines_of(self.text) if lines is None else lines
            first, start = self._index_in(lines, place.start)
            last, end = max(self._index_in(lines, place.end), (first, start))
            begin, behind = max(first - 1, 0), last + 2  # a CR and an LF that meet are one end
            head = "".join(lines[begin:first]) + lines[first][:start]
            tail = lines[last][end:] + "".join(lines[last + 1 : behind])
            changed = _lines_of(head + text + tail)
            lines[begin:behind] = changed[:-1] if behind < len(lines) else changed
        if lines is not None:
            self.text = "".join(lines)
        self.__dict__.pop("_starts", None)

    def _index_in(self, lines: list[str], position: types.Position) -> tuple[int, int]:
        """Return the line and the character of a position; one outside is the nearest inside."""
        if position.line < 0:
            return 0, 0
        if position.line >= len(lines):
            return len(lines) - 1, len(lines[-1])
        line = lines[position.line].rstrip("\r\n")
        return position.line, self.encoding.index(line, max(position.character, 0))


def _lines_of(text: str) -> list[str]:
    """Return the lines of a text with their ends; the last one has none."""
    starts = [0, *(line_break.end() for line_break in _BREAK.finditer(text)), len(text)]
    return [text[start:end] for start, end in pairwise(starts)]


def read_document(file: Path, encoding: Encoding) -> Document | None:
    """Return the document of a file on disk; None if it cannot be read, is too large, or is a
    device or a pipe."""
    try:
        if not file.is_file() or file.stat().st_size > LARGEST:
            return None
        data = file.read_bytes()
    except (OSError, ValueError):
        return None
    try:
        text = data.decode("utf-16" if data.startswith(_UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    return Document(text, encoding)
