"""Trial of a PLC: its first cycles in virtual time, without a station around it.

Requests of blocks to other devices stay unanswered; no axis moves.
"""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from achse.iec import DeclarationError
from achse.plc import Memory, PlcRuntime, Task
from achse.plc.program import area_sizes
from achse.st.files.tasks import FileTask, called_tasks, has_floating_point_exceptions

if TYPE_CHECKING:
    from achse.plc.routines.builtins import Services
    from achse.st.project import Project
    from achse.st.typed.project import TypedProject

_CYCLES = 3
"""Cycles of the fastest task; a much slower one runs its first."""

_EPOCH_NS = 1_767_225_600_000_000_000
"""Unix time at which the trial begins: 2026-01-01."""


class TrialResult(NamedTuple):
    """Result of a trial."""

    runs: bool
    text: str

    def __str__(self) -> str:
        return f"would run: {self.text}" if self.runs else f"would not run: {self.text}"


def try_project(project: "Project", typed: "TypedProject") -> TrialResult:
    """Run the first cycles of a project that has no errors, in plain Python."""
    declared = project.declarations
    programs = declared.programs
    names = [program.__iec__.name for program in programs.values()]
    tasks = []
    own = called_tasks([FileTask(*task) for task in project.tasks], names)
    for task in own:
        missing = [name for name in task.programs if name.lower() not in programs]
        if missing:
            return TrialResult(
                False, f"task {task.name} calls {missing[0]!r}, which is not declared"
            )
        called = [programs[name.lower()] for name in task.programs]
        tasks.append(Task(task.name, task.cycle_ns, called, priority=task.priority, port=task.port))
    if not any(task.programs for task in tasks):
        return TrialResult(True, "there is nothing to run, no task calls a program")
    from achse.plc.bodies import Bodies  # half of a check; libraries have nothing to run
    from achse.plc.code.execution import CodeForm

    units = declared.units
    in_tasks = {program for task in tasks for program in task.programs}
    try:
        with _quiet():
            plc = PlcRuntime(
                tasks,
                [unit for unit in units if unit not in in_tasks],
                memory=Memory(area_sizes(units)),
                pointer_size=project.rules.pointer_size,
                bodies=Bodies(
                    typed,
                    exceptions=has_floating_point_exceptions(own),
                    services=_services(typed),
                    epoch=lambda: _EPOCH_NS,
                    form=CodeForm.PLAIN,
                ),
            )
    except DeclarationError as fault:
        return TrialResult(False, str(fault))
    return try_runtime(plc)


def try_runtime(plc: PlcRuntime) -> TrialResult:
    """Run the first cycles of a PLC whose time has not begun."""
    project = None if plc.bodies is None else plc.bodies.project
    for task in plc.tasks:
        for program in task.programs:
            name = program.__iec__.name
            if project is not None and (why := project.left_out.get(name.lower())):
                return TrialResult(False, f"task {task.name} calls {name}: {why}")
    cycles_ns = sorted(task.cycle_ns for task in plc.tasks)
    with _quiet():
        plc.run_due(_CYCLES * cycles_ns[0])
        for cycle_ns in cycles_ns:
            if cycle_ns > _CYCLES * cycles_ns[0]:
                plc.begin(cycle_ns - 1)  # passes over cycles of faster tasks
                plc.run_due(cycle_ns)
    if plc.failure:
        return TrialResult(False, plc.complaint.removeprefix(f"{plc.name}: "))
    called = [task for task in plc.tasks if task.programs]
    lines = (f"{t.name} ({', '.join(p.__iec__.name for p in t.programs)})" for t in called)
    return TrialResult(True, f"{', '.join(lines)}, {_CYCLES} cycles tried")


def _services(typed: "TypedProject") -> "Services | None":
    """Return the library routines that a station has; None if nothing calls one."""
    if not any(routine.builtin for routine in typed.routines.values()):
        return None
    from achse.devices.plc import PlcRequests

    return PlcRequests(lambda: _EPOCH_NS)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep messages of the program out of the log: the verdict has what matters."""
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)
