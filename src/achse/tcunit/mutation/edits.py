"""Edits of Structured Text that show a mutant: a piece of the source, and the text in its place."""

from bisect import bisect_left
from itertools import pairwise
from typing import Any, NamedTuple

from achse.iec.elementary import RealType
from achse.iec.times import LTIME, TIME, TimeType
from achse.st.lexis.lexer import BOOLEAN, END, INTEGER, REAL, TYPED, scan
from achse.st.lexis.source import Source
from achse.st.syntax.expressions import BINDING


class TextEdit(NamedTuple):
    """A piece of a source's text, and what is put in its place."""

    start: int
    end: int
    text: str


_OPENING = frozenset("([")
_CLOSING = frozenset(")]")
_HEADS = {"IF": "THEN", "ELSIF": "THEN", "WHILE": "DO"}
"""Words before a condition, and behind it."""
_STATEMENT_BOUNDS = frozenset(
    (
        *(";", ":", "IF", "ELSIF", "THEN", "ELSE", "END_IF", "WHILE", "DO", "END_WHILE"),
        *("REPEAT", "UNTIL", "END_REPEAT", "CASE", "OF", "END_CASE", "FOR", "END_FOR"),
        *("__TRY", "__CATCH", "__FINALLY", "__ENDTRY"),
    )
)
"""Tokens that end a statement, or are before one."""
_BOUNDS = _STATEMENT_BOUNDS | {",", ":=", "=>", "..", "RETURN", "EXIT", "CONTINUE", "TO", "BY"}
"""Tokens that end an expression on either side."""
_DURATIONS = {TIME: ("T#", "MS"), LTIME: ("LTIME#", "NS")}


class SourceEdits:
    """Edits of one source. Offsets are of tokens; an edit is None where the text is another."""

    def __init__(self, source: Source) -> None:
        self._text = source.text
        self._kinds: list[str] = []
        self._starts: list[int] = []
        self._words: list[str] = []
        begins = [piece.start for piece in source.pieces]
        for start, end in pairwise([*begins, len(source.text)]):
            tokens = scan(source.text, start, end)
            self._kinds += tokens.kinds
            self._starts += tokens.starts
            self._words += tokens.words

    def is_text(self, at: int) -> bool:
        """Return True if an offset is in text, not in a drawing."""
        return at <= len(self._text)

    def _index(self, at: int) -> int:
        """Return the number of the token at an offset; -1 if none begins there."""
        index = bisect_left(self._starts, at)
        while index < len(self._starts) and self._starts[index] == at:
            if self._kinds[index] is not END:
                return index
            index += 1
        return -1

    def word(self, at: int) -> str:
        """Return the operator or keyword at an offset, in capitals; empty if there is none."""
        index = self._index(at)
        return self._kinds[index] if index >= 0 else ""

    def _end(self, index: int) -> int:
        return self._starts[index] + len(self._words[index])

    # pieces ----------------------------------------------------------------------------------

    def replaced_word(self, at: int, text: str) -> TextEdit | None:
        """Another operator in place of the one at an offset."""
        index = self._index(at)
        return None if index < 0 else TextEdit(at, self._end(index), text)

    def replaced_setter(self, at: int, text: str) -> TextEdit | None:
        """`S=` or `R=`, of two tokens, in place of the other."""
        return None if self._index(at) < 0 else TextEdit(at, at + len(text), text)

    def without_word(self, at: int) -> TextEdit | None:
        """No operator before an operand."""
        index = self._index(at)
        return None if index < 0 else TextEdit(at, self._starts[index + 1], "")

    def without_statement(self, at: int) -> TextEdit | None:
        """No statement around an offset; a semicolon stays."""
        index = self._index(at)
        if index < 0:
            return None
        first = last = index
        while first > 0 and not self._bounds_statement(first - 1):
            first -= 1
        while not self._bounds_statement(last):
            last += 1
        return TextEdit(self._starts[first], self._starts[last], "")

    def _bounds_statement(self, index: int) -> bool:
        return self._kinds[index] in _STATEMENT_BOUNDS or self._kinds[index] is END

    def _condition(self, at: int) -> tuple[int, int] | None:
        """Begin and end of the condition behind the word at an offset."""
        index = self._index(at)
        closing = _HEADS.get(self._kinds[index]) if index >= 0 else None
        if closing is None:
            return None
        last = index + 1
        while self._kinds[last] not in (closing, END):
            last += 1
        return self._starts[index + 1], self._end(last - 1)

    def replaced_condition(self, at: int, text: str) -> TextEdit | None:
        """Another condition behind IF, ELSIF or WHILE."""
        span = self._condition(at)
        return None if span is None else TextEdit(*span, text)

    def negated_condition(self, at: int) -> TextEdit | None:
        """Return the condition behind IF, ELSIF or WHILE with a NOT before it."""
        span = self._condition(at)
        return None if span is None else TextEdit(*span, f"NOT ({self._text[slice(*span)]})")

    # operands --------------------------------------------------------------------------------

    def chain(self, at: int, count: int) -> list[int]:
        """Offsets of the same operator in a row of which the last is at `at`; none if they are not
        `count`."""
        index = self._index(at)
        if index < 0:
            return []
        kind = self._kinds[index]
        offsets, depth = [at], 0
        here = index - 1
        while len(offsets) < count and here >= 0:
            each = self._kinds[here]
            if each in _CLOSING:
                depth += 1
            elif each in _OPENING:
                depth -= 1
            if depth < 0 or (depth == 0 and each in _BOUNDS):
                break
            if depth == 0 and each == kind:
                offsets.insert(0, self._starts[here])
            elif depth == 0 and BINDING.get(each, 99) < BINDING.get(kind, 0):
                break
            here -= 1
        return offsets if len(offsets) == count else []

    def without_operand(self, places: list[int], number: int) -> tuple[TextEdit | None, str]:
        """No operand of that number in a chain of operators, and the operand; nothing if the
        operators are not known."""
        if not places:
            return None, ""
        if number == 0:
            operator = self._index(places[0])
            first = self._left(operator)
            end = self._starts[operator + 1]
            return TextEdit(self._starts[first], end, ""), self._between(first, operator - 1)
        operator = self._index(places[number - 1])
        last = self._index(places[number]) - 1 if number < len(places) else self._right(operator)
        # The blank before the operator goes with it.
        start = self._end(operator - 1)
        return TextEdit(start, self._end(last), ""), self._between(operator + 1, last)

    def _between(self, first: int, last: int) -> str:
        return " ".join(self._text[self._starts[first] : self._end(last)].split())

    def _left(self, operator: int) -> int:
        """Return the first token of the left operand."""
        power, depth, here = BINDING.get(self._kinds[operator], 0), 0, operator
        while here > 0:
            kind = self._kinds[here - 1]
            if kind in _CLOSING:
                depth += 1
            elif kind in _OPENING:
                depth -= 1
            if depth < 0 or kind is END:
                return here
            if depth == 0 and (kind in _BOUNDS or BINDING.get(kind, 99) < power):
                return here
            here -= 1
        return here

    def _right(self, operator: int) -> int:
        """Return the last token of the right operand."""
        power, depth, here = BINDING.get(self._kinds[operator], 0), 0, operator
        while True:
            kind = self._kinds[here + 1]
            if kind in _OPENING:
                depth += 1
            elif kind in _CLOSING:
                depth -= 1
            if depth < 0 or kind is END:
                return here
            if depth == 0 and (kind in _BOUNDS or BINDING.get(kind, 99) <= power):
                return here
            here += 1

    # literals --------------------------------------------------------------------------------

    def _literal(self, at: int) -> tuple[int, int]:
        """First and last token of a literal, which may have a sign; -1 if there is none."""
        first = last = self._index(at)
        if first >= 0 and self._kinds[first] == "-":
            last += 1
        if last < 0 or self._kinds[last] not in (INTEGER, REAL, BOOLEAN, TYPED):
            return -1, -1
        return first, last

    def literal(self, at: int) -> str:
        """Return the literal at an offset, as written."""
        first, last = self._literal(at)
        return self._text[at : self._end(last)] if first >= 0 else ""

    def replaced_literal(
        self, at: int, old: Any, value: int | float | bool, type: Any
    ) -> TextEdit | None:
        """Another value in place of the literal at an offset, if that is the old value."""
        first, last = self._literal(at)
        if first < 0:
            return None
        written = self._text[at : self._end(last)]
        if self._kinds[last] == INTEGER and "#" not in written:
            number = int("".join(written.split()).replace("_", ""))
            if number != old:
                return None  # another value of the same place, a stride say
        if isinstance(value, bool):
            text = str(value).upper()
        elif isinstance(type, RealType):
            text = _real(float(value))
        elif isinstance(type, TimeType):
            if type not in _DURATIONS or self._kinds[last] != TYPED:
                return None
            head, unit = _DURATIONS[type]
            text = f"{head}{value}{unit}"
        else:
            base = written.partition("#")[0] if "#" in written else ""
            text = str(value)
            if base in ("2", "8", "10", "16") and value < 0:
                return None  # a bit pattern
            if base in ("2", "8", "10", "16"):
                text = f"{base}#{_in_base(int(value), int(base))}"
            elif self._kinds[last] == TYPED and base.isidentifier():
                text = f"{base}#{value}"
        return TextEdit(at, self._end(last), text)


def _real(value: float) -> str:
    text = repr(value)
    return text if "e" in text or "." in text else f"{text}.0"


def _in_base(value: int, base: int) -> str:
    return format(value, {2: "b", 8: "o", 10: "d", 16: "X"}[base])
