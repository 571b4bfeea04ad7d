"""Execution: a typed project in the memory of a PLC, ready to be called."""

import logging
import struct
import sys
from collections.abc import Callable, Collection, Container, Iterable, Mapping
from dataclasses import replace
from enum import Enum
from functools import partial
from types import CodeType, FrameType
from typing import TYPE_CHECKING, Any, NoReturn

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.native.backend import compiler_installed
from achse.plc.code.code_store import CodeStore
from achse.plc.code.emitted_programs import EMITTED, EmittedProgram
from achse.plc.code.faults import CATCHABLE, ExceptionCode, PlcFault, code_of
from achse.plc.code.frames import Frames, Heap
from achse.plc.code.linker import Linker, Probe
from achse.plc.code.operations import OPERATIONS, real_operations
from achse.plc.code.pointers import pointer_operations
from achse.plc.code.routines import compiled, emit_routine, function_of, routine_code
from achse.plc.code.texts import TEXTS
from achse.plc.code.views import Views
from achse.plc.coverage.counters import CoverageCounters
from achse.plc.lowering.digest import project_digest
from achse.plc.lowering.placement import MissingPlaceError, Placement
from achse.plc.lowering.places import BYTES_A_PASS
from achse.plc.lowering.project import LoweredProject
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.project import Routine, TypedProject
from achse.st.typed.statements import TypedStatement, TypedStatements

if TYPE_CHECKING:
    from achse.plc.machine.program import MachineProgram

log = logging.getLogger("achse.plc")

Builtins = Mapping[str, Callable[..., Any]]
"""Python functions that stand for routines without Structured Text, by key."""

Listener = Callable[[tuple[Any, ...], Mapping[str, Any]], object]
"""Callback for a call: the arguments in order, and the arguments by name."""


class CodeForm(Enum):
    """Form of the emitted routines."""

    PLAIN = "plain"
    """Functions of Python."""
    MACHINE = "machine"
    """Machine code, as far as they can be translated; needs llvmlite."""
    AUTO = "auto"
    """Machine code where llvmlite is installed."""


BUDGET = 5_000_000
"""Loop passes and calls that one cycle of a task may take: a second or less."""

DEEPEST_CALLS = 2000
"""Calls inside each other, wherever the station itself is called from."""

_CATCHES = 1000
"""Most exceptions that a program may catch in a cycle that does nothing else."""

_FEWEST_CACHED = 50
"""Routines from which on their compiled code is kept in the user's cache."""

_OVERFLOWS = 50
"""The same of stack overflows, which take long to unwind."""


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
    "floating point exceptions". `after` is the execution that this one follows in the same memory:
    what `__NEW` made stays, and with `keeps_statics` so do VAR_STAT variables of functions.
    `form` says what routines become; both forms leave the same bytes.
    `cached`: code comes from the user's cache if it is there; that is for projects that
    come from sources, which are what the cache knows them by. Routines that are `covered` count,
    with `conditions` their decisions, too.
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
        after: "Execution | None" = None,
        keeps_statics: bool = False,
        form: CodeForm = CodeForm.PLAIN,
        cached: bool = False,
        covered: Callable[[Routine], bool] | None = None,
        conditions: bool = False,
    ) -> None:
        self.project = project
        self.memory = memory
        self.budget = budget
        self._fuel: Any = [budget]
        self._limit_before = 0
        """Python's limit of calls when nothing runs; 0 while nothing does."""
        self._overrides = dict(builtins or {})
        self._clock_ns, self._task_index = clock_ns, task_index
        variables = list(variables)
        self.placement = placement = Placement(memory, variables)
        if after is not None and keeps_statics:
            placement.statics.update(after.placement.statics)
        for static in project.statics:
            placement.add_static(static)
        self.views = Views(memory)
        self.frames = Frames(memory, self.views)
        self.heap: Heap = Heap(memory) if after is None else after.heap
        self._linker = Linker(
            LoweredProject(project, placement, exceptions=exceptions, conditions=conditions)
        )
        self.coverage: CoverageCounters | None = None
        """Counters of the routines that are covered; None if none is."""
        if covered is not None:
            self.coverage = CoverageCounters(self._linker.project, covered)
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
            "caught": self._caught,
            "code_of": code_of,
            "delete_memory": self._delete,
            "dispatched": self._dispatched,
            "enter": self.frames.enter,
            "enum_name": _enum_name,
            "exhausted": self._exhausted,
            "find_in_large": self._find_in_large,
            "leave": self.frames.leave,
            "misaligned": _misaligned,
            "new_memory": self._new,
            "spent": self._spent,
            "spent_for": self._spent_for,
            "queried": self._queried,
            "system_ltime": clock_ns,
            "system_task_index": task_index,
            "unavailable": _unavailable,
        }
        self.left_out: dict[str, str] = dict(project.left_out)
        """Routines that cannot run, and why."""
        self.machine: MachineProgram | None = None
        """The machine code; None if all is plain."""
        self.plain_routines: Mapping[str, str] = {}
        """Routines that are plain beside machine code, and why."""
        by_python = sorted(key for key in self._overrides if key in project.routines)
        digest = ""
        if cached:
            digest = project_digest(
                project,
                placement,
                variables,
                by_python,
                exceptions=exceptions,
                counted=self._linker.project.counted,
                conditions=conditions,
            )
        if form is not CodeForm.PLAIN:
            self._translate_if_possible(form, by_python, digest)
        if self.coverage is not None:
            self.namespace |= {"COUNTS": self.coverage.counts, "count": self.coverage.count}
        self.renew()
        self._link(digest, keep=after is None)

    # functions -------------------------------------------------------------------------------

    def _translate_if_possible(
        self, form: CodeForm, by_python: Collection[str], digest: str
    ) -> None:
        """Translate to machine code; with `CodeForm.AUTO` any refusal leaves all routines plain."""
        if form is CodeForm.AUTO and not compiler_installed():
            return
        try:
            self._translate(by_python, digest)
        except Exception as failure:
            if form is CodeForm.MACHINE:
                raise
            log.warning("programs run as plain Python, not as machine code: %r", failure)

    def _translate(self, by_python: Collection[str], digest: str) -> None:
        """Make machine code of what can be; the rest shares budget and frames with it."""
        from achse.plc.machine.build import machine_code
        from achse.plc.machine.program import MachineHost, MachineProgram

        counters = 0 if self.coverage is None else self.coverage.size
        content = machine_code(
            self.project,
            self.placement,
            by_python,
            exceptions=self._linker.project.exceptions,
            digest=digest,
            counted=self._linker.project.counted,
            counters=counters,
            conditions=self._linker.project.conditions,
        )
        host = MachineHost(
            self.project,
            self.memory,
            budget=self.budget,
            clock_ns=self._clock_ns,
            task_index=self._task_index,
            plain_function=lambda key: self.namespace[self._linker.name_of(key)],
            dispatched=self._dispatched,
            caught=self._caught,
            deepest=DEEPEST_CALLS,
        )
        self.machine = MachineProgram(content, host, counters)
        if self.coverage is not None and self.machine.counts is not None:
            self.coverage.counts = self.machine.counts
        self.plain_routines = self.machine.notes.plain_routines
        self._fuel = self.namespace["F"] = self.machine.budget
        self.frames.share(self.machine.frames)
        self.reset_budget()
        for key, reason in self.plain_routines.items():
            log.debug("%s stays plain: %s", key, reason)

    def _link(self, digest: str, *, keep: bool) -> None:
        in_machine = {} if self.machine is None else self.machine.keys
        program = self._emitted(digest, in_machine, keep=keep)
        self._linker.adopt(program.constants)
        self.left_out.update(program.left_out)
        for key, routine in self.project.routines.items():
            name = self._linker.name_of(key)
            if self.machine is not None and key in in_machine:
                self.namespace[name] = self.machine.function(key)
            elif key in program.codes:
                self.namespace[name] = function_of(routine, program.codes[key], self.namespace)
            elif key in program.left_out:
                self.namespace[name] = partial(_left_out, f"{key}: {program.left_out[key]}")
            else:
                self.namespace[name] = self._without_text(routine)
        self.namespace.update(self._linker.constants)
        self.namespace.update(self.views.namespace())
        self._tables = self._all_tables()

    def _emitted(self, digest: str, in_machine: Container[str], *, keep: bool) -> EmittedProgram:
        """Return the plain routines; with a digest, those of a PLC before with the same program.
        Programs of online changes are not kept: their types would outlive the next one."""
        known = f"{digest} {'plain' if self.machine is None else 'beside machine code'}"
        program = EMITTED.get(known) if digest else None
        if program is None:
            program = self._emit(in_machine, is_cached=digest != "")
            if digest and keep:
                EMITTED.add(known, program)
        return program

    def _emit(self, in_machine: Container[str], *, is_cached: bool) -> EmittedProgram:
        store = None
        if is_cached and self.machine is None and len(self.project.routines) >= _FEWEST_CACHED:
            store = CodeStore({each.source.path for each in self.project.routines.values()})
        codes: dict[str, CodeType] = {}
        left_out: dict[str, str] = {}
        for key, routine in self.project.routines.items():
            if key in in_machine or routine.body is None or key in self._overrides:
                continue
            try:
                codes[key] = routine_code(routine, emit_routine(routine, self._linker), store)
            except MissingPlaceError as missing:
                left_out[key] = f"{missing.args[0]} has no memory in this PLC"
            except (SyntaxError, RecursionError, MemoryError) as refusal:
                left_out[key] = f"too large or too deep for Python: {refusal}"
        if store is not None:
            store.save()
        return EmittedProgram(codes, left_out, dict(self._linker.constants))

    def _all_tables(self) -> dict[int, dict[str, Callable[..., Any]]]:
        """Return the functions that calls through an address find, by the number of the block."""
        return {
            number: {
                name: self.namespace[self._linker.name_of(key)]
                for name, key in block.table.items()
                if key in self.project.routines
            }
            for number, block in self.project.block_numbered.items()
        }

    def _without_text(self, routine: Routine) -> Callable[..., Any]:
        override = self._overrides.get(routine.key)
        if override is not None:
            return override
        reason = (
            "it is built in, and this runtime does not have it" if routine.builtin else "no body"
        )
        return lambda *_, **__: _unavailable(f"{routine.name}: {reason}")

    def function(self, key: str) -> Callable[..., Any]:
        """Return the function of a routine. KeyError if there is none."""
        if key not in self.project.routines:
            raise KeyError(key)
        function: Callable[..., Any] = self.namespace[self._linker.name_of(key)]
        return function

    def observe(self, key: str, listener: "Listener") -> None:
        """Call `listener` with what a routine is called with, each time before it runs.

        KeyError if there is no such routine. Machine code does not report its calls: all routines
        are plain from then on.
        """
        if self.machine is not None:
            self.replace(self.plain_functions())
            self.machine = None
        function, name = self.function(key), self._linker.name_of(key)

        def observed(*arguments: Any, **named: Any) -> Any:
            listener(arguments, named)
            return function(*arguments, **named)

        self.namespace[name] = observed
        self._tables = self._all_tables()

    def replace(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        """Let other functions be the routines of these keys, from the next cycle on.

        `function` gives the new ones.
        """
        for key, function in functions.items():
            self.namespace[self._linker.name_of(key)] = function
        self._tables = self._all_tables()

    def plain_functions(self, probe: Probe | None = None) -> dict[str, Callable[..., Any]]:
        """Return the routines with a body as functions of Python, made once more; `probe` for a
        debug build. They are not in use until `replace`."""
        functions: dict[str, Callable[..., Any]] = {}
        self._linker.probe = probe
        try:
            for key, routine in self.project.routines.items():
                if routine.body is None or key in self._overrides or key in self.left_out:
                    continue
                lines = emit_routine(routine, self._linker)
                functions[key] = compiled(routine, lines, self.namespace)
        finally:
            self._linker.probe = None
        self.namespace.update(self._linker.constants)
        return functions

    def variant(
        self, key: str, body: TypedStatements
    ) -> tuple[str, Callable[[], Callable[..., Any]]]:
        """Return a routine with another body, which does not count: its Python source, and what
        makes the function. It is not in use until `replace`. Raises `MissingPlaceError`."""
        routine = replace(self.project.routines[key], body=body)
        counted = self._linker.project.counted
        first = counted.pop(key, None)
        try:
            lines = emit_routine(routine, self._linker)
        finally:
            if first is not None:
                counted[key] = first

        def make() -> Callable[..., Any]:
            self.namespace.update(self._linker.constants)
            return compiled(routine, lines, self.namespace)

        return "\n".join(line.text for line in lines), make

    @property
    def spent(self) -> int:
        """Loop passes and calls of the present cycle, or of the last one."""
        return self.budget - int(self._fuel[0])

    def part(self, key: str, wanted: Callable[[TypedStatement], bool]) -> Callable[..., Any] | None:
        """Return a routine of a unit with the wanted ones of its statements; None without any."""
        routine = self.project.routines.get(key)
        body = () if routine is None else tuple(filter(wanted, routine.body or ()))
        if routine is None or not body or key in self.left_out:
            return None
        lines = emit_routine(replace(routine, body=body), self._linker)
        function = compiled(routine, lines, self.namespace)
        self.namespace.update(self._linker.constants)
        return function

    def type_at(self, address: int) -> StructType[Any] | None:
        """Return the type of the function block at an address; None if there is none."""
        block = self.project.block_numbered.get(self._number_at(address))
        return None if block is None else block.type

    def renew(self) -> None:
        """See the memory as it is now."""
        self.views.renew()
        self.namespace.update(self.views.namespace())
        if self.machine is not None:
            self.machine.renew()

    def release(self) -> None:
        """Let the memory grow: nothing can run until `renew`."""
        self.views.release()
        if self.machine is not None:
            self.machine.release()

    def close(self) -> None:
        """Drop what code and its surroundings refer to each other by: others run instead."""
        self.release()
        if self.machine is not None:
            self.machine.close()
            self.machine = None
        self.namespace.clear()
        self._tables.clear()
        self._overrides.clear()

    def reset_budget(self) -> None:
        """Restore the whole budget of a cycle, and drop frames of the cycle before."""
        self._fuel[0] = self.budget
        self.frames.clear()

    def rest(self) -> None:
        """Restore Python's limit of calls at the end of a run."""
        if self._limit_before:
            sys.setrecursionlimit(self._limit_before)
            self._limit_before = 0

    def allow_calls(self) -> None:
        """Let calls go as deep as always: Python counts the station's own, too."""
        depth = DEEPEST_CALLS
        frame: FrameType | None = sys._getframe()
        while frame is not None:
            depth += 1
            frame = frame.f_back
        self._limit_before = self._limit_before or sys.getrecursionlimit()
        sys.setrecursionlimit(depth)

    # what emitted code calls -----------------------------------------------------------------

    def _exhausted(self) -> None:
        raise PlcFault(
            ExceptionCode.CYCLE_TIME_EXCEED,
            f"{self.budget} loop passes and calls in one cycle: an endless loop?",
        )

    def spend(self, size: int) -> None:
        """Count moved bytes. Raises PlcFault CYCLE_TIME_EXCEED if a cycle moves too many."""
        self._spent(size // BYTES_A_PASS, b"")

    def _spent(self, passes: int, value: bytes) -> bytes:
        """Return a value that took that many passes of the budget."""
        self._fuel[0] -= passes
        if self._fuel[0] < 0:
            self._exhausted()
        return value

    def _spent_for(self, value: bytes) -> bytes:
        """Return a text that took from the budget by its length."""
        return self._spent(len(value) // BYTES_A_PASS, value)

    def _find_in_large(self, text: bytes, other: bytes, unit: int) -> int:
        """FIND takes from the budget what it compares at most: each place with all of `other`."""
        self.spend(len(text) * len(other))
        return int(TEXTS["text_find"](text, other, unit))

    def _caught(self, failure: BaseException) -> None:
        """Charge a caught exception; the end of the budget cannot be caught."""
        if self._fuel[0] < 0:
            raise failure
        is_overflow = code_of(failure) == ExceptionCode.STACK_OVERFLOW
        self._fuel[0] -= self.budget // (_OVERFLOWS if is_overflow else _CATCHES)

    @property
    def _pointer_size(self) -> int:
        for block in self.project.blocks.values():
            return block.type.rules.pointer_size
        return 8

    def _number_at(self, address: int) -> int:
        if not address:
            raise PlcFault(ExceptionCode.ACCESS_VIOLATION, "a call through address 0")
        number: int = self.namespace["load_Q" if self._pointer_size == 8 else "load_I"](address)
        return number

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
        allocation = self.heap.allocation(address)
        if allocation is not None:
            of, count = allocation
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


def _unavailable(reason: str) -> NoReturn:
    raise PlcFault(ExceptionCode.UNRESOLVED_EXTREFS, reason)


def _left_out(reason: str, *_: Any, **__: Any) -> NoReturn:
    _unavailable(reason)


def _enum_name(number: int, names: Mapping[int, bytes]) -> bytes:
    return names.get(number) or str(number).encode()


def _composed(image: bytes, places: tuple[tuple[int, str], ...], values: tuple[Any, ...]) -> bytes:
    """Return a record made on the spot: an image with values put over it."""
    record = bytearray(image)
    for (offset, code), value in zip(places, values, strict=True):
        struct.pack_into(f"<{code}", record, offset, value)
    return bytes(record)
