"""Library routines without Structured Text: Python functions by the key of the routine.

A function accepts the values of its inputs and returns its result. A block accepts its instance as
a record, with attributes for inputs and outputs.
"""

import math
from collections.abc import Callable, Mapping
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal, localcontext
from typing import Any, Protocol

from achse.iec.types import IecType
from achse.plc.memory import Area
from achse.plc.routines.symbol_places import SymbolPlace

_UNIX_EPOCH = 116_444_736_000_000_000
"""1970 in steps of 100 ns since 1601."""

_WRONG_ARGUMENTS = 0xFF
"""Result of MEMCMP for a pointer that is 0, or for no bytes."""

_LONGEST_REAL = 510
"""Characters of a number as text."""


class BuiltinContext(Protocol):
    """Interface of the PLC to a built-in."""

    def load_bytes(self, address: int, size: int) -> bytes:
        """Return bytes of PLC memory. Raises PlcFault ACCESS_VIOLATION for an address outside."""
        ...

    def store_bytes(self, address: int, data: bytes) -> object:
        """Write bytes to PLC memory. Raises PlcFault ACCESS_VIOLATION for an address outside."""
        ...

    def spend(self, size: int) -> None:
        """Count moved bytes. Raises PlcFault CYCLE_TIME_EXCEED if a cycle moves too many."""
        ...

    def make_bytes(self, data: bytes) -> int:
        """Allocate these bytes; the address, 0 if memory is full."""
        ...

    def free_bytes(self, address: int) -> None:
        """Free bytes of `make_bytes`; other addresses are ignored."""
        ...

    @property
    def time_ns(self) -> int:
        """The time of the running cycle."""
        ...

    @property
    def unix_ns(self) -> int:
        """The same since 1970, UTC."""
        ...

    def area_of(self, address: int, size: int) -> Area | None:
        """Return the area that all of these bytes are in, as far as they are in use."""
        ...

    def symbol_named(self, name: str) -> SymbolPlace | None:
        """Return the variable, or part of one, of that name."""
        ...

    def symbol_at(self, address: int, size: int) -> SymbolPlace | None:
        """Return the variable, or part of one, with that address and size."""
        ...

    def type_named(self, name: str) -> IecType[Any] | None:
        """Return the type of that name that a variable, or a part of one, has."""
        ...

    @property
    def task_number(self) -> int:
        """The running task, from 1."""
        ...


FunctionBody = Callable[..., Any]
BlockBody = Callable[[BuiltinContext, Any], None]


class Services(Protocol):
    """Built-in routines that work with what is outside of the PLC, between its cycles."""

    @property
    def functions(self) -> Mapping[str, FunctionBody]: ...

    @property
    def blocks(self) -> Mapping[str, BlockBody]: ...

    def begin_cycle(self, plc: BuiltinContext) -> None:
        """Note that a cycle is about to begin: what came since the last one may be put into
        memory."""
        ...

    def end_cycle(self) -> None:
        """Note that a cycle has ended, with or without a fault."""
        ...

    def forget(self) -> None:
        """Forget addresses: all variables begin again or have moved."""
        ...


def _memory_copy(plc: BuiltinContext, target: int, source: int, count: int) -> int:
    if not (target and source and count):
        return 0
    data = plc.load_bytes(source, count)
    plc.spend(count)
    plc.store_bytes(target, data)
    return count


def _memory_set(plc: BuiltinContext, target: int, fill: int, count: int) -> int:
    if not (target and count):
        return 0
    plc.load_bytes(target, count)  # all of it is there, before so many bytes are made
    plc.spend(count)
    plc.store_bytes(target, bytes([fill]) * count)
    return count


def _memory_compare(plc: BuiltinContext, first: int, second: int, count: int) -> int:
    if not (first and second and count):
        return _WRONG_ARGUMENTS
    left, right = plc.load_bytes(first, count), plc.load_bytes(second, count)
    plc.spend(count)
    return (left > right) - (left < right)


def _task_index(plc: BuiltinContext, block: Any) -> None:
    block.index = plc.task_number


def _cpu_counter(plc: BuiltinContext, block: Any) -> None:
    """Read the counter of 100 ns, which counts the time of the station."""
    count = plc.time_ns // 100
    block.cpuCntLoDW = count & 0xFFFF_FFFF
    block.cpuCntHiDW = count >> 32 & 0xFFFF_FFFF


def _filetime(plc: BuiltinContext) -> int:
    return plc.unix_ns // 100 + _UNIX_EPOCH


def _memory_area(plc: BuiltinContext, address: int, size: int) -> int:
    """`E_TcMemoryArea`: unknown 0, static 1, dynamic 2."""
    area = plc.area_of(address, size)
    if area is None or area is Area.STACK:
        return 0
    return 2 if area is Area.HEAP else 1


def _real_text(plc: BuiltinContext, value: float, precision: int, rounds: bool) -> bytes:
    """`[-]dddd.dddd`: decimals of the exact value, rounded half away from zero, or cut."""
    if not math.isfinite(value):
        sign = b"-" if math.copysign(1, value) < 0 else b""
        return sign + (b"#QNAN" if math.isnan(value) else b"#INF")
    with localcontext() as exact:
        exact.prec = 2000
        step = Decimal(1).scaleb(-min(max(precision, 0), 600))
        number = Decimal(value).quantize(step, ROUND_HALF_UP if rounds else ROUND_DOWN)
    text = f"{number:f}"
    if not number:
        text = text.removeprefix("-")
    return text.encode() if len(text) <= _LONGEST_REAL else b"#OVF"


FUNCTIONS: Mapping[str, FunctionBody] = {
    "memcpy": _memory_copy,
    "memmove": _memory_copy,
    "memset": _memory_set,
    "memcmp": _memory_compare,
    "f_getsystemtime": _filetime,
    "f_gettasktime": _filetime,
    "f_checkmemoryarea": _memory_area,
    "lreal_to_fmtstr": _real_text,
}
"""Functions, called with the surroundings and the values of their inputs."""

BLOCKS: Mapping[str, BlockBody] = {
    "getcurtaskindex": _task_index,
    "getcpucounter": _cpu_counter,
}
"""Bodies of function blocks, called with the surroundings and the instance."""
