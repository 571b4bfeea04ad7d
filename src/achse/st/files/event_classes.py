"""Event classes of a project: from its `.tmc` or `.tsproj` to the constants that programs name.

`TC_EVENTS.<class>.<event>` is what a block of Tc3_EventLogger is created with, or the class's GUID
`TC_EVENT_CLASSES.<class>` with the event's number and severity. The texts of the
events come along, in the language that the file has first.

Source: symbol files of public projects (`<EventId>` in `<DataType>`).
"""

import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from uuid import UUID

from achse.st.lexis.source import Source, SourceError
from achse.st.lexis.xml import Element, parse_xml
from achse.st.syntax.parser import Parsed, parse

_SEVERITIES = ("Verbose", "Info", "Warning", "Error", "Critical")
_LONGEST = 200
"""Signs of a text that are kept."""


@dataclass(frozen=True, slots=True)
class ProjectEvent:
    """One event of a class."""

    name: str
    number: int
    severity: str
    text: str


@dataclass(frozen=True, slots=True)
class EventClass:
    """A class of events, with its GUID."""

    name: str
    title: str
    uuid: UUID
    events: tuple[ProjectEvent, ...]


def event_classes(contents: Iterable[tuple[bytes, str]]) -> list[EventClass]:
    """Return the classes in some files, each once; what is not well formed is passed over."""
    classes: dict[str, EventClass] = {}
    for data, name in contents:
        if b"<EventId>" not in data:
            continue
        try:
            root = parse_xml(data, name)
        except SourceError:
            continue
        for element in root.walk():
            if element.tag == "DataType" and element.find("EventId") is not None:
                event_class = _class(element)
                if event_class is not None:
                    classes.setdefault(event_class.name.lower(), event_class)
    return list(classes.values())


def base_classes(sources: Iterable[Parsed], known: Iterable[EventClass]) -> list[EventClass]:
    """Return the classes that every project has, if its sources name them and no file of it has
    them."""
    texts = [parsed.source.text for parsed in sources]
    others = {one.name.lower() for one in known}
    return [
        one
        for one in _base_classes()
        if one.name.lower() not in others and any(one.name in text for text in texts)
    ]


@cache
def _base_classes() -> tuple[EventClass, ...]:
    data = files(__package__).joinpath("base_event_classes.toml").read_text(encoding="utf-8")
    return tuple(
        EventClass(
            name,
            name,
            UUID(row["guid"]),
            tuple(ProjectEvent(event, number, level, "") for number, event, level in row["events"]),
        )
        for name, row in tomllib.loads(data).items()
    )


def _class(element: Element) -> EventClass | None:
    head = element.find("Name")
    if head is None or not head.text.strip().isidentifier():
        return None
    try:
        uuid = UUID(head.attributes.get("GUID", ""))
    except ValueError:
        return None
    events = tuple(_events(element))
    title = element.text_of("DisplayName").strip() or head.text.strip()
    return EventClass(head.text.strip(), title, uuid, events) if events else None


def _events(element: Element) -> Iterator[ProjectEvent]:
    for item in element.all("EventId"):
        head = item.find("Name")
        number = "" if head is None else head.attributes.get("Id", "")
        if head is None or not head.text.strip().isidentifier() or not number.isdecimal():
            continue
        severity = item.text_of("Severity").strip()
        if severity not in _SEVERITIES:
            severity = "Info"
        text = item.text_of("DisplayName").strip()[:_LONGEST]
        yield ProjectEvent(head.text.strip(), int(number) & 0xFFFF_FFFF, severity, text)


def events_sources(classes: Iterable[EventClass]) -> list[Parsed]:
    """Structured Text with the lists TC_EVENTS and TC_EVENT_CLASSES; nothing without classes."""
    classes = list(classes)
    if not classes:
        return []
    lines: list[str] = []
    for one in classes:
        lines.append(f"TYPE ST_{one.name}_Events : STRUCT")
        lines += (
            f"    {_member(event)} : TcEventEntry := (uuidEventClass := {_guid(one.uuid)},"
            f" nEventId := {event.number}, eSeverity := TcEventSeverity.{event.severity});"
            for event in one.events
        )
        lines.append("END_STRUCT END_TYPE")
    lines.append("{attribute 'qualified_only'} VAR_GLOBAL CONSTANT")
    lines += (f"    {one.name} : ST_{one.name}_Events;" for one in classes)
    lines.append("END_VAR")
    lines += _function("TC_EVENT_TEXT", classes, per_event=True)
    lines += _function("TC_EVENT_CLASS_NAME", classes, per_event=False)
    guids = [f"    {one.name} : GUID := {_guid(one.uuid)};" for one in classes]
    guids = ["{attribute 'qualified_only'} VAR_GLOBAL CONSTANT", *guids, "END_VAR"]
    return [_parsed(lines, "TC_EVENTS"), _parsed(guids, "TC_EVENT_CLASSES")]


def _member(event: ProjectEvent) -> str:
    """Return the name by which a program knows an event: `__1` is `_IECCONF_1`, as a public
    project shows."""
    name = event.name
    return f"_IECCONF_{name[2:]}" if name.startswith("__") else name


def _parsed(lines: Iterable[str], name: str) -> Parsed:
    source = Source("\n".join(lines), f"event classes {name}")
    source.library = "tc3_eventlogger"  # where the texts take the place of those without classes
    return parse(source, name=name).check()


def _function(name: str, classes: Iterable[EventClass], *, per_event: bool) -> Iterator[str]:
    yield f"FUNCTION {name} : STRING(255) VAR_INPUT entry : TcEventEntry; END_VAR"
    yield "VAR known : GUID; END_VAR"
    for one in classes:
        yield f"known := {_entry(one)}.uuidEventClass;"
        yield "IF GuidsEqualByVal(entry.uuidEventClass, known) THEN"
        if per_event:
            yield "CASE entry.nEventId OF"
            for event in {event.number: event for event in one.events}.values():
                yield f"    {event.number}: {name} := {_quoted(event.text)};"
            yield "END_CASE"
        else:
            yield f"    {name} := {_quoted(one.title)};"
        yield "END_IF"
    yield f"IF {name} = '' THEN {name} := CONCAT('event ', TO_STRING(entry.nEventId)); END_IF"
    yield "END_FUNCTION"


def _entry(one: EventClass) -> str:
    return f"TC_EVENTS.{one.name}.{one.events[0].name}"


def _guid(uuid: UUID) -> str:
    rest = ", ".join(str(byte) for byte in uuid.bytes[8:])
    first, second, third = uuid.fields[:3]
    return f"(Data1 := {first}, Data2 := {second}, Data3 := {third}, Data4 := [{rest}])"


def _quoted(text: str) -> str:
    signs = {"$": "$$", "'": "$'", "\n": "$N", "\r": "", "\t": "$T"}
    shown = (signs.get(sign, sign) for sign in text if sign >= " " or sign in signs)
    return f"'{''.join(shown)}'"
