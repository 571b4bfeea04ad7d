"""Bodies: what the Structured Text of a PLC does, from the first instance to the last."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.methods import Method
from achse.iec.structs import Record, RecordKind, StaticRecord, StructType
from achse.iec.types import IecType
from achse.plc.builtins import BLOCKS, FUNCTIONS, BlockBody, FunctionBody, Services
from achse.plc.code.calls import encoded_from, known_from, outputs_of
from achse.plc.code.execution import BUDGET, Execution
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.st.typed.places import flat
from achse.st.typed.project import Routine, RoutineKind, TypedBlock, TypedProject

__all__ = ["Bodies"]


class Bodies:
    """The routines of a typed project in one PLC.

    `budget`: loop passes and calls that one cycle may take before it is stopped.
    `exceptions`: the task option "floating point exceptions". `functions` and `blocks`: what
    routines of libraries do that have no Structured Text, by key; `services` has more of them,
    those that need the station. `epoch_ns` is the Unix time at time 0.
    """

    def __init__(
        self,
        project: TypedProject,
        *,
        budget: int = BUDGET,
        exceptions: bool = True,
        functions: Mapping[str, FunctionBody] = FUNCTIONS,
        blocks: Mapping[str, BlockBody] = BLOCKS,
        services: Services | None = None,
        epoch_ns: int = 0,
    ) -> None:
        self.project = project
        self.budget = budget
        self.exceptions = exceptions
        self.functions = functions if services is None else {**functions, **services.functions}
        self.blocks = blocks if services is None else {**blocks, **services.blocks}
        self._services = services
        self._epoch_ns = epoch_ns
        self._clock_ns: Callable[[], int] = int
        self._task_index: Callable[[], int] = int
        self.execution: Execution | None = None
        self._records: dict[int, Record] = {}
        self._memory: Memory | None = None
        self._variables: list[PlacedVariable] = []

    @property
    def declared(self) -> list[type[StaticRecord]]:
        """Programs and variable lists that the code needs, those of libraries included."""
        return [unit.declared for unit in self.project.units.values() if unit.declared is not None]

    @property
    def paths(self) -> set[str]:
        """The source files."""
        return {routine.source.path for routine in self.project.routines.values()}

    # memory ----------------------------------------------------------------------------------

    def reset(self) -> None:
        """Forget what programs made with `__NEW`: all variables start again."""
        self._running().heap.clear()
        if self._services is not None:
            self._services.forget()

    def release(self) -> None:
        """Let the memory grow: nothing can run until `settle`."""
        if self.execution is not None:
            self.execution.views.release()
        self._records.clear()

    def resume(self) -> None:
        """Go on in the same memory, which may have grown."""
        self._running().renew()

    def settle(
        self,
        memory: Memory,
        variables: Iterable[PlacedVariable],
        clock_ns: Callable[[], int],
        task_index: Callable[[], int],
    ) -> None:
        """All variables have their place: make the code for them."""
        self._memory = memory
        self._clock_ns, self._task_index = clock_ns, task_index
        self._variables = list(variables)
        if self._services is not None:
            self._services.forget()
        self.execution = Execution(
            self.project,
            memory,
            self._variables,
            builtins={**self._builtin_bodies(), **self._python_bodies()},
            clock_ns=clock_ns,
            task_index=task_index,
            budget=self.budget,
            exceptions=self.exceptions,
        )
        memory.let_invoke(self._invoked)

    def _builtin_bodies(self) -> Mapping[str, Callable[..., Any]]:
        """The built-in routines that the project uses."""
        found: dict[str, Callable[..., Any]] = {}
        for key, routine in self.project.routines.items():
            if not routine.builtin:
                continue
            if key in self.functions:
                found[key] = partial(self.functions[key], self)
            elif key in self.blocks and routine.this is not None:
                found[key] = partial(self._run_block, self.blocks[key], routine.this)
        return found

    def _run_block(self, body: BlockBody, type: StructType[Any], address: int) -> None:
        body(self, self.record_at(address, type))

    # what built-in routines see --------------------------------------------------------------

    def load_bytes(self, address: int, size: int) -> bytes:
        """Bytes of PLC memory; raises ACCESS_VIOLATION."""
        found: bytes = self._running().namespace["load_bytes"](address, size)
        return found

    def store_bytes(self, address: int, data: bytes) -> object:
        """Put bytes into PLC memory; raises ACCESS_VIOLATION."""
        return self._running().namespace["store_bytes"](address, data)

    @property
    def time_ns(self) -> int:
        """The time of the running cycle."""
        return self._clock_ns()

    @property
    def unix_ns(self) -> int:
        """The time of the running cycle since 1970."""
        return self._epoch_ns + self._clock_ns()

    def area_of(self, address: int, size: int) -> Area | None:
        """The area that all of these bytes are in, as far as they are in use."""
        assert self._memory is not None
        place = self._memory.at(address)
        if place is None:
            return None
        region, offset = place
        area = next(area for area, one in self._memory.regions.items() if one is region)
        if area is Area.HEAP:
            return area if self._running().heap.covers(offset, size) else None
        return area if offset + size <= len(region) else None

    @property
    def task_number(self) -> int:
        """The running task, from 1."""
        return self._task_index()

    def _python_bodies(self) -> Mapping[str, Callable[..., Any]]:
        """Function blocks and methods that a Python class does: it replaces the source."""
        found: dict[str, Callable[..., Any]] = {}
        for routine in self.project.routines.values():
            if routine.this is None or routine.this.kind is not RecordKind.FUNCTION_BLOCK:
                continue
            body = self._python_body(routine, routine.this)
            if body is not None:
                found[routine.key] = body
        return found

    def _python_body(self, routine: Routine, this: StructType[Any]) -> Callable[..., Any] | None:
        name = "cycle" if routine.kind is RoutineKind.BODY else routine.name.rpartition(".")[2]
        if routine.kind not in (RoutineKind.BODY, RoutineKind.METHOD):
            return None
        attribute = _python_attribute(this.record, name)
        if attribute is None or not callable(getattr(this.record, attribute)):
            return None
        return lambda address, *values: getattr(self.record_at(address, this), attribute)(*values)

    def record_at(self, address: int, type: StructType[Any]) -> Record:
        """The record at an address, the same object each time."""
        found = self._records.get(address)
        if found is None:
            assert self._memory is not None
            place = self._memory.at(address)
            if place is None:
                raise IndexError(f"no memory at address 16#{address:X}")
            region, offset = place
            found = self._records[address] = type.read(region.data, offset)
        return found

    # life ------------------------------------------------------------------------------------

    def create(self, *, retains: bool = True, copying: bool = False) -> None:
        """Bring all instances to life: FB_init, start values, call_after_init, in order."""
        run = self._running()
        run.refuel()
        for unit in self.project.units.values():
            if unit.create:
                self._with_flags(unit.create, retains, copying)
        for call in self.project.init_calls:
            if call.routine in self.project.routines:
                for address in self._instances_of(call.block):
                    run.function(call.routine)(*address)

    def _instances_of(self, block: str) -> list[tuple[int, ...]]:
        """Where instances of a block are; without one, a call without instance."""
        if not block:
            return [()]
        assert self._memory is not None
        wanted = self.project.blocks[block].type
        found: list[tuple[int, ...]] = []
        for placed in self._variables:
            start = self._memory.address(placed.area, placed.offset)
            found += [(start + offset,) for offset in _places_of(wanted, placed.variable.type)]
        return found

    def exit(self, *, copying: bool) -> None:
        """End the life of all instances: FB_exit."""
        self._running().refuel()
        for unit in reversed(list(self.project.units.values())):
            if unit.exit:
                self._with_flags(unit.exit, copying)

    def reinit(self) -> None:
        """After values were copied: FB_reinit."""
        self._running().refuel()
        for unit in self.project.units.values():
            if unit.reinit:
                self._with_flags(unit.reinit)

    def _with_flags(self, key: str, *flags: bool) -> None:
        routine = self.project.routines.get(key)
        if routine is not None:
            self._running().function(key)(*flags[: len(routine.parameters)])

    def _running(self) -> Execution:
        assert self.execution is not None, "settle comes first"
        return self.execution

    # calls -----------------------------------------------------------------------------------

    def cycle_of(self, name: str) -> Callable[[], Any] | None:
        """What a task calls of a program; None if it has no body."""
        unit = self.project.units.get(name.lower())
        if unit is None or not unit.body or unit.body not in self.project.routines:
            return None
        return self._running().function(unit.body)

    def begin_cycle(self) -> None:
        """The whole budget again, and what came from outside."""
        self._running().refuel()
        if self._services is not None:
            self._services.begin_cycle(self)

    def end_cycle(self) -> None:
        """What the cycle had to tell outside may leave."""
        if self._services is not None:
            self._services.end_cycle()

    def block_of(self, type: StructType[Any]) -> TypedBlock | None:
        """The block of a type."""
        return self.project.blocks.get(type.name.lower())

    def call_encoded(self, record: Record, method: Method, data: bytes) -> bytes | None:
        """A method as clients call it, values as bytes; None if no Structured Text does it."""
        routine = self._routine(record, method.name)
        if routine is None:
            return None
        values = []
        for parameter in method.inputs:
            type = resolved(parameter.type)
            values.append(known_from(data[: type.size], flat(type)).value)
            data = data[type.size :]
        return _answer(routine, self._call(routine, record, values))

    def get_encoded(self, record: Record, name: str) -> bytes | None:
        """A property as clients read it; None if no Structured Text gives it."""
        routine = self._routine(record, f"__get{name}")
        return None if routine is None else _answer(routine, self._call(routine, record, ()))

    def set_encoded(self, record: Record, name: str, data: bytes) -> bool:
        """A property as clients write it; FALSE if no Structured Text takes it."""
        routine = self._routine(record, f"__set{name}")
        if routine is None:
            return False
        value = known_from(data, flat(resolved(routine.parameters[0].type))).value
        self._call(routine, record, (value,))
        return True

    def _routine(self, record: Record, name: str) -> Routine | None:
        """The Structured Text of a block's method or of a program's; None without any."""
        type = record.__class__.__iec__
        block = self.block_of(type)
        owner = f"{type.name}.{name}".lower()
        key = owner if block is None else block.table.get(name.lower(), "")
        routine = self.project.routines.get(key)
        if routine is None or routine.body is None or _python_attribute(record.__class__, name):
            return None  # A Python class replaces the source.
        return routine

    def _call(self, routine: Routine, record: Record, values: Sequence[Any]) -> Any:
        self._running().refuel()
        function = self._running().function(routine.key)
        if routine.this is None:
            return function(*values)
        assert self._memory is not None
        address = self._memory.address_of(record.__iec_buffer__, record.__iec_offset__)
        return function(address, *values)

    def _invoked(self, record: Record, name: str, values: tuple[Any, ...]) -> Any:
        """A call of Structured Text from Python: of a block's body (no name) or a method."""
        type = resolved(record.__class__.__iec__)
        assert isinstance(type, StructType)
        block = self.block_of(type)
        key = None if block is None else block.table.get(name.lower())
        if key is None:
            raise AttributeError(f"{type.name} has no {name or 'body'} in Structured Text")
        assert self._memory is not None
        address = self._memory.address_of(record.__iec_buffer__, record.__iec_offset__)
        return self._running().function(key)(address, *values)


def _python_attribute(record: type[Record], name: str) -> str | None:
    """The attribute of a record's Python class that does what a method, GET or SET does."""
    wanted = name.lower().removeprefix("__get").removeprefix("__set")
    for attribute in dir(record):
        if attribute.lower() == wanted and not record.__iec__.has_member(attribute):
            return attribute
    return None


def _answer(routine: Routine, given: Any) -> bytes:
    """What a method gave, as bytes: the result, then the outputs."""
    outputs = outputs_of(routine)
    values = list(given) if outputs else [given]
    types = [None if routine.result is None else routine.result.type]
    types += [output.type for output in outputs]
    return b"".join(
        encoded_from(value, flat(type))
        for value, type in zip(values, types, strict=True)
        if type is not None
    )


def _places_of(wanted: StructType[Any], type: IecType[Any], offset: int = 0) -> Iterator[int]:
    """Offsets of all records of a type inside another."""
    type = resolved(type)
    if isinstance(type, StructType):
        base: StructType[Any] | None = type
        while base is not None:
            if base is wanted:
                yield offset
                break
            base = base.base
        for member in type.fields:
            yield from _places_of(wanted, member.type, offset + member.offset)
    elif isinstance(type, ArrayType) and any(True for _ in _places_of(wanted, type.element)):
        for index in range(type.count):
            yield from _places_of(wanted, type.element, offset + index * type.element.size)
