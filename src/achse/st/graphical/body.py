"""A body drawn in LD, FBD, IL, SFC or CFC: its text in the file, and the statements it means.

The text is kept packed and is read when the body is compiled: a large project has a hundred
megabytes of them. Offsets of its nodes follow the text of their source; a body knows the line
in the file and the place in the drawing, `network 3, rung 1`, for each.
"""

import hashlib
import zlib
from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple, Protocol

from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.tree import Statements, TypeSpec, VarBlock


class Refused(Exception):
    """A body has something that is not supported; it does not run, and its variables are there."""

    def __init__(self, at: int, message: str, code: Code) -> None:
        super().__init__(message)
        self.at = at
        self.message = message
        self.code = code


@dataclass(slots=True, eq=False)
class BodyOwner:
    """The unit that a body belongs to."""

    unit: str = ""
    part: str = ""
    """Name of the action, method or transition; empty for the body of the unit itself."""
    keeps_memory: bool = True
    """False for functions, methods and transitions."""
    result: str = ""
    """Name of the condition that a transition assigns; empty for other routines."""
    actions: Mapping[str, str] = field(default_factory=dict)
    """Actions of the unit as written, by their names in lower case."""
    variables: Mapping[str, TypeSpec] = field(default_factory=dict)
    """Types of the variables that the unit declares, by their names in lower case."""
    transitions: frozenset[str] = frozenset()
    """Transition objects of the unit, in lower case."""


class UnitPins(NamedTuple):
    """Pins of a unit in the order of their declarations."""

    kind: str
    """`FunctionBlock`, `Function` or `Program`."""
    inputs: tuple[str, ...]
    """VAR_INPUT, then VAR_IN_OUT."""
    outputs: tuple[str, ...]
    """The result of a function first, with its name; then VAR_OUTPUT."""


class BodyScope(Protocol):
    """Names around a body, as far as its lowering depends on them."""

    def is_callable(self, name: str) -> bool:
        """Return True if a name means an action, method, function or program."""

    def pins(self, name: str) -> UnitPins | None:
        """Return the pins of a unit; None for any other name."""


class _NoScope:
    """Nothing is known."""

    def is_callable(self, name: str) -> bool:
        return False

    def pins(self, name: str) -> UnitPins | None:
        return None


class GraphicalBody:
    """A body that is not Structured Text."""

    def __init__(
        self, language: str, text: bytes, start: int, line: int, settings: bytes = b""
    ) -> None:
        self.language = language
        """NWL, SFC, CFC, LADDER or StateChart, as in the file."""
        self.start = start
        """Offset of its first sign in the source."""
        self.line = line
        """Line of its first sign in the file."""
        self.owner = BodyOwner()
        self._packed = zlib.compress(settings + b"\0" + text, 1)
        self._places: dict[int, str] = {}
        self.digest = hashlib.blake2b(text + b"\0" + settings, digest_size=20).digest()

    def __repr__(self) -> str:
        return f"<{self.language} body at {self.start}>"

    @property
    def text(self) -> str:
        """The element in the file."""
        return self._unpacked[1]

    @property
    def settings(self) -> str:
        """Settings of the editor for the unit or part; empty without any."""
        return self._unpacked[0]

    @property
    def _unpacked(self) -> tuple[str, str]:
        settings, _, text = zlib.decompress(self._packed).partition(b"\0")
        return settings.decode("utf-8", "replace"), text.decode("utf-8", "replace")

    @cached_property
    def implicit_variables(self) -> tuple[VarBlock, ...]:
        """Variables that the unit keeps for the body: memories of edges, steps, flags."""
        from achse.st.graphical.lowering import implicit_variables  # reads expressions

        return implicit_variables(self)

    def statements(self, scope: BodyScope) -> Statements:
        """Return the statements that the body means. Raises `Refused` and `Unexpected`."""
        from achse.st.graphical.lowering import lowered

        return lowered(self, scope)

    @property
    def readable_statements(self) -> Statements:
        """The statements, without knowledge of other units; none if it cannot be read."""
        try:
            return self.statements(_NoScope())
        except (Refused, Unexpected):
            return ()

    # places ------------------------------------------------------------------------------------

    def name_place(self, at: int, place: str) -> int:
        """Name the place of a node by its offset in the text; return the offset in the source."""
        self._places[at] = place
        return self.start + at

    def place(self, offset: int) -> str:
        """Return the place of an offset in the drawing: `network 3, rung 1`; empty if it has no
        name."""
        at = offset - self.start
        place = self._places.get(at)
        if place is not None:
            return place
        known = sorted(self._places)
        index = bisect_right(known, at)
        return self._places[known[index - 1]] if index else ""

    def locate(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset in the file."""
        at = offset - self.start
        before = bisect_right(self._breaks, at - 1)
        column = at - (self._breaks[before - 1] if before else -1)
        return self.line + before, max(1, column)

    def offset_at(self, line: int, column: int) -> int | None:
        """Return the offset of a line and column of the file; None outside of the drawing."""
        breaks, below = self._breaks, line - self.line
        if not 0 < below <= len(breaks):  # the first line begins with the element's tag
            return None
        at = breaks[below - 1] + column
        end = breaks[below] if below < len(breaks) else len(self.text)
        return None if at > end else self.start + at

    @cached_property
    def _breaks(self) -> list[int]:
        text = self.text
        indexes = []
        index = text.find("\n")
        while index >= 0:
            indexes.append(index)
            index = text.find("\n", index + 1)
        return indexes
