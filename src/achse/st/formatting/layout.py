"""Layout of Structured Text: the beginning and the end of each line.

A line inside of IF, FOR, CASE or VAR begins one level deeper than the line of that word. What
stands directly in a unit, a method or a file keeps the place of the first line of its kind there,
so that both usual styles stay. A line that continues a statement moves with its first line.
Comments of several lines, and lines that begin with a pragma, are left alone, and so are texts
in which words and their ends do not fit.
"""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from achse.st.formatting.options import FormatOptions
from achse.st.lexis.lexer import BLANK, COMMENT, LITERALS, NAME, PRAGMA, raw_words
from achse.st.lexis.words import KEYWORDS, SECTIONS

_STATEMENTS = {
    "IF": "END_IF",
    "CASE": "END_CASE",
    "FOR": "END_FOR",
    "WHILE": "END_WHILE",
    "REPEAT": "END_REPEAT",
    "__TRY": "__ENDTRY",
    "STRUCT": "END_STRUCT",
    "UNION": "END_UNION",
    **dict.fromkeys(SECTIONS, "END_VAR"),
}
"""Words that begin a level, and the words that end it."""
_UNITS = {
    word: f"END_{word}"
    for word in (
        *("ACTION", "FUNCTION", "FUNCTION_BLOCK", "INTERFACE", "METHOD", "NAMESPACE", "PROGRAM"),
        *("PROPERTY", "TYPE", "GET", "SET"),
    )
}
_ENDS = frozenset((*_STATEMENTS.values(), *_UNITS.values()))
_MIDDLE = frozenset(("ELSE", "ELSIF", "UNTIL", "__CATCH", "__FINALLY"))
_OPEN = frozenset(("THEN", "DO", "ELSE", "REPEAT", "OF", "__TRY", "__FINALLY", "STRUCT", "UNION"))
"""Words behind which a statement begins."""
_MAY_BE_OPEN = frozenset(_UNITS) - {"TYPE", "NAMESPACE", "GET", "SET"}
"""Words without their end in an XML file, whose parts are texts of their own."""
_INDENT = 4
_IN_HEADS = frozenset(("EXTENDS", "IMPLEMENTS", ":", ","))
"""Words that begin a further line of a head."""
_ATTRIBUTE = re.compile(r"\{\s*attribute\b", re.IGNORECASE)
"""Pragma that stands as what it belongs to; others may be anywhere."""
_ASIDE = (BLANK, COMMENT, PRAGMA)
_SPACED = frozenset((":=", "=>", "<=", ">=", "<>", "+", "-", "*", "/", "=", "**"))


@dataclass(slots=True)
class _Level:
    """A word that began a level."""

    word: str
    indent: str
    """Blanks before the line of the word."""
    bases: dict[str, str] = field(default_factory=dict)
    """Blanks before the first line of each kind, directly in a unit."""
    label: str | None = None
    """Blanks before the labels of a CASE."""
    is_in_label: bool = False


@dataclass(slots=True)
class _Line:
    """A line: its blanks in front, its words, and what ends it."""

    blanks: str
    words: list[tuple[str, str]]
    end: str
    is_free: bool = True
    """False if the line begins inside of a comment or text."""


class _Unbalanced(Exception):
    """Words and their ends do not fit."""


def formatted(text: str, options: FormatOptions | None = None) -> str:
    """Return a text with the layout that its words and the options require.

    Its words stay as they are, but for the case of keywords if the options change it.
    """
    options = options or FormatOptions()
    words = raw_words(text)
    if words is None:
        return text
    lines = _lines(words)
    indent = options.indent if options.indent is not None else indent_of([text])
    unit = " " * (_INDENT if indent is None else indent) or "\t"
    try:
        indents = _Indents(lines, unit).all()
    except _Unbalanced:
        indents = [line.blanks for line in lines]
    return "".join(
        f"{indent}{_spelled(line, options)}{line.end}"
        for indent, line in zip(indents, lines, strict=True)
    )


def _lines(words: Sequence[tuple[str, str]]) -> list[_Line]:
    """Return the words by lines. A comment of several lines ends lines that are not free."""
    lines = [_Line("", [], "")]
    for kind, word in words:
        pieces = re.split(r"(\r\n|\n|\r)", word) if "\n" in word or "\r" in word else [word]
        for number, piece in enumerate(pieces):
            if number % 2:
                lines[-1].end = piece
                lines.append(_Line("", [], "", kind == BLANK))
            elif piece and kind == BLANK and not lines[-1].words and lines[-1].is_free:
                lines[-1].blanks += piece
            elif piece:
                lines[-1].words.append((kind, piece))
    for line, following in pairwise(lines):  # the last one has no end
        if not following.is_free:
            continue  # blanks at the end are in a comment
        while line.words and line.words[-1][0] == BLANK:
            line.words.pop()
        if line.words and line.words[-1][1].startswith("//"):
            line.words[-1] = (COMMENT, line.words[-1][1].rstrip())
        if not line.words and line.is_free:
            line.blanks = ""
    return lines


def indent_of(texts: Iterable[str]) -> int | None:
    """Return the blanks of one level that texts have most, 0 for a tab; None if they have none."""
    steps: Counter[int] = Counter()
    for text in texts:
        before = ""
        for line in _lines(raw_words(text) or ()):
            if not line.words or not line.is_free:
                continue
            if line.blanks.startswith(before) and len(line.blanks) > len(before):
                step = line.blanks[len(before) :]
                steps[0 if step[0] == "\t" else len(step)] += 1
            before = line.blanks
    return steps.most_common(1)[0][0] if steps else None


class _Indents:
    """Walks through the lines of a text and finds the blanks in front of each."""

    def __init__(self, lines: Sequence[_Line], unit: str) -> None:
        self._lines = lines
        self._unit = unit
        self._levels = [_Level("", "")]
        self._depth = 0
        """Open brackets."""
        self._is_begin = True
        """True where a statement or declaration begins."""
        self._moved = ("", "")
        """Blanks of the first line of the statement, before and now."""
        self._is_heading = False
        """True in a head, which ends with its line."""

    def all(self) -> list[str]:
        """Return the blanks of all lines. Raises `_Unbalanced`."""
        blanks = [self._indent(number, line) for number, line in enumerate(self._lines)]
        if self._depth or any(one.word not in _MAY_BE_OPEN for one in self._levels[1:]):
            raise _Unbalanced
        return blanks

    def _indent(self, number: int, line: _Line) -> str:
        if not line.words:
            return line.blanks
        if self._is_heading and not self._depth and _has_code(line):
            self._is_heading = line.words[0][1].upper() in _IN_HEADS
            self._is_begin |= not self._is_heading
        if not line.is_free:
            self._read(line, line.blanks)
            return line.blanks
        kind, word = line.words[0]
        if kind == PRAGMA and not _ATTRIBUTE.match(word):
            indent = line.blanks
        elif kind in (COMMENT, PRAGMA) and not _has_code(line):
            is_apart = self._is_begin or self._is_heading
            indent = self._comment(number, line) if is_apart else self._continued(line)
        elif self._is_begin and not self._depth:
            indent = self._begun(line, kind, word.upper())
            self._moved = line.blanks, indent
        else:
            indent = self._continued(line)
        self._read(line, indent)
        return indent

    def _continued(self, line: _Line) -> str:
        before, now = self._moved
        if line.blanks.startswith(before):
            return now + line.blanks[len(before) :]
        return line.blanks

    def _comment(self, number: int, line: _Line) -> str:
        """A comment stands as the code below it; at the end of a level as what is in the level."""
        for following in self._lines[number + 1 :]:
            if not following.words or not following.is_free or not _has_code(following):
                continue
            kind, word = next(one for one in following.words if one[0] not in _ASIDE)
            level = self._levels[-1]
            if word.upper() in _ENDS or word.upper() in _MIDDLE or _is_label(following):
                if level.word in _STATEMENTS:
                    inner = self._inside(level, "statement", line)
                    # as the word below, if it stands there now
                    return line.blanks if line.blanks == level.indent else inner
                break
            return self._inside(level, _class_of(kind, word.upper()), following)
        return line.blanks

    def _begun(self, line: _Line, kind: str, word: str) -> str:
        level = self._levels[-1]
        if word in _ENDS:
            return self._opener(word).indent
        if word in _MIDDLE:
            if level.word == "CASE" and level.label is not None:
                is_deeper = len(line.blanks) > len(level.indent)
                level.label = level.label if is_deeper else level.indent
                return level.label
            return level.indent
        if level.word == "CASE" and _is_label(line):
            if level.label is None:
                is_deeper = len(line.blanks) > len(level.indent)
                level.label = level.indent + self._unit if is_deeper else level.indent
            level.is_in_label = True
            return level.label
        return self._inside(level, _class_of(kind, word), line)

    def _inside(self, level: _Level, kind: str, line: _Line) -> str:
        """Return the blanks of a line directly in a level."""
        if level.word == "CASE" and level.label is not None:
            return level.label + self._unit
        if level.word in _STATEMENTS:
            return level.indent + self._unit
        return level.bases.setdefault(kind, line.blanks)

    def _opener(self, end: str) -> _Level:
        for level in reversed(self._levels):
            if end == _STATEMENTS.get(level.word) or end == _UNITS.get(level.word):
                return level
        raise _Unbalanced

    # words -----------------------------------------------------------------------------------

    def _read(self, line: _Line, indent: str) -> None:
        """Follow the words of a line."""
        label = _label_end(line) if self._levels[-1].word == "CASE" and self._is_begin else -1
        for index, (kind, word) in enumerate(line.words):
            if kind in _ASIDE:
                continue
            upper = word.upper()
            if word in "([":
                self._depth += 1
            elif word in ")]":
                self._depth -= 1
                if self._depth < 0:
                    raise _Unbalanced
            is_head = self._is_begin and not self._depth
            if upper in _ENDS and (kind != NAME or self._opens(upper)):
                self._end(upper)
            elif upper in ("STRUCT", "UNION") and not self._depth:
                self._levels.append(_Level(upper, indent))
            elif (is_head and upper in _STATEMENTS) or (upper in SECTIONS and not self._depth):
                self._levels.append(_Level(upper, indent))
                self._is_heading = upper in SECTIONS
            elif is_head and upper in _UNITS and self._is_unit(upper):
                self._close_open_units(upper)
                self._levels.append(_Level(upper, indent))
                self._is_heading = True
            self._is_begin = self._begins_behind(upper, is_label=index == label)

    def _opens(self, end: str) -> bool:
        """Return True if a word that may be a name ends a level here."""
        return any(end == _UNITS.get(level.word) for level in self._levels)

    def _is_unit(self, word: str) -> bool:
        """Return True if GET or SET, which may be names, begin an accessor."""
        return word not in ("GET", "SET") or self._levels[-1].word == "PROPERTY"

    def _close_open_units(self, word: str) -> None:
        """End a unit that has no end: the next one begins."""
        if self._levels[-1].word in ("METHOD", "PROPERTY", "ACTION") and word in (
            "METHOD",
            "PROPERTY",
            "ACTION",
        ):
            self._levels.pop()

    def _end(self, end: str) -> None:
        while len(self._levels) > 1:
            level = self._levels.pop()
            if end in (_STATEMENTS.get(level.word), _UNITS.get(level.word)):
                return
            if level.word not in _MAY_BE_OPEN:
                break
        raise _Unbalanced

    def _begins_behind(self, word: str, *, is_label: bool) -> bool:
        """Return True if a statement, declaration or unit begins behind a word."""
        if self._depth:
            return False
        if word == "OF":
            return self._levels[-1].word == "CASE"
        return is_label or word == ";" or word in _OPEN or word in _ENDS or word in SECTIONS


def _has_code(line: _Line) -> bool:
    return any(kind not in _ASIDE for kind, _ in line.words)


def _class_of(kind: str, word: str) -> str:
    """Return the class of a line directly in a unit or file."""
    if word in SECTIONS:
        return "section"
    return "unit" if word in _UNITS and kind != NAME else "statement"


def _is_label(line: _Line) -> bool:
    return _label_end(line) >= 0


def _label_end(line: _Line) -> int:
    """Return the index of the colon if a line begins with a label of a CASE; else -1."""
    for index, (kind, word) in enumerate(line.words):
        if word == ":":
            return index
        if kind in (BLANK, COMMENT, NAME) or kind in LITERALS:
            continue
        if word not in (",", "..", ".", "-", "+", "^"):
            break
    return -1


# words of a line ----------------------------------------------------------------------------------


def _spelled(line: _Line, options: FormatOptions) -> str:
    """Return the words of a line as the options require."""
    if options.keywords == "keep" and not options.operators:
        return "".join(word for _, word in line.words)
    words: list[str] = []
    last = ""
    for kind, word in line.words:
        if options.keywords != "keep" and kind in KEYWORDS and word.upper() == kind:
            word = kind if options.keywords == "upper" else kind.lower()
        if options.operators and kind in _SPACED and _is_binary(kind, last):
            if words and not words[-1][-1:].isspace():
                words.append(" ")
            words += [word, " "]
            last = kind
            continue
        if kind == BLANK and words and words[-1] == " " and last in _SPACED:
            words[-1] = word  # more blanks align it
            continue
        words.append(word)
        if kind not in (BLANK, COMMENT):
            last = kind
    if words and words[-1] == " " and last in _SPACED:
        words.pop()  # no blank behind an operator that ends a line
    return "".join(words)


def _is_binary(sign: str, before: str) -> bool:
    """Return True if a sign is between two operands."""
    return sign not in "+-*" or before == NAME or before in LITERALS or before in (")", "]", "^")
