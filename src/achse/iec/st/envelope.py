"""Sources in XML envelopes: `.TcPOU`, `.TcGVL`, `.TcDUT`, `.TcIO` and the task files `.TcTTO`.

The texts lie in CDATA parts: one declaration and one body for each unit, method, accessor and
action. Faults are told by their place in the file. A document with a DOCTYPE is refused, so that
nothing in it can grow or fetch anything.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple, TypeVar
from xml.parsers import expat

from achse.iec.st.lexer import Defines
from achse.iec.st.parser import Parsed, Parser
from achse.iec.st.source import Fault, Location, Piece, Source, SourceError
from achse.iec.st.tree import NO_NOTE
from achse.iec.st.units import (
    Accessor,
    Action,
    Body,
    Function,
    FunctionBlock,
    Interface,
    Method,
    Part,
    Program,
    Property,
    Unit,
)

__all__ = ["Element", "TaskDeclaration", "parse_envelope", "parse_xml", "read_task"]

P = TypeVar("P")

_DEEPEST = 64
_TEXTS = ("Declaration", "ST")


class Element:
    """An XML element: its text, and where the element and its text begin."""

    __slots__ = ("attributes", "children", "column", "line", "span", "tag", "text", "text_place")

    def __init__(self, tag: str, attributes: dict[str, str], line: int, column: int) -> None:
        self.tag = tag
        self.attributes = attributes
        self.line = line
        self.column = column
        self.text = ""
        self.text_place = (line, column)
        self.span = (0, 0)
        """Offsets of the text in the source made of the file."""
        self.children: list[Element] = []

    def find(self, *tags: str) -> "Element | None":
        """The first child, grandchild and so on of these tags."""
        found: Element | None = self
        for tag in tags:
            children = () if found is None else found.children
            found = next((child for child in children if child.tag == tag), None)
        return found

    def text_of(self, *tags: str) -> str:
        found = self.find(*tags)
        return "" if found is None else found.text.strip()

    def walk(self) -> Iterator["Element"]:
        """The element and all in it, in order of the file."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))


def parse_xml(data: bytes, path: str) -> Element:
    """The root of a document. Raises `SourceError`."""
    parser = expat.ParserCreate()
    stack: list[Element] = []
    roots: list[Element] = []

    def place() -> tuple[int, int]:
        return parser.CurrentLineNumber, parser.CurrentColumnNumber + 1

    def refuse(message: str) -> SourceError:
        return SourceError([Fault(Location(path, *place()), message)])

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(stack) >= _DEEPEST:
            raise refuse(f"elements nest deeper than {_DEEPEST}")
        element = Element(tag.rpartition(":")[2], attributes, *place())
        (stack[-1].children if stack else roots).append(element)
        stack.append(element)

    def text(content: str) -> None:
        if stack:
            element = stack[-1]
            if not element.text.strip():
                # Blanks around the CDATA part belong to the file, not to the source.
                element.text = ""
                element.text_place = place()
            element.text += content

    def doctype(*_: object) -> None:
        raise refuse("a DOCTYPE is not accepted")

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: stack.pop()
    parser.CharacterDataHandler = text
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(data, True)
    except expat.ExpatError as failure:
        place_ = Location(path, failure.lineno, failure.offset + 1)
        reason = f"no well-formed XML: {expat.ErrorString(failure.code)}"
        raise SourceError([Fault(place_, reason)]) from None
    except (LookupError, ValueError) as failure:
        reason = f"no well-formed XML: {failure}"
        raise SourceError([Fault(Location(path, 1, 1), reason)]) from None
    return roots[0]


class TaskDeclaration(NamedTuple):
    """A task as a `.TcTTO` declares it."""

    name: str
    cycle_ns: int
    priority: int
    programs: tuple[str, ...]


def read_task(root: Element, path: str) -> TaskDeclaration:
    """The task in a `.TcTTO`; its cycle is given in µs. Raises `SourceError`."""
    task = root.find("Task")
    if task is None:
        raise SourceError([_misses(root, "a <Task>", path)])
    cycle, priority = task.text_of("CycleTime"), task.text_of("Priority") or "20"
    for text in (cycle, priority):
        if not (text.isascii() and text.isdigit()) or len(text) > 9:
            raise SourceError([_misses(task, "<CycleTime> and <Priority> as whole numbers", path)])
    calls = [child for child in task.children if child.tag == "PouCall"]
    names = tuple(call.text_of("Name") for call in calls)
    return TaskDeclaration(
        task.attributes.get("Name", "PlcTask"), int(cycle) * 1000, int(priority), names
    )


def _misses(element: Element, expected: str, path: str) -> Fault:
    place = Location(path, element.line, element.column)
    return Fault(place, f"expected {expected} in <{element.tag}>")


def parse_envelope(root: Element, path: str, defines: Defines = ()) -> Parsed:
    """The units of a file and all that is wrong with it."""
    texts = [element for element in root.walk() if element.tag in _TEXTS]
    pieces = []
    start = 0
    for element in texts:
        element.span = (start, start + len(element.text))
        pieces.append(Piece(start, *element.text_place))
        start += len(element.text) + 1
    source = Source("\n".join(element.text for element in texts), path, pieces)
    return _Envelope(source, defines).parsed(root)


class _Envelope:
    """Puts units together from the texts of one file."""

    def __init__(self, source: Source, defines: Defines) -> None:
        self._source = source
        self._defines = defines
        self._faults: list[Fault] = []

    def parsed(self, root: Element) -> Parsed:
        units: list[Unit] = []
        for element in root.children:
            name = element.attributes.get("Name", "")
            if element.tag in ("GVL", "DUT", "EnumerationTextList"):
                units += self._list(element, name)
            elif element.tag == "POU":
                units += self._unit(element)
            elif element.tag == "Itf":
                units += self._interface(element)
        if not root.children:
            self._faults.append(_misses(root, "a <POU>, <GVL>, <DUT> or <Itf>", self._source.path))
        return Parsed(self._source, tuple(units), tuple(self._faults))

    def _parser(self, element: Element) -> Parser | None:
        declaration = element.find("Declaration")
        if declaration is None:
            self._faults.append(_misses(element, "a <Declaration>", self._source.path))
            return None
        return Parser(self._source, *declaration.span, self._defines)

    def _attempt(self, parser: Parser, read: Callable[[], P]) -> P | None:
        found = parser.attempt(read)
        self._faults += parser.faults
        return found

    def _list(self, element: Element, name: str) -> tuple[Unit, ...]:
        parser = self._parser(element)
        if parser is None:
            return ()
        return self._attempt(parser, lambda: parser.units(name)) or ()

    def _unit(self, element: Element) -> Iterator[Unit]:
        parser = self._parser(element)
        if parser is None:
            return
        unit = self._attempt(parser, lambda: _head(parser))
        body, parts = self._body(element), self._parts(element)
        if isinstance(unit, Function):
            yield replace(unit, body=body)
        elif unit is not None:
            yield replace(unit, body=body, parts=parts)

    def _interface(self, element: Element) -> Iterator[Interface]:
        parser = self._parser(element)
        if parser is None:
            return
        unit = self._attempt(parser, lambda: parser.interface(whole=False))
        parts = self._parts(element)
        if unit is not None:
            yield replace(unit, parts=parts)

    def _body(self, element: Element) -> Body:
        """The statements; None for a body in another language, () where there is none."""
        implementation = element.find("Implementation")
        if implementation is None or not implementation.children:
            return ()
        text = implementation.find("ST")
        if text is None:
            return None
        parser = Parser(self._source, *text.span, self._defines)
        return self._attempt(parser, parser.statements) or ()

    def _parts(self, element: Element) -> tuple[Part, ...]:
        parts: list[Part] = []
        for child in element.children:
            if child.tag == "Method":
                parts += self._method(child)
            elif child.tag == "Property":
                parts += self._property(child)
            elif child.tag == "Action":
                name = child.attributes.get("Name", "")
                parts.append(Action(name, self._body(child), NO_NOTE, child.span[0]))
        return tuple(parts)

    def _method(self, element: Element) -> Iterator[Method]:
        parser = self._parser(element)
        if parser is None:
            return
        method = self._attempt(parser, lambda: parser.method(whole=False))
        body = self._body(element)
        if method is not None:
            yield replace(method, body=body)

    def _property(self, element: Element) -> Iterator[Property]:
        parser = self._parser(element)
        if parser is None:
            return
        found = self._attempt(parser, lambda: parser.property(whole=False))
        get, set = self._accessor(element.find("Get")), self._accessor(element.find("Set"))
        if found is not None:
            yield replace(found, get=get, set=set)

    def _accessor(self, element: Element | None) -> Accessor | None:
        if element is None:
            return None
        declaration = element.find("Declaration")
        accessor: Accessor | None = Accessor((), (), (), NO_NOTE, 0)
        if declaration is not None:
            parser = Parser(self._source, *declaration.span, self._defines)
            accessor = self._attempt(parser, parser.accessor)
        body = self._body(element)
        return None if accessor is None else replace(accessor, body=body)


def _head(parser: Parser) -> Program | FunctionBlock | Function:
    kind = parser.kinds[parser.position]
    if kind == "FUNCTION_BLOCK":
        return parser.function_block(whole=False)
    if kind == "FUNCTION":
        return parser.function(whole=False)
    if kind == "PROGRAM":
        return parser.program(whole=False)
    raise parser.unexpected("PROGRAM, FUNCTION_BLOCK or FUNCTION")
