"""Storages in machine code: reading, writing and addressing what a name or path means.

What is in an area at an offset that is known needs no check. An address of the PLC is looked up
in the table of areas each time: machine code never reaches what is not PLC memory.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.elementary import BoolType, IntegerType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.native.backend import BOOL, I64, U8, U64, LocalVariable, Operand, Relation
from achse.plc.code.storages import BYTES_A_PASS
from achse.plc.layout import parts_without_headers
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    is_number,
    machine_type,
)
from achse.plc.memory import Area
from achse.st.check.kinds import counted
from achse.st.typed.expressions import Conversion, Converted, Known, TypedValue
from achse.st.typed.places import (
    CalleeBase,
    FrameBase,
    ImageBase,
    IndexStep,
    InstanceBase,
    PointerBase,
    StaticBase,
    Storage,
    TemporaryBase,
    UnitBase,
)

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

__all__ = ["Aim", "MachineStorages", "OwnBytes", "Shape"]

_HALF_WORD = 32


@dataclass(slots=True)
class OwnBytes:
    """A variable of the frame that no address leads to: a text or record on the stack."""

    room: Operand
    size: int
    length: LocalVariable | None = None
    """Of a text, in bytes."""


@dataclass(slots=True)
class Shape:
    """Location of a storage, as far as it is known without computing."""

    storage: Storage
    offset: int
    bit: int | None
    area: Area | None = None
    """Of variables of units; also of the frame, which is at a place of its own in it."""
    local: LocalVariable | None = None
    variable: Variable[Any, Any] | None = None
    """The one that `local` is."""
    own: "OwnBytes | None" = None
    """Of a text or record that needs no address."""
    is_instance: bool = False
    is_frame: bool = False
    alignment: int = 8
    is_bounded: bool = True
    """True if all indexes have bounds that are constants."""

    @property
    def is_direct(self) -> bool:
        """True if it is reached without looking an address up."""
        return self.is_bounded and (self.area is not None or self.is_instance)


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

    # what a storage is -----------------------------------------------------------------------

    def shape(self, storage: Storage) -> Shape:
        """Return the location of a storage, as far as it is known without computing."""
        of = self._of
        base = storage.base
        while isinstance(base, CalleeBase):
            storage = of.calls.storage_of(storage)
            base = storage.base
        found = Shape(storage, storage.offset, storage.bit)
        match base:
            case UnitBase() | StaticBase() | ImageBase():
                spot = of.module.spot(base)
                found.area = spot.area
                found.offset += spot.offset
                if spot.bit is not None:
                    found.bit = spot.bit
                size = max(storage.type.size, 1)
                if not storage.steps and found.offset + size > of.module.room(spot.area):
                    raise NotTranslatedError("a direct address is beyond the process image")
            case InstanceBase():
                assert of.routine.this is not None
                found.is_instance = True
                found.alignment = of.routine.this.alignment
            case FrameBase():
                variable = of.frame_variable(storage.offset)
                local = of.locals.get(variable.name.lower())
                if isinstance(local, OwnBytes):
                    if storage.offset != variable.offset or storage.steps:
                        raise NotTranslatedError(f"a part of {variable.name} is used")
                    found.own = local
                elif local is not None:
                    found.local, found.variable = local, variable
                    found.offset = storage.offset - variable.offset
                else:
                    found.is_frame, found.area = True, Area.STACK
            case TemporaryBase(variable):
                if variable.name.lower() not in of.routine.addressed:
                    raise NotTranslatedError("a hidden variable without an address")
        for step in storage.steps:
            if not isinstance(step.first, Known) or not isinstance(step.last, Known):
                found.is_bounded = False
            if isinstance(step.first, Known):
                assert isinstance(step.first.value, int)
                found.offset -= step.first.value * step.stride
                if isinstance(step.index, Known) and _is_within(step):
                    assert isinstance(step.index.value, int)
                    found.offset += step.index.value * step.stride
        return found

    def comes_first(self, shape: Shape) -> bool:
        """Return True if, in an assignment of its own, the value is computed before the index, as
        in plain code, which is the case for numbers at their alignment."""
        if not shape.is_direct or shape.bit is not None or not is_number(shape.storage.type):
            return False
        size = shape.storage.type.size
        based = shape.is_instance or shape.is_frame
        aligned = shape.offset % size == 0 and (not based or shape.alignment % size == 0)
        return aligned and not any(step.stride % size for step in shape.storage.steps)

    # where it is -----------------------------------------------------------------------------

    def aim(self, shape: Shape) -> Aim:
        """Compute where a storage is, with the checks of its indexes."""
        of = self._of
        b = of.builder
        if shape.is_direct:
            if shape.is_instance:
                of.uses_instance = True
                if is_number(shape.storage.type):
                    of.aligned_instance = True
                base = of.instance
            elif shape.is_frame:
                base = of.frame
            else:
                assert shape.area is not None
                base = of.area(shape.area)
            for index, stride in self._terms(shape):
                base = b.address(base, index, stride)
            return Aim(base, shape.offset)
        if isinstance(shape.storage.base, TemporaryBase) and shape.is_bounded:
            base = self._kept(shape.storage.base)
            for index, stride in self._terms(shape):
                base = b.address(base, index, stride)
            return Aim(base, shape.offset)
        return Aim(self._plc_address(shape), 0, is_plc=True)

    def _kept(self, base: TemporaryBase) -> Operand:
        """Put the value of a hidden variable into it; its machine address."""
        of = self._of
        assert base.value.type is not None
        kept = Storage(FrameBase(), base.variable.offset, base.value.type)
        self.store(kept, lambda: of.value(base.value))
        return of.builder.address(of.frame, base.variable.offset)

    def _terms(self, shape: Shape) -> list[tuple[Operand, int]]:
        """Return the offsets of index steps that the shape does not include: numbers and
        strides."""
        of = self._of
        b = of.builder
        found: list[tuple[Operand, int]] = []
        for step in shape.storage.steps:
            if isinstance(step.first, Known) and isinstance(step.index, Known) and _is_within(step):
                continue
            index = b.convert(of.number(step.index), I64)
            first = b.convert(of.number(step.first), I64)
            if step.last is not None and not _never_outside(step):
                last = b.convert(of.number(step.last), I64)
                self._check(index, first, last)
            found.append((index, step.stride))
            if not isinstance(step.first, Known):
                found.append((first, -step.stride))
        return found

    def _check(self, index: Operand, first: Operand, last: Operand) -> None:
        """ARRAYBOUNDS unless an index is within."""
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

    def _plc_address(self, shape: Shape) -> Operand:
        """U64: what a pointer to the storage holds."""
        of = self._of
        b = of.builder
        base = shape.storage.base
        offset = shape.offset
        if isinstance(base, PointerBase):
            address = b.convert(of.number(base.address), U64)
        elif isinstance(base, TemporaryBase):
            self._kept(base)
            address = of.frame_offset
            offset += of.module.address_of(Area.STACK) + base.variable.offset
        elif shape.is_instance:
            address = of.this
        elif shape.is_frame:
            offset += of.module.address_of(Area.STACK)
            address = of.frame_offset
        elif shape.area is not None:
            address = b.constant(U64, 0)
            offset += of.module.address_of(shape.area)
        else:
            raise NotTranslatedError("the address of a variable in a register")
        for index, stride in self._terms(shape):
            if stride != 1:
                index = b.multiply(index, b.constant(I64, stride))
            address = b.add(address, b.convert(index, U64))
        if offset:
            if address.is_constant:
                return b.constant(U64, int(address.text) + offset & (1 << 64) - 1)
            return b.add(address, b.constant(U64, offset & (1 << 64) - 1))
        return address

    def address(self, storage: Storage) -> Operand:
        """U64: what a pointer to the storage holds."""
        return self._plc_address(self.shape(storage))

    def reach(self, aim: Aim, size: int | Operand) -> tuple[Operand, int]:
        """A machine address and an offset, where that many bytes are; ACCESS_VIOLATION if not."""
        if not aim.is_plc:
            return aim.base, aim.offset
        return self.looked_up(aim.base, size), 0

    def looked_up(self, address: Operand, size: int | Operand) -> Operand:
        """The machine address of an address of the PLC."""
        of = self._of
        b = of.builder
        wanted = b.constant(I64, size) if isinstance(size, int) else size
        (found,) = b.call(of.module.support.locate, address, wanted)
        b.require(b.convert(found, BOOL), of.site(FaultKind.ACCESS), address)
        return found

    # reading ---------------------------------------------------------------------------------

    def read(self, storage: Storage) -> MachineValue:
        """Return the value in a storage."""
        shape = self.shape(storage)
        if shape.own is not None:
            return self._read_own(shape.own)
        if shape.local is not None:
            return self._read_local(shape)
        of = self._of
        b = of.builder
        type = storage.type
        aim = self.aim(shape)
        if isinstance(type, StringType):
            limit = type.length * type.unit
            base, offset = self.reach(aim, limit)
            base = b.address(base, offset)
            (length,) = b.call(of.module.support.length(type.unit), base, b.constant(I64, limit))
            if limit >= BYTES_A_PASS:
                passes = b.shift_right(length, b.constant(I64, BYTES_A_PASS.bit_length() - 1))
                b.spend(passes, of.site(FaultKind.BUDGET))
            return MachineText(base, length)
        if isinstance(type, StructType | ArrayType):
            base, offset = self.reach(aim, type.size)
            self._spend(type.size)
            return PackedBytes(b.address(base, offset), type.size)
        if shape.bit is not None:
            base, offset = self.reach(aim, 1)
            mask = b.constant(U8, 1 << shape.bit)
            return b.convert(b.bit_and(b.load(U8, base, offset), mask), BOOL)
        base, offset = self.reach(aim, type.size)
        return b.load(machine_type(type), base, offset)

    def _spend(self, size: int) -> None:
        """A large value takes from the budget."""
        if size >= BYTES_A_PASS:
            self._of.builder.spend(size // BYTES_A_PASS, self._of.site(FaultKind.BUDGET))

    def _read_own(self, own: OwnBytes) -> MachineValue:
        if own.length is None:
            return PackedBytes(own.room, own.size)
        return MachineText(own.room, self._of.builder.get(own.length))

    def _store_own(self, own: OwnBytes, given: MachineValue) -> MachineValue:
        b = self._of.builder
        if isinstance(given, MachineText):
            assert own.length is not None
            b.copy(own.room, given.address, given.length)
            b.set(own.length, given.length)
        else:
            assert isinstance(given, PackedBytes)
            b.copy(own.room, given.address, own.size)
        return self._read_own(own)

    def _read_local(self, shape: Shape) -> Operand:
        assert shape.local is not None
        assert shape.variable is not None
        b = self._of.builder
        value = b.get(shape.local)
        if shape.bit is not None and not isinstance(resolved(shape.variable.type), BoolType):
            mask = b.constant(value.type, _bit_of(value.type.bits, shape.offset * 8 + shape.bit))
            return b.convert(b.bit_and(value, mask), BOOL)
        return self._of.at_type(value, machine_type(shape.storage.type))

    # writing ---------------------------------------------------------------------------------

    def store(
        self, storage: Storage, value: Callable[[], MachineValue], *, alone: bool = False
    ) -> MachineValue:
        """Compute a value and put it into a storage; gives it back.

        `alone`: as a statement, not within an expression.
        """
        of = self._of
        shape = self.shape(storage)
        if shape.own is not None:
            return self._store_own(shape.own, value())
        if shape.local is not None:
            return self._store_local(shape, value())
        if alone and self.comes_first(shape):
            given = value()
            aim = self.aim(shape)
        else:
            aim = self.aim(shape)
            given = value()
        if isinstance(given, MachineText):
            return self._store_text(aim, storage.type, given)
        if isinstance(given, PackedBytes):
            return self._store_packed(aim, storage, given)
        b = of.builder
        if shape.bit is not None:
            base, offset = self.reach(aim, 1)
            self._put_bit(base, offset, 1 << shape.bit, given)
            return given
        given = of.at_type(given, machine_type(storage.type))
        base, offset = self.reach(aim, storage.type.size)
        b.store(given, base, offset)
        return given

    def _put_bit(self, base: Operand, offset: int, mask: int, state: Operand) -> None:
        b = self._of.builder
        place = b.address(base, offset)
        old = b.load(U8, place)
        yes = b.bit_or(old, b.constant(U8, mask))
        no = b.bit_and(old, b.constant(U8, 0xFF & ~mask))
        b.store(b.select(state, yes, no), place)

    def _store_local(self, shape: Shape, given: MachineValue) -> Operand:
        assert shape.local is not None
        assert shape.variable is not None
        assert isinstance(given, Operand)
        b, local = self._of.builder, shape.local
        if shape.bit is None or isinstance(resolved(shape.variable.type), BoolType):
            b.set(local, self._of.at_type(given, local.type))
            return given
        old = b.get(local)
        bit = shape.offset * 8 + shape.bit
        bits = local.type.bits
        yes = b.bit_or(old, b.constant(local.type, _bit_of(bits, bit, local.type.signed)))
        no = b.bit_and(
            old, b.bit_not(b.constant(local.type, _bit_of(bits, bit, local.type.signed)))
        )
        b.set(local, b.select(given, yes, no))
        return given

    def _store_text(self, aim: Aim, type: IecType[Any], given: MachineText) -> MachineText:
        assert isinstance(type, StringType)
        b = self._of.builder
        if aim.is_plc:
            base = self.looked_up(aim.base, b.add(given.length, b.constant(I64, type.unit)))
        else:
            base = b.address(aim.base, aim.offset)
        b.copy(base, given.address, given.length)
        end = b.address(base, given.length)
        for number in range(type.unit):
            b.store(b.constant(U8, 0), end, number)
        return MachineText(base, given.length)

    def _store_packed(self, aim: Aim, storage: Storage, given: PackedBytes) -> PackedBytes:
        of = self._of
        b = of.builder
        parts = parts_without_headers(storage.type)
        if len(parts) > 1 and not given.steady and aim.is_plc:
            given = of.snapshot(given)
        if not aim.is_plc:
            base = b.address(aim.base, aim.offset)
            for start, end in parts:
                b.copy(b.address(base, start), b.address(given.address, start), end - start)
            return given
        for start, end in parts:
            address = b.add(aim.base, b.constant(U64, start)) if start else aim.base
            base = self.looked_up(address, end - start)
            b.copy(base, b.address(given.address, start), end - start)
        return given

    def latch(
        self, storage: Storage, value: Callable[[], Operand], *, sets: bool, alone: bool = False
    ) -> Operand:
        """S= and R= of a BOOL."""
        of = self._of
        b = of.builder
        shape = self.shape(storage)
        new = b.constant(BOOL, sets)
        if alone or shape.local is not None:
            state = value()
            yes, end = b.label(), b.label()
            b.branch(state, yes, end)
            b.begin(yes)
            self.store(storage, lambda: new, alone=True)
            b.begin(end)
            return state
        aim = self.aim(shape)
        state = value()
        yes, end = b.label(), b.label()
        b.branch(state, yes, end)
        b.begin(yes)
        base, offset = self.reach(aim, 1)
        if shape.bit is None:
            b.store(new, base, offset)
        else:
            self._put_bit(base, offset, 1 << shape.bit, new)
        b.begin(end)
        return state


def _bit_of(bits: int, number: int, signed: bool = True) -> int:
    """The number that has one bit set, of that many bits."""
    found = 1 << number
    return found - (1 << bits) if signed and number == bits - 1 else found


def _signed(word: int) -> int:
    word &= (1 << 64) - 1
    return word - (1 << 64) if word >> 63 else word


def _is_within(step: IndexStep) -> bool:
    """Return True if a constant index is in its bounds."""
    parts = (step.first, step.index, step.last)
    numbers = [part.value for part in parts if isinstance(part, Known)]
    if len(numbers) < len(parts):
        return False
    low, index, high = numbers
    assert isinstance(low, int)
    assert isinstance(index, int)
    assert isinstance(high, int)
    return low <= index <= high


def _never_outside(step: IndexStep) -> bool:
    """Return True if the type of an index keeps it in its bounds."""
    assert step.last is not None
    if not isinstance(step.first, Known) or not isinstance(step.last, Known):
        return False
    index: TypedValue = step.index
    if isinstance(index, Known):
        return _is_within(step)
    if not isinstance(index, Converted) or index.rule is not Conversion.EXTEND:
        return False
    type = index.operand.type
    if not isinstance(type, IntegerType):
        return False
    whole = counted(type)
    low, high = step.first.value, step.last.value
    assert isinstance(low, int)
    assert isinstance(high, int)
    return low <= whole.low and whole.high <= high
