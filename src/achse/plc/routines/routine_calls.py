"""RoutineCalls: calls of methods and properties from outside of a cycle: by clients and Python."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from achse.iec.derived import resolved
from achse.iec.methods import Method
from achse.iec.structs import Record, StructType
from achse.iec.variables import Section
from achse.plc.code.execution import Execution
from achse.plc.code.storages import encoded_from
from achse.plc.lowering.calls import outputs_of, parameters_of
from achse.plc.memory import Memory
from achse.plc.routines.python_bodies import python_attribute
from achse.st.check.kinds import known_from
from achse.st.typed.places import flat
from achse.st.typed.project import Routine, TypedBlock, TypedProject

Guard = Callable[[str, Callable[[], Any]], Any]
"""Runs something that is named in words."""


@contextmanager
def outside_cycle(execution: Execution) -> Iterator[Execution]:
    """Give the whole budget to what runs outside of cycles."""
    execution.reset_budget()
    execution.allow_calls()
    try:
        yield execution
    finally:
        execution.rest()


def unguarded(what: str, work: Callable[[], Any]) -> Any:
    """Run `work` as it is."""
    return work()


class RoutineCalls:
    """Calls of the routines of a project whose code is linked with a memory."""

    def __init__(
        self, project: TypedProject, memory: Memory, execution: Execution, guard: Guard
    ) -> None:
        """`guard` runs what a client calls: the PLC puts itself around it."""
        self._project = project
        self._memory = memory
        self._execution = execution
        self._guard = guard

    def block_of(self, type: StructType[Any]) -> TypedBlock | None:
        return self._project.blocks.get(type.name.lower())

    def call_encoded(self, record: Record, method: Method, data: bytes) -> bytes | None:
        """Return a method as clients call it, values as bytes; None if no Structured Text does
        it."""
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
        """Return a property as clients read it; None if no Structured Text gives it."""
        routine = self._routine(record, f"__get{name}")
        return None if routine is None else _answer(routine, self._call(routine, record, ()))

    def set_encoded(self, record: Record, name: str, data: bytes) -> bool:
        """Return a property as clients write it; FALSE if no Structured Text takes it."""
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
        by_name = {item.name.lower(): value for item, value in zip(inputs, values, strict=False)}
        for key, value in named.items():
            if key.lower() in by_name or key.lower() not in {item.name.lower() for item in inputs}:
                names = ", ".join(item.name for item in inputs) or "no inputs"
                raise TypeError(f"{routine.name} takes {names}, each once, got {key}")
            by_name[key.lower()] = value
        image = routine.frame.default
        arguments = []
        for item in inputs:
            data = image[item.offset : item.offset + item.type.size]
            if item.name.lower() in by_name:
                data = item.type.encode(by_name[item.name.lower()])
            arguments.append(known_from(data, flat(item.type)).value)
        answer = self._call(routine, record, arguments)
        outputs = outputs_of(routine)
        answers = list(answer) if outputs else [answer]
        of = [routine.result, *outputs]
        result = [
            item.type.decode(encoded_from(value, flat(item.type)))
            for value, item in zip(answers, of, strict=True)
            if item is not None
        ]
        if not result:
            return None
        return tuple(result) if len(result) > 1 else result[0]

    def _routine(self, record: Record, name: str) -> Routine | None:
        """Return the Structured Text of a block's method or of a program's; None without any."""
        type = record.__class__.__iec__
        block = self.block_of(type)
        owner = f"{type.name}.{name}".lower()
        key = owner if block is None else block.table.get(name.lower(), "")
        routine = self._project.routines.get(key)
        if routine is None or routine.body is None or python_attribute(record.__class__, name):
            return None  # A Python class replaces the source.
        return routine

    def _call(self, routine: Routine, record: Record, values: Sequence[Any]) -> Any:
        function = self._execution.function(routine.key)
        if routine.this is not None:
            address = self._memory.address_of(record.__iec_buffer__, record.__iec_offset__)
            values = (address, *values)
        with outside_cycle(self._execution):
            return self._guard(f"a call of {routine.name}", lambda: function(*values))

    def invoke(self, record: Record, name: str, values: tuple[Any, ...]) -> Any:
        """Return a call of Structured Text from Python: of a block's body (no name) or a method."""
        type = resolved(record.__class__.__iec__)
        assert isinstance(type, StructType)
        block = self.block_of(type)
        key = None if block is None else block.table.get(name.lower())
        if key is None:
            raise AttributeError(f"{type.name} has no {name or 'body'} in Structured Text")
        address = self._memory.address_of(record.__iec_buffer__, record.__iec_offset__)
        return self._execution.function(key)(address, *values)


def _answer(routine: Routine, answer: Any) -> bytes:
    """Return the outcome of a method as bytes: the result, then the outputs."""
    outputs = outputs_of(routine)
    values = list(answer) if outputs else [answer]
    types = [None if routine.result is None else routine.result.type]
    types += [output.type for output in outputs]
    return b"".join(
        encoded_from(value, flat(type))
        for value, type in zip(values, types, strict=True)
        if type is not None
    )
