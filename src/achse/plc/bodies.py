"""Bodies: what the Structured Text of a PLC does, from the first instance to the last."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

from achse.iec.arrays import ArrayType
from achse.iec.derived import resolved
from achse.iec.errors import DeclarationError
from achse.iec.methods import Method
from achse.iec.structs import Record, RecordKind, StaticRecord, StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.plc.builtins import BLOCKS, FUNCTIONS, BlockBody, FunctionBody, Services
from achse.plc.code.calls import encoded_from, outputs_of, parameters_of
from achse.plc.code.execution import BUDGET, CodeForm, Execution
from achse.plc.code.faults import PlcFault
from achse.plc.json_documents import JSON_FUNCTIONS
from achse.plc.lives import Moves, is_alike, unit_variable
from achse.plc.memory import Area, Memory
from achse.plc.program import PlacedVariable
from achse.plc.static_lives import StaticLives
from achse.st.check.kinds import known_from
from achse.st.typed.places import flat
from achse.st.typed.project import InitCall, Routine, RoutineKind, TypedBlock, TypedProject

__all__ = ["Bodies", "Guard"]

_RETAINS = _COPYING = True
"""Flags of FB_init and FB_exit, by their names in words."""

Guard = Callable[[str, Callable[[], Any]], Any]
"""Runs something that is named in words."""


class Bodies:
    """The routines of a typed project in one PLC.

    `budget`: loop passes and calls that one cycle may take before it is stopped.
    `exceptions`: the task option "floating point exceptions". `functions` and `blocks`: what
    routines of libraries do that have no Structured Text, by key; `services` has more of them,
    those that need the station. `epoch()` is the Unix time at time 0, ns. `form` is what routines
    become: plain Python or machine code.
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
        epoch: Callable[[], int] = int,
        form: CodeForm = CodeForm.AUTO,
    ) -> None:
        self.project = project
        self.form = form
        self.budget = budget
        self.exceptions = exceptions
        of_station = {} if services is None else services.functions
        self.functions = {**functions, **JSON_FUNCTIONS, **of_station}
        self.blocks = blocks if services is None else {**blocks, **services.blocks}
        self._services = services
        self._epoch = epoch
        self._clock_ns: Callable[[], int] = int
        self._task_index: Callable[[], int] = int
        self.guard: Guard = _unguarded
        """Runs what a client calls: the PLC puts itself around it."""
        self.execution: Execution | None = None
        self._records: dict[int, Record] = {}
        self._memory: Memory | None = None
        self._variables: list[PlacedVariable] = []

    @property
    def declared(self) -> list[type[StaticRecord]]:
        """Programs and variable lists that the code needs, those of libraries included."""
        return [unit.declared for unit in self.project.units.values() if unit.declared is not None]

    @property
    def statics(self) -> list[PlacedVariable]:
        """VAR_STAT variables of functions and methods."""
        return [] if self.execution is None else list(self.execution.placement.statics.values())

    def has_statics_of(self, other: "Bodies") -> bool:
        """Return True if VAR_STAT variables of functions and methods are declared alike."""
        return _static_rows(self.project) == _static_rows(other.project)

    @property
    def has_python(self) -> bool:
        """True if a Python class implements a block of the project."""
        return bool(self._python_bodies())

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
            self.execution.release()
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
        *,
        after: "Bodies | None" = None,
        keeps_statics: bool = False,
    ) -> None:
        """All variables have their place: make the code for them.

        `after` are the bodies that these follow in the same memory. With `keeps_statics`, VAR_STAT
        variables of functions stay where they are, too: no declaration has changed.
        """
        if after is not None:
            self.project = self.project.numbered_after(after.project)
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
            after=None if after is None else after.execution,
            keeps_statics=keeps_statics,
            form=self.form,
            cached=True,
        )
        memory.let_invoke(self._invoked)

    def _builtin_bodies(self) -> Mapping[str, Callable[..., Any]]:
        """The built-in routines that the project uses."""
        found: dict[str, Callable[..., Any]] = {}
        for key, routine in self.project.routines.items():
            known = key in self.functions or key in self.blocks
            name = key if known else key.partition(".")[2] or key
            block = self.blocks.get(name.partition("<")[0].removeprefix("_"))  # or its base
            if routine.builtin and name in self.functions:
                found[key] = partial(self.functions[name], self)
            elif routine.builtin and block is not None and routine.this is not None:
                found[key] = partial(self._run_block, block, routine.this)
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

    def spend(self, size: int) -> None:
        """So many bytes are moved; raises CYCLE_TIME_EXCEED."""
        self._running().spend(size)

    def make_bytes(self, data: bytes) -> int:
        """Allocate these bytes; the address, 0 if memory is full."""
        address = self._running().heap.allocate(len(data))
        if address:
            self.store_bytes(address, data)
        return address

    def free_bytes(self, address: int) -> None:
        """Give back what `make_bytes` made; anything else is passed over."""
        with suppress(PlcFault):
            self._running().heap.free(address)

    @property
    def time_ns(self) -> int:
        """The time of the running cycle."""
        return self._clock_ns()

    @property
    def unix_ns(self) -> int:
        """The time of the running cycle since 1970."""
        return self._epoch() + self._clock_ns()

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
        if routine.kind is RoutineKind.BODY:
            return lambda address: getattr(self.record_at(address, this), attribute)()
        inputs, outputs = parameters_of(routine), outputs_of(routine)

        def method(address: int, *values: Any) -> Any:
            given = [
                item.type.decode(encoded_from(value, flat(item.type)))
                if item.section is Section.INPUT
                else value
                for item, value in zip(inputs, values, strict=True)
            ]
            answer = getattr(self.record_at(address, this), attribute)(*given)
            if not outputs:
                return None if routine.result is None else _taken(routine.result, answer)
            told = list(answer) if isinstance(answer, tuple) else [answer]
            slots = [routine.result, *outputs]
            if routine.result is None:
                told = [None, *told]
            return tuple(
                None if slot is None else _taken(slot, value)
                for slot, value in zip(slots, told, strict=True)
            )

        return method

    def record_at(self, address: int, type: StructType[Any]) -> Record:
        """The record at an address, the same object while a block of its kind is there."""
        found, wanted = self._records.get(address), type.record
        # Frames of routines put other blocks at the same place, one after the other.
        if found is None or not (isinstance(found, wanted) or issubclass(wanted, found.__class__)):
            assert self._memory is not None
            place = self._memory.at(address)
            if place is None:
                raise IndexError(f"no memory at address 16#{address:X}")
            region, offset = place
            found = self._records[address] = type.read(region.data, offset)
        return found

    # life ------------------------------------------------------------------------------------

    def create(self, moves: Moves | None = None, known: Collection[str] = ()) -> None:
        """Bring all instances to life: FB_init, start values, call_after_init, in order.

        With `moves`, those that begin in an online change; VAR_STAT that are `known` go on.
        """
        with self._awake():
            assert self._memory is not None
            statics = [one for one in self._variables if one.variable.section is Section.STATIC]
            lives = StaticLives(self.project, self._memory, self._running().function)
            lives.begin([*statics, *self.statics], known)
            for unit in self.project.units.values():
                if moves is None:
                    self._with_flags(unit.create, _RETAINS, False)
                else:
                    self._part(unit.create, moves.again, False, _COPYING)
                    self._part(unit.create, moves.new, _RETAINS, False)
            if moves is None:
                self._call_in_slots(self.project.init_calls)

    def online_changed(self, after: "Bodies") -> None:
        """Tell those that want to know of an online change: of block layouts, then of any."""
        before = after.project.blocks
        changed = {
            key
            for key, block in self.project.blocks.items()
            if key in before and not is_alike(before[key].type, block.type)
        }
        with self._awake() as run:
            for call in self.project.type_change_calls:
                routine = self.project.routines.get(call.routine)
                if routine is not None and call.types & changed:
                    values = _start_values(routine)
                    for address in self._instances_of(call.block):
                        run.function(call.routine)(*address, *values)
            self._call_in_slots(self.project.online_change_calls)

    def _call_in_slots(self, calls: Iterable[InitCall]) -> None:
        for call in calls:
            if call.routine in self.project.routines:
                for address in self._instances_of(call.block):
                    self._running().function(call.routine)(*address)

    @contextmanager
    def _awake(self) -> Iterator[Execution]:
        """The whole budget for what runs outside of cycles."""
        run = self._running()
        run.refuel()
        run.allow_calls()
        try:
            yield run
        finally:
            run.rest()

    def _instances_of(self, block: str) -> list[tuple[int, ...]]:
        """Return the call arguments for each instance of a block: its address; without a block one
        call without arguments."""
        if not block:
            return [()]
        assert self._memory is not None
        wanted = self.project.blocks[block].type.name
        found: list[tuple[int, ...]] = []
        for placed in self._variables:
            start = self._memory.address(placed.area, placed.offset)
            found += [(start + offset,) for offset in _places_of(wanted, placed.variable.type)]
        return found

    def exit(self, moves: Moves) -> None:
        """End the life of the instances that an online change ends: FB_exit."""
        with self._awake():
            for unit in reversed(list(self.project.units.values())):
                self._part(unit.exit, moves.again, _COPYING)
                self._part(unit.exit, moves.gone, False)

    def reinit(self, moves: Moves) -> None:
        """After values were copied: FB_reinit."""
        with self._awake():
            for unit in self.project.units.values():
                self._part(unit.reinit, moves.copied)

    def made(self) -> Iterator[tuple[int, IecType[Any]]]:
        """Address and type of each record that `__NEW` made."""
        for address, of, count in self._running().heap.all_held():
            for number in range(count):
                yield address + number * of.size, of

    def refuse_other_layouts(self, declared: Mapping[str, StructType[Any]]) -> None:
        """Raise `DeclarationError` if what `__NEW` made would have another layout.

        `declared` are the types from now on, by name in lower case. (The vendor's tools take no
        online change then either: such memory does not move.)
        """
        for _, of, _ in self._running().heap.all_held():
            new = declared.get(of.name.lower())
            if new is None or not is_alike(of, new):
                what = "is gone" if new is None else "has another layout"
                raise DeclarationError(
                    f"{of.name} {what}, but there are instances that __NEW made: this takes"
                    " a reset or a restart, not an online change"
                )

    def _part(self, key: str, names: Collection[str], *flags: bool) -> None:
        """Run the statements of a unit's routine that concern some of its variables."""
        if not key or not names:
            return
        part = self._running().part(key, lambda statement: unit_variable(statement) in names)
        if part is not None:
            part(*flags[: len(self.project.routines[key].parameters)])

    def _with_flags(self, key: str, *flags: bool) -> None:
        routine = self.project.routines.get(key)
        if routine is not None:
            self._running().function(key)(*flags[: len(routine.parameters)])

    def _running(self) -> Execution:
        assert self.execution is not None, "settle comes first"
        return self.execution

    # calls -----------------------------------------------------------------------------------

    def cycle_of(self, name: str) -> Callable[[], Any] | None:
        """Return the function that a task calls for a program; None if it has no body."""
        unit = self.project.units.get(name.lower())
        if unit is None or not unit.body or unit.body not in self.project.routines:
            return None
        return self._running().function(unit.body)

    def begin_cycle(self) -> None:
        """The whole budget again, and what came from outside."""
        self._running().refuel()
        self._running().allow_calls()
        if self._services is not None:
            self._services.begin_cycle(self)

    def end_cycle(self) -> None:
        """End the cycle, and let the services send its output."""
        self._running().rest()
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

    def has(self, record: Record, name: str) -> bool:
        """Return True if Structured Text implements a method of a block or program; `__getX`,
        `__setX` for a property."""
        return self._routine(record, name) is not None

    def call(
        self, record: Record, name: str, values: Sequence[object], named: Mapping[str, object]
    ) -> Any:
        """Call a method with Python values, in order or by name; inputs left out start as
        declared. The result; with outputs a tuple of it and them.

        Raises LookupError if there is none, TypeError for other inputs, `IecValueError` for what
        an input does not take, and what the Structured Text raises.
        """
        routine = self._routine(record, name)
        if routine is None:
            raise LookupError(f"{record.__class__.__iec__.name} has no method {name} here")
        inputs = parameters_of(routine)
        if any(item.section is not Section.INPUT for item in inputs):
            raise TypeError(f"{routine.name} has VAR_IN_OUT: call it from Structured Text")
        if len(values) > len(inputs):
            raise TypeError(f"{routine.name} takes {len(inputs)} inputs, got {len(values)}")
        given = {item.name.lower(): value for item, value in zip(inputs, values, strict=False)}
        for key, value in named.items():
            if key.lower() in given or key.lower() not in {item.name.lower() for item in inputs}:
                names = ", ".join(item.name for item in inputs) or "no inputs"
                raise TypeError(f"{routine.name} takes {names}, each once, got {key}")
            given[key.lower()] = value
        image = routine.frame.default
        arguments = []
        for item in inputs:
            data = image[item.offset : item.offset + item.type.size]
            if item.name.lower() in given:
                data = item.type.encode(given[item.name.lower()])
            arguments.append(known_from(data, flat(item.type)).value)
        answer = self._call(routine, record, arguments)
        outputs = outputs_of(routine)
        answers = list(answer) if outputs else [answer]
        of = [routine.result, *outputs]
        found = [
            item.type.decode(encoded_from(value, flat(item.type)))
            for value, item in zip(answers, of, strict=True)
            if item is not None
        ]
        if not found:
            return None
        return tuple(found) if len(found) > 1 else found[0]

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
        function = self._running().function(routine.key)
        if routine.this is not None:
            assert self._memory is not None
            address = self._memory.address_of(record.__iec_buffer__, record.__iec_offset__)
            values = (address, *values)
        with self._awake():
            return self.guard(f"a call of {routine.name}", lambda: function(*values))

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


def _taken(variable: Variable[Any, Any], value: Any) -> Any:
    """A value that a Python method gives, as emitted code has it; None is what it starts with."""
    data = variable.initial_bytes() if value is None else variable.type.encode(value)
    return known_from(data, flat(variable.type)).value


def _start_values(routine: Routine) -> list[Any]:
    """Return the start values of a routine's inputs."""
    return [
        known_from(item.initial_bytes(), flat(item.type)).value for item in parameters_of(routine)
    ]


def _unguarded(what: str, work: Callable[[], Any]) -> Any:
    return work()


def _static_rows(project: TypedProject) -> list[tuple[Any, ...]]:
    return sorted(
        (
            f"{one.owner}.{one.variable.name}".lower(),
            one.variable.type.guid,
            one.variable.initial_bytes(),
        )
        for one in project.statics
    )


def _python_attribute(record: type[Record], name: str) -> str | None:
    """The attribute of a record's Python class that does what a method, GET or SET does."""
    wanted = name.lower().removeprefix("__get").removeprefix("__set")
    for attribute in dir(record):
        if attribute.lower() == wanted and not record.__iec__.has_member(attribute):
            return attribute
    return None


def _answer(routine: Routine, given: Any) -> bytes:
    """Return the outcome of a method as bytes: the result, then the outputs."""
    outputs = outputs_of(routine)
    values = list(given) if outputs else [given]
    types = [None if routine.result is None else routine.result.type]
    types += [output.type for output in outputs]
    return b"".join(
        encoded_from(value, flat(type))
        for value, type in zip(values, types, strict=True)
        if type is not None
    )


def _places_of(wanted: str, type: IecType[Any], offset: int = 0) -> Iterator[int]:
    """Offsets of all records of a name inside a type: an online change of bodies only leaves the
    types of variables as they are."""
    type = resolved(type)
    if isinstance(type, StructType):
        base: StructType[Any] | None = type
        while base is not None:
            if base.name == wanted:
                yield offset
                break
            base = base.base
        for member in type.fields:
            yield from _places_of(wanted, member.type, offset + member.offset)
    elif isinstance(type, ArrayType) and any(True for _ in _places_of(wanted, type.element)):
        for index in range(type.count):
            yield from _places_of(wanted, type.element, offset + index * type.element.size)
