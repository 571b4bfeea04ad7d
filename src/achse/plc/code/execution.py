"""Execution: a typed project in the memory of a PLC, ready to be called."""

import logging
import struct
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.plc.code.faults import CATCHABLE, ExceptionCode, PlcFault, code_of
from achse.plc.code.frames import Frames, Heap
from achse.plc.code.linker import Linker
from achse.plc.code.operations import OPERATIONS, real_operations
from achse.plc.code.placement import MissingPlaceError, Placement
from achse.plc.code.pointers import pointer_operations
from achse.plc.code.routines import compiled, emit_routine
from achse.plc.code.statements import TooDeepError
from achse.plc.code.texts import TEXTS
from achse.plc.code.views import Views
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable
from achse.st.check.folding import rescaled
from achse.st.typed.project import Routine, TypedProject

__all__ = ["Builtins", "Execution"]

log = logging.getLogger("achse.plc")

Builtins = Mapping[str, Callable[..., Any]]
"""Python functions that stand for routines without Structured Text, by key."""

BUDGET = 20_000_000
"""Loop passes and calls that one cycle of a task may take."""


class _Jump(Exception):
    """JMP, on its way to its mark."""

    def __init__(self, label: str) -> None:
        self.label = label


class _LoopLeft(Exception):
    """EXIT, on its way out of a list with marks."""


class _LoopGoesOn(Exception):
    """CONTINUE, on its way out of a list with marks."""


class Execution:
    """All routines of a project as functions.

    `clock_ns` gives the time of the running cycle, `task_index` the number of the running task.
    `budget` is how many loop passes and calls one cycle may take. `exceptions` is the task option
    "floating point exceptions".
    """

    def __init__(
        self,
        project: TypedProject,
        memory: Memory,
        variables: Iterable[PlacedVariable],
        *,
        builtins: Builtins | None = None,
        clock_ns: Callable[[], int] = lambda: 0,
        task_index: Callable[[], int] = lambda: 1,
        budget: int = BUDGET,
        exceptions: bool = True,
    ) -> None:
        self.project = project
        self.memory = memory
        self.budget = budget
        self._fuel = [budget]
        self._overrides = dict(builtins or {})
        placement = Placement(memory, variables)
        for static in project.statics:
            placement.add_static(static)
        self.views = Views(memory)
        self.frames = Frames(memory, self.views)
        self.heap = Heap(memory)
        self._linker = Linker(project, placement)
        self.namespace: dict[str, Any] = {
            **OPERATIONS,
            **TEXTS,
            **real_operations(exceptions=exceptions),
            **pointer_operations(self.views),
            "F": self._fuel,
            "CATCHABLE": CATCHABLE,
            "Jump": _Jump,
            "LoopLeft": _LoopLeft,
            "LoopGoesOn": _LoopGoesOn,
            "composed": _composed,
            "begin_block": self._begin_block,
            "caught": self._caught,
            "code_of": code_of,
            "delete_memory": self._delete,
            "dispatched": self._dispatched,
            "enter": self.frames.enter,
            "enum_name": _enum_name,
            "exhausted": self._exhausted,
            "leave": self.frames.leave,
            "misaligned": _misaligned,
            "new_memory": self._new,
            "queried": self._queried,
            "rescaled": rescaled,
            "system_ltime": clock_ns,
            "system_task_index": task_index,
            "system_time": lambda: clock_ns() // 1_000_000 & 0xFFFF_FFFF,
            "unavailable": _unavailable,
        }
        self.left_out: dict[str, str] = dict(project.left_out)
        """Routines that cannot run, and why."""
        self.views.renew()
        self._link()

    # functions -------------------------------------------------------------------------------

    def _link(self) -> None:
        for key, routine in self.project.routines.items():
            name = self._linker.name_of(key)
            if routine.body is None or key in self._overrides:
                self.namespace[name] = self._without_text(routine)
                continue
            try:
                lines = emit_routine(routine, self._linker)
                function = compiled(routine, lines, self.namespace, self._linker.names)
            except TooDeepError:
                self._leave_out(key, "loops and __TRY inside each other are too deep")
            except MissingPlaceError as missing:
                self._leave_out(key, f"{missing.args[0]} has no memory in this PLC")
            except (SyntaxError, RecursionError, MemoryError) as refusal:
                self._leave_out(key, f"too large or too deep for Python: {refusal}")
            else:
                self.namespace[name] = function
        self.namespace.update(self._linker.constants)
        self.namespace.update(self.views.namespace())
        self._tables: dict[int, dict[str, Callable[..., Any]]] = {
            number: {
                name: self.namespace[self._linker.name_of(key)]
                for name, key in block.table.items()
                if key in self.project.routines
            }
            for number, block in self.project.block_numbered.items()
        }

    def _leave_out(self, key: str, why: str) -> None:
        self.left_out[key] = why
        self.namespace[self._linker.name_of(key)] = lambda *_, **__: _unavailable(f"{key}: {why}")

    def _without_text(self, routine: Routine) -> Callable[..., Any]:
        found = self._overrides.get(routine.key)
        if found is not None:
            return found
        why = "it is built in, and this runtime does not have it" if routine.builtin else "no body"
        return lambda *_, **__: _unavailable(f"{routine.name}: {why}")

    def function(self, key: str) -> Callable[..., Any]:
        """The function of a routine. KeyError if there is none."""
        if key not in self.project.routines:
            raise KeyError(key)
        found: Callable[..., Any] = self.namespace[self._linker.name_of(key)]
        return found

    def renew(self) -> None:
        """See the memory as it is now."""
        self.views.renew()
        self.namespace.update(self.views.namespace())

    def refuel(self) -> None:
        """A new cycle: the whole budget, and no frame left from before."""
        self._fuel[0] = self.budget
        self.frames.clear()

    # what emitted code calls -----------------------------------------------------------------

    def _exhausted(self) -> None:
        raise PlcFault(
            ExceptionCode.CYCLE_TIME_EXCEED,
            f"{self.budget} loop passes and calls in one cycle: an endless loop?",
        )

    def _caught(self, failure: BaseException) -> None:
        """A program may catch what it likes, but not the end of its budget."""
        if self._fuel[0] < 0:
            raise failure

    def _begin_block(self, address: int, number: int) -> None:
        self.namespace["store_Q" if self._pointer_size == 8 else "store_I"](address, number)

    @property
    def _pointer_size(self) -> int:
        for block in self.project.blocks.values():
            return block.type.rules.pointer_size
        return 8

    def _number_at(self, address: int) -> int:
        if not address:
            raise PlcFault(ExceptionCode.ACCESS_VIOLATION, "a call through address 0")
        found: int = self.namespace["load_Q" if self._pointer_size == 8 else "load_I"](address)
        return found

    def _dispatched(self, address: int, name: str) -> Callable[..., Any]:
        table = self._tables.get(self._number_at(address))
        if table is None:
            raise PlcFault(
                ExceptionCode.ACCESS_VIOLATION, f"no function block at address 16#{address:X}"
            )
        if name not in table:
            _unavailable(f"{name or 'the body'} of the block is abstract or has an error")
        return table[name]

    def _queried(self, address: int, interface: str) -> int:
        if not address:
            return 0
        block = self.project.block_numbered.get(self._number_at(address))
        if block is None or (interface and interface not in block.interfaces):
            return 0
        return address

    def _new(self, of: IecType[Any], count: int, create: Callable[[int], object] | None) -> int:
        if count <= 0:
            return 0
        address = self.heap.allocate(of.size * count)
        if not address:
            return 0
        store = self.namespace["store_bytes"]
        for number in range(count):
            store(address + number * of.size, of.default)
        if create is not None:
            for number in range(count):
                create(address + number * of.size)
        if isinstance(of, StructType):
            self.heap.holds(address, of, count)
        return address

    def _delete(self, address: int) -> None:
        if not address:
            return
        held = self.heap.held(address)
        if held is not None:
            of, count = held
            block = self.project.blocks.get(of.name.lower())
            if block is not None and block.exit:
                routine = self.project.routines.get(block.exit)
                function = self.namespace[self._linker.name_of(block.exit)]
                wanted = len(routine.parameters) if routine is not None else 0
                for number in range(count):
                    function(address + number * of.size, *([False] * wanted))
        self.heap.free(address)


def _misaligned(address: int) -> None:
    raise PlcFault(
        ExceptionCode.MISALIGNMENT, f"a function block at address 16#{address:X}, not aligned"
    )


def _unavailable(why: str) -> NoReturn:
    raise PlcFault(ExceptionCode.UNRESOLVED_EXTREFS, why)


def _enum_name(number: int, names: Mapping[int, bytes]) -> bytes:
    return names.get(number) or str(number).encode()


def _composed(image: bytes, places: tuple[tuple[int, str], ...], values: tuple[Any, ...]) -> bytes:
    """A record made on the spot: an image with values put over it."""
    record = bytearray(image)
    for (offset, code), value in zip(places, values, strict=True):
        struct.pack_into(f"<{code}", record, offset, value)
    return bytes(record)
