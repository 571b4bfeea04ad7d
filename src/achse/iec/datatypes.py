"""Data type entries on the wire (0xF00E, 0xF011), with members, methods and enumeration values.

Source: recorded traffic of TwinCAT 3.1 targets and the code of public clients; no manual prints it.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntFlag
from typing import Self

from achse.iec.entries import (
    BOUNDS,
    EntryReader,
    attribute_bytes,
    open_entry,
    padded_entry,
    short_text,
    text_bytes,
)
from achse.iec.errors import IecDecodeError
from achse.iec.text import Coding

STATIC_OFFSET = 0xFFFF_FFFF
"""The offset of a member that no instance has."""

_HEAD = struct.Struct("<7I5H")
_METHOD_HEAD = struct.Struct("<5I16sII4H")
_PARAMETER_HEAD = struct.Struct("<5I16s4H")
_U16 = struct.Struct("<H")
_U32 = struct.Struct("<I")
_NOTE_HEAD = struct.Struct("<BB")
_DEEPEST = 16
"""Members of members that a table may nest; real ones have none."""

Attributes = tuple[tuple[str, str], ...]


class TypeFlag(IntFlag):
    """The flags of a data type entry and of its members."""

    TYPE = 0x0000_0001
    MEMBER = 0x0000_0002
    REFERENCE = 0x0000_0004
    METHOD_DEREF = 0x0000_0008
    OVERSAMPLE = 0x0000_0010
    BIT_VALUES = 0x0000_0020
    PROPERTY_ITEM = 0x0000_0040
    TYPE_GUID = 0x0000_0080
    PERSISTENT = 0x0000_0100
    COPY_MASK = 0x0000_0200
    TCOM_POINTER = 0x0000_0400
    METHODS = 0x0000_0800
    ATTRIBUTES = 0x0000_1000
    ENUM_VALUES = 0x0000_2000
    ALIGNED = 0x0001_0000
    STATIC = 0x0002_0000
    PROTECTION_LEVELS = 0x0004_0000
    IGNORE_PERSISTENT = 0x0008_0000
    ANY_SIZE = 0x0010_0000
    PERSISTENT_TYPE = 0x0020_0000
    INIT_ON_RESET = 0x0040_0000
    PLC_POINTER = 0x0080_0000
    REFACTOR_INFO = 0x0100_0000
    HIDE_MEMBERS = 0x0200_0000
    INCOMPLETE = 0x0400_0000
    ONLINE_CHANGE_POINTER = 0x0800_0000
    DEREF_ITEMS = 0x1000_0000
    ENUM_NOTES = 0x2000_0000
    EXTENDED_FLAGS = 0x8000_0000


class MethodFlag(IntFlag):
    """The flags of a method entry."""

    PLC_CALL = 1
    UNLOCKED = 2
    NOT_CALLABLE = 4
    ATTRIBUTES = 8


class ParameterFlag(IntFlag):
    """The flags of a parameter entry."""

    IN = 1
    OUT = 2
    BY_REFERENCE = 4
    ATTRIBUTES = 0x40


@dataclass(frozen=True, slots=True)
class ParameterEntry:
    """A parameter of a method."""

    name: str
    type_name: str
    size: int
    alignment: int
    adst: int
    flags: int
    guid: bytes = bytes(16)
    comment: str = ""
    attributes: Attributes = ()
    reserved: int = 0
    length_is: int = 0
    """Number of the parameter that holds the length of this one."""
    tail: bytes = b""

    def encode(self, coding: Coding = "cp1252") -> bytes:
        name = text_bytes(self.name, coding, "a parameter name")
        type_name = text_bytes(self.type_name, coding, "a type name")
        comment = text_bytes(self.comment, coding, "a comment")
        head = _PARAMETER_HEAD.pack(
            self.size,
            self.alignment,
            self.adst,
            self.flags,
            self.reserved,
            self.guid,
            self.length_is,
            len(name),
            len(type_name),
            len(comment),
        )
        parts = [head, name, b"\0", type_name, b"\0", comment, b"\0"]
        if self.flags & ParameterFlag.ATTRIBUTES:
            parts.append(_attribute_part(self.attributes, coding))
        return open_entry(b"".join(parts), self.tail)

    @classmethod
    def read(cls, parent: EntryReader) -> Self:
        """Return the entry at the cursor's position; moves it on."""
        cursor = parent.child("parameter entry")
        size, alignment, adst, flags, reserved, guid, length_is, *lengths = cursor.unpack(
            _PARAMETER_HEAD
        )
        name, type_name, comment = map(cursor.text, lengths)
        attributes = cursor.attributes(cursor.u16()) if flags & ParameterFlag.ATTRIBUTES else ()
        return cls(
            name,
            type_name,
            size,
            alignment,
            adst,
            flags,
            guid,
            comment,
            attributes,
            reserved,
            length_is,
            cursor.take(cursor.left),
        )


@dataclass(frozen=True, slots=True)
class MethodEntry:
    """A method of a function block. `return_size` 0 and no type name: it returns nothing."""

    name: str
    return_type: str
    return_size: int
    return_alignment: int
    return_adst: int
    parameters: tuple[ParameterEntry, ...] = ()
    flags: int = MethodFlag.PLC_CALL
    return_guid: bytes = bytes(16)
    comment: str = ""
    attributes: Attributes = ()
    version: int = 1
    table_index: int = 0
    """Place in the function block's table of methods."""
    reserved: int = 0
    tail: bytes = b""

    def encode(self, coding: Coding = "cp1252") -> bytes:
        name = text_bytes(self.name, coding, "a method name")
        return_type = text_bytes(self.return_type, coding, "a type name")
        comment = text_bytes(self.comment, coding, "a comment")
        head = _METHOD_HEAD.pack(
            self.version,
            self.table_index,
            self.return_size,
            self.return_alignment,
            self.reserved,
            self.return_guid,
            self.return_adst,
            self.flags,
            len(name),
            len(return_type),
            len(comment),
            len(self.parameters),
        )
        parts = [head, name, b"\0", return_type, b"\0", comment, b"\0"]
        parts += [item.encode(coding) for item in self.parameters]
        if self.flags & MethodFlag.ATTRIBUTES:
            parts.append(_attribute_part(self.attributes, coding))
        return open_entry(b"".join(parts), self.tail)

    @classmethod
    def read(cls, parent: EntryReader) -> Self:
        """Return the entry at the cursor's position; moves it on."""
        cursor = parent.child("method entry")
        version, index, size, alignment, reserved, guid, adst, flags, *lengths, count = (
            cursor.unpack(_METHOD_HEAD)
        )
        name, return_type, comment = map(cursor.text, lengths)
        parameters = tuple(ParameterEntry.read(cursor) for _ in range(count))
        attributes = cursor.attributes(cursor.u16()) if flags & MethodFlag.ATTRIBUTES else ()
        return cls(
            name,
            return_type,
            size,
            alignment,
            adst,
            parameters,
            flags,
            guid,
            comment,
            attributes,
            version,
            index,
            reserved,
            cursor.take(cursor.left),
        )


@dataclass(frozen=True, slots=True)
class EnumNote:
    """Comment and attributes of one enumeration value, from the extended part."""

    comment: str = ""
    attributes: Attributes = ()
    tail: bytes = b""

    def encode(self, coding: Coding) -> bytes:
        comment = short_text(self.comment, coding, "a comment of an enumeration value")
        head = _NOTE_HEAD.pack(len(comment), len(self.attributes))
        attributes = attribute_bytes(self.attributes, coding)
        body = b"%b%b\0%b%b" % (head, comment, attributes, self.tail)
        return _U16.pack(2 + len(body)) + body

    @classmethod
    def read(cls, parent: EntryReader) -> Self:
        cursor = parent.child("enumeration note", width=2)
        length, count = cursor.unpack(_NOTE_HEAD)
        return cls(cursor.text(length), cursor.attributes(count), cursor.take(cursor.left))


@dataclass(frozen=True, slots=True)
class DataTypeEntry:
    """A type, or a member of one. `flags` decides which optional parts are there."""

    name: str
    type_name: str
    size: int
    adst: int
    flags: int
    offset: int = 0
    """Bytes in the parent; bits for a BIT member; `STATIC_OFFSET` for a static one."""
    comment: str = ""
    dimensions: tuple[tuple[int, int], ...] = ()
    """Lower bound and element count of each dimension."""
    members: tuple["DataTypeEntry", ...] = ()
    guid: bytes = bytes(16)
    copy_mask: bytes = b""
    methods: tuple[MethodEntry, ...] = ()
    attributes: Attributes = ()
    enum_values: tuple[tuple[str, bytes], ...] = ()
    extended_flags: int = 0
    deref_items: tuple[bytes, ...] = ()
    enum_notes: tuple[EnumNote, ...] = ()
    version: int = 1
    hash_value: int = 0
    type_hash: int = 0
    tail: bytes = b""
    """Unknown parts of the entry."""

    def encode(self, coding: Coding = "cp1252") -> bytes:
        """Return the entry of a type, padded to 8 bytes. Raises `IecValueError`."""
        return padded_entry(self._body(coding), self.tail)

    def _body(self, coding: Coding) -> bytes:
        name = text_bytes(self.name, coding, "a type name")
        type_name = text_bytes(self.type_name, coding, "a type name")
        comment = text_bytes(self.comment, coding, "a comment")
        flags = self.flags
        head = _HEAD.pack(
            self.version,
            self.hash_value,
            self.type_hash,
            self.size,
            self.offset,
            self.adst,
            flags,
            len(name),
            len(type_name),
            len(comment),
            len(self.dimensions),
            len(self.members),
        )
        parts = [head, name, b"\0", type_name, b"\0", comment, b"\0"]
        parts += [BOUNDS.pack(*bounds) for bounds in self.dimensions]
        parts += [open_entry(item._body(coding), item.tail) for item in self.members]
        if flags & TypeFlag.TYPE_GUID:
            parts.append(self.guid)
        if flags & TypeFlag.COPY_MASK:
            parts.append(self.copy_mask)
        if flags & TypeFlag.METHODS:
            parts.append(_U16.pack(len(self.methods)))
            parts += [item.encode(coding) for item in self.methods]
        if flags & TypeFlag.ATTRIBUTES:
            parts.append(_attribute_part(self.attributes, coding))
        if flags & TypeFlag.ENUM_VALUES:
            parts.append(_U16.pack(len(self.enum_values)))
            for value_name, value in self.enum_values:
                raw = short_text(value_name, coding, "the name of an enumeration value")
                parts.append(b"%c%b\0%b" % (len(raw), raw, value))
        if flags & TypeFlag.REFACTOR_INFO:
            return b"".join(parts)
        if flags & TypeFlag.EXTENDED_FLAGS:
            parts.append(_U32.pack(self.extended_flags))
        if flags & TypeFlag.DEREF_ITEMS:
            parts.append(_U16.pack(len(self.deref_items)))
            parts += self.deref_items
        if flags & TypeFlag.ENUM_NOTES:
            parts += [item.encode(coding) for item in self.enum_notes]
        return b"".join(parts)

    @classmethod
    def decode(cls, data: bytes, coding: Coding = "cp1252") -> Self:
        """Return the type entry at the start of `data`. Raises `IecDecodeError`."""
        return cls._type(EntryReader.entry(data, 0, len(data), "type entry", coding))

    @classmethod
    def _type(cls, cursor: EntryReader) -> Self:
        return cls._read(cursor, 0)

    @classmethod
    def _read(cls, cursor: EntryReader, depth: int) -> Self:
        if depth > _DEEPEST:
            raise IecDecodeError(f"a type entry nests members deeper than {_DEEPEST}")
        version, hash_value, type_hash, size, offset, adst, flags, *lengths, dims, count = (
            cursor.unpack(_HEAD)
        )
        name, type_name, comment = map(cursor.text, lengths)
        dimensions = tuple(cursor.bounds() for _ in range(dims))
        members = tuple(cls._read(cursor.child("member entry"), depth + 1) for _ in range(count))
        guid = cursor.take(16) if flags & TypeFlag.TYPE_GUID else bytes(16)
        copy_mask = cursor.take(size) if flags & TypeFlag.COPY_MASK else b""
        methods: tuple[MethodEntry, ...] = ()
        if flags & TypeFlag.METHODS:
            methods = tuple(MethodEntry.read(cursor) for _ in range(cursor.u16()))
        attributes = cursor.attributes(cursor.u16()) if flags & TypeFlag.ATTRIBUTES else ()
        values: tuple[tuple[str, bytes], ...] = ()
        if flags & TypeFlag.ENUM_VALUES:
            values = tuple(
                (cursor.text(cursor.take(1)[0]), cursor.take(size)) for _ in range(cursor.u16())
            )
        extended_flags = 0
        deref_items: tuple[bytes, ...] = ()
        notes: tuple[EnumNote, ...] = ()
        # How refactor info is laid out is not known: what follows it stays as it came.
        if not flags & TypeFlag.REFACTOR_INFO:
            if flags & TypeFlag.EXTENDED_FLAGS:
                extended_flags = cursor.u32()
            if flags & TypeFlag.DEREF_ITEMS:
                deref_items = tuple(cursor.take(16) for _ in range(cursor.u16()))
            if flags & TypeFlag.ENUM_NOTES:
                notes = tuple(EnumNote.read(cursor) for _ in values)
        return cls(
            name,
            type_name,
            size,
            adst,
            flags,
            offset,
            comment,
            dimensions,
            members,
            guid,
            copy_mask,
            methods,
            attributes,
            values,
            extended_flags,
            deref_items,
            notes,
            version,
            hash_value,
            type_hash,
            cursor.tail() if depth == 0 else cursor.take(cursor.left),
        )


def _attribute_part(attributes: Attributes, coding: Coding) -> bytes:
    return _U16.pack(len(attributes)) + attribute_bytes(attributes, coding)


def encode_types(types: Iterable[DataTypeEntry], coding: Coding = "cp1252") -> bytes:
    """Return the upload of 0xF00E: entries back to back, sorted by name without case."""
    ordered = sorted(types, key=lambda entry: entry.name.lower())
    return b"".join([entry.encode(coding) for entry in ordered])


def decode_types(data: bytes, coding: Coding = "cp1252") -> list[DataTypeEntry]:
    """Return all entries of an upload, in its order. Raises `IecDecodeError`."""
    types = []
    position = 0
    while position < len(data):
        cursor = EntryReader.entry(data, position, len(data), "type entry", coding)
        types.append(DataTypeEntry._type(cursor))
        position = cursor.end
    return types
