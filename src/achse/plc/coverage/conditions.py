"""Conditions of decisions: as they are written, how often they were TRUE and FALSE, and which were
shown to decide alone (masking MC/DC)."""

from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from achse.plc.lowering.decisions import DecisionShape
from achse.st.lexis.lexer import END, scan
from achse.st.lexis.source import Source

_LOGIC = frozenset(("AND", "OR", "XOR", "NOT", "AND_THEN", "OR_ELSE"))
_BOUNDS = frozenset(
    (
        *(";", ",", ":", ":=", "=>", "..", "IF", "ELSIF", "THEN", "ELSE", "WHILE", "DO", "UNTIL"),
        *("END_REPEAT", "CASE", "OF", "FOR", "TO", "BY", "RETURN", "REPEAT", END),
    )
)
_LONGEST = 60


class ConditionHits(NamedTuple):
    """One condition of a decision."""

    name: str
    """Source text; `condition 2` of a drawing."""
    true: int
    false: int
    alone_true: int
    """Times that it was TRUE and nothing masked it."""
    alone_false: int
    is_shown: bool
    """True if two vectors show that it decides alone."""

    @property
    def gap(self) -> str:
        """The gap in words; empty if there is none."""
        if self.is_shown:
            return ""
        if not self.true or not self.false:
            never = " or ".join(
                word for word, count in (("TRUE", self.true), ("FALSE", self.false)) if not count
            )
            return f"{self.name} never {never}"
        return f"{self.name} never decides"


@dataclass(frozen=True)
class DecisionHits:
    """A decision of two conditions or more."""

    line: int
    """Line of the statement or ELSIF in the file."""
    place: str
    """Place in a drawing; empty in text."""
    shape: DecisionShape
    names: tuple[str, ...]
    """Conditions as they are written."""
    hits: tuple[int, ...]
    """Hits of each vector of the shape."""

    @cached_property
    def conditions(self) -> tuple[ConditionHits, ...]:
        """The conditions in the order of the text."""
        return tuple(self._condition(number) for number in range(self.shape.count))

    @cached_property
    def seen(self) -> list[int]:
        """Vectors that have come."""
        return [number for number, count in enumerate(self.hits) if count]

    def _condition(self, number: int) -> ConditionHits:
        counts = {True: [0, 0], False: [0, 0]}
        for vector, count in zip(self.shape.vectors, self.hits, strict=True):
            value = vector.values[number]
            if value is not None:
                counts[value][0] += count
                counts[value][1] += count * (number in vector.unmasked)
        return ConditionHits(
            self.names[number],
            counts[True][0],
            counts[False][0],
            counts[True][1],
            counts[False][1],
            self.shape.pair(number, self.seen) is not None,
        )


class ConditionTexts:
    """Texts of conditions of one source."""

    def __init__(self, source: Source) -> None:
        self._source = source
        self._kinds: list[str] | None = None
        self._starts: list[int] = []
        self._words: list[str] = []

    def _scan(self) -> list[str]:
        if self._kinds is None:
            self._kinds = []
            begins = [piece.start for piece in self._source.pieces]
            text = self._source.text
            for start, end in zip(begins, [*begins[1:], len(text)], strict=True):
                tokens = scan(text, start, end)
                self._kinds += tokens.kinds
                self._starts += tokens.starts
                self._words += tokens.words
        return self._kinds

    def of(self, at: int, number: int) -> str:
        """Return the condition around an offset; of a drawing its number, from 0, in words."""
        if at > len(self._source.text):
            return f"condition {number + 1}"
        kinds = self._scan()
        here = bisect_right(self._starts, at) - 1
        while here > 0 and kinds[here] is END:
            here -= 1
        first, last = self._edge(here, -1), self._edge(here, 1)
        end = self._starts[last] + len(self._words[last])
        text = " ".join(self._source.text[self._starts[first] : end].split())
        return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"

    def _edge(self, here: int, step: int) -> int:
        """Return the outermost token of a condition, in one direction."""
        kinds = self._kinds or []
        opening, closing = ("([", ")]") if step > 0 else (")]", "([")
        depth = 1 if kinds[here] in opening else 0
        while 0 <= here + step < len(kinds):
            kind = kinds[here + step]
            if depth == 0 and (kind in closing or kind in _LOGIC or kind in _BOUNDS):
                break
            depth += (kind in opening) - (kind in closing)
            here += step
        return here
