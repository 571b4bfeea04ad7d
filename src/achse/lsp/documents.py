"""Documents: texts as the client has them, with its positions.

A client counts columns in the units of the position encoding, UTF-16 unless both agree on
another; achse counts characters. Lines end with LF, CRLF or CR and with nothing else.

Source: Language Server Protocol 3.17, Text Documents.
"""

import re
from bisect import bisect_right
from functools import cached_property
from pathlib import Path

from lsprotocol import types

_BREAK = re.compile(r"\r\n|\n|\r")
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")


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
        return [0, *(found.end() for found in _BREAK.finditer(self.text))]

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

    def edit(self, place: types.Range | None, text: str) -> None:
        """Replace a range, or all without one."""
        if place is None:
            self.text = text
        else:
            start, end = self.offset_at(place.start), self.offset_at(place.end)
            self.text = self.text[:start] + text + self.text[max(start, end) :]
        self.__dict__.pop("_starts", None)


def read_document(file: Path, encoding: Encoding) -> Document | None:
    """Return the document of a file on disk; None if it cannot be read."""
    try:
        data = file.read_bytes()
    except (OSError, ValueError):
        return None
    try:
        text = data.decode("utf-16" if data.startswith(_UTF_16) else "utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")
    return Document(text, encoding)
