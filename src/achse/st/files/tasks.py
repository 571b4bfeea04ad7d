"""Tasks as files declare them.

Source: `.TcTTO` files of public projects.
"""

import logging
import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

_VISU = re.compile(r"VisuElems\.|.*\bVisu_Prg$", re.IGNORECASE)
"""Programs that the vendor's visualisation brings along."""

log = logging.getLogger("achse.plc")


class FileTask(NamedTuple):
    """A task; `programs` only if the file lists them."""

    name: str
    cycle_ns: int = 10_000_000
    priority: int = 20
    programs: tuple[str, ...] = ()
    watchdog_cycles: int = 0
    port: int = 0
    floating_point_exceptions: bool = True


def has_floating_point_exceptions(tasks: Iterable[FileTask]) -> bool:
    """Return False if a task of a PLC has them off: code that tasks share exists once."""
    return all(task.floating_point_exceptions for task in tasks)


def called_tasks(declared: Iterable[FileTask], programs: Sequence[str]) -> list[FileTask]:
    """Return the tasks that run the declared `programs`: those of the project without the programs
    of its screens, else one for all programs."""
    known = {name.lower() for name in programs}
    if not known:
        return [task._replace(programs=()) for task in declared] or [FileTask("PlcTask")]
    calling = []
    for task in declared:
        screens = [n for n in task.programs if n.lower() not in known and _VISU.match(n)]
        if screens:
            log.info("task %s: %s is left out: there are no screens", task.name, ", ".join(screens))
        rest = tuple(name for name in task.programs if name not in screens)
        if rest or not screens:
            calling.append(task._replace(programs=rest))
    return calling or [FileTask("PlcTask", programs=tuple(programs))]
