"""Frames of running calls, and memory that programs make with `__NEW`."""

from collections.abc import Iterator
from typing import Any

from achse.iec.structs import StructType
from achse.plc.code.faults import ExceptionCode, PlcFault
from achse.plc.code.views import Views
from achse.plc.memory import Area, Memory

STACK_SIZE = 1 << 20
"""Bytes for frames with variables that need an address."""

HEAP_SIZE = 1 << 22
"""Bytes for `__NEW`: they take memory of the computer as they are used."""

_ALIGNMENT = 8


class Frames:
    """A stack of frames in the stack area."""

    def __init__(self, memory: Memory, views: Views) -> None:
        memory.grow({Area.STACK: STACK_SIZE})
        self._region = memory[Area.STACK]
        self._views = views
        self._top: Any = [0]
        self._floor = 0
        """Frames below are those of a cycle that a debugger holds."""

    def share(self, top: Any) -> None:
        """Count in a word that machine code counts in as well."""
        self._top = top

    def clear(self) -> None:
        """Drop all frames but those of halted calls."""
        self._top[0] = self._floor

    def hold(self) -> None:
        """Keep the frames that there are, whatever runs meanwhile."""
        self._floor = self._top[0]

    def let_go(self) -> None:
        """Release the halted frames: their cycle continues."""
        self._top[0], self._floor = self._floor, 0

    def enter(self, size: int, image: bytes) -> int:
        """Return the offset of a new frame that begins as `image`. STACK_OVERFLOW if there is no
        room."""
        start: int = self._top[0]
        end = start + (size + _ALIGNMENT - 1 & -_ALIGNMENT)
        if end > STACK_SIZE:
            raise PlcFault(ExceptionCode.STACK_OVERFLOW, f"{STACK_SIZE} bytes of frames are full")
        self._top[0] = end
        self._region.data[start : start + size] = image
        return start

    def leave(self, start: int) -> None:
        """Drop the frame at that offset, and all after it."""
        self._top[0] = start


class Heap:
    """Memory blocks by first fit: what is free is known by offset and size."""

    def __init__(self, memory: Memory) -> None:
        memory.grow({Area.HEAP: HEAP_SIZE})
        self._memory = memory
        self._free: list[tuple[int, int]] = []
        self._used: dict[int, int] = {}
        self._records: dict[int, tuple[StructType[Any], int]] = {}
        self.clear()

    def clear(self) -> None:
        """Forget all used bytes and records."""
        self._free = [(0, HEAP_SIZE)]
        self._used.clear()
        self._records.clear()

    def allocate(self, size: int) -> int:
        """Return the address of new bytes; 0 if there are not so many in one piece."""
        size = max(size + _ALIGNMENT - 1 & -_ALIGNMENT, _ALIGNMENT)
        for number, (offset, room) in enumerate(self._free):
            if room >= size:
                if room == size:
                    del self._free[number]
                else:
                    self._free[number] = (offset + size, room - size)
                self._used[offset] = size
                return self._memory.address(Area.HEAP, offset)
        return 0

    def holds(self, address: int, of: StructType[Any], count: int) -> None:
        """Say what is in the bytes at an address."""
        self._records[address] = (of, count)

    def allocations(self) -> Iterator[tuple[int, StructType[Any], int]]:
        """Address, type and number of all records."""
        for address, (of, count) in self._records.items():
            yield address, of, count

    def allocation(self, address: int) -> tuple[StructType[Any], int] | None:
        """Return the records that are there; None if there are others or none."""
        return self._records.get(address)

    def free(self, address: int) -> None:
        """Free bytes. Raises PlcFault ACCESS_VIOLATION if they are not in use."""
        offset = address - self._memory.address(Area.HEAP, 0)
        size = self._used.pop(offset, None)
        if size is None:
            raise PlcFault(
                ExceptionCode.ACCESS_VIOLATION,
                f"__DELETE of 16#{address:X}, which __NEW did not make",
            )
        self._records.pop(address, None)
        self._free.append((offset, size))
        self._merge()

    def covers(self, offset: int, size: int) -> bool:
        """Return True if all of these bytes are in one block in use."""
        return any(
            start <= offset and offset + size <= start + room for start, room in self._used.items()
        )

    def _merge(self) -> None:
        self._free.sort()
        merged: list[tuple[int, int]] = []
        for offset, size in self._free:
            if merged and merged[-1][0] + merged[-1][1] == offset:
                merged[-1] = (merged[-1][0], merged[-1][1] + size)
            else:
                merged.append((offset, size))
        self._free = merged

    @property
    def used(self) -> int:
        """Bytes in use."""
        return sum(self._used.values())
