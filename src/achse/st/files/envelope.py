"""Sources in XML envelopes: `.TcPOU`, `.TcGVL`, `.TcDUT`, `.TcIO` and the task files `.TcTTO`.

The texts are in CDATA parts: one declaration and one body for each unit, method, accessor, action
and transition. Bodies in other languages than Structured Text are kept as they are in the file.
Faults have their place in the file.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple, TypeVar

from achse.st.files.owners import with_drawn_bodies
from achse.st.graphical.body import GraphicalBody
from achse.st.lexis.codes import Code
from achse.st.lexis.lexer import Defines
from achse.st.lexis.source import Diagnostic, Source, SourceSegment
from achse.st.lexis.xml import Element
from achse.st.syntax.nodes import changed
from achse.st.syntax.parser import Parsed, Parser
from achse.st.syntax.tree import NO_NOTE, Assign, Expression, Name, NamedType
from achse.st.syntax.units import (
    Accessor,
    Action,
    Body,
    Function,
    FunctionBlock,
    GlobalList,
    Interface,
    Method,
    Part,
    Program,
    Property,
    Unit,
)

P = TypeVar("P")

_TEXTS = ("Declaration", "ST")

_EDITORS = frozenset(("NWL", "CFC", "SFC", "LADDER", "StateChart"))
_LANGUAGES = _EDITORS | {"PLCOPEN_LD", "PLCOPEN_FBD", "PLCOPEN_CFC", "PLCOPEN_SFC", "EXP_IL"}
WITHOUT_TEXT = _EDITORS | {"ObjectProperties", "LineIds"}
"""Elements without Structured Text: bodies in other languages, options of the editor. The network
of a ladder body has thousands of elements."""

_MICROSECONDS = re.compile(r"[0-9]{1,9}(\.[0-9]{1,3})?")
_PRIORITY = re.compile(r"[0-9]{1,9}")


class TaskDeclaration(NamedTuple):
    """A task as a `.TcTTO` declares it."""

    name: str
    cycle_ns: int
    priority: int
    programs: tuple[str, ...]
    watchdog_cycles: int = 0
    """This and the following are in the `.tsproj` of the solution; 0 if it is not there."""
    port: int = 0
    floating_point_exceptions: bool = True


def read_task(root: Element) -> TaskDeclaration:
    """Return the task in a `.TcTTO`; its cycle is given in µs, such as 12.5. Raises
    `SourceError`."""
    task = root.child("Task")
    cycle, priority = task.text_of("CycleTime").strip(), task.text_of("Priority", "20").strip()
    if not (_MICROSECONDS.fullmatch(cycle) and _PRIORITY.fullmatch(priority)):
        task.fault(
            "expected <CycleTime> in µs and <Priority> as a whole number in <Task>",
            Code.BAD_ELEMENT,
        )
    whole, _, fraction = cycle.partition(".")
    cycle_ns = int(whole) * 1000 + int(fraction.ljust(3, "0"))
    names = tuple(call.text_of("Name").strip() for call in task.all("PouCall"))
    return TaskDeclaration(task.attributes.get("Name", "PlcTask"), cycle_ns, int(priority), names)


def _misses(element: Element, expected: str) -> Diagnostic:
    return Diagnostic(element.location, f"expected {expected} in <{element.tag}>", Code.BAD_ELEMENT)


def parse_envelope(root: Element, path: str, defines: Defines = ()) -> Parsed:
    """Return the units of a file and all that is wrong with it."""
    texts: list[str] = []
    pieces = []
    spans: dict[Element, tuple[int, int]] = {}
    start = 0
    for element in root.walk():
        if element.tag in _TEXTS:
            # Blanks around the CDATA part belong to the file, not to the source.
            text = element.text[element.begin :]
            spans[element] = (start, start + len(text))
            pieces.append(SourceSegment(start, element.begin_at.line, element.begin_at.column))
            texts.append(text)
            start += len(text) + 1
    drawings = _drawings(root, start + 1)
    source = Source("\n".join(texts), path, pieces, drawings.values())
    return _Envelope(source, spans, drawings, defines).parsed(root)


def _drawings(root: Element, start: int) -> dict[Element, GraphicalBody]:
    """Return the bodies in other languages, with offsets from `start` on."""
    bodies: dict[Element, GraphicalBody] = {}
    for owner in root.walk():
        implementation = owner.find("Implementation")
        for element in implementation.children if implementation is not None else ():
            if element.tag in _LANGUAGES:
                options = owner.find("ObjectProperties")
                settings = b"" if options is None else options.raw
                line = element.location.line
                bodies[element] = GraphicalBody(element.tag, element.raw, start, line, settings)
                start += len(element.raw) + 1
    return bodies


class _Envelope:
    """Puts units together from the texts of one file."""

    def __init__(
        self,
        source: Source,
        spans: Mapping[Element, tuple[int, int]],
        drawings: Mapping[Element, GraphicalBody],
        defines: Defines,
    ) -> None:
        self._source = source
        self._spans = spans
        self._drawings = drawings
        self._defines = defines
        self._faults: list[Diagnostic] = []

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
            self._faults.append(_misses(root, "a <POU>, <GVL>, <DUT> or <Itf>"))
        return Parsed(self._source, tuple(units), tuple(self._faults))

    def _parser(self, element: Element) -> Parser | None:
        declaration = element.find("Declaration")
        if declaration is None:
            self._faults.append(_misses(element, "a <Declaration>"))
            return None
        return Parser(self._source, *self._spans[declaration], self._defines)

    def _attempt(self, parser: Parser, read: Callable[[], P]) -> P | None:
        result = parser.attempt(read)
        self._faults += parser.faults
        return result

    def _list(self, element: Element, name: str) -> tuple[Unit, ...]:
        parser = self._parser(element)
        if parser is None:
            return ()
        units = self._attempt(parser, lambda: parser.units(name)) or ()
        properties = [item for child in element.all("Property") for item in self._property(child)]
        if not properties:
            return units
        # A list of properties alone may have no VAR_GLOBAL.
        lists = [unit for unit in units if isinstance(unit, GlobalList)]
        whole = lists[0] if lists else GlobalList(name, (), NO_NOTE, self._start_of(element))
        others = tuple(unit for unit in units if unit is not whole)
        return (*others, changed(whole, parts=tuple(properties)))

    def _start_of(self, element: Element) -> int:
        """Return the index at which the declaration of an element begins."""
        return self._spans[element.child("Declaration")][0]

    def _unit(self, element: Element) -> Iterator[Unit]:
        parser = self._parser(element)
        if parser is None:
            return
        unit = self._attempt(parser, lambda: head_of(parser))
        body, parts = self._body(element), self._parts(element)
        if unit is None:
            return
        unit = changed(unit, body=body)
        if not isinstance(unit, Function):
            unit = changed(unit, parts=parts)
        transitions = frozenset(
            child.attributes.get("Name", "").lower() for child in element.all("Transition")
        )
        yield with_drawn_bodies(unit, transitions)

    def _interface(self, element: Element) -> Iterator[Interface]:
        parser = self._parser(element)
        if parser is None:
            return
        unit = self._attempt(parser, lambda: parser.interface(whole=False))
        parts = self._parts(element)
        if unit is not None:
            yield changed(unit, parts=parts)

    def _body(self, element: Element) -> Body:
        """Return the statements; None for a body in another language, () where there is none."""
        implementation = element.find("Implementation")
        if implementation is None or not implementation.children:
            return ()
        text = implementation.find("ST")
        if text is None:
            return self._drawings.get(implementation.children[0])
        parser = Parser(self._source, *self._spans[text], self._defines)
        return self._attempt(parser, parser.statements.statements) or ()

    def _parts(self, element: Element) -> tuple[Part, ...]:
        parts: list[Part] = []
        for child in element.children:
            if child.tag == "Method":
                parts += self._method(child)
            elif child.tag == "Property":
                parts += self._property(child)
            elif child.tag == "Action":
                name = child.attributes.get("Name", "")
                parts.append(Action(name, self._body(child), NO_NOTE, 0))
            elif child.tag == "Transition":
                parts.append(self._transition(child))
        return tuple(parts)

    def _transition(self, element: Element) -> Method:
        """Return a transition object: a method that returns its condition, which its body assigns
        to its name; Structured Text may be the condition alone."""
        name = element.attributes.get("Name", "")
        condition = self._condition(element)
        if condition is None:
            body = self._body(element)
        else:
            at = condition.at
            body = (Assign(":=", Name(name, at), condition, at),)
        return Method(name, (), NamedType("BOOL"), (), body, NO_NOTE, self._start_of_text(element))

    def _condition(self, element: Element) -> Expression | None:
        """Return the condition that the text of a transition is; None if it has statements or
        none."""
        implementation = element.find("Implementation")
        text = None if implementation is None else implementation.find("ST")
        if text is None:
            return None
        parser = Parser(self._source, *self._spans[text], self._defines)
        condition = parser.attempt(parser.expressions.expression)
        return None if parser.faults or isinstance(condition, Assign) else condition

    def _start_of_text(self, element: Element) -> int:
        implementation = element.find("Implementation")
        for child in implementation.children if implementation else ():
            if child in self._spans:
                return self._spans[child][0]
            if child in self._drawings:
                return self._drawings[child].start
        return 0

    def _method(self, element: Element) -> Iterator[Method]:
        parser = self._parser(element)
        if parser is None:
            return
        method = self._attempt(parser, lambda: parser.method(whole=False))
        body = self._body(element)
        if method is not None:
            yield changed(method, body=body)

    def _property(self, element: Element) -> Iterator[Property]:
        parser = self._parser(element)
        if parser is None:
            return
        tree = self._attempt(parser, lambda: parser.property(whole=False))
        get, set = self._accessor(element.find("Get")), self._accessor(element.find("Set"))
        if tree is not None:
            yield changed(tree, get=get, set=set)

    def _accessor(self, element: Element | None) -> Accessor | None:
        if element is None:
            return None
        declaration = element.find("Declaration")
        accessor: Accessor | None = Accessor((), (), (), NO_NOTE, 0)
        if declaration is not None:
            parser = Parser(self._source, *self._spans[declaration], self._defines)
            accessor = self._attempt(parser, parser.accessor)
        body = self._body(element)
        return None if accessor is None else changed(accessor, body=body)


def head_of(parser: Parser) -> Program | FunctionBlock | Function:
    """Return the head and the variables of a unit."""
    kind = parser.cursor.kinds[parser.cursor.position]
    if kind == "FUNCTION_BLOCK":
        return parser.function_block(whole=False)
    if kind == "FUNCTION":
        return parser.function(whole=False)
    if kind == "PROGRAM":
        return parser.program(whole=False)
    raise parser.cursor.unexpected("PROGRAM, FUNCTION_BLOCK or FUNCTION")
