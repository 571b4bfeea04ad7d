"""Calls in machine code: of functions and methods with their values, of blocks with stores."""

from typing import TYPE_CHECKING, NamedTuple

from achse.native.backend import (
    ADDRESS,
    I64,
    U32,
    U64,
    CallTarget,
    FunctionSignature,
    Operand,
    Relation,
)
from achse.plc.code.calls import HeldAddress
from achse.plc.machine.signatures import PartKind, RoutineSignature, SignaturePart, signature_of
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    machine_type,
)
from achse.st.check.kinds import known_from
from achse.st.typed.expressions import (
    AddressOf,
    DirectTarget,
    Invocation,
    Stored,
    TypedValue,
)
from achse.st.typed.places import CalleeBase, PointerBase, Storage
from achse.st.typed.project import Routine, RoutineKind

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

__all__ = ["CallTranslator"]

_WITH_FRAME = frozenset(
    {RoutineKind.FUNCTION, RoutineKind.METHOD, RoutineKind.GET, RoutineKind.SET, RoutineKind.LIFE}
)
_WORD = 8
_MOST_PARAMETERS = 500
"""Words that a call may pass: they are on the stack before the callee checks it."""


class _Callee(NamedTuple):
    """Present referent of CalleeBase: the outputs of a call, or an instance."""

    outputs: dict[int, MachineValue]
    instance: Storage | None


class CallTranslator:
    """Translates the calls of one routine."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions
        self._callees: list[_Callee] = []
        self._held: dict[str, Operand] = {}

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

    def result_read(self, storage: Storage) -> MachineValue | None:
        """An output of the function that was called; None for any other storage."""
        if not isinstance(storage.base, CalleeBase) or self._callees[-1].instance is not None:
            return None
        found = self._callees[-1].outputs[storage.offset]
        if isinstance(found, Operand):
            return self._of.at_type(found, machine_type(storage.type))
        return found

    def held(self, held: HeldAddress) -> Operand:
        """An address that was computed before."""
        return self._held[held.name]

    # calls -----------------------------------------------------------------------------------

    def check_parameters(self, signature: RoutineSignature) -> None:
        """Raise NotTranslatedError if a call passes too much for the stack."""
        if len(signature.parameters) > _MOST_PARAMETERS:
            raise NotTranslatedError(f"more than {_MOST_PARAMETERS} parameters are on the stack")

    def call(self, call: Invocation, *, alone: bool = False) -> MachineValue:
        """A call; its result, or a number that means nothing."""
        of = self._of
        key = call.target.routine if isinstance(call.target, DirectTarget) else call.target.declared
        routine = of.module.routine(key)
        if isinstance(routine, str):
            raise NotTranslatedError(f"it calls what is not there: {routine}")
        dispatched = not isinstance(call.target, DirectTarget)
        signature = signature_of(routine, dispatched=dispatched)
        self.check_parameters(signature)
        if routine.kind in _WITH_FRAME:
            return self._function_call(call, routine, signature)
        storage, address = self._instance(call)
        self._callees.append(_Callee({}, storage))
        for stored in call.inputs:
            self._store(stored, alone)
        arguments = []
        if signature.has_instance:
            if address is None:
                assert storage is not None
                address = of.storages.address(storage)
            arguments.append(address)
        if isinstance(call.target, DirectTarget):
            of.builder.call(of.module.function(routine.key), *arguments)
        else:
            found = self._dispatched(arguments[0], call.target.name, routine)
            of.builder.call_at(found, _like(signature), *arguments)
        for stored in call.outputs:
            self._store(stored, alone)
        self._callees.pop()
        return of.builder.constant(I64, 0)

    def _store(self, stored: Stored, alone: bool) -> None:
        of = self._of
        of.storages.store(stored.storage, lambda: of.value(stored.value), alone=alone)

    def _instance(self, call: Invocation) -> tuple[Storage | None, Operand | None]:
        """The instance of a block's call as a storage, and its address if that is computed."""
        instance = call.instance
        if instance is None:
            return None, None
        of = self._of
        if isinstance(instance, AddressOf):
            storage = instance.storage
            if not storage.steps and not isinstance(storage.base, PointerBase):
                return storage, None
        address = of.builder.convert(of.number(instance), U64)
        name = f"h{len(self._held)}"
        self._held[name] = address
        assert instance.type is not None
        base = PointerBase(HeldAddress(name, instance.type))  # type: ignore[arg-type]
        return Storage(base, 0, instance.type), address

    def _function_call(
        self, call: Invocation, routine: Routine, signature: RoutineSignature
    ) -> MachineValue:
        of = self._of
        b = of.builder
        arguments: list[Operand] = []
        if call.instance is not None:
            arguments.append(b.convert(of.number(call.instance), U64))
        target = None
        if not isinstance(call.target, DirectTarget):
            target = self._dispatched(arguments[0], call.target.name, routine)
        arguments += self._inputs(routine, signature, call.inputs)
        result = signature.result
        room: Operand | None = None
        if result is not None and result.kind is not PartKind.NUMBER:
            room = of.buffer(result.room)
            arguments.append(room)
        places = [self._output(part) for part in signature.outputs]
        for place in places:
            arguments += place
        if target is None:
            results = b.call(of.module.function(routine.key), *arguments)
        else:
            results = b.call_at(target, _like(signature), *arguments)
        given = self._given(result, results, room)
        if signature.outputs:
            outputs = {
                part.offset: self._read(part, place)
                for part, place in zip(signature.outputs, places, strict=True)
            }
            self._callees.append(_Callee(outputs, None))
            for stored in call.outputs:
                self._store(stored, alone=False)
            self._callees.pop()
        return given

    def _given(
        self, result: SignaturePart | None, results: tuple[Operand, ...], room: Operand | None
    ) -> MachineValue:
        if result is None:
            return self._of.builder.constant(I64, 0)
        match result.kind:
            case PartKind.NUMBER:
                return results[0]
            case PartKind.TEXT:
                assert room is not None
                return MachineText(room, results[0], steady=True)
        assert room is not None
        return PackedBytes(room, result.room, steady=True)

    def _output(self, part: SignaturePart) -> list[Operand]:
        """Room for an output."""
        of = self._of
        if part.kind is PartKind.NUMBER:
            return [of.buffer(_WORD)]
        room = of.buffer(part.room)
        return [room, of.buffer(_WORD)] if part.kind is PartKind.TEXT else [room]

    def _read(self, part: SignaturePart, place: list[Operand]) -> MachineValue:
        b = self._of.builder
        match part.kind:
            case PartKind.NUMBER:
                return b.load(machine_type(part.type), place[0])
            case PartKind.TEXT:
                return MachineText(place[0], b.load(I64, place[1]), steady=True)
        return PackedBytes(place[0], part.room, steady=True)

    def _inputs(
        self, routine: Routine, signature: RoutineSignature, inputs: tuple[Stored, ...]
    ) -> list[Operand]:
        """The arguments, computed in the order they are given; the others start as declared."""
        of = self._of
        values: list[TypedValue] = [stored.value for stored in inputs]
        given = {
            stored.storage.offset: self._as_words(part)
            for stored, part in zip(inputs, of.several(values), strict=True)
        }
        found: list[Operand] = []
        for part in signature.inputs:
            words = given.get(part.offset)
            if words is None:
                image = routine.frame.default[part.offset : part.offset + part.type.size]
                words = self._as_words(of.value(known_from(image, part.type)))
            if part.kind is PartKind.NUMBER:
                words = [of.at_type(words[0], machine_type(part.type))]
            found += words
        return found

    def _as_words(self, value: MachineValue) -> list[Operand]:
        if isinstance(value, Operand):
            return [value]
        if isinstance(value, MachineText):
            return [value.address, value.length]
        return [value.address]

    # methods of the instance -----------------------------------------------------------------

    def _dispatched(self, instance: Operand, name: str, routine: Routine) -> Operand:
        """ADDRESS: the function that the block of an instance has under a name."""
        of = self._of
        b = of.builder
        table, length = of.module.dispatch_table(name, routine)
        size = of.module.pointer_size
        kind = U64 if size == U64.size else U32
        (place,) = b.call(of.module.support.locate, instance, b.constant(I64, size))
        found = b.variable(ADDRESS)
        b.set(found, Operand(ADDRESS, "null"))
        there, known, end = b.label(), b.label(), b.label()
        b.branch(b.compare(Relation.NOT_EQUAL, place, Operand(ADDRESS, "null")), there, end)
        b.begin(there)
        number = b.load(kind, place)
        b.branch(b.compare(Relation.LESS, number, b.constant(kind, length)), known, end)
        b.begin(known)
        b.set(found, b.load(ADDRESS, table, b.multiply(b.convert(number, U64), b.constant(U64, 8))))
        b.begin(end)
        got = b.get(found)
        missing, good = b.label(), b.label()
        b.branch(b.compare(Relation.EQUAL, got, Operand(ADDRESS, "null")), missing, good)
        b.begin(missing)
        b.call(of.module.support.missing, instance, b.constant(I64, of.module.text_number(name)))
        b.begin(good)
        return got


def _like(signature: RoutineSignature) -> CallTarget:
    """Return the call target for a table's function with this signature."""
    types = FunctionSignature(tuple(signature.parameters), tuple(signature.results))
    return CallTarget("", types, faults=True)
