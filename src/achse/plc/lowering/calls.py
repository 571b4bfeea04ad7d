"""Calls: instance, arguments, results and outputs in their order, and records that are created."""

from typing import Any

from achse.iec.structs import StructType
from achse.iec.types import IecType
from achse.iec.variables import Section, Variable
from achse.plc.lowering import nodes
from achse.plc.lowering.places import ADDRESS_TYPE, PlaceLowering, PresentCallee
from achse.st.check.kinds import UNSIGNED, known_from
from achse.st.typed.expressions import AddressOf, Created, DirectTarget, Invocation, Known, Stored
from achse.st.typed.places import PointerBase, TemporaryBase, flat
from achse.st.typed.project import Routine, RoutineKind, TypedBlock

WITH_PARAMETERS = frozenset(
    {RoutineKind.FUNCTION, RoutineKind.METHOD, RoutineKind.GET, RoutineKind.SET, RoutineKind.LIFE}
)
"""Kinds of routines that have parameters; the others find theirs in the instance or unit."""


def parameters_of(routine: Routine) -> list[Variable[Any, Any]]:
    """Return the parameters that a call passes as values: inputs, and in/outs as addresses."""
    return [item for item in routine.parameters if item.section is not Section.OUTPUT]


def outputs_of(routine: Routine) -> list[Variable[Any, Any]]:
    """Return the outputs of a routine, without its result."""
    return [item for item in routine.parameters if item.section is Section.OUTPUT]


class CallLowering(PlaceLowering):
    """Lowers the calls of one routine."""

    def call(self, call: Invocation) -> nodes.LoweredValue:
        """Return a call as a value: its result."""
        effects, result = self.call_effects(call, alone=False)
        if result is None:
            result = effects.pop()
        return nodes.Sequence(tuple(effects), result) if effects else result

    def call_effects(
        self, call: Invocation, *, alone: bool
    ) -> tuple[list[nodes.LoweredValue], nodes.LoweredValue | None]:
        """Return all effects of a call in order, and its value unless that is the last effect."""
        target = call.target
        if isinstance(target, DirectTarget):
            routine, entry = self.project.routine(target.routine), None
        else:
            routine, entry = self.project.routine(target.declared), target.name
        if isinstance(routine, str):
            if isinstance(target, DirectTarget) and target.routine in self.project.typed.inert:
                return [], None
            return [_missing(routine, call.type)], None
        if routine.kind in WITH_PARAMETERS:
            return self._function(call, routine, entry)
        effects, place, address = self._instance(call)
        self.callees.append(PresentCallee(place, {}))
        self.changes += 1
        effects += [self.store(one.storage, one.value, alone=alone) for one in call.inputs]
        if routine.this is None and entry is None:
            address = None
        effects.append(nodes.RoutineCall(routine, entry, address, (), (), call.type))
        effects += [self.store(one.storage, one.value, alone=alone) for one in call.outputs]
        self.callees.pop()
        return effects, None

    def _instance(
        self, call: Invocation
    ) -> tuple[list[nodes.LoweredValue], nodes.ResolvedPlace | None, nodes.LoweredValue | None]:
        """Return the instance of a block: what is done first, its place and its address."""
        instance = call.instance
        if instance is None:
            return [], None, None
        if isinstance(instance, AddressOf):
            storage = instance.storage
            if not storage.steps and not isinstance(storage.base, PointerBase | TemporaryBase):
                place = self.place(storage)
                return [], place, nodes.PlaceAddress(place, instance.type)
        pointer = self.temporary(instance.type)
        place = nodes.ResolvedPlace(nodes.Home.ADDRESS, 0, ADDRESS_TYPE, address=pointer)
        return [nodes.Keep(pointer, self.value(instance))], place, pointer

    def _function(
        self, call: Invocation, routine: Routine, entry: str | None
    ) -> tuple[list[nodes.LoweredValue], nodes.LoweredValue | None]:
        instance = None if call.instance is None else self.value(call.instance)
        arguments = self.arguments(routine, call.inputs)
        self.changes += 1
        outputs = {one.offset: self.temporary(flat(one.type)) for one in outputs_of(routine)}
        if not (outputs or call.outputs):
            return [nodes.RoutineCall(routine, entry, instance, arguments, (), call.type)], None
        result = self.temporary(call.type)
        targets = (result, *outputs.values()) if outputs else ()
        called = nodes.RoutineCall(routine, entry, instance, arguments, targets, call.type)
        effects: list[nodes.LoweredValue] = [called if outputs else nodes.Keep(result, called)]
        if routine.result is not None:  # `F(a := x, F => y)` stores it.
            outputs[routine.result.offset] = result
        self.callees.append(PresentCallee(None, outputs))
        effects += [self.store(one.storage, one.value, alone=False) for one in call.outputs]
        self.callees.pop()
        return effects, result

    def arguments(
        self, routine: Routine, inputs: tuple[Stored, ...]
    ) -> tuple[tuple[Variable[Any, Any], nodes.LoweredValue], ...]:
        """Return all arguments in the order of evaluation; omitted ones start as declared."""
        parameters = {parameter.offset: parameter for parameter in parameters_of(routine)}
        parameters_in_order = [parameters.pop(one.storage.offset) for one in inputs]
        arguments = zip(
            parameters_in_order, self.operands(one.value for one in inputs), strict=True
        )
        missing = [(one, initial_value(routine, one)) for one in parameters.values()]
        return (*arguments, *missing)

    # records that are created ----------------------------------------------------------------

    def creation(self, value: Created) -> nodes.LoweredValue:
        """`__NEW`."""
        count = Known(1, ADDRESS_TYPE) if value.count is None else self.value(value.count)
        pointer = self.temporary(ADDRESS_TYPE)
        self.changes += 1
        effects: list[nodes.LoweredValue] = []
        if isinstance(value.of, StructType):
            effects += self.begin(value.of, value.arguments, pointer)
            effects += self.after_init(value.of, pointer)
        return nodes.Creation(value.of, count, pointer, tuple(effects), value.type)

    def begin(
        self, type: StructType[Any], arguments: tuple[Stored, ...], pointer: nodes.Temporary
    ) -> list[nodes.LoweredValue]:
        """Return the first effects on a record at an address: its header, then its `create`."""
        record = self.project.record(type)
        if record is None:
            return []
        effects: list[nodes.LoweredValue] = []
        if isinstance(record, TypedBlock):
            word = UNSIGNED[type.rules.pointer_size]
            header = nodes.ResolvedPlace(nodes.Home.ADDRESS, 0, word, address=pointer)
            effects.append(nodes.StoreValue(header, Known(record.number, word)))
        if record.create:
            effects.append(self.life_call(record.create, arguments, pointer))
        return effects

    def after_init(
        self, type: StructType[Any], pointer: nodes.Temporary
    ) -> list[nodes.LoweredValue]:
        """Return the calls after a record has all its values."""
        record = self.project.record(type)
        keys = record.after_init if isinstance(record, TypedBlock) else ()
        return [self.life_call(key, (), pointer) for key in keys]

    def life_call(
        self, key: str, arguments: tuple[Stored, ...], pointer: nodes.Temporary
    ) -> nodes.LoweredValue:
        """Return the call of a routine of a record's lifecycle."""
        routine = self.project.routine(key)
        if isinstance(routine, str):
            return _missing(routine, None)
        return nodes.RoutineCall(
            routine, None, pointer, self.arguments(routine, arguments), (), None
        )


def _missing(reason: str, type: IecType[Any] | None) -> nodes.RuntimeCall:
    return nodes.RuntimeCall(
        "unavailable", (), reason, type, f"it calls what is not there: {reason}"
    )


def initial_value(routine: Routine, variable: Variable[Any, Any]) -> Known:
    """Return the value that a variable of the frame begins with."""
    image = routine.frame.default[variable.offset : variable.offset + variable.type.size]
    return known_from(image, flat(variable.type))
