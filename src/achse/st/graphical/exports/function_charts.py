"""Continuous function charts in `.EXP`: an element after the other, with numbers for its sources.

A pin is the number of its element and its place among the pins there; pins have no names.

Source: exports in public repositories. Types of elements that were not seen are refused by name.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

from achse.st.graphical.boxes import call_of_operator
from achse.st.graphical.function_charts import (
    ChartBox,
    ChartInput,
    ChartOutput,
    ChartPin,
    FunctionChart,
    Ordered,
)
from achse.st.lexis.codes import Code
from achse.st.lexis.literals import whole_number
from achse.st.syntax.cursor import Unexpected

_LINE = re.compile(r"^[ \t]*(_\w+)(?::[ \t]*(.*?))?[ \t]*\r?$", re.MULTILINE)
_PLACES = 1 << 10
"""Pins that an element may have."""
_INPUTS = 1 << 9
_NONE = -(10**18)
_STORING = {"_NONE": "None", "_SET": "Set", "_RESET": "Reset"}


class _Line(NamedTuple):
    word: str
    value: str
    at: int


def read_exported_function_chart(text: str) -> FunctionChart:
    """Return the chart of a body. Raises `Unexpected` for what was not seen."""
    inputs: list[ChartInput] = []
    ordered: list[Ordered] = []
    sources: list[tuple[int, int]] = []
    for lines in _elements(text):
        element = _Element(lines)
        match element.facts.get("_TYPE"):
            case "_INPUT":
                inputs.append(
                    ChartInput(element.facts.get("_TEXT", ""), element.output(0, "0"), element.at)
                )
            case "_OUTPUT":
                ordered.append(element.written())
            case "_BOX":
                ordered.append(element.box())
            case "_COMMENT":
                continue
            case type:
                raise Unexpected(
                    element.at,
                    f"'{str(type)[:40]}' is not supported in a chart",
                    Code.UNSUPPORTED_DRAWING,
                )
        sources += element.sources
    return FunctionChart(tuple(inputs), tuple(ordered), tuple(sources), False)


def _elements(text: str) -> Iterator[list[_Line]]:
    """Return the lines of each element: `_ELEMENT`, its facts, groups of pins, `_END`."""
    element: list[_Line] = []
    depth = 0
    for match in _LINE.finditer(text):
        line = _Line(match[1], match[2] or "", match.start(1))
        if line.word == "_ELEMENT" and not depth:
            element = []
        if line.word in ("_ELEMENT", "_IN", "_OUT"):
            depth += 1
        element.append(line)
        if line.word == "_END":
            depth -= 1
            if depth == 0:
                yield element
    if depth > 0:
        raise Unexpected(element[0].at, "an element is not closed", Code.BAD_DRAWING)


class _Element:
    """One element: its own facts, and those of each of its pins."""

    def __init__(self, lines: list[_Line]) -> None:
        self.at = lines[0].at
        self.facts: dict[str, str] = {}
        self.sources: list[tuple[int, int]] = []
        """Pins that are connected: `(destination, source)`."""
        self._pins: dict[str, list[dict[str, str]]] = {"_IN": [], "_OUT": []}
        facts = self.facts
        for line in lines[1:]:
            if line.word in self._pins:
                facts = {}
                self._pins[line.word].append(facts)
            elif line.word == "_END":
                facts = self.facts
            else:
                facts[line.word] = line.value
        self.id = self._number(self.facts, "_ID")

    def _number(self, facts: dict[str, str], key: str) -> int:
        text = facts.get(key, "")
        number = whole_number(text, _NONE)
        if number == _NONE:
            raise Unexpected(
                self.at, f"expected {key}: NUMBER, got '{text[:40]}'", Code.BAD_DRAWING
            )
        return number

    @property
    def _bounds(self) -> tuple[int, int]:
        left, _, top = self.facts.get("_POS", "").partition(",")
        return whole_number(left), whole_number(top)

    def output(self, number: int, negated: str) -> ChartPin:
        return ChartPin(self.id * _PLACES + number, "", negated == "1")

    def _input(self, number: int, facts: dict[str, str]) -> ChartPin:
        pin = ChartPin(self.id * _PLACES + _INPUTS + number, "", facts.get("_NEGATE") == "1")
        source = self._number(facts, "_INPUTID")
        if source >= 0:
            place = self._number(facts, "_INPUTIDX")
            self.sources.append((pin.id, source * _PLACES + place))
        return pin

    def written(self) -> ChartOutput:
        storing = _STORING.get(self.facts.get("_SETRESET", "_NONE"))
        if storing is None:
            raise Unexpected(
                self.at,
                f"_SETRESET {self.facts['_SETRESET'][:20]} is not supported",
                Code.UNSUPPORTED_DRAWING,
            )
        pin = self._input(0, self.facts)
        return ChartOutput(self.facts.get("_TEXT", ""), pin, storing, self._bounds, self.at)

    def box(self) -> ChartBox:
        inputs = tuple(self._input(number, one) for number, one in enumerate(self._pins["_IN"]))
        outputs = tuple(
            self.output(number, one.get("_NEGATE", "0"))
            for number, one in enumerate(self._pins["_OUT"])
        )
        type = self.facts.get("_TYPENAME", "")
        if self.facts.get("_ENENO", "0") != "0":
            raise Unexpected(
                self.at,
                f"the box {type[:80]} shows EN and ENO: not supported here",
                Code.UNSUPPORTED_DRAWING,
            )
        instance = self.facts.get("_INSTANCENAME", "")
        call = "FunctionBlock" if self.facts.get("_INSTANCE") == "1" else "Function"
        if call == "Function" and call_of_operator(type):
            call = "Operator"
        return ChartBox(call, type, instance, inputs, outputs, False, self._bounds, self.at)
