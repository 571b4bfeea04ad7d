"""Memory layout: the places of the members of a structure.

TwinCAT 3 aligns each member to its natural alignment, at most 8 (attribute `pack_mode` lowers
that); TwinCAT 2 packs to 1 byte on x86 and to 4 on ARM. Consecutive BIT members share bytes.

Source: offsets in symbol uploads of TwinCAT 2 and 3 targets; the standard leaves them open.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from achse.iec.errors import DeclarationError


@dataclass(frozen=True, slots=True)
class LayoutRules:
    """Layout rules of a target platform: largest alignment and size of a pointer, in bytes."""

    pack: int = 8
    pointer_size: int = 8


TC3_X64 = LayoutRules(pack=8, pointer_size=8)
TC3_X86 = LayoutRules(pack=8, pointer_size=4)
TC2_X86 = LayoutRules(pack=1, pointer_size=4)
TC2_ARM = LayoutRules(pack=4, pointer_size=4)


class Occupant(Protocol):
    """Interface of a member's type to the layout."""

    @property
    def size(self) -> int: ...
    @property
    def alignment(self) -> int: ...
    @property
    def is_bit(self) -> bool: ...


class MemberOffset(NamedTuple):
    """Byte offset of a member, and its bit in that byte if it is a BIT."""

    offset: int
    bit: int | None = None


class TypeLayout(NamedTuple):
    """Size and alignment of the whole, and the spot of each member in order."""

    size: int
    alignment: int
    spots: tuple[MemberOffset, ...]


def align(offset: int, alignment: int) -> int:
    """Return the next multiple of `alignment` at or after `offset`."""
    return -(-offset // alignment) * alignment


def pack_of(pack_mode: str) -> int:
    """Return the largest alignment that attribute `pack_mode` := '0' … '8' allows.

    A number between two alignments allows the lower one.
    """
    try:
        return {"0": 1, "1": 1, "2": 2, "3": 2, **dict.fromkeys("4567", 4), "8": 8}[
            pack_mode.strip()
        ]
    except KeyError:
        raise DeclarationError(f"pack_mode is 0 … 8, got {pack_mode!r}") from None


def sequential(
    members: Iterable[Occupant], pack: int, *, start: int = 0, alignment: int = 1
) -> TypeLayout:
    """Members one after the other.

    `start` and `alignment` are those of what is before them: a base structure or the table
    pointer of a function block.
    """
    position = start
    spots: list[MemberOffset] = []
    next_bit = 8
    for member in members:
        if member.is_bit:
            if next_bit == 8:
                next_bit = 0
                position += 1
            spots.append(MemberOffset(position - 1, next_bit))
            next_bit += 1
            continue
        next_bit = 8
        needed = min(member.alignment, pack)
        alignment = max(alignment, needed)
        position = align(position, needed)
        spots.append(MemberOffset(position))
        position += member.size
    return TypeLayout(align(position, alignment), alignment, tuple(spots))


def overlaid(members: Iterable[Occupant], pack: int) -> TypeLayout:
    """Members all at the start: a union."""
    alignment = 1
    size = 0
    spots: list[MemberOffset] = []
    for member in members:
        alignment = max(alignment, min(member.alignment, pack))
        size = max(size, member.size)
        spots.append(MemberOffset(0, 0 if member.is_bit else None))
    return TypeLayout(align(size, alignment), alignment, tuple(spots))
