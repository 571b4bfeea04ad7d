"""Records: structures, unions, function blocks, programs and variable lists over memory.

A record object is a view of bytes: its attributes read and write them in place. `decode` and
calling the class give a record with memory of its own, `read` one that shares the buffer.

Source: IEC 61131-3 (2013) table 11, no. 5; tables 40 and 47; unions as in TwinCAT 3.
"""

from collections.abc import Mapping, Sequence
from enum import Enum
from functools import cached_property
from typing import Any, ClassVar, Generic, Self, TypeVar

from achse.iec.arrays import Array
from achse.iec.errors import (
    DeclarationError,
    IecPathError,
    IecValueError,
    UnboundError,
)
from achse.iec.layout import (
    TC3_X64,
    LayoutRules,
    MemberOffset,
    TypeLayout,
    align,
    overlaid,
    pack_of,
    sequential,
)
from achse.iec.methods import Method, Property
from achse.iec.types import CHUNK, Adst, Buffer, IecType, no_attributes, put_zeros
from achse.iec.variables import Place, Variable

R = TypeVar("R", bound="Record")

_NOWHERE = MemberOffset(0)


class RecordKind(Enum):
    """Kind of a record."""

    STRUCT = "STRUCT"
    UNION = "UNION"
    FUNCTION_BLOCK = "FUNCTION_BLOCK"
    UNIT = "UNIT"
    """A program or a global variable list: one instance, whose variables are the symbols."""


class StructType(IecType[R], Generic[R]):
    """A type with members. `layout` overrides the computed one, as a target's type table does.

    `least_size` in bytes counts without `layout`. A type that `is_joined` shows the members of its
    base as its own, and no base.
    """

    is_view = True

    def __init__(
        self,
        name: str,
        members: Mapping[str, Variable[Any, Any]] | Sequence[Variable[Any, Any]],
        *,
        kind: RecordKind = RecordKind.STRUCT,
        base: "StructType[Any] | None" = None,
        rules: LayoutRules = TC3_X64,
        pack: int | None = None,
        layout: TypeLayout | None = None,
        least_size: int = 0,
        is_joined: bool = False,
        methods: Sequence[Method] = (),
        properties: Sequence[Property] = (),
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
        guid: bytes | None = None,
        record: type[R] | None = None,
    ) -> None:
        if not isinstance(members, Mapping):
            members = {member.name: member for member in members}
        self.kind = kind
        self.base = base
        self.shown_base = None if is_joined else base
        """The base that clients see."""
        self.rules = rules
        if pack is None:
            mode = attributes.get("pack_mode")
            pack = rules.pack if mode is None else min(pack_of(mode), rules.pack)
        is_unit = kind is RecordKind.UNIT
        apart = [
            not member.in_memory or (is_unit and (member.retain or member.address is not None))
            for member in members.values()
        ]
        inside = [
            member.type for member, away in zip(members.values(), apart, strict=True) if not away
        ]
        is_computed = layout is None
        if layout is None:
            layout = self._lay_out(inside, pack)
            size = align(max(layout.size, least_size), layout.alignment)
            layout = layout._replace(size=size)
        super().__init__(
            name,
            layout.size,
            layout.alignment,
            Adst.BIGTYPE,
            comment=comment,
            attributes=attributes,
        )
        self.rest_on(member.type for member in members.values())
        spots = iter(layout.spots)
        self.own_members = tuple(
            member.placed(attribute, *(_NOWHERE if away else next(spots)), apart=away)
            for (attribute, member), away in zip(members.items(), apart, strict=True)
        )
        self.attribute_names = dict(zip(members, self.own_members, strict=True))
        """Own members by the name of their Python attribute."""
        self.members: tuple[Variable[Any, Any], ...] = (
            *(base.members if base else ()),
            *self.own_members,
        )
        """All members, inherited ones first."""
        self.fields = tuple(item for item in self.members if item.in_memory and not item.apart)
        """The members within the record's own memory."""
        self._by_name: dict[str, Variable[Any, Any]] = {
            item.name.lower(): item for item in reversed(self.members)
        }
        if is_computed and len(self._by_name) < len(self.members):
            double = next(m for m in self.members if self._by_name[m.name.lower()] is not m)
            raise DeclarationError(f"{name} has two members named {double.name}")
        self.own_methods = tuple(methods)
        # A method that overrides another has the place of that in the table.
        self._methods: dict[str, Method] = {
            **(base._methods if base else {}),
            **{method.name.lower(): method for method in methods},
        }
        self._properties: dict[str, Property] = {
            **(base._properties if base else {}),
            **{item.name.lower(): item for item in properties},
        }
        self._record = record
        if guid is not None:
            self.guid = guid

    def _lay_out(self, types: Sequence[IecType[Any]], pack: int) -> TypeLayout:
        if self.kind is RecordKind.UNION:
            return overlaid(types, pack)
        if self.base is not None:
            return sequential(types, pack, start=self.base.size, alignment=self.base.alignment)
        if self.kind is RecordKind.FUNCTION_BLOCK:
            # The table pointer of its methods comes first.
            pointer = self.rules.pointer_size
            return sequential(types, pack, start=pointer, alignment=min(pointer, pack))
        return sequential(types, pack)

    @cached_property
    def shown(self) -> tuple[Variable[Any, Any], ...]:
        """The members that clients see, by their offsets if a base has members among them."""
        shown = (item for item in self.members if not item.hidden)
        if self.base is None:
            return tuple(shown)
        return tuple(sorted(shown, key=lambda item: (not item.in_memory, item.offset)))

    def describe(self) -> str:
        parts = [
            f"{item.name}@{item.offset}.{item.bit} {item.type.guid.hex()}" for item in self.members
        ]
        return f"{self.kind.value} {self.name} {self.size} {{{'; '.join(parts)}}}"

    @property
    def record(self) -> type[R]:
        """The Python class of its values."""
        if self._record is None:
            self.behave()
        return self._record  # type: ignore[return-value]

    def behave(self, behaviour: type | None = None) -> None:
        """Make the Python class of the values, with the methods of the class `behaviour`.

        What a base type does, its derived types do. Raises `DeclarationError` if there is a
        class already, as all records declared in Python have.
        """
        if self._record is not None:
            raise DeclarationError(f"{self.name} has a Python class already: {self._record!r}")
        base: type = FunctionBlock if self.kind is RecordKind.FUNCTION_BLOCK else Struct
        if self.base is not None and self.base.kind is self.kind:
            base = self.base.record
        # A foreign table may hold any name; `__class__` and the like must stay Python's.
        members = {
            item.name: item
            for item in self.members
            if not (item.name.startswith("__") and item.name.endswith("__"))
        }
        name = self.name.replace("\0", "")
        bases = (base,) if behaviour is None else (behaviour, base)
        self._record = RecordMeta(name, bases, members, iec=self)  # type: ignore[assignment]

    def member(self, name: str) -> Variable[Any, Any]:
        """Return the member of that name, without case. Raises `IecPathError`."""
        variable = self._by_name.get(name.lower())
        if variable is None:
            raise IecPathError(f"{self.name} has no member {name[:80]!r}")
        return variable

    def has_member(self, name: str) -> bool:
        """Return True if a member has this name, without case."""
        return name.lower() in self._by_name

    @property
    def methods(self) -> tuple[Method, ...]:
        """All methods that can be called, inherited ones first."""
        return tuple(self._methods.values())

    def method(self, name: str) -> Method:
        """Return the method of that name, without case; the most derived one. Raises
        `IecPathError`."""
        method = self._methods.get(name.lower())
        if method is None:
            raise IecPathError(f"{self.name} has no method {name[:80]!r}")
        return method

    @property
    def properties(self) -> tuple[Property, ...]:
        """All properties that clients reach, inherited ones first."""
        return tuple(self._properties.values())

    def property_named(self, name: str) -> Property | None:
        """Return the property of that name, without case; None if there is none."""
        return self._properties.get(name.lower())

    @cached_property
    def default(self) -> bytes:
        """All members at their initial values. Raises `DeclarationError` if one does not fit."""
        memory = bytearray(self.size)
        for member in self.fields:
            # In a union only what is said counts, not the zeros of the members beside it.
            if member.initial is None and member.type.starts_at_zero:
                continue
            data = member.initial_bytes()
            if member.bit is not None:
                memory[member.offset] |= data[0] << member.bit
            else:
                memory[member.offset : member.offset + member.type.size] = data
        return bytes(memory)

    @cached_property
    def starts_at_zero(self) -> bool:
        if "default" in self.__dict__:  # its declaration may have an initial value
            return not any(self.default)
        return all(
            member.type.starts_at_zero
            if member.initial is None
            else not any(member.initial_bytes())
            for member in self.fields
        )

    def put_default(self, buffer: Buffer, offset: int) -> None:
        if self.size <= CHUNK or "default" in self.__dict__:
            super().put_default(buffer, offset)
            return
        put_zeros(buffer, offset, self.size)
        for member in self.fields:
            if member.initial is None and member.type.starts_at_zero:
                continue
            if member.bit is not None:
                buffer[offset + member.offset] |= member.initial_bytes()[0] << member.bit
            else:
                member.put_initial(buffer, offset + member.offset)

    def encode(self, value: object) -> bytes:
        """Return a record of this type, or a mapping; members it leaves out start as declared."""
        if isinstance(value, Record) and type(value).__iec__ is self:
            return bytes(value)
        if isinstance(value, Record):
            value = plain(value)
        if not isinstance(value, Mapping):
            raise self.reject(value)
        memory = bytearray(self.default)
        self.initialise(memory, 0, value)
        return bytes(memory)

    def initialise(self, buffer: Buffer, offset: int, value: object) -> None:
        """Encode, but leave members that a mapping omits as the outer type has them."""
        if not isinstance(value, Mapping):
            self.write(buffer, offset, value)
            return
        for name, item in value.items():
            member = self._by_name.get(name.lower()) if isinstance(name, str) else None
            if member is None or not member.in_memory:
                raise self.reject(name, f"members {', '.join(m.name for m in self.fields[:20])}")
            try:
                if member.bit is None:
                    member.type.initialise(buffer, offset + member.offset, item)
                else:
                    member.store(buffer, offset, item)
            except IecValueError as error:
                raise IecValueError(
                    f"{self.name}.{member.name}: {error.type_name}", error.expected, error.value
                ) from None

    def read(self, buffer: Buffer, offset: int) -> R:
        record = self.record.__new__(self.record)
        bind(record, buffer, offset)
        if self.kind is RecordKind.FUNCTION_BLOCK:
            record.__init__()  # type: ignore[misc]
        return record

    @property
    def expected(self) -> str:
        return f"a {self.name} or a mapping of its members"


class RecordMeta(type):
    """Makes a `StructType` of the variables in a class body."""

    __iec__: StructType[Any]

    def __new__(
        mcs,
        class_name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        kind: RecordKind | None = None,
        name: str = "",
        pack: int | None = None,
        rules: LayoutRules = TC3_X64,
        comment: str = "",
        attributes: Mapping[str, str] = no_attributes,
        iec: StructType[Any] | None = None,
    ) -> "RecordMeta":
        # Without slots a misspelt member would quietly become a Python attribute.
        namespace.setdefault("__slots__", ())
        cls = super().__new__(mcs, class_name, bases, namespace)
        if kind is not None:
            cls.__kind__ = kind
            return cls
        if iec is not None:
            cls.__iec__ = iec
            return cls
        bases_with_type = [base for base in bases if isinstance(base, RecordMeta)]
        if len(bases_with_type) != 1:
            raise DeclarationError(f"{class_name} needs exactly one record class as its base")
        declared = {
            attribute: value
            for attribute, value in namespace.items()
            if isinstance(value, Variable)
        }
        methods = [
            value.__iec_method__
            for value in namespace.values()
            if isinstance(getattr(value, "__iec_method__", None), Method)
        ]
        cls.__iec__ = StructType(
            name or class_name,
            declared,
            kind=cls.__kind__,
            base=getattr(bases_with_type[0], "__iec__", None),
            rules=rules,
            pack=pack,
            methods=methods,
            comment=comment,
            attributes=attributes,
            record=cls,
        )
        for attribute, member in cls.__iec__.attribute_names.items():
            setattr(cls, attribute, member)
            if member.initial is not None:
                member.initial_bytes()
        return cls

    def __init__(cls, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args)

    __kind__: RecordKind


class Record(metaclass=RecordMeta, kind=RecordKind.STRUCT):
    """Base of all records. Its own names are dunders, so that members may have any IEC name."""

    __slots__ = ("__iec_buffer__", "__iec_offset__", "__iec_views__")
    __hash__ = None  # type: ignore[assignment]

    __iec__: ClassVar[StructType[Any]]
    __iec_buffer__: Buffer
    __iec_offset__: int
    __iec_views__: dict[str, Any]

    def __init__(self, values: Mapping[str, object] | None = None, /, **members: object) -> None:
        """A record with memory of its own: initial values, then `values` and `members`."""
        if not hasattr(self, "__iec_buffer__"):
            bind(self, bytearray(type(self).__iec__.encode({**(values or {}), **members})))

    def __getitem__(self, name: str) -> Any:
        """Return the member of that name, without case."""
        return type(self).__iec__.member(name).__get__(self, type(self))

    def __setitem__(self, name: str, value: object) -> None:
        type(self).__iec__.member(name).__set__(self, value)

    def __bytes__(self) -> bytes:
        offset = self.__iec_offset__
        return bytes(self.__iec_buffer__[offset : offset + type(self).__iec__.size])

    def __copy__(self) -> Self:
        """Return the same values in memory of their own."""
        return type(self).__iec__.decode(bytes(self))  # type: ignore[no-any-return]

    def __deepcopy__(self, memo: object) -> Self:
        return self.__copy__()

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Record):
            return NotImplemented
        same_name = type(self).__iec__.name.lower() == type(other).__iec__.name.lower()
        return same_name and bool(plain(self) == plain(other))

    def __repr__(self) -> str:
        if not hasattr(self, "__iec_buffer__"):
            return f"<unbound {type(self).__iec__.name}>"
        members = ", ".join(
            f"{item.name}={self[item.name]!r}" for item in type(self).__iec__.fields
        )
        return f"{type(self).__iec__.name}({members})"


class Struct(Record, kind=RecordKind.STRUCT):
    """Base of structures: `class ST_Axis(Struct): fPos = var(LREAL)`.

    Class arguments: `name`, `pack` (largest alignment), `rules`, `comment`, `attributes`.
    """

    __slots__ = ()


class Union(Record, kind=RecordKind.UNION):
    """Base of unions: all members share their memory."""

    __slots__ = ()


class FunctionBlock(Record, kind=RecordKind.FUNCTION_BLOCK):
    """Base of function blocks; may keep Python attributes beside its variables.

    Calling one sets the inputs that are named and runs its body, if it has one in Structured
    Text: `fb(bExecute=True)`.
    """

    __slots__ = ("__dict__", "__weakref__")

    def __call__(self, *args: Any, **inputs: Any) -> Any:
        if args:
            raise TypeError(f"{type(self).__iec__.name} takes inputs by name")
        for name, value in inputs.items():
            self[name] = value
        invoke = getattr(self.__iec_buffer__, "invoke", None)
        if invoke is None:
            raise UnboundError(f"{type(self).__iec__.name} has no body in Structured Text here")
        invoke(self, "", ())


class StaticRecord(Record, kind=RecordKind.UNIT):
    """Base of programs and global variable lists: no memory until it is bound."""

    __slots__ = ("__dict__", "__iec_places__", "__weakref__")

    __iec_places__: Mapping[str, Place]

    def __init__(self) -> None:
        """Nothing: a unit gets its memory from the PLC it runs in, or from `bind`."""


def bind(
    record: Record,
    buffer: Buffer | None = None,
    offset: int = 0,
    places: Mapping[str, Place] | None = None,
) -> None:
    """Give a record its memory: `size` bytes of `buffer` from `offset`.

    `places` holds the variables that are stored apart (`Variable.apart`), by name. Without a buffer
    the record gets memory of its own with initial values, for trying out.
    """
    iec = type(record).__iec__
    if buffer is None:
        buffer = bytearray(iec.default)
        apart = [item for item in iec.members if item.apart]
        own = {item.name: Place(bytearray(item.initial_bytes()), 0) for item in apart}
        places = own | dict(places or {})
    if not 0 <= offset <= len(buffer) - iec.size:
        raise IecValueError(iec.name, f"{iec.size} bytes of memory", len(buffer) - offset)
    record.__iec_buffer__ = buffer
    record.__iec_offset__ = offset
    record.__iec_views__ = {}
    if isinstance(record, StaticRecord):
        record.__iec_places__ = places or {}


def plain(value: Any) -> Any:
    """Return the value without views: records as dicts, arrays as lists (index 0 at the lower
    bound)."""
    if isinstance(value, Record):
        return {item.name: plain(value[item.name]) for item in type(value).__iec__.fields}
    if isinstance(value, Array):
        return [plain(item) for item in value.tolist()]
    if isinstance(value, list):
        return [plain(item) for item in value]
    return value
