"""Resolution of names at a stop: variables of the call, its instance, its program, lists, in
memory."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec import ArrayType, GlobalVariables, IecType, StructType, resolved
from achse.iec.derived import InterfaceType, PointerType, ReferenceType
from achse.iec.describe import types_within
from achse.iec.enums import EnumType
from achse.iec.strings import StringType
from achse.iec.structs import RecordKind
from achse.iec.times import TimeType
from achse.iec.types import Buffer
from achse.iec.variables import Variable
from achse.plc.memory import Area
from achse.st.typed.project import Routine

if TYPE_CHECKING:
    from achse.plc.runtime import PlcRuntime

_LONGEST_TEXT = 400


class NotThere(LookupError):
    """A name, member, element or address that is not there; the message says which."""


class CallView(NamedTuple):
    """A halted call with its variables."""

    routine: Routine
    this: int
    """Address of the instance; 0 without one."""
    frame: int
    """Offset of its frame in the stack area."""


class DebugSpot(NamedTuple):
    """A variable in memory."""

    name: str
    type: IecType[Any]
    data: Buffer
    offset: int
    bit: int | None = None

    def read(self) -> Any:
        """Return the value: int, float, bool, str; of a time or enumeration its number."""
        real = resolved(self.type)
        if self.bit is not None:
            return bool(self.data[self.offset] >> self.bit & 1)
        data = bytes(self.data[self.offset : self.offset + real.size])
        if isinstance(real, TimeType | EnumType):
            return int.from_bytes(data, "little", signed=isinstance(real, EnumType))
        return real.decode(data)

    def write(self, value: object) -> None:
        """Write a value. Raises `IecValueError` for one that the type does not accept."""
        if self.bit is not None:
            state = bool(value)
            byte = self.data[self.offset]
            self.data[self.offset] = byte & ~(1 << self.bit) | state << self.bit
            return
        data = self.type.encode(value)
        self.data[self.offset : self.offset + len(data)] = data


class DebugNames:
    """Names that can be resolved in one PLC."""

    def __init__(self, plc: "PlcRuntime") -> None:
        self._plc = plc

    # names -----------------------------------------------------------------------------------

    def find(self, name: str, view: CallView | None) -> DebugSpot | str:
        """Return a variable; or the name of a unit or enumeration, for a member. Raises
        NotThere."""
        key = name.lower()
        if view is not None:
            for spot in (self._in_frame(key, view), self._in_this(key, view)):
                if spot is not None:
                    return spot
            owner = view.routine.owner or view.routine.key
            spot = self._units.get(owner, {}).get(key)
            if spot is not None:
                return spot
        if key in self._units or key in self._enums:
            return key
        for unit in self._lists:
            if key in self._units[unit]:
                return self._units[unit][key]
        raise NotThere(f"nothing is named {name!r} here")

    def member_of(self, unit: str, name: str) -> DebugSpot | int:
        """Return a variable of a unit, or the number of an enumerator."""
        enum = self._enums.get(unit)
        if enum is not None:
            for member, number in enum.numbers.items():
                if member.lower() == name.lower():
                    return number
        spot = self._units.get(unit, {}).get(name.lower())
        if spot is None:
            raise NotThere(f"{unit} has no {name!r}")
        return spot

    def this(self, view: CallView | None) -> DebugSpot:
        """THIS^. Raises NotThere outside of a function block."""
        if view is None or not view.this or view.routine.this is None:
            raise NotThere("THIS is there in a function block only")
        return self.at("THIS^", view.routine.this, view.this)

    def at(self, name: str, type: IecType[Any], address: int) -> DebugSpot:
        """Return the variable at an address. Raises NotThere if no memory is there."""
        place = self._plc.memory.at(address) if address > 0 else None
        if place is None or place[1] + type.size > len(place[0].data):
            raise NotThere(f"{name}: no memory at address 16#{address:X}")
        region, offset = place
        return DebugSpot(name, type, region.data, offset)

    # scopes ----------------------------------------------------------------------------------

    def locals(self, view: CallView) -> list[DebugSpot]:
        """Variables of the frame."""
        fields = view.routine.frame.fields
        spots = (self._in_frame(field.name.lower(), view) for field in fields)
        return [spot for spot in spots if spot is not None]

    def instance(self, view: CallView) -> list[DebugSpot]:
        """Variables of the function block."""
        if view.routine.this is None or not view.this:
            return []
        spots = (self._in_this(one.name.lower(), view) for one in view.routine.this.members)
        return [spot for spot in spots if spot is not None]

    def unit(self, name: str) -> list[DebugSpot]:
        """Variables of a program or list."""
        return list(self._units.get(name.lower(), {}).values())

    @property
    def lists(self) -> list[str]:
        """The variable lists, as written."""
        return [unit.name for unit in self._plc.units if unit.name.lower() in set(self._lists)]

    def children(self, spot: DebugSpot, start: int = 0, count: int = 1000) -> Iterator[DebugSpot]:
        """Members, elements, or the target of a pointer."""
        real = resolved(spot.type)
        if isinstance(real, StructType):
            for member in real.members[start : start + count]:
                child = self._member(spot, member)
                if child is not None:
                    yield child
        elif isinstance(real, ArrayType):
            for index in range(start, min(start + count, real.count)):
                yield self._element(spot, real, index)
        elif isinstance(real, PointerType) and not isinstance(real, InterfaceType):
            try:
                yield self.follow(spot)
            except NotThere:
                return

    # steps -----------------------------------------------------------------------------------

    def member(self, spot: DebugSpot, name: str) -> DebugSpot:
        """`spot.name`. Raises NotThere."""
        spot = self._through(spot)
        real = resolved(spot.type)
        if isinstance(real, StructType) and real.has_member(name):
            member = self._member(spot, real.member(name))
            if member is not None:
                return member
        raise NotThere(f"{spot.name} has no {name!r}")

    def element(self, spot: DebugSpot, indices: list[int]) -> DebugSpot:
        """`spot[indices]`. Raises NotThere outside of the bounds."""
        spot = self._through(spot)
        real = resolved(spot.type)
        if isinstance(real, PointerType) and len(indices) == 1:
            target = real.target
            address = int(spot.read()) + indices[0] * target.size
            return self.at(f"{spot.name}[{indices[0]}]", target, address)
        if not isinstance(real, ArrayType) or len(indices) != len(real.dimensions):
            raise NotThere(f"{spot.name} is not an array of {len(indices)} dimensions")
        number = 0
        for index, bounds in zip(indices, real.dimensions, strict=True):
            if not bounds.first <= index <= bounds.last:
                raise NotThere(f"{spot.name}: index {index} is outside of {bounds}")
            number = number * bounds.length + index - bounds.first
        return self._element(spot, real, number)

    def follow(self, spot: DebugSpot) -> DebugSpot:
        """`spot^`. Raises NotThere without a pointer, or for a dangling one."""
        real = resolved(spot.type)
        if not isinstance(real, PointerType) or isinstance(real, InterfaceType):
            raise NotThere(f"{spot.name} is not a pointer")
        return self.at(f"{spot.name}^", real.target, int(spot.read()))

    def _through(self, spot: DebugSpot) -> DebugSpot:
        if isinstance(resolved(spot.type), ReferenceType):
            return self.follow(spot)._replace(name=spot.name)
        return spot

    # memory ----------------------------------------------------------------------------------

    def _in_frame(self, key: str, view: CallView) -> DebugSpot | None:
        for field in view.routine.frame.fields:
            if field.name.lower() == key:
                data = self._plc.memory[Area.STACK].data
                spot = DebugSpot(field.name, field.type, data, view.frame + field.offset)
                if isinstance(resolved(field.type), ReferenceType):
                    try:
                        return self.follow(spot)._replace(name=field.name)
                    except NotThere:
                        return spot
                return spot
        return None

    def _in_this(self, key: str, view: CallView) -> DebugSpot | None:
        type = view.routine.this
        if type is None or not view.this or not type.has_member(key):
            return None
        return self._member(self.this(view), type.member(key))

    def _member(self, spot: DebugSpot, member: Variable[Any, Any]) -> DebugSpot | None:
        if not member.in_memory:
            place = self._plc.memory.statics.get(member)
            if place is None:
                return None
            return DebugSpot(member.name, member.type, place.buffer, place.offset, place.bit)
        spot_of_member = DebugSpot(
            member.name, member.type, spot.data, spot.offset + member.offset, member.bit
        )
        if isinstance(resolved(member.type), ReferenceType):
            try:
                return self.follow(spot_of_member)._replace(name=member.name)
            except NotThere:
                return spot_of_member
        return spot_of_member

    def _element(self, spot: DebugSpot, type: ArrayType[Any], number: int) -> DebugSpot:
        rest, subscripts = number, []
        for bounds in reversed(type.dimensions):
            rest, place = divmod(rest, bounds.length)
            subscripts.append(bounds.first + place)
        name = f"[{','.join(map(str, reversed(subscripts)))}]"
        offset = spot.offset + number * type.element.size
        return DebugSpot(name, type.element, spot.data, offset)

    @cached_property
    def _units(self) -> Mapping[str, Mapping[str, DebugSpot]]:
        """Variables by unit and name, in lower case."""
        memory = self._plc.memory
        return {
            unit.name.lower(): {
                placed.variable.name.lower(): DebugSpot(
                    placed.variable.name,
                    placed.variable.type,
                    memory[placed.area].data,
                    placed.offset,
                    placed.bit,
                )
                for placed in unit.variables
            }
            for unit in self._plc.units
        }

    @cached_property
    def _lists(self) -> list[str]:
        return [
            unit.name.lower()
            for unit in self._plc.units
            if isinstance(unit.instance, GlobalVariables)
        ]

    @cached_property
    def _enums(self) -> Mapping[str, EnumType[Any]]:
        units = [type(unit.instance).__iec__ for unit in self._plc.units]
        return {
            enum.name.lower(): enum for enum in types_within(units) if isinstance(enum, EnumType)
        }


def is_long(type: IecType[Any]) -> bool:
    """Return True if a value is better shown part by part."""
    real = resolved(type)
    if isinstance(real, StructType):
        return real.kind is not RecordKind.STRUCT or real.size > _LONGEST_TEXT
    if isinstance(real, StringType):
        return False
    return real.size > _LONGEST_TEXT
