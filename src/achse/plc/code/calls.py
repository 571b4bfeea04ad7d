"""Calls as Python source: of functions and methods with their values, of blocks with stores."""

from typing import TYPE_CHECKING, Any, NamedTuple

from achse.iec.elementary import BoolType, RealType
from achse.iec.strings import StringType
from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.plc.code.source import ATOM, CodeExpression
from achse.plc.code.storages import local_name
from achse.st.check.kinds import counted, is_whole, known_from
from achse.st.typed.expressions import (
    AddressOf,
    Created,
    DirectTarget,
    Invocation,
    Stored,
    TypedValue,
)
from achse.st.typed.places import CalleeBase, PointerBase, Storage, flat
from achse.st.typed.project import Routine, RoutineKind

if TYPE_CHECKING:
    from achse.plc.code.expressions import ExpressionWriter

__all__ = [
    "CallWriter",
    "HeldAddress",
    "encoded_from",
    "is_plain",
    "outputs_of",
    "parameters_of",
]

_WITH_FRAME = frozenset(
    {RoutineKind.FUNCTION, RoutineKind.METHOD, RoutineKind.GET, RoutineKind.SET, RoutineKind.LIFE}
)


def parameters_of(routine: Routine) -> list[Variable[Any, Any]]:
    """Return the parameters that a call passes as values: inputs, and in/outs as addresses."""
    return [item for item in routine.parameters if item.section is not Section.OUTPUT]


def outputs_of(routine: Routine) -> list[Variable[Any, Any]]:
    """Return the outputs of a routine, without its result."""
    return [item for item in routine.parameters if item.section is Section.OUTPUT]


class _Callee(NamedTuple):
    """Present referent of CalleeBase: the results of a call, or an instance."""

    routine: Routine
    results: str
    instance: Storage | None


class CallWriter:
    """Writes the calls of one routine."""

    def __init__(self, expressions: "ExpressionWriter") -> None:
        self._of = expressions
        self._callees: list[_Callee] = []

    # the callee, while its arguments are written ---------------------------------------------

    def storage_of(self, storage: Storage) -> Storage:
        """A variable of the instance that is called."""
        instance = self._callees[-1].instance
        assert instance is not None
        return Storage(
            instance.base,
            instance.offset + storage.offset,
            storage.type,
            storage.bit,
            (*instance.steps, *storage.steps),
        )

    def result_read(self, storage: Storage) -> CodeExpression | None:
        """An output of the function that was called; None for any other storage."""
        if not isinstance(storage.base, CalleeBase) or self._callees[-1].instance is not None:
            return None
        callee = self._callees[-1]
        for number, output in enumerate(outputs_of(callee.routine), 1):
            if output.offset == storage.offset:
                return _ranged(f"{callee.results}[{number}]", storage.type)
        raise AssertionError(f"{callee.routine.name} has no output at {storage.offset}")

    # calls -----------------------------------------------------------------------------------

    def expression(self, call: Invocation) -> CodeExpression:
        """A call as an expression."""
        effects, result = self._effects(call)
        if len(effects) == 1 and result is None:
            return _ranged(effects[0], call.type)
        if result is not None:
            effects.append(result)
            return _ranged(f"({', '.join(effects)})[-1]", call.type)
        return CodeExpression(f"({', '.join(effects)})[-1]")

    def _routine(self, call: Invocation) -> Routine | str:
        target = call.target
        key = target.routine if isinstance(target, DirectTarget) else target.declared
        return self._of.linker.routine(key)

    def statements(self, call: Invocation) -> list[str]:
        """Lines that make a call whose value nobody wants."""
        routine = self._routine(call)
        if isinstance(routine, str) or routine.kind in _WITH_FRAME:
            return self._effects(call)[0]
        of = self._of
        lines: list[str] = []
        storage, address = self._instance(call, lines)
        self._callees.append(_Callee(routine, "", storage))
        store = of.storages.store_statement
        lines += [store(stored.storage, of.value(stored.value)) for stored in call.inputs]
        lines.append(self._body_call(call, routine, address))
        lines += [store(stored.storage, of.value(stored.value)) for stored in call.outputs]
        self._callees.pop()
        return lines

    def _effects(self, call: Invocation) -> tuple[list[str], str | None]:
        """Expressions in order, and the one that is the value; None if that is the only one."""
        routine = self._routine(call)
        if isinstance(routine, str):
            return [f"unavailable({routine!r})"], None
        if routine.kind in _WITH_FRAME:
            return self._function_call(call, routine)
        effects: list[str] = []
        lines: list[str] = []
        storage, address = self._instance(call, lines)
        effects += [f"({line.replace(' = ', ' := ', 1)})" for line in lines]
        self._callees.append(_Callee(routine, "", storage))
        effects += map(self._stored, call.inputs)
        effects.append(self._body_call(call, routine, address))
        effects += map(self._stored, call.outputs)
        self._callees.pop()
        return effects, None

    def _instance(self, call: Invocation, lines: list[str]) -> tuple[Storage | None, str]:
        """The instance of a block's call as a storage, and its address."""
        instance = call.instance
        if instance is None:
            return None, ""
        of = self._of
        if isinstance(instance, AddressOf) and is_plain(instance.storage):
            return instance.storage, of.storages.address(instance.storage).text
        name = of.temporary()
        lines.append(f"{name} = {of.exact_value(instance).text}")
        return Storage(PointerBase(HeldAddress(name, instance.type)), 0, instance.type), name  # type: ignore[arg-type]

    def _body_call(self, call: Invocation, routine: Routine, address: str) -> str:
        if isinstance(call.target, DirectTarget):
            arguments = address if routine.this is not None else ""
            return f"{self._of.linker.name_of(routine.key)}({arguments})"
        return f"dispatched({address}, {call.target.name!r})({address})"

    def _function_call(self, call: Invocation, routine: Routine) -> tuple[list[str], str | None]:
        of = self._of
        arguments: list[str] = []
        name = of.linker.name_of(routine.key)
        if call.instance is not None:
            address = of.exact_value(call.instance).text
            if isinstance(call.target, DirectTarget):
                arguments.append(address)
            else:
                held = of.temporary()
                name = f"dispatched({held} := {address}, {call.target.name!r})"
                arguments.append(held)
        arguments += self.arguments(routine, call.inputs)
        text = f"{name}({', '.join(arguments)})"
        if not outputs_of(routine):
            return [text], None
        held = of.temporary()
        effects = [f"({held} := {text})"]
        self._callees.append(_Callee(routine, held, None))
        effects += map(self._stored, call.outputs)
        self._callees.pop()
        return effects, f"{held}[0]"

    def _stored(self, stored: Stored) -> str:
        of = self._of
        return of.storages.store_expression(stored.storage, of.value(stored.value)).text

    def arguments(self, routine: Routine, inputs: tuple[Stored, ...]) -> list[str]:
        """The arguments of a function, in the order of evaluation; left out ones start as
        declared."""
        of = self._of
        parameters = parameters_of(routine)
        by_offset = {parameter.offset: parameter for parameter in parameters}
        given: list[tuple[Variable[Any, Any], str]] = []
        for stored in inputs:
            parameter = by_offset[stored.storage.offset]
            value: TypedValue = stored.value
            piece = of.exact_value(value)
            given.append((parameter, piece.text))
        names = [parameter.name for parameter, _ in given]
        if names == [parameter.name for parameter in parameters]:
            return [text for _, text in given]
        missing = [
            f"{local_name(parameter)}={self._initial(routine, parameter)}"
            for parameter in parameters
            if parameter.name not in names
        ]
        return [f"{local_name(parameter)}={text}" for parameter, text in given] + missing

    def _initial(self, routine: Routine, parameter: Variable[Any, Any]) -> str:
        image = routine.frame.default[parameter.offset : parameter.offset + parameter.type.size]
        return self._of.value(known_from(image, flat(parameter.type))).text

    # memory that programs make ---------------------------------------------------------------

    def created(self, value: Created) -> CodeExpression:
        """`__NEW`."""
        of = self._of
        count = "1" if value.count is None else of.exact_value(value.count).text
        create = "None"
        if isinstance(value.of, StructType):
            create = self.life_call(value.of, value.arguments, complete=True)
        text = f"new_memory({of.linker.constant(value.of)}, {count}, {create})"
        return CodeExpression(text, ATOM, 0, (1 << 64) - 1)

    def life_call(
        self, type: StructType[Any], arguments: tuple[Stored, ...], *, complete: bool = False
    ) -> str:
        """A function of an address that brings a record there to life; None if none is needed.

        `complete`: methods with `call_after_init` too.
        """
        of = self._of
        record = of.linker.record(type)
        if record is None:
            return "None"
        steps = [f"begin_block(p, {record.number})"] if record.number else []
        if record.create:
            routine = of.linker.routine(record.create)
            if isinstance(routine, str):
                steps.append(f"unavailable({routine!r})")
            else:
                texts = ", ".join(["p", *self.arguments(routine, arguments)])
                steps.append(f"{of.linker.name_of(record.create)}({texts})")
        if complete:
            steps += [f"{of.linker.name_of(key)}(p)" for key in record.after_init]
        return f"lambda p: ({', '.join(steps)},)" if steps else "None"

    def deleted(self, address: CodeExpression) -> str:
        """`__DELETE`, without the pointer that becomes 0."""
        return f"delete_memory({address.text})"


class HeldAddress(NamedTuple):
    """A typed value that is an address in a Python variable."""

    name: str
    type: IecType[Any] | None


def is_plain(storage: Storage) -> bool:
    """Return True if the address of a storage can be written twice: it has no side effect."""
    return not storage.steps and not isinstance(storage.base, PointerBase)


def _ranged(text: str, type: IecType[Any] | None) -> CodeExpression:
    if type is not None and is_whole(type):
        whole = counted(type)
        return CodeExpression(text, ATOM, whole.low, whole.high)
    return CodeExpression(text)


def encoded_from(value: Any, type: IecType[Any]) -> bytes:
    """The bytes in memory of a value that emitted code made, of a flat type."""
    if isinstance(type, StringType):
        return bytes(value[: type.length * type.unit]).ljust(type.size, b"\0")
    if isinstance(type, BoolType):
        return b"\1" if value else b"\0"
    if isinstance(type, RealType):
        return type.codec.pack(value)
    if is_whole(type):
        whole = counted(type)
        return int(value).to_bytes(whole.size, "little", signed=whole.low < 0)
    return bytes(value)
