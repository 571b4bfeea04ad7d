"""Routines: what a call takes, its frame, what it does, and its results."""

from typing import Any

from achse.iec.variables import Variable
from achse.plc.lowering.calls import WITH_PARAMETERS, initial_value, outputs_of, parameters_of
from achse.plc.lowering.counters import RoutineCounters
from achse.plc.lowering.nodes import LoweredRoutine, StoreValue
from achse.plc.lowering.places import BYTES_A_PASS
from achse.plc.lowering.project import LoweredProject
from achse.plc.lowering.statements import StatementLowering
from achse.plc.retention.layout import frame_image
from achse.st.typed.places import FrameBase, Storage, flat
from achse.st.typed.project import Routine


def lowered(
    project: LoweredProject, routine: Routine, *, all_in_memory: bool = False
) -> LoweredRoutine:
    """Lower a routine. Raises `MissingPlaceError`.

    `all_in_memory`: every variable of the frame has memory, where a debugger finds it.
    """
    fields = routine.frame.fields
    names = {field.name.lower() for field in fields}
    in_memory = frozenset(names if all_in_memory else names & routine.addressed)
    first = project.counted.get(routine.key)
    counters = None if first is None else RoutineCounters(first)
    of = StatementLowering(project, routine, in_memory, counters)
    parameters = parameters_of(routine) if routine.kind in WITH_PARAMETERS else []
    passed = {one.offset: of.temporary(flat(one.type)) for one in parameters}
    start: list[StoreValue] = []
    entry: list[StoreValue] = []
    for field in fields:
        place = of.place(_storage(field))
        if field.offset in passed:
            stores = entry if field.name.lower() in in_memory else start
            stores.append(StoreValue(place, passed[field.offset]))
        elif field.name.lower() not in in_memory:
            start.append(StoreValue(place, initial_value(routine, field)))
    result = [] if routine.result is None else [routine.result]
    is_framed = bool(in_memory) or all_in_memory
    opening = len(routine.opening)
    body, texts = of.priced((*routine.opening, *(routine.body or ())), uncounted=opening)
    return LoweredRoutine(
        routine,
        1 + routine.frame.size // BYTES_A_PASS + texts,
        tuple(zip(parameters, passed.values(), strict=True)),
        tuple(start),
        is_framed,
        frame_image(routine, project.typed.blocks) if is_framed else b"",
        tuple(entry),
        body,
        tuple(of.read(_storage(one)) for one in (*result, *outputs_of(routine))),
        counters,
    )


def _storage(variable: Variable[Any, Any]) -> Storage:
    return Storage(FrameBase(), variable.offset, flat(variable.type))
