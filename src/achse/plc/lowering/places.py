"""Places: what a storage of the typed form is in the memory of this PLC, and what reaches it."""

from bisect import bisect_left
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from achse.iec.arrays import ArrayType
from achse.iec.elementary import IntegerType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Variable
from achse.plc.lowering import nodes
from achse.plc.lowering.project import LoweredProject
from achse.plc.memory import Area
from achse.st.check.kinds import UNSIGNED, counted
from achse.st.typed.expressions import Conversion, Converted, Known, TypedValue
from achse.st.typed.places import (
    CalleeBase,
    FrameBase,
    IndexStep,
    InstanceBase,
    PointerBase,
    Storage,
    TemporaryBase,
)
from achse.st.typed.project import Routine

BYTES_A_PASS = 1024
"""Bytes that are copied as long as a loop passes once: so many take one from the budget."""

ADDRESS_TYPE = UNSIGNED[8]


class PresentCallee(NamedTuple):
    """Present referent of CalleeBase: an instance, or the outputs of a call by their offsets."""

    instance: nodes.ResolvedPlace | None
    outputs: Mapping[int, nodes.Temporary]


class PlaceLowering:
    """Lowers the storages of one routine. `in_memory` are variables that the frame has."""

    def __init__(
        self, project: LoweredProject, routine: Routine, in_memory: frozenset[str]
    ) -> None:
        self.project = project
        self.routine = routine
        self.in_memory = in_memory
        self.callees: list[PresentCallee] = []
        self.changes = 0
        """Number of values so far that may change memory."""
        self.texts = 0
        """Text functions and conversions of the present list of statements so far."""
        self._temporaries = 0
        self._variables = sorted(routine.frame.fields, key=lambda field: field.offset)
        self._offsets = [variable.offset for variable in self._variables]

    def value(self, value: TypedValue) -> nodes.LoweredValue:
        raise NotImplementedError

    def temporary(self, type: IecType[Any] | None) -> nodes.Temporary:
        """Return a temporary that nothing else uses."""
        self._temporaries += 1
        return nodes.Temporary(self._temporaries, type)

    def operands(self, values: Iterable[TypedValue]) -> tuple[nodes.LoweredValue, ...]:
        """Lower values that are evaluated one after the other: texts and records are copied if a
        later one may change memory."""
        lowered: list[nodes.LoweredValue] = []
        changes: list[int] = []
        for value in values:
            lowered.append(self.value(value))
            changes.append(self.changes)
        for number, one in enumerate(lowered):
            type = one.type
            if changes[number] != self.changes and type is not None and not is_number(type):
                lowered[number] = nodes.Copy(one, type)
        return tuple(lowered)

    # where it is -----------------------------------------------------------------------------

    def place(self, storage: Storage) -> nodes.ResolvedPlace:
        base = storage.base
        place = nodes.ResolvedPlace(nodes.Home.AREA, storage.offset, storage.type, storage.bit)
        match base:
            case InstanceBase():
                assert self.routine.this is not None
                place.home, place.alignment = nodes.Home.INSTANCE, self.routine.this.alignment
            case FrameBase():
                self._in_frame(place, self.frame_variable(storage.offset))
            case TemporaryBase(variable):
                place.offset += variable.offset
                self._in_frame(place, variable)
            case PointerBase(address):
                place.home, place.address = nodes.Home.ADDRESS, self.value(address)
            case CalleeBase():
                instance = self.callees[-1].instance
                assert instance is not None
                place.home, place.variable = instance.home, instance.variable
                place.area, place.address = instance.area, instance.address
                place.alignment = instance.alignment
                place.offset += instance.offset
            case _:
                spot = self.project.spot(base)
                place.area = spot.area
                place.offset += spot.offset
                if spot.bit is not None:
                    place.bit = spot.bit
        if storage.steps:
            self._index(place, storage.steps)
        return place

    def frame_variable(self, offset: int) -> Variable[Any, Any]:
        """Return the variable of the frame that has the byte at `offset`."""
        number = bisect_left(self._offsets, offset)
        if number == len(self._offsets) or self._offsets[number] != offset:
            number -= 1
        if number >= 0:
            variable = self._variables[number]
            if offset < variable.offset + max(variable.type.size, 1):
                return variable
        raise AssertionError(f"{self.routine.name}: nothing in the frame at {offset}")

    def _in_frame(self, place: nodes.ResolvedPlace, variable: Variable[Any, Any]) -> None:
        place.variable = variable
        if variable.name.lower() in self.in_memory:
            place.home, place.area = nodes.Home.FRAME, Area.STACK
        else:
            place.home = nodes.Home.LOCAL
            place.offset -= variable.offset

    def _index(self, place: nodes.ResolvedPlace, steps: tuple[IndexStep, ...]) -> None:
        """Add the indexes: of those that are constant, the bytes."""
        terms: list[nodes.Term] = []
        for step in steps:
            stride, index, low = step.stride, step.index, self.value(step.first)
            is_checked = step.last is not None and not _never_outside(step)
            place.is_bounded = place.is_bounded and step.last is not None
            if isinstance(low, Known):
                place.offset -= int(low.value) * stride
            else:
                low = nodes.Keep(self.temporary(low.type), low, is_repeatable=True)
            if isinstance(index, Known) and not is_checked:
                place.offset += int(index.value) * stride
            elif step.last is not None and is_checked:
                terms.append(nodes.Term(self.value(index), stride, low, self.value(step.last)))
            else:
                terms.append(nodes.Term(self.value(index), stride))
            if isinstance(low, nodes.Keep):
                terms.append(nodes.Term(low.temporary if is_checked else low, -stride))
        place.terms = tuple(terms)

    # what reaches it -------------------------------------------------------------------------

    def read(self, storage: Storage) -> nodes.LoweredValue:
        """Return the value in a storage; a large one takes from the budget."""
        if isinstance(storage.base, CalleeBase):
            callee = self.callees[-1]
            if callee.instance is None:
                return callee.outputs[storage.offset]
        place = self.place(storage)
        spends = place.home is not nodes.Home.LOCAL and is_large(storage.type)
        return self._with_value(storage, nodes.LoadValue(place, spends))

    def address(self, storage: Storage, type: IecType[Any] = ADDRESS_TYPE) -> nodes.LoweredValue:
        return self._with_value(storage, nodes.PlaceAddress(self.place(storage), type))

    def store(self, storage: Storage, value: TypedValue, *, alone: bool) -> nodes.LoweredValue:
        """Return an assignment; `alone` as a statement, where the value of a number comes first if
        no address is computed."""
        place, lowered = self.place(storage), self.value(value)
        self.changes += 1
        type = place.type
        value_first = alone and place.bit is None and is_number(type)
        value_first = value_first and place.is_aligned(type.size)
        return self._with_value(storage, nodes.StoreValue(place, lowered, value_first))

    def latch(self, storage: Storage, value: TypedValue, *, sets: bool) -> nodes.LoweredValue:
        """S= or R= in an expression: its place first, then the value, which it is."""
        place = self.place(storage)
        effects: list[nodes.LoweredValue] = []
        if not place.is_fixed:
            pointer = self.temporary(ADDRESS_TYPE)
            effects.append(nodes.Keep(pointer, nodes.PlaceAddress(place, ADDRESS_TYPE)))
            place = nodes.ResolvedPlace(
                nodes.Home.ADDRESS, 0, place.type, place.bit, address=pointer
            )
        state = self.temporary(place.type)
        self.changes += 1
        effects.append(nodes.Keep(state, self.value(value)))
        store = nodes.StoreValue(place, Known(sets, place.type))
        effects.append(nodes.LazyChoice(state, store, Known(False, place.type), place.type))
        return self._with_value(storage, nodes.Sequence(tuple(effects), state))

    def _with_value(self, storage: Storage, value: nodes.LoweredValue) -> nodes.LoweredValue:
        """Return a value that reaches a storage, after what is put into it if it is a hidden
        variable."""
        base = storage.base
        if not isinstance(base, TemporaryBase):
            return value
        assert base.value.type is not None
        hidden = Storage(FrameBase(), base.variable.offset, base.value.type)
        return nodes.Sequence(
            (nodes.StoreValue(self.place(hidden), self.value(base.value)),), value
        )


def is_large(type: IecType[Any] | None) -> bool:
    """Return True if values of the type take from the budget by their length."""
    if isinstance(type, StringType):
        return type.length * type.unit >= BYTES_A_PASS
    return isinstance(type, StructType | ArrayType) and type.size >= BYTES_A_PASS


def is_number(type: IecType[Any]) -> bool:
    """Return True if values of a type are numbers, no memory that is copied."""
    return not isinstance(type, StructType | ArrayType | StringType)


def _never_outside(step: IndexStep) -> bool:
    """Return True if the type of an index, or its value, keeps it in its bounds."""
    first, last, index = step.first, step.last, step.index
    if not isinstance(first, Known) or not isinstance(last, Known):
        return False
    if isinstance(index, Known):
        return int(first.value) <= int(index.value) <= int(last.value)
    if not isinstance(index, Converted) or index.rule is not Conversion.EXTEND:
        return False
    type = index.operand.type
    if not isinstance(type, IntegerType):
        return False
    whole = counted(type)
    return int(first.value) <= whole.low and whole.high <= int(last.value)
