"""Instance paths: `MAIN.st.a[3].x`, `a[1,2]`, `a[1][2]`, `ptr^`, `word.3`, `fb#Method`.

A path is parsed into steps, and steps are followed from a type to an offset. Case does not
matter.

Source: IEC 61131-3 (2013) tables 11, 16 and 17.
"""

import re
from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from achse.iec.arrays import ArrayType
from achse.iec.derived import InterfaceType, PointerType, ReferenceType, resolved
from achse.iec.elementary import BIT, IntegerType
from achse.iec.errors import IecIndexError, IecPathError
from achse.iec.methods import Method, Property
from achse.iec.structs import StructType
from achse.iec.symbols import fold
from achse.iec.types import IecType, no_attributes
from achse.iec.variables import Variable


@dataclass(frozen=True, slots=True)
class PathMember:
    """`.name`, or the first name of a path."""

    name: str


@dataclass(frozen=True, slots=True)
class PathIndex:
    """`[i, j]`."""

    indices: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Deref:
    """`^`."""


@dataclass(frozen=True, slots=True)
class Bit:
    """`.3`."""

    number: int


@dataclass(frozen=True, slots=True)
class PathMethod:
    """`#Method`."""

    name: str


Step: TypeAlias = PathMember | PathIndex | Deref | Bit | PathMethod


class ResolvedPath(NamedTuple):
    """Target of a path: a type at an offset.

    `hops` are the pointers on the way: each is the offset of a pointer, from the start or from the
    target of the pointer before it. `offset` counts from the start, or from the target of the last
    pointer.
    """

    type: IecType[Any]
    offset: int
    bit: int | None = None
    hops: tuple[int, ...] = ()
    method: Method | None = None
    static: Variable[Any, Any] | None = None
    """The VAR_STAT variable on the way, if there is one: `offset` and `hops` count from it."""
    property: Property | None = None
    comment: str = ""
    """Comment of the member where the path ends."""
    attributes: Mapping[str, str] = no_attributes
    """Attributes of the member where the path ends; for a part or target of the member only its
    encoding."""


_NAME = re.compile(r"[^\W\d]\w*")
_NUMBER = re.compile(r"[0-9]+")
_INDEX = re.compile(r"\s*([+-]?)0*([0-9]+)\s*")
_LONGEST_INDEX = 11
_MOST_STEPS = 256
_MOST_SEGMENTS = 32
"""Dots in the name of a symbol that `split_symbol` tries."""


def parse_path(text: str) -> tuple[Step, ...]:
    """Return the steps of a path, or of the rest of one that starts with `.`, `[`, `^` or `#`.

    Raises `IecPathError` with the position of the fault.
    """
    text = text.strip()
    steps: list[Step] = []
    position = 0
    first = _NAME.match(text)
    if first is not None:
        steps.append(PathMember(first[0]))
        position = first.end()
    while position < len(text):
        step, position = _step(text, position)
        steps.append(step)
        if len(steps) > _MOST_STEPS:
            raise IecPathError(f"a path has at most {_MOST_STEPS} steps: {text[:60]!r}…")
    if not steps:
        raise _fault(text, 0, "a name")
    return tuple(steps)


def format_path(steps: Iterable[Step]) -> str:
    """Return the rest of a path as text without the zeros and blanks that an index may have."""
    parts = []
    for step in steps:
        match step:
            case PathMember(name):
                parts.append(f".{name}")
            case PathIndex(indices):
                parts.append(f"[{','.join(map(str, indices))}]")
            case Deref():
                parts.append("^")
            case Bit(number):
                parts.append(f".{number}")
            case PathMethod(name):
                parts.append(f"#{name}")
    return "".join(parts)


def _step(text: str, position: int) -> tuple[Step, int]:
    sign = text[position]
    position += 1
    if sign == "^":
        return Deref(), position
    if sign == "[":
        return _index(text, position)
    if sign not in ".#":
        raise _fault(text, position - 1, "'.', '[', '^' or '#'")
    match = _NAME.match(text, position)
    if match is not None:
        return (PathMember if sign == "." else PathMethod)(match[0]), match.end()
    number = _NUMBER.match(text, position) if sign == "." else None
    if number is None:
        raise _fault(text, position, "a name")
    if number.end() - number.start() > 2:
        raise _fault(text, position, "a bit number")
    return Bit(int(number[0])), number.end()


def _index(text: str, position: int) -> tuple[Step, int]:
    indices = []
    while True:
        match = _INDEX.match(text, position)
        if match is None:
            raise _fault(text, position, "an index")
        if len(match[2]) > _LONGEST_INDEX:
            raise IecIndexError(
                f"index {match[0].strip()[:40]} of {text[:60]!r} is outside any array"
            )
        indices.append(int(match[1] + match[2]))
        position = match.end()
        sign = text[position : position + 1]
        if sign == "]":
            return PathIndex(tuple(indices)), position + 1
        if sign != ",":
            raise _fault(text, position, "',' or ']'")
        position += 1


def _fault(text: str, position: int, expected: str) -> IecPathError:
    came = repr(text[position : position + 20]) if position < len(text) else "the end"
    return IecPathError(
        f"path {text[:60]!r}: expected {expected} at position {position}, got {came}"
    )


def split_symbol(path: str, symbols: Container[str]) -> tuple[str, str]:
    """Return the longest symbol name a path starts with, folded, and the rest of the path.

    `symbols` holds names folded by `fold`. Raises `IecPathError` if none fits.
    """
    folded = fold(path.strip())
    if folded in symbols:
        return folded, ""
    end = next((i for i, sign in enumerate(folded) if sign in "[^#"), len(folded))
    ends = [end]
    for _ in range(_MOST_SEGMENTS):
        dot = folded.find(".", ends[-1] + 1 if len(ends) > 1 else 0, end)
        if dot < 0:
            break
        ends.append(dot)
    for cut in sorted(ends, reverse=True):
        if folded[:cut] in symbols:
            return folded[:cut], path.strip()[cut:]
    raise IecPathError(f"no symbol is named {path.strip()[:80]!r}")


def locate(type: IecType[Any], path: str) -> ResolvedPath:
    """Follow the text of a path from a type: `locate(st, "a[3].x")` or `locate(st, ".a[3].x")`."""
    return follow(type, parse_path(path))


def follow(
    type: IecType[Any], steps: Iterable[Step], attributes: Mapping[str, str] = no_attributes
) -> ResolvedPath:
    """Follow steps from a type. Raises `IecPathError` where they lead out of it.

    `attributes` are those of the variable at the start.
    """
    location = ResolvedPath(type, 0, attributes=attributes)
    for step in steps:
        if location.method is not None:
            raise IecPathError(f"nothing follows a method: {step}")
        if location.property is not None:
            raise IecPathError(f"nothing follows a property: {step}")
        if location.bit is not None:
            raise IecPathError(f"nothing follows a bit: {step}")
        location = _next(location, step)
    return location


def _next(location: ResolvedPath, step: Step) -> ResolvedPath:
    type = resolved(location.type)
    if isinstance(step, Deref):
        if not isinstance(type, PointerType) or isinstance(type, InterfaceType):
            raise IecPathError(f"{location.type.name} is not a pointer: ^ leads nowhere")
        return _pointee(location, type)
    if isinstance(type, ReferenceType):
        # A reference is followed by itself.
        return _next(_pointee(location, type), step)
    if isinstance(step, PathMember):
        if not isinstance(type, StructType):
            raise IecPathError(f"{location.type.name} has no member {step.name[:80]!r}")
        if (declared := type.property_named(step.name)) is not None:
            return location._replace(type=declared.type, property=declared)
        member = type.member(step.name)
        if member.hidden:
            raise IecPathError(f"{type.name} shows no member {step.name[:80]!r}")
        if not member.in_memory:
            return ResolvedPath(
                member.type,
                0,
                member.bit,
                static=member,
                comment=member.comment,
                attributes=member.attributes,
            )
        if member.apart:
            raise IecPathError(f"{member.name} of {type.name} is stored apart: it has no offset")
        return location._replace(
            type=member.type,
            offset=location.offset + member.offset,
            bit=member.bit,
            comment=member.comment,
            attributes=member.attributes,
        )
    if isinstance(step, PathIndex):
        return _element(location, type, step.indices)
    if isinstance(step, Bit):
        if not isinstance(type, IntegerType) or step.number >= 8 * type.size:
            raise IecPathError(f"{location.type.name} has no bit {step.number}")
        offset = location.offset + step.number // 8
        return location._replace(
            type=BIT, offset=offset, bit=step.number % 8, comment="", attributes=no_attributes
        )
    if not isinstance(type, StructType):
        raise IecPathError(f"{location.type.name} has no method {step.name[:80]!r}")
    return location._replace(method=type.method(step.name))


def _pointee(location: ResolvedPath, type: PointerType) -> ResolvedPath:
    hops = (*location.hops, location.offset)
    return _inherited(location)._replace(type=type.target, offset=0, hops=hops)


def dereferenced(location: ResolvedPath) -> ResolvedPath:
    """Return the target of a path, for a path that ends at a reference the reference's target."""
    while isinstance(type := resolved(location.type), ReferenceType):
        if len(location.hops) > _MOST_STEPS:
            raise IecPathError(f"{location.type.name} refers to itself")
        location = _pointee(location, type)
    return location


def _inherited(location: ResolvedPath) -> ResolvedPath:
    """Return the location without comment and attributes, except the encoding, for a part or
    target."""
    attributes = {
        key: text for key, text in location.attributes.items() if key.lower() == "tcencoding"
    }
    return location._replace(comment="", attributes=attributes or no_attributes)


def _element(location: ResolvedPath, type: IecType[Any], indices: tuple[int, ...]) -> ResolvedPath:
    if not isinstance(type, ArrayType):
        raise IecPathError(f"{location.type.name} is not an array: [{indices[0]}] leads nowhere")
    # `a[1,2]` also reaches into an array of arrays, as `a[1][2]` does into two dimensions.
    here, beyond = indices[: len(type.dimensions)], indices[len(type.dimensions) :]
    offset = location.offset + type.position(here)
    part = type.element if len(here) == len(type.dimensions) else type.row(len(here))
    element = _inherited(location)._replace(type=part, offset=offset)
    return _next(element, PathIndex(beyond)) if beyond else element
