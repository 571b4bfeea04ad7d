"""Documents in PLCopen XML (TC6): their units, types, lists and tasks.

The elements are put together as in a file of TwinCAT 3, whose reader does the rest. Declarations
are those that vendors add as text, else they are made of the interface.

Source: PLCopen TC6 XML schema 2.01; exports of TwinCAT, CODESYS, Beremiz and OpenPLC in public
repositories.
"""

import re
from collections.abc import Iterator

from achse.st.files.envelope import TaskDeclaration, parse_envelope
from achse.st.files.plcopen.declarations import DeclarationText, plain_text
from achse.st.graphical.plcopen.charts import drawn_conditions, inline_actions
from achse.st.lexis.lexer import Defines
from achse.st.lexis.literals import literal_value, whole_number
from achse.st.lexis.source import Location
from achse.st.lexis.xml import Element, parse_xml
from achse.st.syntax.parser import Parsed

_DIAGRAMS = ("FBD", "LD", "SFC", "CFC")
_NAMESPACE = b"plcopen.org/xml/tc6"
PLCOPEN_HEAD = 4096
"""Bytes at the beginning of a file that show what it is."""
_CYCLE_NS = 10_000_000
"""Cycle of a task without an interval."""
_SECONDS = re.compile(
    r"P?T?(?:(\d{1,9})H)?(?:(\d{1,9})M)?(?:(\d{1,18}(?:\.\d{1,18})?)S)?", re.IGNORECASE
)


def is_plcopen(data: bytes) -> bool:
    """Return True if a file begins like PLCopen XML."""
    return _NAMESPACE in data[:PLCOPEN_HEAD]


def parse_plcopen(data: bytes, path: str, name: str, defines: Defines = ()) -> Parsed:
    """Return the units of a document and all that is wrong with them. Raises `SourceError`."""
    root = parse_xml(data, path, skip=_DIAGRAMS)
    document = Element("TcPlcObject", {}, root.location)
    document.children = list(_units(root, name))
    if not document.children:
        document.children = [Element("Empty", {}, root.location)]
    return parse_envelope(document, path, defines)


def tasks_of_plcopen(data: bytes, path: str) -> list[TaskDeclaration]:
    """Return the tasks of a document. Raises `SourceError`."""
    root = parse_xml(data, path, skip=_DIAGRAMS)
    tasks = []
    for task in root.walk():
        if task.tag != "task":
            continue
        programs = dict.fromkeys(
            (item.attributes.get("typeName") or item.attributes.get("name", "")).rpartition(".")[2]
            for item in task.all("pouInstance")
        )
        priority = task.attributes.get("priority", "")
        tasks.append(
            TaskDeclaration(
                task.attributes.get("name", "PlcTask"),
                _nanoseconds(task.attributes.get("interval", "")) or _CYCLE_NS,
                whole_number(priority, 20),
                tuple(programs),
            )
        )
    return tasks


def _nanoseconds(text: str) -> int:
    """Return the length of an interval, a TIME literal or a duration as XML has it; 0 if it is
    neither."""
    duration = _SECONDS.fullmatch(text.strip())
    if text and duration is not None:
        hours, minutes, seconds = (float(one or 0) for one in duration.groups())
        return round((hours * 3600 + minutes * 60 + seconds) * 1_000_000_000)
    try:
        milliseconds = literal_value(text).value if text else 0
    except ValueError:
        return 0
    return int(milliseconds) * 1_000_000 if isinstance(milliseconds, int) and "#" in text else 0


# units -------------------------------------------------------------------------------------------


def _units(root: Element, name: str) -> Iterator[Element]:
    lists: dict[str, int] = {}
    waiting = [root]
    while waiting:
        element = waiting.pop()
        match element.tag:
            case "pou":
                yield _unit(element)
            case "dataType":
                yield _named("DUT", element, _data_type(element))
            case "globalVars":
                title = element.attributes.get("name") or name
                lists[title] = lists.get(title, 0) + 1
                list = _named("GVL", element, _list(element))
                list.attributes["Name"] = re.sub(r"\W", "_", title)
                if lists[title] > 1:
                    list.attributes["Name"] += f"_{lists[title]}"
                yield list
            case "Interface" if element.attributes.get("name"):
                yield _interface(element)
            case _:
                waiting.extend(reversed(element.children))


def _named(tag: str, element: Element, declaration: Element | None) -> Element:
    envelope = Element(tag, {"Name": element.attributes.get("name", "")}, element.location)
    if declaration is not None:
        envelope.children.append(declaration)
    return envelope


def _as_text(element: Element) -> Element | None:
    """Return the declaration that a vendor added."""
    added = plain_text(element)
    if added is None or not added.text.strip():
        return None
    return _copied("Declaration", added)


def _copied(tag: str, text: Element) -> Element:
    copy = Element(tag, {}, text.location)
    copy.text, copy.begin, copy.begin_at = text.text, text.begin, text.begin_at
    return copy


def _data_type(element: Element) -> Element:
    declaration = _as_text(element)
    if declaration is None:
        text = DeclarationText(element.location)
        text.data_type(element)
        declaration = text.element
    return declaration


def _list(element: Element) -> Element:
    declaration = _as_text(element)
    if declaration is None:
        text = DeclarationText(element.location)
        text.block(element)
        declaration = text.element
    return declaration


def _unit(element: Element) -> Element:
    declaration = _as_text(element)
    interface = element.find("interface")
    if declaration is None:
        text = DeclarationText(element.location)
        text.unit(element, interface)
        declaration = text.element
    unit = _named("POU", element, declaration)
    unit.children += _implementation(element)
    for group, inner, tag in (
        ("actions", "action", "Action"),
        ("transitions", "transition", "Transition"),
    ):
        for part in (one for outer in element.all(group) for one in outer.all(inner)):
            child = _named(tag, part, None)
            child.children += _implementation(part)
            unit.children.append(child)
    unit.children += _parts(element)
    for owner in (unit, *unit.all("Action")):
        unit.children += _parts_of_chart(owner)
    return unit


def _parts(element: Element) -> Iterator[Element]:
    """Methods and properties, which vendors add."""
    for part in element.walk():
        if part.tag == "Method":
            yield _method(part)
        elif part.tag == "Property":
            yield _property(part)


def _method(part: Element) -> Element:
    declaration = _as_text(part)
    if declaration is None:
        text = DeclarationText(part.location)
        text.method(part, part.find("interface"))
        declaration = text.element
    method = _named("Method", part, declaration)
    method.children += _implementation(part)
    return method


def _property(part: Element) -> Element:
    declaration = _as_text(part)
    if declaration is None:
        text = DeclarationText(part.location)
        text.property(part, part.find("interface"))
        declaration = text.element
    property = _named("Property", part, declaration)
    for tag, accessor in (("Get", part.find("GetAccessor")), ("Set", part.find("SetAccessor"))):
        if accessor is not None:
            own = _as_text(accessor)
            if own is None:
                text = DeclarationText(accessor.location)
                text.variables(accessor.find("interface"))
                own = text.element
            inner = _named(tag, accessor, own)
            inner.children += _implementation(accessor)
            property.children.append(inner)
    return property


def _interface(element: Element) -> Element:
    declaration = _as_text(element)
    if declaration is None:
        text = DeclarationText(element.location)
        text.put(f"INTERFACE {element.attributes['name']}")
        declaration = text.element
    interface = _named("Itf", element, declaration)
    interface.children += _parts(element)
    return interface


# bodies ------------------------------------------------------------------------------------------


def _implementation(element: Element) -> Iterator[Element]:
    body = element.find("body")
    if body is None:
        return
    implementation = Element("Implementation", {}, body.location)
    diagrams = [one for one in body.walk() if one.tag in _DIAGRAMS]
    if diagrams:
        first = diagrams[0]
        drawn = Element(f"PLCOPEN_{first.tag}", {}, first.location)
        drawn.raw = b"<nested" if first.children else first.raw  # one of its kind is inside
        implementation.children.append(drawn)
    else:
        implementation.children += [
            _text(child) for child in body.children if child.tag in ("ST", "IL")
        ][:1]
    yield implementation


def _text(element: Element) -> Element:
    """Return a body that is text: in an element of XHTML, or bare."""
    inner = next((one for one in element.children if one.text.strip()), element)
    if element.tag == "ST":
        return _copied("ST", inner)
    text = Element("EXP_IL", {}, inner.begin_at)
    text.raw = inner.text[inner.begin :].encode()
    return text


def _parts_of_chart(owner: Element) -> Iterator[Element]:
    """Actions for the statements in action blocks of a chart, transitions for its diagrams."""
    implementation = owner.find("Implementation")
    chart = None if implementation is None else implementation.find("PLCOPEN_SFC")
    if chart is None:
        return
    for name, condition in drawn_conditions(chart.raw.decode("utf-8", "replace")):
        drawn = Element("PLCOPEN_FBD", {}, chart.location)
        drawn.raw = condition.encode()
        yield _part("Transition", name, drawn)
    for action in inline_actions(chart.raw.decode("utf-8", "replace")):
        line = chart.location.line + action.line - 1
        column = action.column + (chart.location.column - 1 if action.line == 1 else 0)
        text = Element("ST", {}, Location(chart.location.path, line, column))
        text.text = action.text
        yield _part("Action", action.name, text)


def _part(tag: str, name: str, body: Element) -> Element:
    element = Element(tag, {"Name": name}, body.location)
    implementation = Element("Implementation", {}, body.location)
    implementation.children.append(body)
    element.children.append(implementation)
    return element
