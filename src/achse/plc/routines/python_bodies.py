"""Python bodies: function blocks and methods whose Python class replaces the source."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from achse.iec.structs import Record, RecordKind, StructType
from achse.iec.variables import Section, Variable
from achse.plc.code.storages import encoded_from
from achse.plc.lowering.calls import outputs_of, parameters_of
from achse.st.check.kinds import known_from
from achse.st.typed.places import flat
from achse.st.typed.project import Routine, RoutineKind, TypedProject

RecordAt = Callable[[int, StructType[Any]], Record]
"""The record of a type at an address."""


def has_python_bodies(project: TypedProject) -> bool:
    """Return True if a Python class implements a block of the project."""
    return any(True for _ in _replaced(project))


def python_bodies(project: TypedProject, record_at: RecordAt) -> Mapping[str, Callable[..., Any]]:
    """Return the function blocks and methods that a Python class implements, by key."""
    return {
        routine.key: _python_body(routine, this, attribute, record_at)
        for routine, this, attribute in _replaced(project)
    }


def _replaced(project: TypedProject) -> Iterator[tuple[Routine, StructType[Any], str]]:
    """Yield each routine whose source is replaced, its block and the attribute that replaces it."""
    known: dict[type[Record], Mapping[str, str]] = {}
    for routine in project.routines.values():
        this = routine.this
        if this is None or this.kind is not RecordKind.FUNCTION_BLOCK:
            continue
        if routine.kind not in (RoutineKind.BODY, RoutineKind.METHOD):
            continue
        name = "cycle" if routine.kind is RoutineKind.BODY else routine.name.rpartition(".")[2]
        if (attributes := known.get(this.record)) is None:
            attributes = known[this.record] = _attributes(this.record)
        attribute = attributes.get(_key(name))
        if attribute is not None and callable(getattr(this.record, attribute)):
            yield routine, this, attribute


def _python_body(
    routine: Routine, this: StructType[Any], attribute: str, record_at: RecordAt
) -> Callable[..., Any]:
    if routine.kind is RoutineKind.BODY:
        return lambda address: getattr(record_at(address, this), attribute)()
    inputs, outputs = parameters_of(routine), outputs_of(routine)

    def method(address: int, *values: Any) -> Any:
        arguments = [
            item.type.decode(encoded_from(value, flat(item.type)))
            if item.section is Section.INPUT
            else value
            for item, value in zip(inputs, values, strict=True)
        ]
        answer = getattr(record_at(address, this), attribute)(*arguments)
        if not outputs:
            return None if routine.result is None else _taken(routine.result, answer)
        results = list(answer) if isinstance(answer, tuple) else [answer]
        slots = [routine.result, *outputs]
        if routine.result is None:
            results = [None, *results]
        return tuple(
            None if slot is None else _taken(slot, value)
            for slot, value in zip(slots, results, strict=True)
        )

    return method


def _taken(variable: Variable[Any, Any], value: Any) -> Any:
    """Return a value that a Python method gives, as emitted code has it; None is what it starts
    with."""
    data = variable.initial_bytes() if value is None else variable.type.encode(value)
    return known_from(data, flat(variable.type)).value


def python_attribute(record: type[Record], name: str) -> str | None:
    """Return the attribute of a record's Python class that does what a method, GET or SET does."""
    wanted = _key(name)
    for attribute in dir(record):
        if attribute.lower() == wanted and not record.__iec__.has_member(attribute):
            return attribute
    return None


def _key(name: str) -> str:
    return name.lower().removeprefix("__get").removeprefix("__set")


def _attributes(record: type[Record]) -> Mapping[str, str]:
    """Attributes apart from members, by the name in lower case; of equal names the first."""
    has_member = record.__iec__.has_member
    return {name.lower(): name for name in reversed(dir(record)) if not has_member(name)}
