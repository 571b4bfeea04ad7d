"""Source texts and the faults found in them: file, line, column, the line with a caret."""

import hashlib
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol
from unicodedata import category, combining, east_asian_width

from achse.iec.errors import DeclarationError
from achse.st.lexis.codes import Code

_BREAK = re.compile("\n")
_WORD = re.compile(
    r"""'(?:[^'$\n]|\$.)*'?|"(?:[^"$\n]|\$.)*"?|%[A-Za-z*][\w.*]*|\d[\w.]*(?:\#[\w.:+-]+)?"""
    r"""|\w+(?:\#[\w.:+-]+)?|:=|=>|<=|>=|<>|\*\*|//.*|\(\*.*|/\*.*|\{[^}\n]*\}?|[^\s]"""
)
"""A word, literal or sign: what a finding at its first character underlines."""
_LONGEST_LINE = 160
_REPLACEMENT = "\ufffd"
_UNPRINTABLE = ("Cc", "Cf", "Cs", "Zl", "Zp")
"""General categories of Unicode: controls, formats (directions too), surrogates, separators."""
_SHOWN_FAULTS = 20


class Location(NamedTuple):
    """A place in a file; line and column count from 1, the column in characters."""

    path: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.path}:{self.line}:{self.column}"


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One thing wrong with a source."""

    location: Location
    message: str
    code: Code
    text: str = ""
    """The line it is in."""
    end_line: int = 0
    end_column: int = 0
    """End of the place, behind its last character; without one the place has no characters."""
    origin: "FindingOrigin | None" = field(default=None, compare=False, repr=False)
    """The same place in its source, so that a finding can follow an edit in front of it."""

    def __post_init__(self) -> None:
        if not self.end_line:
            object.__setattr__(self, "end_line", self.location.line)
            object.__setattr__(self, "end_column", self.location.column)

    def __str__(self) -> str:
        place = printable(str(self.location)).replace("\n", _REPLACEMENT)
        head = f"{place}: {printable(self.message)}"
        if not self.text:
            return head
        text = printable(self.text)
        indent = "".join(map(_blank, text[: self.location.column - 1]))
        return f"{head}\n    {text}\n    {indent}^"


def printable(text: str) -> str:
    """Return a text with U+FFFD for signs that command terminals or cannot be encoded."""
    if text.isprintable():
        return text
    return "".join(
        _REPLACEMENT if category(sign) in _UNPRINTABLE and sign not in "\t\n" else sign
        for sign in text
    )


def _blank(sign: str) -> str:
    """Return blanks as wide as a sign, so that the caret is under its column in any terminal."""
    if sign == "\t":
        return sign
    if combining(sign):
        return ""
    return "  " if east_asian_width(sign) in "WF" else " "


class FindingOrigin(NamedTuple):
    """Place and message that a finding was made of."""

    source: "Source"
    at: int
    end: int | None
    message: str


class SourceError(DeclarationError):
    """Sources have faults: `faults` lists all of them, by file and place; `hint` helps on.

    The message has one line for all faults that follow from one cause: `following`.
    """

    def __init__(
        self,
        faults: Iterable[Diagnostic],
        hint: str = "",
        following: Mapping[str, Sequence[Diagnostic]] | None = None,
    ) -> None:
        self.faults = tuple(sorted(faults, key=lambda fault: fault.location))
        causes = following or {}
        folded = {fault for of_cause in causes.values() for fault in of_cause}
        apart = [fault for fault in self.faults if fault not in folded]
        shown = [str(fault) for fault in apart[:_SHOWN_FAULTS]]
        if len(apart) > _SHOWN_FAULTS:
            shown.append(f"… and {len(apart) - _SHOWN_FAULTS} more")
        shown += causes
        self.hint = hint
        super().__init__("\n".join([*shown, hint] if hint else shown))


class SourceSegment(NamedTuple):
    """A part of a text that is elsewhere in its file: where it starts, in both."""

    start: int
    line: int
    column: int


_PLAIN = (SourceSegment(0, 1, 1),)
"""The pieces of a file that is all text."""


class Drawing(Protocol):
    """A body that is drawn: its nodes have offsets behind the text of the source."""

    start: int
    digest: bytes

    def locate(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset in the file."""

    def offset_at(self, line: int, column: int) -> int | None:
        """Return the offset of a line and column of the file; None outside of the drawing."""

    def place(self, offset: int) -> str:
        """Return the place of an offset in the drawing: `network 3, rung 1`."""


class Source:
    """A text and where it comes from.

    The text of an XML file is the texts of its parts one after the other; `pieces` say where in
    the file each of them starts. Syntax trees keep offsets into `text`, and `locate` turns them
    into lines and columns on request.
    """

    def __init__(
        self,
        text: str,
        path: str = "<text>",
        pieces: Iterable[SourceSegment] = (),
        drawings: Iterable[Drawing] = (),
    ) -> None:
        self.text = text
        self.path = path
        self.library = ""
        """The library that a source is from: its title."""
        self.namespace = ""
        """Prefix of the library's names in a project, if it is not the library's title."""
        self.file = ""
        """The file that it was read from, with its whole path."""
        self.content: object = None
        """Further results of the same text, dropped with the source."""
        self.pieces = tuple(pieces) or _PLAIN
        self._starts = [piece.start for piece in self.pieces]
        self.drawings = tuple(drawings)
        """Drawn bodies, by their first offsets, all behind the text."""

    def adopt(self, edited: "Source") -> None:
        """Take over the text and the places of an edited version of the same file."""
        self.text, self.pieces, self.drawings = edited.text, edited.pieces, edited.drawings
        self._starts = edited._starts
        for name in ("_breaks", "digest"):
            self.__dict__.pop(name, None)

    def offset_at(self, line: int, column: int) -> int | None:
        """Return the offset of a line and column of the file, from 1; None outside of the text.

        A place behind the end of a line is that end.
        """
        for index, piece in enumerate(self.pieces):
            last = self._starts[index + 1] - 1 if index + 1 < len(self.pieces) else len(self.text)
            first = bisect_left(self._breaks, piece.start)
            lines = bisect_left(self._breaks, last) - first
            below = line - piece.line
            if not 0 <= below <= lines or (below == 0 and column < piece.column):
                continue
            start = piece.start if below == 0 else self._breaks[first + below - 1] + 1
            end = self._breaks[first + below] if below < lines else last
            offset = start + column - (piece.column if below == 0 else 1)
            if offset > end and below == lines and self.pieces != _PLAIN:
                continue  # behind a CDATA part
            return min(offset, end)
        return None

    def drawn_offset_at(self, line: int, column: int) -> int | None:
        """Return the offset of a line and column in a drawing of the file; None outside of them."""
        offsets = (drawing.offset_at(line, column) for drawing in self.drawings)
        return next((offset for offset in offsets if offset is not None), None)

    def locate(self, offset: int) -> Location:
        """Return the place of an offset."""
        drawing = self._drawing(offset)
        if drawing is not None:
            return Location(self.path, *drawing.locate(offset))
        offset = max(0, min(offset, len(self.text)))
        piece = self.pieces[max(0, bisect_right(self._starts, offset) - 1)]
        here = bisect_left(self._breaks, offset)
        breaks = here - bisect_left(self._breaks, piece.start)
        if breaks == 0:
            return Location(self.path, piece.line, piece.column + offset - piece.start)
        return Location(self.path, piece.line + breaks, offset - self._breaks[here - 1])

    def place(self, offset: int) -> str:
        """Return the place of an offset in a drawing, `network 3, rung 1`; empty in text."""
        drawing = self._drawing(offset)
        return "" if drawing is None else drawing.place(offset)

    def _drawing(self, offset: int) -> Drawing | None:
        """Return the drawing that an offset is in."""
        if offset <= len(self.text) or not self.drawings:
            return None
        last = None
        for drawing in self.drawings:
            if drawing.start > offset:
                break
            last = drawing
        return last

    @cached_property
    def _breaks(self) -> list[int]:
        """Positions of line ends: a routine looks up the place of each of its statements."""
        return [line_end.start() for line_end in _BREAK.finditer(self.text)]

    @cached_property
    def digest(self) -> bytes:
        """A hash of path and content, 20 bytes."""
        path = f"{self.path}\0".encode("utf-8", "surrogatepass")
        return hashlib.blake2b(path + self.content_digest, digest_size=20).digest()

    @cached_property
    def content_digest(self) -> bytes:
        """A hash of text, places in the file and drawings, 20 bytes."""
        content = f"{self.pieces}\0{self.text}".encode("utf-8", "surrogatepass")
        digest = hashlib.blake2b(content, digest_size=20)
        for drawing in self.drawings:
            digest.update(drawing.digest)
        return digest.digest()

    def line_at(self, offset: int) -> str:
        """Return the whole line an offset is in, as far as its piece goes."""
        offset = max(0, min(offset, len(self.text)))
        index = max(0, bisect_right(self._starts, offset) - 1)
        first = self.pieces[index].start
        last = self._starts[index + 1] if index + 1 < len(self._starts) else len(self.text)
        start = self.text.rfind("\n", first, offset) + 1 or first
        end = self.text.find("\n", offset, last)
        return self.text[start : last if end < 0 else end]

    def fault(self, offset: int, message: str, code: Code, end: int | None = None) -> Diagnostic:
        """Return a fault at an offset, up to `end` or that of the word there; in a drawing the
        message names the place."""
        location = self.locate(offset)
        place = self.place(offset)
        origin = FindingOrigin(self, offset, end, message)
        if place:
            return Diagnostic(location, f"{place}: {message}", code, origin=origin)
        line = self.line_at(offset)
        if len(line) > _LONGEST_LINE or "\0" in line or location.column > len(line) + 1:
            line = ""
        end = self._word_end(offset) if end is None else end
        if end <= offset:
            return Diagnostic(location, message, code, line, origin=origin)
        last = self.locate(end - 1)  # `end` may be in the next piece
        return Diagnostic(location, message, code, line, last.line, last.column + 1, origin)

    def _word_end(self, offset: int) -> int:
        """Return the offset behind the word that begins at an offset; the same where none
        begins."""
        offset = max(0, min(offset, len(self.text)))
        index = bisect_right(self._starts, offset)
        last = self._starts[index] if index < len(self._starts) else len(self.text)
        word = _WORD.match(self.text, offset, last)
        return offset if word is None else word.end()
