"""Trees of sequential function charts: steps, transitions, branches, jumps, macros.

Source: IEC 61131-3 (2013) §6.7; charts of public TwinCAT 3 projects.
"""

from enum import StrEnum
from typing import TypeAlias

from achse.st.graphical.archive import ArchiveObject, read_archive
from achse.st.lexis.codes import Code
from achse.st.syntax.cursor import Unexpected
from achse.st.syntax.nodes import node, place


class AttributeId(StrEnum):
    """First digits of the GUIDs of attributes of elements."""

    NAME = "38391c6d"
    EXCLUDE = "01580b27"
    INITIAL = "6844a48e"
    MAIN = "700a583f"
    ENTRY = "a6b08bd8"
    EXIT = "a2621e18"
    MINIMUM = "cacf1a68"
    MAXIMUM = "b693554c"
    PARALLEL = "23bdaa98"
    QUALIFIER = "e174fc0d"


QUALIFIERS = frozenset(["N", "R", "S", "L", "D", "P", "P0", "P1", "SD", "DS", "SL"])
"""Qualifiers of actions."""

TIMED = frozenset(["L", "D", "SD", "DS", "SL"])
"""Qualifiers that have a time."""


@node
class ActionAssociation:
    """An action or Boolean variable that a step controls."""

    name: str
    qualifier: str
    """N, R, S, L, D, P, P0, P1, SD, DS or SL."""
    time: str
    """Text of the TIME of L, D, SD, DS and SL."""
    at: int = place()


@node
class ChartStep:
    """A step."""

    name: str
    is_initial: bool
    entry: str
    """Name of its entry action; empty for none."""
    main: str
    exit: str
    minimum: str
    """Text of the shortest TIME it is active; empty for none."""
    maximum: str
    associations: tuple[ActionAssociation, ...]
    at: int = place()


@node
class ChartTransition:
    """A transition: an expression or the name of a transition object."""

    text: str
    at: int = place()


@node
class ChartJump:
    """A jump to a step, or to the label of a parallel branch."""

    target: str
    at: int = place()


@node
class Alternative:
    """An alternative branch: its segments from left to right."""

    segments: "tuple[tuple[ChartElement, ...], ...]"
    at: int = place()


@node
class Simultaneous:
    """A parallel branch: its segments from left to right."""

    label: str
    segments: "tuple[tuple[ChartElement, ...], ...]"
    at: int = place()


@node
class Macro:
    """A part of a chart that the editor folds."""

    name: str
    elements: "tuple[ChartElement, ...]"
    at: int = place()


ChartElement: TypeAlias = (
    ChartStep | ChartTransition | ChartJump | Alternative | Simultaneous | Macro
)


@node
class Chart:
    """A whole chart, from top to bottom."""

    elements: tuple[ChartElement, ...]


def read_chart(text: str) -> Chart:
    """Return the chart of a body. Raises `Unexpected` for what the format does not have."""
    root = read_archive(text)
    if root.type != "SFCImplementationObject":
        raise Unexpected(
            root.at,
            f"expected an SFCImplementationObject, got '{root.type[:80]}'",
            Code.BAD_DRAWING,
        )
    segment = root.part("Root")
    if segment is None:
        raise Unexpected(root.at, "the chart has no elements", Code.BAD_DRAWING)
    return Chart(_segment(segment))


def read_flags(text: str) -> dict[str, bool]:
    """Return the SFC flags that a chart uses, by their names without `SFC` in lower case; True
    for those that the compiler declares. `text` are the settings of the POU."""
    if "SFCProperty" not in text:
        return {}
    start = text.find("<XmlArchive")
    while start >= 0:
        end = text.find("</XmlArchive>", start)
        try:
            root = read_archive(text[start:end])
        except Unexpected:
            return {}
        flags = root.part("Flags") if root.type == "SFCProperty" else _flags_within(root)
        if flags is not None:
            return {
                key.lower().removeprefix("sfc"): value.flag("Declare")
                for key, value in flags.pairs
                if isinstance(value, ArchiveObject) and value.flag("Use")
            }
        start = text.find("<XmlArchive", end)
    return {}


def _flags_within(source: ArchiveObject) -> ArchiveObject | None:
    for value in (*source.members.values(), *source.items):
        if isinstance(value, ArchiveObject):
            if value.type == "SFCProperty":
                return value.part("Flags")
            inner = _flags_within(value)
            if inner is not None:
                return inner
    return None


def _elements(source: ArchiveObject) -> list[ArchiveObject]:
    """Return the elements in the object `ElementList`."""
    outer = source.part("ElementList")
    return [] if outer is None else outer.objects("InnerList")


def _segment(source: ArchiveObject) -> tuple[ChartElement, ...]:
    return tuple(_element(item) for item in _elements(source))


def _attributes(source: ArchiveObject) -> dict[str, str]:
    """Values by the first eight digits of the attribute's GUID."""
    values = {}
    for item in source.objects("Attributes"):
        value = item.part("Value")
        if value is not None:
            values[item.text("AttributeId").strip("{}")[:8].lower()] = value.text("Value").strip()
    return values


def _element(source: ArchiveObject) -> ChartElement:
    values = _attributes(source)
    name = values.get(AttributeId.NAME, "")
    is_excluded = values.get(AttributeId.EXCLUDE, "").upper() == "TRUE"
    match source.type:
        case "SFCStep":
            return _step(source, values, is_excluded)
        case "SFCTransition":
            if is_excluded:
                raise Unexpected(
                    source.at,
                    "a transition that is left out is not supported",
                    Code.UNSUPPORTED_DRAWING,
                )
            return ChartTransition(name.rstrip("; "), source.at)
        case "SFCJump":
            return ChartJump(name, source.at)
        case "SFCBranch":
            segments = tuple(_segment(item) for item in _elements(source))
            if values.get(AttributeId.PARALLEL, "").upper() == "TRUE":
                return Simultaneous(name, segments, source.at)
            return Alternative(segments, source.at)
        case "SFCMacro":
            inner = source.part("Segment")
            return Macro(name, () if inner is None else _segment(inner), source.at)
    raise Unexpected(
        source.at, f"'{source.type[:80]}' is not supported in a chart", Code.UNSUPPORTED_DRAWING
    )


def _step(source: ArchiveObject, values: dict[str, str], is_excluded: bool) -> ChartStep:
    associations = () if is_excluded else tuple(_association(item) for item in _elements(source))
    names = (AttributeId.ENTRY, AttributeId.MAIN, AttributeId.EXIT)
    entry, main, exit = ("" if is_excluded else values.get(key, "") for key in names)
    return ChartStep(
        values.get(AttributeId.NAME, ""),
        values.get(AttributeId.INITIAL, "").upper() == "TRUE",
        entry,
        main,
        exit,
        values.get(AttributeId.MINIMUM, ""),
        values.get(AttributeId.MAXIMUM, ""),
        tuple(item for item in associations if item is not None),
        source.at,
    )


def _association(source: ArchiveObject) -> ActionAssociation | None:
    values = _attributes(source)
    if values.get(AttributeId.EXCLUDE, "").upper() == "TRUE":
        return None
    name = values.get(AttributeId.NAME, "")
    if not name:
        return None
    text = values.get(AttributeId.QUALIFIER, "").replace(",", " ").split(None, 1)
    qualifier = text[0].upper() if text else "N"
    time = text[1].strip() if len(text) > 1 else ""
    if qualifier not in QUALIFIERS:
        raise Unexpected(
            source.at, f"{name}: '{qualifier[:20]}' is not a qualifier", Code.INCOMPLETE_DRAWING
        )
    if qualifier in TIMED and not time:
        raise Unexpected(
            source.at, f"{name}: qualifier {qualifier} has no time", Code.INCOMPLETE_DRAWING
        )
    return ActionAssociation(name, qualifier, time, source.at)
