"""A part program: its text, its lines, and where blocks and subroutines begin.

Lines become blocks when they are first run, so that a long program loads at once. The text index of
a block is the offset of its first byte; a text is bytes in Latin-1, so that character and byte are
the same.
"""

import re
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from itertools import accumulate
from pathlib import Path

from achse.codes import NcError
from achse.gcode.errors import GcodeError, WordRefused
from achse.gcode.text.blocks import ProgramBlock, parse_block

CACHED_BLOCKS = 4096
"""Blocks that are cached for loops and subroutines; a long program is not in memory twice."""

LONGEST_BLOCK = 1024
"""Characters of a block, decision 0090. A longer line is refused when it is to run."""
_SHOWN = 80
"""Characters of a longer line that its error shows."""

_NUMBER_DIGITS = 12
_BEFORE_NUMBER = re.compile(r"[ \t]*(?:/[ \t]*\d*[ \t]*)?")
_LABEL = re.compile(r"L[ \t]*(\d{1,9})[ \t]*(?:\([^()\n]*\)?[ \t]*)?\r*$", re.MULTILINE)
_LINES_AT_ONCE = 1024
"""Lines that a search backwards looks at before it goes further back."""
_ENDS = re.compile(r"(?<![A-Z@#])M[ \t]*0*(?:2|17|30)(?!\d)")
_NOTHING = re.compile(r"[ \t;\r]*(?:\([^()\n]*\)?[ \t;\r]*)*")


_UTF8_MARK = b"\xef\xbb\xbf"
_TAIL = frozenset(b"\0\x1a")
"""Padding or end-of-file bytes of some systems (CP/M and DOS)."""
_PADDING = re.compile(r"(?<![^\n])[\0 \t]++|(?<![\0 \t])[\0 \t]++(?=\r*+(?:\n|\Z))")
_RETURNS = re.compile(r"(?<!\r)\r++(?!\n)")
_WIDE_MARKS = (b"\xff\xfe", b"\xfe\xff")
_FIRST_BYTES = 64


def _has_wide_characters(data: bytes) -> bool:
    """Return True if each character has more than one byte: by its mark, or every second byte is
    0."""
    if data.startswith(_WIDE_MARKS):
        return True
    first = data.lstrip(b"\0")[:_FIRST_BYTES]
    return len(first) > 2 and not any(first[1::2])


def _separated(text: str) -> str:
    """Every line ends with LF, perhaps behind CR; NUL bytes around blocks are blanks."""
    if "\r" in text:
        text = _RETURNS.sub(lambda match: "\n" * len(match[0]), text)
    if "\0" in text:
        text = _PADDING.sub(lambda match: " " * len(match[0]), text)
    return text


def _ends(line: str) -> bool:
    """Return True if a program or subroutine ends with this line; comments do not count."""
    if "(" in line:
        line = re.sub(r"\([^()]*\)?", " ", line)
    return _ENDS.search(line) is not None


class PartProgram:
    """A text with its lines; `name` is what errors and displays call it."""

    def __init__(self, text: str | bytes, name: str = "") -> None:
        if isinstance(text, str):
            text = text.encode("latin-1", "replace")
        self.name = name
        if text.startswith(_UTF8_MARK):
            text = b"   " + text[len(_UTF8_MARK) :]
        if not _TAIL.isdisjoint(text[-1:]):
            text = text.rstrip(bytes(_TAIL)).ljust(len(text))
        self.text = text.decode("latin-1")
        upper = _separated(text.upper().decode("latin-1"))
        self._upper = upper
        whole = upper.split("\n")
        self.lines = [line.rstrip("\r") for line in whole] if "\r" in upper else whole
        self.starts = list(accumulate((len(line) + 1 for line in whole[:-1]), initial=0))
        self._blocks: dict[int, ProgramBlock] = {}
        self._labels: dict[int, int] | None = None

    @classmethod
    def load(cls, path: Path) -> "PartProgram":
        """Return the program in a file. Raises GcodeError 0x4110 for a file that cannot be read,
        0x4111 for one in UTF-16 or UTF-32."""
        try:
            data = path.read_bytes()
        except OSError as fault:
            raise GcodeError(
                NcError.PROGRAM_OPEN, f"{fault.strerror}", program=str(path)
            ) from fault
        if _has_wide_characters(data):
            message = "the text is in UTF-16 or UTF-32, expected ASCII, Latin-1 or UTF-8"
            raise GcodeError(
                NcError.PROGRAM_SYNTAX_LOADING, message, program=path.name, line=1, index=0
            )
        return cls(data, path.name)

    def __len__(self) -> int:
        return len(self.lines)

    def block(self, line: int) -> ProgramBlock:
        """Return the block of a line, counted from 0. Raises `GcodeError` with line, column and
        word."""
        block = self._blocks.get(line)
        if block is None:
            text = self.lines[line]
            if len(text) > LONGEST_BLOCK:
                raise self._too_long(line)
            try:
                if "\0" in text:
                    raise WordRefused(
                        NcError.PROGRAM_SYNTAX_RUNNING, "a NUL byte inside a block", "\0"
                    )
                block = parse_block(text, self.original(line) if "#" in text else "")
            except WordRefused as refused:
                raise self.error(line, refused) from None
            if len(self._blocks) >= CACHED_BLOCKS:
                self._blocks.clear()
            self._blocks[line] = block
        return block

    def begins_subroutine(self, line: int, block: ProgramBlock) -> bool:
        """Return True if the line is the label of a subroutine of this file, not a call."""
        number = block.values.get("L")
        if not isinstance(number, float) or len(block.values) > 1 or block.number:
            return False
        return self.labels.get(int(number)) == line

    def original(self, line: int) -> str:
        """Return the text of a line as it was written."""
        start = self.starts[line]
        return self.text[start : start + len(self.lines[line])]

    def error(self, line: int, refused: WordRefused) -> GcodeError:
        """Return the error for refused input, with its place in the program."""
        line = min(line, len(self.lines) - 1)
        return GcodeError(
            refused.code,
            refused.message,
            program=self.name,
            line=line + 1,
            column=self.column(line, refused.word) + 1,
            index=self.starts[line],
            word=refused.word,
            text=self.original(line),
        )

    def _too_long(self, line: int) -> GcodeError:
        return GcodeError(
            NcError.PROGRAM_SYNTAX_RUNNING,
            f"the block has {len(self.lines[line])} characters, expected {LONGEST_BLOCK} at most",
            program=self.name,
            line=line + 1,
            index=self.starts[line],
            text=self.original(line)[:_SHOWN],
        )

    def column(self, line: int, word: str) -> int:
        """Return the column of a word in its line, from 0; the line's first character if it is not
        found."""
        text = self.lines[line]
        first = len(text) - len(text.lstrip())
        if not word:
            return min(first, max(len(text) - 1, 0))
        word = re.sub(r"\s+", "", word.upper())
        number = word[1:].lstrip("0") or "0"
        spelled = [r"\s*".join(map(re.escape, word))]
        if word[1:].isdecimal():
            spelled.insert(0, rf"{re.escape(word[0])}\s*0*{number}(?!\d)")
        for pattern in spelled:
            match = re.search(pattern, text)
            if match is not None:
                return match.start()
        return first

    def line_of(self, index: int) -> int:
        """Return the line, from 0, that the text index is in."""
        line = bisect_left(self.starts, index)
        if line < len(self.starts) and self.starts[line] == index:
            return line
        return max(line - 1, 0)

    def find_block(self, number: int, after: int, direction: str) -> int | None:
        """Return the line with this block number: "+" behind `after`, "-" before it, nearest first.

        A line may jump to itself backwards. Lines in comments do not count.
        """
        if len(str(number)) > _NUMBER_DIGITS:
            return None
        zeros = _NUMBER_DIGITS - len(str(number))
        wanted = re.compile(rf"N[ \t]*0{{0,{zeros}}}{number}(?!\d)")
        if direction == "-":
            end = min(after + 1, len(self.lines))
            while end > 0:
                begin = max(end - _LINES_AT_ONCE, 0)
                lines = list(self._numbered(wanted, begin, end))
                if lines:
                    return lines[-1]
                end = begin
            return None
        return next(self._numbered(wanted, after + 1, len(self.lines)), None)

    def _numbered(self, wanted: re.Pattern[str], begin: int, end: int) -> Iterator[int]:
        """Lines among these that begin with the block number."""
        if begin >= end:
            return
        last = self.starts[end] if end < len(self.starts) else len(self._upper)
        for match in wanted.finditer(self._upper, self.starts[begin], last):
            line = self.line_of(match.start())
            if _BEFORE_NUMBER.fullmatch(self._upper, self.starts[line], match.start()):
                yield line

    @property
    def labels(self) -> dict[int, int]:
        """Lines at which subroutines of this file begin, by number.

        A label is a line with nothing but `L<n>` behind the end of a program or subroutine.
        """
        if self._labels is None:
            self._labels = {}
            for match in _LABEL.finditer(self._upper):
                at = self.line_of(match.start())
                if self._upper[self.starts[at] : match.start()].strip(" \t"):
                    continue
                before = at - 1
                while before >= 0 and _NOTHING.fullmatch(self.lines[before]):
                    before -= 1
                if before >= 0 and _ends(self.lines[before]):
                    self._labels.setdefault(int(match[1]), at)
        return self._labels

    def begin(self, number: int) -> int:
        """Return the first line of this file as subroutine `number`: behind its `L<n>`, if it has
        one."""
        for at, line in enumerate(self.lines):
            if _NOTHING.fullmatch(line) or line.lstrip().startswith("%"):
                continue
            match = _LABEL.fullmatch(line)
            return at + 1 if match is not None and int(match[1]) == number else 0
        return 0


SubroutineSource = Callable[[int], PartProgram | None]
"""Gives the program of a subroutine by number, or None if there is none."""


def search_folders(folders: Sequence[Path | None]) -> SubroutineSource:
    """Subroutine n is `L<n>.NC` in the first of the folders that has it, in any case of letters.

    The documented order is: the optional path, the folder of the main program, the default folder.
    Source: tcnci, ItpSetSubroutinePathEx.
    """
    loaded: dict[int, PartProgram | None] = {}

    def find(number: int) -> PartProgram | None:
        if number not in loaded:
            loaded[number] = None
            for folder in folders:
                path = _find_file(folder, f"l{number}.nc")
                if path is not None:
                    loaded[number] = PartProgram.load(path)
                    break
        return loaded[number]

    return find


def _find_file(folder: Path | None, name: str) -> Path | None:
    if folder is None or not folder.is_dir():
        return None
    for path in sorted(folder.iterdir()):
        if path.name.lower() == name and path.is_file():
            return path
    return None
