"""Bodies: what the Structured Text of a PLC does, from the first instance to the last."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from achse.iec.structs import StaticRecord, StructType
from achse.plc.code.execution import BUDGET, CodeForm, Execution
from achse.plc.lifecycle.instances import InstanceLifecycle
from achse.plc.memory import Memory
from achse.plc.program import PlacedVariable
from achse.plc.routines.builtin_memory import BuiltinMemory
from achse.plc.routines.builtins import BLOCKS, FUNCTIONS, BlockBody, FunctionBody, Services
from achse.plc.routines.json_documents import JSON_FUNCTIONS
from achse.plc.routines.json_symbols import JSON_SYMBOL_FUNCTIONS
from achse.plc.routines.python_bodies import has_python_bodies, python_bodies
from achse.plc.routines.routine_calls import Guard, RoutineCalls, unguarded
from achse.plc.routines.xml_documents import XML_FUNCTIONS
from achse.plc.routines.xml_symbols import XML_SYMBOL_FUNCTIONS
from achse.st.typed.project import Routine, TypedProject


class Bodies:
    """The routines of a typed project in one PLC.

    `budget`: loop passes and calls that one cycle may take before it is stopped.
    `exceptions`: the task option "floating point exceptions". `functions` and `blocks`: what
    routines of libraries do that have no Structured Text, by key; `services` has more of them,
    those that need the station. `epoch()` is the Unix time at time 0, ns. `form` is what routines
    become: plain Python or machine code. Statements and branches of routines that are `covered`
    count, with `conditions` their decisions, too.
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
        covered: Callable[[Routine], bool] | None = None,
        conditions: bool = False,
    ) -> None:
        self.project = project
        self.form = form
        self.covered = covered
        self.conditions = conditions
        self.budget = budget
        self.exceptions = exceptions
        of_station = {} if services is None else services.functions
        self.functions = {
            **functions,
            **JSON_FUNCTIONS,
            **JSON_SYMBOL_FUNCTIONS,
            **XML_FUNCTIONS,
            **XML_SYMBOL_FUNCTIONS,
            **of_station,
        }
        self.blocks = blocks if services is None else {**blocks, **services.blocks}
        self._services = services
        self.guard: Guard = unguarded
        """Runs what a client calls: the PLC puts itself around it."""
        self.context = BuiltinMemory(epoch)
        """Memory, time and records, as built-in routines and Python classes see them."""
        self.execution: Execution | None = None
        self.calls: RoutineCalls
        """Calls by clients and Python, from `link` on."""
        self.instances: InstanceLifecycle
        """Lifecycle of function blocks, from `link` on."""

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
        return has_python_bodies(self.project)

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
        """Let the memory grow: nothing can run until `link`."""
        if self.execution is not None:
            self.execution.release()
        self.context.forget()

    def resume(self) -> None:
        """Go on in the same memory, which may have grown."""
        self._running().renew()

    def link(
        self,
        memory: Memory,
        variables: Iterable[PlacedVariable],
        clock_ns: Callable[[], int],
        task_index: Callable[[], int],
        *,
        after: "Bodies | None" = None,
        keeps_statics: bool = False,
    ) -> None:
        """Make the code for placed variables.

        `after` are the bodies that these follow in the same memory. With `keeps_statics`, VAR_STAT
        variables of functions stay where they are, too: no declaration has changed.
        """
        if after is not None:
            self.project = self.project.numbered_after(after.project)
        placed = list(variables)
        self.context.place(memory, placed, clock_ns, task_index)
        if self._services is not None:
            self._services.forget()
        replaced = (after or self).execution
        self.execution = Execution(
            self.project,
            memory,
            placed,
            builtins={
                **self._builtin_bodies(),
                **python_bodies(self.project, self.context.record_at),
            },
            clock_ns=clock_ns,
            task_index=task_index,
            budget=self.budget,
            exceptions=self.exceptions,
            after=None if after is None else after.execution,
            keeps_statics=keeps_statics,
            form=self.form,
            cached=True,
            covered=self.covered,
            conditions=self.conditions,
        )
        counters = self.execution.coverage
        if counters is not None and replaced is not None and replaced.coverage is not None:
            counters.take_over(replaced.coverage)
        self.context.link(self.execution)
        self.calls = RoutineCalls(self.project, memory, self.execution, self.guard)
        self.instances = InstanceLifecycle(self.project, memory, placed, self.execution)
        memory.let_invoke(self.calls.invoke)

    def _builtin_bodies(self) -> Mapping[str, Callable[..., Any]]:
        """Return the built-in routines that the project uses."""
        functions: dict[str, Callable[..., Any]] = {}
        for key, routine in self.project.routines.items():
            known = key in self.functions or key in self.blocks
            name = key if known else key.partition(".")[2] or key
            block = self.blocks.get(name.partition("<")[0].removeprefix("_"))  # or its base
            if routine.builtin and name in self.functions:
                functions[key] = partial(self.functions[name], self.context)
            elif routine.builtin and block is not None and routine.this is not None:
                functions[key] = partial(self._run_block, block, routine.this)
        return functions

    def _run_block(self, body: BlockBody, type: StructType[Any], address: int) -> None:
        body(self.context, self.context.record_at(address, type))

    def _running(self) -> Execution:
        assert self.execution is not None, "link comes first"
        return self.execution

    # calls -----------------------------------------------------------------------------------

    def cycle_of(self, name: str) -> Callable[[], Any] | None:
        """Return the function that a task calls for a program; None if it has no body."""
        unit = self.project.units.get(name.lower())
        if unit is None or not unit.body or unit.body not in self.project.routines:
            return None
        return self._running().function(unit.body)

    def begin_cycle(self) -> None:
        """Reset the budget, and let the services apply their input."""
        self._running().reset_budget()
        self._running().allow_calls()
        if self._services is not None:
            self._services.begin_cycle(self.context)

    def end_cycle(self) -> None:
        """End the cycle, and let the services send its output."""
        self._running().rest()
        if self._services is not None:
            self._services.end_cycle()


def _static_rows(project: TypedProject) -> list[tuple[Any, ...]]:
    return sorted(
        (
            f"{one.owner}.{one.variable.name}".lower(),
            one.variable.type.guid,
            one.variable.initial_bytes(),
        )
        for one in project.statics
    )
