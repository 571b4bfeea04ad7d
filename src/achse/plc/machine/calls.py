"""Calls in machine code: arguments, room for what comes back, and methods of the instance."""

from typing import TYPE_CHECKING

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
from achse.plc.lowering.nodes import RoutineCall
from achse.plc.machine.signatures import PartKind, RoutineSignature, SignaturePart, signature_of
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    machine_type,
    words_of,
)
from achse.st.typed.project import Routine

if TYPE_CHECKING:
    from achse.plc.machine.expressions import ExpressionTranslator

_WORD = 8
_MOST_PARAMETERS = 500
"""Words that a call may pass: they are on the stack before the callee checks it."""


class CallTranslator:
    """Translates the calls of one routine."""

    def __init__(self, expressions: "ExpressionTranslator") -> None:
        self._of = expressions

    def check_parameters(self, signature: RoutineSignature) -> None:
        """Raise NotTranslatedError if a call passes too much for the stack."""
        if len(signature.parameters) > _MOST_PARAMETERS:
            raise NotTranslatedError(f"more than {_MOST_PARAMETERS} parameters are on the stack")

    def call(self, call: RoutineCall) -> MachineValue:
        """Return a call; its result, or a number that means nothing."""
        of = self._of
        b = of.builder
        signature = signature_of(call.routine, dispatched=call.entry is not None)
        self.check_parameters(signature)
        arguments: list[Operand] = []
        if call.instance is not None:
            arguments.append(b.convert(of.number(call.instance), U64))
        target = None
        if call.entry is not None:
            target = self._dispatched(arguments[0], call.entry, call.routine)
        if call.arguments:
            arguments += self._inputs(signature, call)
        result = signature.result
        room: Operand | None = None
        if result is not None and result.kind is not PartKind.NUMBER:
            room = of.buffer(result.room)
            arguments.append(room)
        places = [self._output(part) for part in signature.outputs]
        for place in places:
            arguments += place
        if target is None:
            results = b.call(of.module.function(call.routine.key), *arguments)
        else:
            results = b.call_at(target, _like(signature), *arguments)
        result_value = self._result_value(result, results, room)
        if call.outputs:
            parts = zip(signature.outputs, places, strict=True)
            values = (result_value, *[self._read(*part) for part in parts])
            for output, value in zip(call.outputs, values, strict=True):
                of.temporaries[output.number] = value
        return result_value

    def _inputs(self, signature: RoutineSignature, call: RoutineCall) -> list[Operand]:
        """Return the arguments, computed in the order they are given."""
        of = self._of
        arguments = {
            variable.offset: words_of(of.value(value)) for variable, value in call.arguments
        }
        operands: list[Operand] = []
        for part in signature.inputs:
            words = arguments[part.offset]
            if part.kind is PartKind.NUMBER:
                words = [of.at_type(words[0], machine_type(part.type))]
            operands += words
        return operands

    def _result_value(
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

    # methods of the instance -----------------------------------------------------------------

    def _dispatched(self, instance: Operand, name: str, routine: Routine) -> Operand:
        """ADDRESS: the function that the block of an instance has under a name."""
        of = self._of
        b = of.builder
        table, length = of.module.dispatch_table(name, routine)
        size = of.module.pointer_size
        kind = U64 if size == U64.size else U32
        (place,) = b.call(of.module.support.locate, instance, b.constant(I64, size))
        target = b.variable(ADDRESS)
        b.set(target, Operand(ADDRESS, "null"))
        there, known, end = b.label(), b.label(), b.label()
        b.branch(b.compare(Relation.NOT_EQUAL, place, Operand(ADDRESS, "null")), there, end)
        b.begin(there)
        number = b.load(kind, place)
        b.branch(b.compare(Relation.LESS, number, b.constant(kind, length)), known, end)
        b.begin(known)
        b.set(
            target, b.load(ADDRESS, table, b.multiply(b.convert(number, U64), b.constant(U64, 8)))
        )
        b.begin(end)
        got = b.get(target)
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
