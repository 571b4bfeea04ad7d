"""BuiltinMemory: what built-in routines and Python classes see of their PLC."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from achse.iec.structs import Record, StructType
from achse.iec.types import IecType
from achse.plc.code.execution import Execution
from achse.plc.code.faults import PlcFault
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.plc.routines.symbol_places import SymbolPlace, SymbolPlaces


class BuiltinMemory:
    """Memory, time and records of one PLC, for routines that have no Structured Text.

    `epoch()` is the Unix time at time 0, ns.
    """

    def __init__(self, epoch: Callable[[], int]) -> None:
        self._epoch = epoch
        self._clock_ns: Callable[[], int] = int
        self._task_index: Callable[[], int] = int
        self._memory: Memory | None = None
        self._execution: Execution | None = None
        self._records: dict[int, Record] = {}
        self._symbols: SymbolPlaces | None = None

    def place(
        self,
        memory: Memory,
        variables: Sequence[PlacedVariable],
        clock_ns: Callable[[], int],
        task_index: Callable[[], int],
    ) -> None:
        """Use this memory, these variables, this time and task from now on."""
        self._memory = memory
        self._symbols = SymbolPlaces(memory, variables)
        self._clock_ns, self._task_index = clock_ns, task_index

    def link(self, execution: Execution) -> None:
        """Use the heap and the budget of this code."""
        self._execution = execution

    def forget(self) -> None:
        """Drop all records: their memory is to move."""
        self._records.clear()

    def load_bytes(self, address: int, size: int) -> bytes:
        """Return bytes of PLC memory. Raises PlcFault ACCESS_VIOLATION for an address outside."""
        data: bytes = self._linked().namespace["load_bytes"](address, size)
        return data

    def store_bytes(self, address: int, data: bytes) -> object:
        """Write bytes to PLC memory. Raises PlcFault ACCESS_VIOLATION for an address outside."""
        return self._linked().namespace["store_bytes"](address, data)

    def spend(self, size: int) -> None:
        """Count moved bytes. Raises PlcFault CYCLE_TIME_EXCEED if a cycle moves too many."""
        self._linked().spend(size)

    def make_bytes(self, data: bytes) -> int:
        """Allocate these bytes; the address, 0 if memory is full."""
        address = self._linked().heap.allocate(len(data))
        if address:
            self.store_bytes(address, data)
        return address

    def free_bytes(self, address: int) -> None:
        """Free bytes of `make_bytes`; other addresses are ignored."""
        with suppress(PlcFault):
            self._linked().heap.free(address)

    @property
    def time_ns(self) -> int:
        """The time of the running cycle."""
        return self._clock_ns()

    @property
    def unix_ns(self) -> int:
        """The time of the running cycle since 1970."""
        return self._epoch() + self._clock_ns()

    def area_of(self, address: int, size: int) -> Area | None:
        """Return the area that all of these bytes are in, as far as they are in use."""
        assert self._memory is not None
        place = self._memory.at(address)
        if place is None:
            return None
        region, offset = place
        area = next(area for area, one in self._memory.regions.items() if one is region)
        if area is Area.HEAP:
            return area if self._linked().heap.covers(offset, size) else None
        return area if offset + size <= len(region) else None

    def symbol_named(self, name: str) -> SymbolPlace | None:
        """Return the variable, or part of one, of that name."""
        return None if self._symbols is None else self._symbols.named(name)

    def symbol_at(self, address: int, size: int) -> SymbolPlace | None:
        """Return the variable, or part of one, with that address and size."""
        return None if self._symbols is None else self._symbols.at(address, size)

    def type_named(self, name: str) -> IecType[Any] | None:
        """Return the type of that name that a variable, or a part of one, has."""
        return None if self._symbols is None else self._symbols.type_named(name)

    @property
    def task_number(self) -> int:
        """The running task, from 1."""
        return self._task_index()

    def record_at(self, address: int, type: StructType[Any]) -> Record:
        """Return the record at an address, the same object while a block of its kind is there."""
        record, wanted = self._records.get(address), type.record
        # Frames of routines put other blocks at the same place, one after the other.
        if record is None or not (
            isinstance(record, wanted) or issubclass(wanted, record.__class__)
        ):
            assert self._memory is not None
            place = self._memory.at(address)
            if place is None:
                raise IndexError(f"no memory at address 16#{address:X}")
            region, offset = place
            record = self._records[address] = type.read(region.data, offset)
        return record

    def _linked(self) -> Execution:
        assert self._execution is not None, "link comes first"
        return self._execution
