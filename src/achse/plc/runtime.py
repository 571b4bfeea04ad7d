"""A PLC: programs and variable lists in memory, tasks on their grid of cycles, run, stop, reset."""

import hashlib
import logging
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from enum import Enum
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, TypeVar

from achse.iec import DeclarationError, PointerType, Program
from achse.iec.structs import StaticRecord
from achse.iec.variables import Section
from achse.plc.changes import TrialPlacement, calls_like, with_code
from achse.plc.code.faults import FaultReport, report_of
from achse.plc.lifecycle.instance_moves import InstanceMoves, layouts
from achse.plc.lifecycle.instance_paths import put_instance_paths
from achse.plc.lifecycle.start_values import put_start_values
from achse.plc.memory import Area, AreaFullError, Memory
from achse.plc.program import PlacedUnit, PlacedVariable, hand_to_blocks, place, place_statics
from achse.plc.retention.online_change_snapshot import OnlineChangeSnapshot
from achse.plc.system_info import SystemInfo, system_info_list
from achse.plc.task import Stopwatch, Task

if TYPE_CHECKING:
    from achse.plc.bodies import Bodies  # half of a start; only Structured Text needs it
    from achse.plc.debug import Debugger

log = logging.getLogger("achse.plc")

U = TypeVar("U", bound=StaticRecord)
T = TypeVar("T")

_FIRST_TASK_PORT = 350
_due = attrgetter("due_ns")


class PlcState(Enum):
    """State of a PLC."""

    RUN = "run"
    STOP = "stop"
    EXCEPTION = "exception"
    """A program raised an error; only a reset leads out."""


class PlcStateError(RuntimeError):
    """The PLC cannot do this in its present state."""


class PlcRuntime:
    """One PLC application.

    `tasks` name the program classes; `globals` are variable lists and further programs that no
    task calls. The same program in two tasks is one instance. `name`, `project`, `port` and
    `timestamp` (seconds since 1970) are what `_AppInfo` shows. `stopwatch` measures execution
    times; without one they are 0, and every run is the same as the last. `pointer_size` is 8, or
    4 for the declarations of a 32-bit PLC. `bodies` is what the Structured Text does.

    It is in RUN after construction. Time is handed in: call `run_due(now_ns)` as time goes on.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        globals: Iterable[type[StaticRecord]] = (),
        *,
        name: str = "Port_851",
        project: str = "achse",
        port: int = 851,
        timestamp: int = 0,
        memory: Memory | None = None,
        stopwatch: Stopwatch | None = None,
        pointer_size: int = 8,
        bodies: "Bodies | None" = None,
    ) -> None:
        if not tasks:
            raise ValueError("a PLC has at least one task")
        for number, task in enumerate(tasks):
            task.port = task.port or _FIRST_TASK_PORT + number
        self.name = name
        self.project = project
        self.port = port
        self.tasks = tuple(tasks)
        self.memory = Memory() if memory is None else memory
        self.stopwatch = stopwatch
        self.state = PlcState.RUN
        self._state_listeners: list[Callable[[PlcState], None]] = []
        self.keep_persistent: Callable[[], bool] = lambda: True
        """Keeps PERSISTENT and RETAIN variables as they are now; False if they cannot be written.
        The station sets it."""
        self.failure = ""
        """The traceback that led to EXCEPTION."""
        self.fault: FaultReport | None = None
        """The same in short, with the place in the Structured Text."""
        self.complaint = ""
        """The same as one line of the log: what was done, and what came of it."""
        self.bodies = bodies
        self.debugger: Debugger | None = None
        """Debugger that stops its tasks at breakpoints; None without a debugger."""
        self._running: Task = tasks[0]
        self.warnings: tuple[str, ...] = ()
        """Initial values that only a running program would give, with file, line and column; none
        where the bodies run."""
        self.online_changes = 0
        self.restarts = 0
        """Resets so far."""
        self._change_listeners: list[Callable[[], None]] = []
        self.pointer_size = pointer_size
        self._system = system_info_list(
            tasks, app_name=name, project_name=project, port=port, timestamp=timestamp
        )
        self._globals = tuple(globals)
        self._indices = {task: number for number, task in enumerate(tasks)}
        self._by_priority = sorted(tasks, key=attrgetter("priority"))
        self._next = min(self._by_priority, key=_due)
        self._place()
        if bodies is None:
            self._start()
            return
        try:
            self._start()
        except Exception as failure:
            self._fail("the start failed", failure)

    def _place(self, previous: "Bodies | None" = None) -> None:
        programs = [program for task in self.tasks for program in task.programs]
        declared = dict.fromkeys([self._system, *self._globals, *programs])
        self.units = place(with_code(declared, self.bodies), self.memory)
        self._statics = place_statics(self.units, self.memory)
        left = put_start_values(self.units, self._statics, self.memory)
        self.warnings = left if self.bodies is None else ()  # else its code does what is left
        put_instance_paths(self.variables, self.memory)
        if self.bodies is not None:
            self._link(previous)
        self.memory.hold_initial()
        self._by_class: dict[type[StaticRecord], PlacedUnit] = {
            type(unit.instance): unit for unit in self.units
        }
        self._info = SystemInfo(self.memory[Area.DATA].data, self._by_class[self._system].variables)

    def _link(self, previous: "Bodies | None", *, keeps_statics: bool = False) -> None:
        assert self.bodies is not None
        replaced = self.bodies.execution
        self.bodies.guard = self._guarded
        self.bodies.link(
            self.memory,
            self.variables,
            lambda: self._running.time_ns,
            lambda: self._indices[self._running] + 1,
            after=previous,
            keeps_statics=keeps_statics,
        )
        if replaced is not None:
            replaced.close()

    def unit(self, declared: type[U]) -> U:
        """Return the instance of a program or variable list. KeyError if the PLC has none."""
        instance = self._by_class[declared].instance
        assert isinstance(instance, declared)
        return instance

    @property
    def variables(self) -> list[PlacedVariable]:
        """Every declared variable with its place in memory, sorted by name without case."""
        return sorted(
            (*(placed for unit in self.units for placed in unit.variables), *self._statics),
            key=lambda placed: placed.name.lower(),
        )

    @property
    def statics(self) -> Sequence[PlacedVariable]:
        """The VAR_STAT variables, each once for all instances: `FB_Motor.nCount`."""
        return self._statics

    def instance(self, name: str) -> StaticRecord:
        """Return the program or variable list of that name, without case. KeyError if there is
        none."""
        for unit in self.units:
            if unit.name.lower() == name.lower():
                return unit.instance
        raise KeyError(name)

    def task_of(self, unit: PlacedUnit) -> Task:
        """Return the first task that calls the program; the first of all for a variable list."""
        declared = type(unit.instance)
        return next((task for task in self.tasks if declared in task.programs), self.tasks[0])

    # time ------------------------------------------------------------------------------------

    @property
    def next_due_ns(self) -> int:
        """Time at which the next cycle of any task is due."""
        return self._next.due_ns

    def run_due(self, now_ns: int) -> None:
        """Run every cycle that is due at `now_ns`, in order of due time, then priority.

        Cycles that fall into STOP or EXCEPTION are passed over, not made up for.
        """
        task = self._next
        while task.due_ns <= now_ns:
            if self.state is PlcState.RUN and not self.is_halted:
                self._cycle(task)
            else:
                task.skip(now_ns)
            if len(self._by_priority) > 1:
                task = self._next = min(self._by_priority, key=_due)

    def begin(self, now_ns: int) -> None:
        """Let time begin at `now_ns`: cycles before it are passed over."""
        for task in self.tasks:
            task.skip(now_ns)
        self._next = min(self._by_priority, key=_due)

    def _cycle(self, task: Task) -> None:
        task.begin()
        self._info.show_task(self._indices[task], task)
        self._running = task
        if self.bodies is not None:
            self.bodies.begin_cycle()
        if self.debugger is not None:
            self.debugger.run(task, lambda: task.cycle(self.stopwatch))
            return
        failed: Exception | None = None
        try:
            task.cycle(self.stopwatch)
        except Exception as failure:
            failed = failure
        self.end_cycle(task, failed)

    def end_cycle(self, task: Task, failure: Exception | None) -> None:
        """Note that a cycle has ended, by itself or by what it raised."""
        if failure is not None:
            self._fail(f"task {task.name} stopped in cycle {task.cycle_count}", failure)
        if self.bodies is not None:
            self.bodies.end_cycle()
        if task.exceeds_in_a_row and task.exceeds_in_a_row == task.watchdog_cycles:
            log.warning(
                "%s: task %s took longer than its %g ms %d times in a row (%d times so far)",
                self.name,
                task.name,
                task.cycle_ns / 1e6,
                task.exceeds_in_a_row,
                task.exceed_count,
            )

    def _guarded(self, what: str, work: Callable[[], T]) -> T:
        """Run what a client calls: a fault in it stops the PLC, as one in a task does."""
        if self.state is PlcState.EXCEPTION:
            raise PlcStateError(f"{self.name} is in EXCEPTION: nothing of it is called")
        try:
            return work()
        except Exception as failure:
            self._fail(f"{what} failed", failure)
            raise

    # debugging -------------------------------------------------------------------------------

    def debug(self) -> "Debugger":
        """Return the debugger of this PLC, from now on until `end_debugging`.

        Meanwhile its code is a debug build, which is slower. Raises `DebugError` if it runs no
        Structured Text.
        """
        from achse.plc.debug import Debugger

        if self.debugger is None:
            self.debugger = Debugger(self)
        return self.debugger

    def end_debugging(self) -> None:
        """Forget all breakpoints; a halted cycle resumes."""
        if self.debugger is not None:
            self.debugger.end()
            self.debugger = None

    def drop_debugger(self) -> None:
        """End a halted cycle where it is: the PLC or its code is replaced."""
        if self.debugger is not None:
            self.debugger.abandon()
            self.debugger.close()
            self.debugger = None

    @property
    def is_halted(self) -> bool:
        """True if a cycle is stopped at a breakpoint; no task runs then."""
        return self.debugger is not None and self.debugger.stop is not None

    def resume_cycle(self, task: Task) -> None:
        """Note that a halted cycle is about to resume."""
        self._running = task

    def _abandon(self) -> None:
        """End a halted cycle where it is."""
        if self.debugger is not None:
            self.debugger.abandon()

    def _fail(self, what: str, failure: Exception) -> None:
        self.failure = "".join(traceback.format_exception(failure))
        if self.bodies is not None:
            self.fault = report_of(failure, self.bodies.paths)
        placed = self.fault is not None and self.fault.path
        self.complaint = f"{self.name}: {what}: {self.fault if placed else repr(failure)}"
        self._enter(PlcState.EXCEPTION)
        if placed:
            log.error("%s", self.complaint)
        else:
            log.error("%s: %s", self.name, what, exc_info=failure)

    # states ----------------------------------------------------------------------------------

    def online_change(
        self,
        globals: Iterable[type[StaticRecord]] | None = None,
        programs: Mapping[str, Sequence[type[Program]]] | None = None,
        sizes: Mapping[Area, int] | None = None,
        bodies: "Bodies | None" = None,
    ) -> None:
        """Go on with other declarations, and notify clients: symbol version and count go up.

        `globals` are the variable lists and programs without task from now on, `programs` those
        of each task by its name; None keeps what there is. Areas have at least `sizes` bytes
        then. Tasks and their cycles stay. What
        keeps its name and type keeps its value, member by member where a structure changed, and
        Python attributes stay too; everything else starts as declared, and so do pointers and
        references declared with an address, as their targets may have moved. The process
        image and the state of the PLC stay.

        With `bodies`, programs do what these say from the next cycle on. Where only they changed,
        no instance is touched. Raises `DeclarationError` if the declarations cannot be placed;
        nothing has changed then.
        """
        if globals is not None or programs is not None:
            self._redeclare(
                self._globals if globals is None else tuple(globals),
                dict(programs or {}),
                sizes or {},
                bodies,
            )
        if self.debugger is not None:
            if self.bodies is None:
                self.drop_debugger()
            else:
                self.debugger.renew()
        self.online_changes += 1
        self._info.show_online_changes(self.online_changes)
        for listener in self._change_listeners:
            listener()

    def _redeclare(
        self,
        globals: tuple[type[StaticRecord], ...],
        programs: dict[str, Sequence[type[Program]]],
        sizes: Mapping[Area, int],
        bodies: "Bodies | None",
    ) -> None:
        names = [task.name for task in self.tasks]
        if unknown := programs.keys() - set(names):
            raise DeclarationError(
                f"an online change keeps the tasks {', '.join(names)}, got {', '.join(unknown)}"
            )
        called = {task: tuple(programs.get(task.name, task.programs)) for task in self.tasks}
        all_programs = [program for programs in called.values() for program in programs]
        declared = dict.fromkeys([self._system, *globals, *all_programs])
        memory = Memory(self.memory.sizes)
        memory.grow(sizes)
        trial = TrialPlacement(with_code(declared, bodies or self.bodies), memory)
        if self.bodies is not None:
            self.bodies.instances.refuse_other_layouts(layouts(trial.units))
        moves = InstanceMoves.between(self.variables, trial.variables)
        self._abandon()
        if bodies is not None and self._changes_bodies_only(trial, bodies, called):
            self._put_bodies(bodies)
            return
        if self.bodies is not None:
            self.bodies.release()
        try:
            self.memory.grow({area: len(region) for area, region in memory.regions.items()})
        except AreaFullError as failure:
            raise DeclarationError(str(failure)) from None
        finally:
            if self.bodies is not None:
                self.bodies.resume()
        if self.bodies is not None:
            self._in_change("FB_exit before", partial(self.bodies.instances.exit, moves))
            self.bodies.release()
        previous = self.bodies
        statics = [] if previous is None else previous.statics
        snapshot = OnlineChangeSnapshot.of(self.memory, self.units, [*self.variables, *statics])
        if bodies is not None:
            self.bodies = bodies
        firsts = {task: task.first_cycle for task in self.tasks}
        self._globals = globals
        for task, of_task in called.items():
            task.programs = of_task
        self.memory.begin_again()
        self._place(previous)
        try:
            self._start_units()
            snapshot.restore_attributes(self.units)
        except Exception as failure:
            self._fail("the start after an online change failed", failure)
        statics = [] if self.bodies is None else self.bodies.statics
        allocations = () if self.bodies is None else self.bodies.instances.allocations()
        variables = [*self.variables, *statics]
        carried = snapshot.restore_values(self.memory, variables, allocations, moves.renewed)
        put_start_values(self.units, self._statics, self.memory, of=PointerType)
        if self.bodies is not None:
            # What FB_init writes to other variables stays: only its own are copied after it.
            copied = [
                placed
                for placed in variables
                if placed.name.lower() in moves.copied
                and placed.variable.section is not Section.STATIC
            ]
            carried.start_again(copied)
            known = snapshot.variables.keys() - moves.renewed
            self._in_change("FB_init in", partial(self.bodies.instances.create, moves, known))
            carried.copy_again(copied)
            put_start_values(
                self.units, self._statics, self.memory, of=PointerType, only=moves.copied
            )
            self._in_change("FB_reinit after", partial(self.bodies.instances.reinit, moves))
            self._notify_bodies(previous)
        self._close(previous)
        for task, first in firsts.items():
            task.first_cycle = first
            self._info.show_task(self._indices[task], task)

    def _close(self, previous: "Bodies | None") -> None:
        """Free the code of bodies that others have replaced."""
        if previous is not None and previous is not self.bodies and previous.execution is not None:
            previous.execution.close()

    def _changes_bodies_only(
        self,
        trial: TrialPlacement,
        bodies: "Bodies",
        called: Mapping[Task, Sequence[type[Program]]],
    ) -> bool:
        """Return True if all declarations are as before, and no Python is involved."""
        return (
            self.bodies is not None
            and calls_like(called, [self.bodies, bodies])
            and bodies.has_statics_of(self.bodies)
            and trial.is_like(self.units, self._statics)
            and trial.starts_like(self.units, self._statics, self._initial_of)
        )

    def _initial_of(self, placed: PlacedVariable) -> bytes:
        size = max(placed.variable.type.size, 1)
        return self.memory[placed.area].initial(placed.offset, size)

    def _put_bodies(self, bodies: "Bodies") -> None:
        """Run other bodies in the same memory from the next cycle on; no instance is touched."""
        assert self.bodies is not None
        previous, self.bodies = self.bodies, bodies
        previous.release()
        self._link(previous, keeps_statics=True)
        self.bind_tasks()
        self._notify_bodies(previous)
        self._close(previous)

    def on_online_change(self, listener: Callable[[], None]) -> None:
        """Call `listener` after each online change from now on."""
        self._change_listeners.append(listener)

    def on_state(self, listener: Callable[[PlcState], None]) -> None:
        """Call `listener` with each state that is entered from now on."""
        self._state_listeners.append(listener)

    def _enter(self, state: PlcState) -> None:
        self.state = state
        for listener in self._state_listeners:
            listener(state)

    def run(self) -> None:
        """Go from STOP to RUN; variables keep their values. Raises PlcStateError in EXCEPTION."""
        if self.state is PlcState.EXCEPTION:
            raise PlcStateError(f"{self.name} is in EXCEPTION: reset it first")
        if self.state is PlcState.STOP:
            for task in self.tasks:
                task.first_cycle = True
            self._enter(PlcState.RUN)

    def stop(self) -> None:
        """Go from RUN to STOP; variables keep their values. An EXCEPTION stays one."""
        self._abandon()
        if self.state is PlcState.RUN:
            self._enter(PlcState.STOP)

    def reset(self, *, origin: bool = False) -> None:
        """Initialise all variables again and stop.

        A cold reset spares retain and persistent variables, whatever FB_init or the declaration of
        an instance says of them, as a restart of the station does; `origin` does not.
        """
        # They know this module.
        from achse.plc.retention.retained_state import (
            inherit_variables,
            reset_heap_pointers,
            retained_variables,
        )

        self._abandon()
        retained = {} if origin else retained_variables(self)
        self.memory.reset(origin=origin)
        reset_heap_pointers(self)
        if self.bodies is not None:
            self.bodies.reset()
        self.restarts += 1
        self.failure = self.complaint = ""
        self.fault = None
        self._enter(PlcState.STOP)
        for task in self.tasks:
            task.clear_counters()
        try:
            self._start()
        except Exception as failure:
            self._fail("the start after a reset failed", failure)
        inherit_variables(self, retained)

    def _notify_bodies(self, previous: "Bodies | None") -> None:
        if self.bodies is not None and previous is not None:
            notify = partial(self.bodies.instances.online_changed, previous.project)
            self._in_change("a call that follows", notify)

    def _in_change(self, what: str, work: Callable[[], None]) -> None:
        """Run the Structured Text of an online change; skip a PLC in EXCEPTION."""
        if self.state is PlcState.EXCEPTION:
            return
        try:
            work()
        except Exception as failure:
            self._fail(f"{what} an online change failed", failure)

    def _start(self) -> None:
        self._start_units()
        if self.bodies is not None:
            self.bodies.instances.create()

    def _start_units(self) -> None:
        partners: dict[object, object] = {PlcRuntime: self, "PlcRuntime": self}
        for unit in self.units:
            partners[type(unit.instance)] = partners[type(unit.instance).__name__] = unit.instance
        self._info.show_online_changes(self.online_changes)
        hand_to_blocks(self.units, partners)
        for unit in self.units:
            task = self.task_of(unit)
            unit.start(partners | {Task: task, "Task": task})
        for task in self.tasks:
            task.first_cycle = True
        self.bind_tasks()

    def bind_tasks(self) -> None:
        """Let the tasks call what their programs are now."""
        for task in self.tasks:
            cycles = [self._cycle_of(program) for program in task.programs]
            task.calls = [cycle for cycle in cycles if callable(cycle)]

    def _cycle_of(self, program: type[Program]) -> object:
        """Return the function that a task calls for a program: Python's, else its Structured
        Text."""
        unit = self._by_class[program]
        own = getattr(unit.instance, "cycle", None)
        if callable(own) or self.bodies is None:
            return own
        return self.bodies.cycle_of(unit.name)

    def digest(self) -> bytes:
        """Return a hash of memory, state, and tasks with their counters, 16 bytes.

        Plain Python attributes of programs are not in it.
        """
        state = hashlib.blake2b(self.memory.digest(), digest_size=16)
        state.update(self.state.value.encode())
        for task in self.tasks:
            counters = (task.due_ns, task.cycle_count, task.exceed_count, task.first_cycle)
            state.update(repr(counters).encode())
        return state.digest()
