"""Routines in machine code: head, frame, body; entries and callbacks between them and Python."""

from typing import TYPE_CHECKING, Any

from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.native.backend import (
    ADDRESS,
    BOOL,
    F64,
    I64,
    U8,
    U64,
    CallTarget,
    FunctionBuilder,
    MachineType,
    Operand,
    Relation,
)
from achse.plc.code.frames import STACK_SIZE
from achse.plc.lowering.routines import lowered
from achse.plc.machine.expressions import ExpressionTranslator
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.signatures import PartKind, RoutineSignature, signature_of
from achse.plc.machine.statements import StatementTranslator
from achse.plc.machine.support import WORD
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    is_packed,
)
from achse.plc.memory import Area
from achse.st.typed.project import Routine

if TYPE_CHECKING:
    from achse.plc.machine.module import ProjectTranslator

_ALIGNMENT = 8
_LARGEST_FRAME = 512 << 10
"""Bytes of the stack that one call may take, about: the main thread on Windows has 1 MB."""


def translate_routine(
    module: "ProjectTranslator", routine: Routine, number: int, builder: FunctionBuilder
) -> None:
    """Write a routine. Raises `NotTranslatedError`."""
    _RoutineTranslator(module, routine, number, builder).write()


class _RoutineTranslator:
    def __init__(
        self, module: "ProjectTranslator", routine: Routine, number: int, builder: FunctionBuilder
    ) -> None:
        self._module = module
        self._routine = routine
        self._low = lowered(module.lowered, routine)
        self._builder = builder
        self._signature = signature_of(routine)
        self._of = ExpressionTranslator(module, self._low, number, builder)
        parameters = list(builder.parameters)
        if self._signature.has_instance:
            self._of.this = parameters.pop(0)
        passed = [temporary for _, temporary in self._low.parameters]
        for part, temporary in zip(self._signature.inputs, passed, strict=True):
            width = 2 if part.kind is PartKind.TEXT else 1
            words = [parameters.pop(0) for _ in range(width)]
            self._of.temporaries[temporary.number] = _as_value(words, part.type)
        self._rooms = parameters

    def write(self) -> None:
        """Write the routine, body first: it shows what the head needs."""
        routine, of, b = self._routine, self._of, self._builder
        of.calls.check_parameters(self._signature)
        b.will_descend()
        for store in self._low.start:
            assert store.place.variable is not None
            of.locals[store.place.variable.name.lower()] = of.own(store.place.type)
        of.place(routine.at)
        statements = StatementTranslator(of, self._results, self._leave)
        statements.block(self._low.body)
        if not b.ended:
            self._leave(self._results())
        with b.opening():
            self._head()
        if b.frame_estimate > _LARGEST_FRAME:
            raise NotTranslatedError("it is too large for the stack")

    # the head --------------------------------------------------------------------------------

    def _head(self) -> None:
        routine, of, b = self._routine, self._of, self._builder
        of.place(routine.at)
        b.descend(of.site(FaultKind.DEPTH))
        b.spend(self._low.cost, of.site(FaultKind.BUDGET))
        if of.uses_instance:
            self._instance()
        if self._low.is_framed:
            of.area(Area.STACK)
        for area in sorted(of.areas, key=lambda one: one.name):
            row = b.load(ADDRESS, self._module.support.areas, self._module.area_row(area))
            b.named(f"area.{area.name.lower()}", row)
        for store in self._low.start:
            of.value(store)
        if self._low.is_framed:
            self._enter()

    def _instance(self) -> None:
        of, b, this = self._of, self._builder, self._routine.this
        assert this is not None
        if of.aligned_instance and this.alignment > 1:
            low = b.bit_and(of.this, b.constant(U64, this.alignment - 1))
            good = b.compare(Relation.EQUAL, low, b.constant(U64, 0))
            b.require(good, of.site(FaultKind.ALIGNMENT), of.this)
        b.named("instance", of.storages.looked_up(of.this, this.size))

    def _enter(self) -> None:
        """Write the frame: room for it, its image, and the parameters that need memory."""
        routine, of, b = self._routine, self._of, self._builder
        frames = self._module.support.frames
        top = b.named("frame.offset", b.load(U64, frames))
        size = routine.frame.size
        end = b.add(top, b.constant(U64, size + _ALIGNMENT - 1 & -_ALIGNMENT))
        room = b.compare(Relation.LESS_EQUAL, end, b.constant(U64, STACK_SIZE))
        b.require(room, of.site(FaultKind.FRAMES))
        b.store(end, frames)
        frame = b.named("frame", b.address(of.area(Area.STACK), top))
        b.copy(frame, b.module.data(self._low.image), size)
        for store in self._low.entry:
            of.value(store)

    # the end ---------------------------------------------------------------------------------

    def _results(self) -> list[Operand]:
        """Return the results in registers; texts, records and outputs are stored at the caller's
        addresses."""
        of, b, rooms = self._of, self._builder, list(self._rooms)
        results: list[Operand] = []
        values = list(self._low.results)
        if self._signature.result is not None:
            value = of.value(values.pop(0))
            if isinstance(value, Operand):
                results.append(value)
            elif isinstance(value, MachineText):
                b.copy(rooms.pop(0), value.address, value.length)
                results.append(value.length)
            else:
                b.copy(rooms.pop(0), value.address, value.size)
        for value in map(of.value, values):
            room = rooms.pop(0)
            if isinstance(value, Operand):
                b.store(value, room)
            elif isinstance(value, MachineText):
                b.copy(room, value.address, value.length)
                b.store(value.length, rooms.pop(0))
            else:
                b.copy(room, value.address, value.size)
        return results

    def _leave(self, results: list[Operand]) -> None:
        if self._low.is_framed:
            self._builder.store(self._of.frame_offset, self._module.support.frames)
        self._builder.return_(*results)


def _as_value(words: list[Operand], type: IecType[Any]) -> MachineValue:
    """Return a parameter."""
    if isinstance(type, StringType):
        return MachineText(words[0], words[1])
    return PackedBytes(words[0], type.size) if is_packed(type) else words[0]


# doors: a block has a word for each argument and each thing that is given ----------------------


def _to_word(b: FunctionBuilder, value: Operand) -> Operand:
    if value.type.is_real:
        return b.reinterpret(b.convert(value, F64), I64)
    if value.type is BOOL:
        value = b.convert(value, U8)
    return b.convert(value, I64)


def _from_word(b: FunctionBuilder, word: Operand, type: MachineType) -> Operand:
    if type.is_real:
        return b.convert(b.reinterpret(word, F64), type)
    return b.convert(word, type)


def write_entry(
    module: "ProjectTranslator", signature: RoutineSignature, target: CallTarget, name: str
) -> CallTarget:
    """Return a function of a block, for Python: the words of all parameters; after them, the
    result."""
    b = module.module.function(name, [ADDRESS], faults=True)
    (block,) = b.parameters
    arguments = [
        _from_word(b, b.load(I64, block, number * WORD), type)
        for number, type in enumerate(signature.parameters)
    ]
    results = b.call(target, *arguments)
    for result in results:
        b.store(_to_word(b, result), block, len(arguments) * WORD)
    b.return_()
    return b.function


def write_callback(
    module: "ProjectTranslator", signature: RoutineSignature, builder: FunctionBuilder, number: int
) -> None:
    """Write a function of machine code that calls Python's function `number`."""
    b = builder
    b.place = None
    size = len(b.parameters) + 1
    block = b.buffer(size * WORD)
    for place, value in enumerate(b.parameters):
        b.store(_to_word(b, value), block, place * WORD)
    b.call(module.support.call_plain, b.constant(I64, number), block)
    results = [
        _from_word(b, b.load(I64, block, len(b.parameters) * WORD), type)
        for type in signature.results
    ]
    b.return_(*results)
