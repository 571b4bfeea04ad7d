"""Places in machine code: reading, writing and addressing them.

What is in an area at an offset that is known needs no check. An address of the PLC is looked up
in the table of areas each time: machine code never reaches what is not PLC memory.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BoolType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.native.backend import BOOL, I64, U8, U32, U64, LocalVariable, Operand, Relation
from achse.plc.lowering.nodes import Home, ResolvedPlace, StoreValue
from achse.plc.lowering.places import BYTES_A_PASS, is_number
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    machine_type,
)
from achse.plc.memory import Area
from achse.plc.retention.layout import headers_within, parts_without_headers

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_HALF_WORD = 32


@dataclass(slots=True)
class OwnBytes:
    """A variable of the frame without an address: a text or record on the stack."""

    room: Operand
    size: int
    length: LocalVariable | None = None
    """Length of a text, in bytes."""


@dataclass(slots=True)
class Aim:
    """Computed location of a storage: a valid machine address, or an address of the PLC."""

    base: Operand
    offset: int
    is_plc: bool = False
    """True if `base` is the complete address of the PLC, not looked up yet."""


class MachineStorages:
    """Reads, writes and addresses storages for one routine."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions

    # where it is -----------------------------------------------------------------------------

    def _local(self, place: ResolvedPlace) -> LocalVariable | OwnBytes:
        """Return the variable that needs no memory."""
        assert place.variable is not None
        local = self._of.locals[place.variable.name.lower()]
        if isinstance(local, OwnBytes) and (place.offset or place.terms):
            raise NotTranslatedError(f"a part of {place.variable.name} is used")
        return local

    def _aim(self, place: ResolvedPlace) -> Aim:
        """Compute where a place is, with the checks of its indexes."""
        of = self._of
        if place.home is Home.ADDRESS or not place.is_bounded:
            return Aim(self.address(place), 0, is_plc=True)
        if place.home is Home.INSTANCE:
            of.uses_instance = True
            if is_number(place.type):
                of.aligned_instance = True
            base = of.instance
        elif place.home is Home.FRAME:
            base = of.frame
        else:
            base = of.area(self._area(place))
        for index, stride in self._terms(place):
            base = of.builder.address(base, index, stride)
        return Aim(base, place.offset)

    def _area(self, place: ResolvedPlace) -> Area:
        if place.area is None:
            raise NotTranslatedError("the address of a variable in a register")
        size = max(place.type.size, 1)
        if not place.terms and place.offset + size > self._of.module.room(place.area):
            raise NotTranslatedError("a direct address is beyond the process image")
        return place.area

    def _terms(self, place: ResolvedPlace) -> list[tuple[Operand, int]]:
        """Indexes and the bytes that each counts."""
        of = self._of
        b = of.builder
        terms: list[tuple[Operand, int]] = []
        for term in place.terms:
            index = b.convert(of.number(term.index), I64)
            if term.low is not None and term.high is not None:
                first = b.convert(of.number(term.low), I64)
                self._check(index, first, b.convert(of.number(term.high), I64))
            terms.append((index, term.stride))
        return terms

    def _check(self, index: Operand, first: Operand, last: Operand) -> None:
        """Raise ARRAYBOUNDS unless an index is within."""
        of = self._of
        b = of.builder
        if first.is_constant and last.is_constant and int(last.text) >= int(first.text):
            low, high = int(first.text), int(last.text)
            moved = b.subtract(index, first) if low else index
            span = b.constant(U64, high - low)
            good = b.compare(Relation.LESS_EQUAL, b.convert(moved, U64), span)
            both = b.constant(I64, _signed((low << _HALF_WORD) | (high & (1 << _HALF_WORD) - 1)))
        else:
            above = b.compare(Relation.LESS_EQUAL, first, index)
            good = b.bit_and(above, b.compare(Relation.LESS_EQUAL, index, last))
            half = b.constant(I64, _HALF_WORD)
            low_word = b.bit_and(last, b.constant(I64, (1 << _HALF_WORD) - 1))
            both = b.bit_or(b.shift_left(first, half), low_word)
        b.require(good, of.site(FaultKind.BOUNDS), index, both)

    def address(self, place: ResolvedPlace) -> Operand:
        """U64: what a pointer to the place holds."""
        of = self._of
        b = of.builder
        offset = place.offset
        if place.home is Home.ADDRESS:
            assert place.address is not None
            address = b.convert(of.number(place.address), U64)
        elif place.home is Home.INSTANCE:
            address = of.this
        else:
            offset += of.module.address_of(self._area(place))
            address = of.frame_offset if place.home is Home.FRAME else b.constant(U64, 0)
        for index, stride in self._terms(place):
            if stride != 1:
                index = b.multiply(index, b.constant(I64, stride))
            address = b.add(address, b.convert(index, U64))
        if offset:
            if address.is_constant:
                return b.constant(U64, int(address.text) + offset & (1 << 64) - 1)
            return b.add(address, b.constant(U64, offset & (1 << 64) - 1))
        return address

    def _reach(self, aim: Aim, size: int | Operand) -> tuple[Operand, int]:
        """Return a machine address and an offset, where that many bytes are; ACCESS_VIOLATION if
        not."""
        if not aim.is_plc:
            return aim.base, aim.offset
        return self.looked_up(aim.base, size), 0

    def looked_up(self, address: Operand, size: int | Operand) -> Operand:
        """Return the machine address of an address of the PLC."""
        of = self._of
        b = of.builder
        wanted = b.constant(I64, size) if isinstance(size, int) else size
        (place,) = b.call(of.module.support.locate, address, wanted)
        b.require(b.convert(place, BOOL), of.site(FaultKind.ACCESS), address)
        return place

    # reading ---------------------------------------------------------------------------------

    def read(self, place: ResolvedPlace, *, spends: bool = False) -> MachineValue:
        """Return the value in a place; `spends`: it takes from the budget."""
        if place.home is Home.LOCAL:
            local = self._local(place)
            if isinstance(local, OwnBytes):
                return self._read_own(local)
            return self._read_local(place, local)
        b, type, aim = self._of.builder, place.type, self._aim(place)
        if isinstance(type, StringType):
            limit = type.length * type.unit
            base = b.address(*self._reach(aim, limit))
            length_of = self._of.module.support.length(type.unit)
            (length,) = b.call(length_of, base, b.constant(I64, limit))
            if spends:
                self._spend(b.shift_right(length, b.constant(I64, BYTES_A_PASS.bit_length() - 1)))
            return MachineText(base, length)
        if isinstance(type, StructType | ArrayType):
            base, offset = self._reach(aim, type.size)
            if spends:
                self._spend(type.size // BYTES_A_PASS)
            return PackedBytes(b.address(base, offset), type.size)
        if place.bit is not None:
            base, offset = self._reach(aim, 1)
            mask = b.constant(U8, 1 << place.bit)
            return b.convert(b.bit_and(b.load(U8, base, offset), mask), BOOL)
        base, offset = self._reach(aim, type.size)
        return b.load(machine_type(type), base, offset)

    def _spend(self, passes: int | Operand) -> None:
        self._of.builder.spend(passes, self._of.site(FaultKind.BUDGET))

    def _read_own(self, own: OwnBytes) -> MachineValue:
        if own.length is None:
            return PackedBytes(own.room, own.size)
        return MachineText(own.room, self._of.builder.get(own.length))

    def _store_own(self, own: OwnBytes, value: MachineValue) -> MachineValue:
        b = self._of.builder
        if isinstance(value, MachineText):
            assert own.length is not None
            b.copy(own.room, value.address, value.length)
            b.set(own.length, value.length)
        else:
            assert isinstance(value, PackedBytes)
            b.copy(own.room, value.address, own.size)
        return self._read_own(own)

    def _read_local(self, place: ResolvedPlace, local: LocalVariable) -> Operand:
        assert place.variable is not None
        b = self._of.builder
        value = b.get(local)
        if place.bit is not None and not isinstance(resolved(place.variable.type), BoolType):
            mask = b.constant(value.type, _bit_of(value.type.bits, place.offset * 8 + place.bit))
            return b.convert(b.bit_and(value, mask), BOOL)
        return self._of.at_type(value, machine_type(place.type))

    # writing ---------------------------------------------------------------------------------

    def store(self, store: StoreValue) -> MachineValue:
        """Compute a value and put it into a place; returns it."""
        of, place = self._of, store.place
        if store.value_first or place.home is Home.LOCAL:
            value = of.value(store.value)
            return self.put(place, value)
        aim = self._aim(place)
        return self._put(aim, place, of.value(store.value))

    def put(self, place: ResolvedPlace, value: MachineValue) -> MachineValue:
        """Put a value into a place; returns it."""
        if place.home is not Home.LOCAL:
            return self._put(self._aim(place), place, value)
        local = self._local(place)
        if isinstance(local, OwnBytes):
            return self._store_own(local, value)
        return self._store_local(place, local, value)

    def _put(self, aim: Aim, place: ResolvedPlace, value: MachineValue) -> MachineValue:
        of = self._of
        if isinstance(value, MachineText):
            return self._store_text(aim, place.type, value)
        if isinstance(value, PackedBytes):
            return self._store_packed(aim, place.type, value)
        if place.bit is not None:
            base, offset = self._reach(aim, 1)
            self._put_bit(base, offset, 1 << place.bit, value)
            return value
        value = of.at_type(value, machine_type(place.type))
        base, offset = self._reach(aim, place.type.size)
        of.builder.store(value, base, offset)
        return value

    def _put_bit(self, base: Operand, offset: int, mask: int, state: Operand) -> None:
        b = self._of.builder
        place = b.address(base, offset)
        old = b.load(U8, place)
        yes = b.bit_or(old, b.constant(U8, mask))
        no = b.bit_and(old, b.constant(U8, 0xFF & ~mask))
        b.store(b.select(state, yes, no), place)

    def _store_local(
        self, place: ResolvedPlace, local: LocalVariable, value: MachineValue
    ) -> Operand:
        assert place.variable is not None
        assert isinstance(value, Operand)
        b = self._of.builder
        if place.bit is None or isinstance(resolved(place.variable.type), BoolType):
            b.set(local, self._of.at_type(value, local.type))
            return value
        old = b.get(local)
        mask = _bit_of(local.type.bits, place.offset * 8 + place.bit, local.type.signed)
        yes = b.bit_or(old, b.constant(local.type, mask))
        no = b.bit_and(old, b.bit_not(b.constant(local.type, mask)))
        b.set(local, b.select(value, yes, no))
        return value

    def _store_text(self, aim: Aim, type: IecType[Any], value: MachineText) -> MachineText:
        assert isinstance(type, StringType)
        b = self._of.builder
        if aim.is_plc:
            base = self.looked_up(aim.base, b.add(value.length, b.constant(I64, type.unit)))
        else:
            base = b.address(aim.base, aim.offset)
        b.copy(base, value.address, value.length)
        end = b.address(base, value.length)
        for number in range(type.unit):
            b.store(b.constant(U8, 0), end, number)
        return MachineText(base, value.length)

    def _store_packed(self, aim: Aim, type: IecType[Any], value: PackedBytes) -> PackedBytes:
        of = self._of
        b = of.builder
        parts = parts_without_headers(type)
        if len(parts) > 1 and not value.steady and aim.is_plc:
            value = of.snapshot(value)
        if not aim.is_plc:
            base = b.address(aim.base, aim.offset)
            for start, end in parts:
                b.copy(b.address(base, start), b.address(value.address, start), end - start)
            return value
        for start, end in parts:
            address = b.add(aim.base, b.constant(U64, start)) if start else aim.base
            base = self.looked_up(address, end - start)
            b.copy(base, b.address(value.address, start), end - start)
        headers = list(headers_within(type))
        base = self.looked_up(aim.base, type.size) if headers else aim.base
        for at, block in headers:  # raw memory becomes a block by an assignment
            word = U64 if block.rules.pointer_size == 8 else U32
            own, other = b.load(word, base, at), b.load(word, value.address, at)
            is_empty = b.compare(Relation.EQUAL, own, b.constant(word, 0))
            b.store(b.select(is_empty, other, own), base, at)
        return value


def _bit_of(bits: int, number: int, signed: bool = True) -> int:
    """Return the number that has one bit set, of that many bits."""
    mask = 1 << number
    return mask - (1 << bits) if signed and number == bits - 1 else mask


def _signed(word: int) -> int:
    word &= (1 << 64) - 1
    return word - (1 << 64) if word >> 63 else word
