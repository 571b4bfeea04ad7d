"""Layout: where in a type the bytes are that mean something in one memory only.

These are pointers (references and interfaces, too) and the headers of function blocks.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from achse.iec import ArrayType, IecType, InterfaceType, PointerType, StructType, resolved
from achse.iec.structs import RecordKind

if TYPE_CHECKING:
    from achse.st.typed.project import Routine, TypedBlock


class Pointer(NamedTuple):
    """A pointer in a type."""

    offset: int
    size: int
    type: PointerType

    @property
    def is_to_values(self) -> bool:
        """True if the pointer points to numbers of several bytes. Others may point to records."""
        if isinstance(self.type, InterfaceType):
            return False
        target = resolved(self.type.target)
        return target.size > 1 and not isinstance(target, StructType | ArrayType)


KnownPointers: TypeAlias = dict[int, Sequence[Pointer]]
"""The pointers of types met before."""


def pointers_within(type: IecType[Any], known: KnownPointers | None = None) -> Sequence[Pointer]:
    known = {} if known is None else known
    type = resolved(type)
    pointers = known.get(id(type))
    if pointers is not None:
        return pointers
    if isinstance(type, PointerType):
        pointers = [Pointer(0, type.size, type)]
    elif isinstance(type, ArrayType):
        inner = pointers_within(type.element, known)
        step = type.element.size
        pointers = [
            one._replace(offset=n * step + one.offset)
            for n in range(type.count if inner else 0)
            for one in inner
        ]
    elif isinstance(type, StructType) and type.kind is not RecordKind.UNION:
        pointers = [
            one._replace(offset=member.offset + one.offset)
            for member in type.fields
            if member.bit is None
            for one in pointers_within(member.type, known)
        ]
    else:
        pointers = []
    known[id(type)] = pointers
    return pointers


def parts_without_headers(type: IecType[Any]) -> tuple[tuple[int, int], ...]:
    """Return the bytes of a record that a copy takes: all but the headers of function blocks."""
    gaps = sorted({(at, at + block.rules.pointer_size) for at, block in headers_within(type)})
    parts: list[tuple[int, int]] = []
    at = 0
    for start, end in gaps:
        if start > at:
            parts.append((at, start))
        at = end
    if at < type.size:
        parts.append((at, type.size))
    return tuple(parts)


def headers_within(type: IecType[Any], offset: int = 0) -> Iterator[tuple[int, StructType[Any]]]:
    """Offset and block of each header in a type that is stored at `offset`."""
    type = resolved(type)
    if isinstance(type, StructType):
        if type.kind is RecordKind.FUNCTION_BLOCK:
            yield offset, type
        for member in type.fields:
            yield from headers_within(member.type, offset + member.offset)
    elif isinstance(type, ArrayType) and any(True for _ in headers_within(type.element)):
        for index in range(type.count):
            yield from headers_within(type.element, offset + index * type.element.size)


def frame_image(routine: "Routine", blocks: "Mapping[str, TypedBlock]") -> bytes:
    """Return the bytes that a frame begins with, the headers of its function blocks included.

    A block that is passed by value, or is a result, is not created: it gets its header only here.
    """
    image = routine.frame.default
    for field in routine.frame.fields:
        if field.type.size < routine.frame.rules.pointer_size:
            continue
        for offset, type in headers_within(field.type, field.offset):
            block = blocks.get(type.name.lower())
            if block is not None:
                size = type.rules.pointer_size
                header = block.number.to_bytes(size, "little")
                image = image[:offset] + header + image[offset + size :]
    return image
