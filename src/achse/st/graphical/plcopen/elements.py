"""Elements of a diagram in PLCopen XML: by number, with their places and connections.

Source: PLCopen TC6 XML schema 2.01.
"""

import re
from collections.abc import Iterator

from achse.st.lexis.codes import Code
from achse.st.lexis.source import SourceError
from achse.st.lexis.xml import Element, parse_xml
from achse.st.syntax.cursor import Unexpected

_TAG = re.compile(r"<([\w:]+)")
_ALONE = re.compile(r"<[^<>]*/>")


class DiagramElements:
    """The elements of a diagram, in order of the file. Raises `Unexpected` for no diagram."""

    def __init__(self, text: str) -> None:
        closed = _closed(text)
        try:
            self.root = parse_xml(closed.encode(), "diagram")
        except SourceError as error:
            raise Unexpected(0, error.faults[0].message, Code.BAD_DRAWING) from None
        self.closed = closed
        """The whole text of the diagram."""
        self.condition: dict[str, str] = {}
        """Number of the transition whose condition alone counts, and name for its value."""
        if self.root.tag == "condition" and self.root.children:
            self.condition = self.root.attributes
            self.root = self.root.children[0]
        self._lines = [0]
        place = text.find("\n")
        while place >= 0:
            self._lines.append(place + 1)
            place = text.find("\n", place + 1)
        self.by_id: dict[str, Element] = {}
        for element in self.root.children:
            key = element.attributes.get("localId")
            if key is not None:
                self.by_id[key] = element

    def at(self, element: Element) -> int:
        """Offset of an element in the text."""
        location = element.location
        return self._lines[min(location.line, len(self._lines)) - 1] + location.column - 1

    def fault(
        self, element: Element, message: str, code: Code = Code.UNSUPPORTED_DRAWING
    ) -> Unexpected:
        """Return the fault at an element."""
        return Unexpected(self.at(element), message, code)

    def position(self, element: Element) -> tuple[int, int]:
        """Left and top of an element."""
        position = element.find("position")
        attributes = {} if position is None else position.attributes
        left, top = (attributes.get(key, "0") for key in "xy")
        return _number(left), _number(top)


def _closed(text: str) -> str:
    """Return a skipped element as the reader of XML gives it, with its end tag; one without content
    has no text."""
    text = text.rstrip() or "<none/>"
    tag = _TAG.match(text)
    if tag is None or text.endswith(f"</{tag[1]}>") or _ALONE.fullmatch(text):
        return text
    return f"{text}</{tag[1]}>"


def _number(text: str) -> int:
    try:
        return int(float(text))
    except (ValueError, OverflowError):
        return 0


def connections_of(element: Element | None) -> Iterator[tuple[str, str]]:
    """Yield numbers of the elements that lead to a `connectionPointIn`'s owner, and their
    outputs."""
    point = None if element is None else element.find("connectionPointIn")
    for connection in point.all("connection") if point is not None else ():
        attributes = connection.attributes
        yield attributes.get("refLocalId", ""), attributes.get("formalParameter", "")
