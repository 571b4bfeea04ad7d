"""Values of the lowered form in machine code."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

from achse.iec.elementary import BoolType, RealType
from achse.iec.strings import StringType
from achse.iec.types import IecType
from achse.native.backend import (
    ADDRESS,
    BOOL,
    F64,
    I64,
    U8,
    U64,
    FunctionBuilder,
    LocalVariable,
    MachineType,
    Operand,
    Relation,
)
from achse.plc.lowering import nodes
from achse.plc.machine.calls import CallTranslator
from achse.plc.machine.fault_places import FaultKind
from achse.plc.machine.outside import OutsideTranslator
from achse.plc.machine.reals import RealTranslator
from achse.plc.machine.storages import MachineStorages, OwnBytes
from achse.plc.machine.texts import TextTranslator
from achse.plc.machine.values import (
    MachineText,
    MachineValue,
    NotTranslatedError,
    PackedBytes,
    is_packed,
    machine_type,
    words_of,
)
from achse.plc.memory import Area
from achse.st.check.kinds import counted
from achse.st.typed.expressions import Conversion, Known, Operator

if TYPE_CHECKING:
    from achse.plc.machine.module import ProjectTranslator

_RELATIONS = {
    Operator.EQ: Relation.EQUAL,
    Operator.NE: Relation.NOT_EQUAL,
    Operator.LT: Relation.LESS,
    Operator.LE: Relation.LESS_EQUAL,
    Operator.GT: Relation.GREATER,
    Operator.GE: Relation.GREATER_EQUAL,
}
_TEXTS = frozenset(
    map(Operator, ["LEN", "LEFT", "RIGHT", "MID", "CONCAT", "INSERT", "DELETE", "REPLACE", "FIND"])
)
_LARGEST_BUFFER = 1 << 14
"""Bytes of a value that has no place in PLC memory; routines with larger ones stay plain."""


class ExpressionTranslator:
    """Translates the values of one routine. `number` is the routine's place in the project."""

    def __init__(
        self,
        module: "ProjectTranslator",
        routine: nodes.LoweredRoutine,
        number: int,
        builder: FunctionBuilder,
    ) -> None:
        self.module = module
        self.routine = routine
        self.number_of_routine = number
        self.builder = builder
        builder.place = lambda: self.site(FaultKind.CALL)
        self.at = routine.routine.at
        """Present offset in the source."""
        self.this = Operand(U64, "%this")
        self.instance = Operand(ADDRESS, "%instance")
        self.frame = Operand(ADDRESS, "%frame")
        self.frame_offset = Operand(U64, "%frame.offset")
        self.uses_instance = False
        self.aligned_instance = False
        self.areas: dict[Area, Operand] = {}
        self.locals: dict[str, LocalVariable | OwnBytes] = {}
        """Variables of the frame that need no address, by name."""
        self.storages = MachineStorages(self)
        self.calls = CallTranslator(self)
        self.outside = OutsideTranslator(self)
        self.reals = RealTranslator(self)
        self._texts = TextTranslator(self)
        self.temporaries: dict[int, MachineValue] = {}
        """Values of temporaries."""
        self._vectors: dict[int, LocalVariable] = {}
        """Vectors of decisions, by their temporaries."""
        self._buffers: dict[int, list[Operand]] = {}
        self._borrowed_buffers: list[tuple[int, Operand]] = []

    # what the routine has --------------------------------------------------------------------

    def area(self, area: Area) -> Operand:
        """Return the address at which an area begins."""
        address = self.areas.get(area)
        if address is None:
            address = self.areas[area] = Operand(ADDRESS, f"%area.{area.name.lower()}")
        return address

    def site(self, kind: FaultKind) -> int:
        """Return the number of what may happen where we are."""
        return self.module.sites.number(self.number_of_routine, self.at, kind)

    def place(self, at: int) -> None:
        """Set the place in the source."""
        self.at = at

    def buffer(self, size: int) -> Operand:
        """Return the address of bytes that are ours until the statement ends."""
        if size > _LARGEST_BUFFER:
            raise NotTranslatedError(f"a value of {size} bytes is computed")
        size = max(size + 15 & -16, 16)
        free = self._buffers.setdefault(size, [])
        address = free.pop() if free else self.builder.buffer(size)
        self._borrowed_buffers.append((size, address))
        return address

    def own(self, type: IecType[Any]) -> LocalVariable | OwnBytes:
        """Room for a variable that needs no address."""
        if not isinstance(type, StringType) and not is_packed(type):
            return self.builder.variable(machine_type(type))
        if type.size > _LARGEST_BUFFER:
            raise NotTranslatedError(f"a variable of {type.size} bytes is on the stack")
        length = self.builder.variable(I64) if isinstance(type, StringType) else None
        return OwnBytes(self.builder.buffer(max(type.size + 7 & -8, 8)), type.size, length)

    def end_statement(self) -> None:
        """Free the buffers."""
        for size, buffer in self._borrowed_buffers:
            self._buffers[size].append(buffer)
        self._borrowed_buffers.clear()

    # values ----------------------------------------------------------------------------------

    def number(self, value: nodes.LoweredValue) -> Operand:
        """Return a value in a register."""
        operand = self.value(value)
        assert isinstance(operand, Operand)
        return operand

    def at_type(self, value: Operand, type: MachineType) -> Operand:
        """Return a value where its type has another name."""
        return value if value.type is type else self.builder.convert(value, type)

    def text(self, value: nodes.LoweredValue) -> MachineText:
        text = self.value(value)
        assert isinstance(text, MachineText)
        return text

    def steady(self, value: MachineValue, type: IecType[Any] | None) -> MachineValue:
        """Return a value that nothing changes."""
        is_steady = isinstance(value, Operand) or value.steady
        return value if is_steady else self.snapshot(value, type)

    def refuse(self, reason: str) -> MachineValue:
        """Leave the routine plain."""
        raise NotTranslatedError(reason)

    def snapshot(self, value: Any, type: IecType[Any] | None = None) -> Any:
        """Return a copy of a text or record that nothing changes."""
        b = self.builder
        if isinstance(value, MachineText):
            assert isinstance(type, StringType)
            copy = self.buffer(type.length * type.unit)
            b.copy(copy, value.address, value.length)
            return MachineText(copy, value.length, steady=True)
        assert isinstance(value, PackedBytes)
        copy = self.buffer(value.size)
        b.copy(copy, value.address, value.size)
        return PackedBytes(copy, value.size, steady=True)

    def value(self, value: nodes.LoweredValue) -> MachineValue:
        """Return a value, exactly of its type."""
        return _TRANSLATIONS[type(value)](self, value)

    def known(self, value: Known) -> MachineValue:
        """Return a constant."""
        known, type, b = value.value, value.type, self.builder
        if isinstance(known, bytes):
            address = b.module.data(known)
            if is_packed(type):
                return PackedBytes(address, len(known), steady=True)
            return MachineText(address, b.constant(I64, len(known)), steady=True)
        kind = machine_type(type)
        if kind.is_whole:
            whole = counted(type)
            cut = int(known) & (1 << 8 * whole.size) - 1
            known = cut - (1 << 8 * whole.size) if cut > whole.high else cut
        return b.constant(kind, known)

    def keep(self, value: nodes.Keep) -> MachineValue:
        """Keep a value that is needed again."""
        temporary = self.steady(self.value(value.value), value.type)
        self.temporaries[value.temporary.number] = temporary
        return temporary

    def address(self, value: nodes.PlaceAddress) -> Operand:
        """Return the address of a place, as a pointer of its type."""
        return self.at_type(self.storages.address(value.place), machine_type(value.type))

    def record(self, value: nodes.RecordValue) -> PackedBytes:
        """Return a record made on the spot."""
        b = self.builder
        parts = [(offset, self.number(part)) for offset, part in value.parts]
        record = self.buffer(len(value.image))
        b.copy(record, b.module.data(value.image), len(value.image))
        for offset, part in parts:
            b.store(part, record, offset)
        return PackedBytes(record, len(value.image), steady=True)

    def sequence(self, value: nodes.Sequence) -> MachineValue:
        """Effects and then a value."""
        for one in value.effects:
            self.value(one)
        return self.value(value.value)

    def count(self, number: int) -> Operand:
        """One more in a counter; the value is that of no one."""
        b, counts = self.builder, self.module.counts
        assert counts is not None
        b.increment(counts, number * 8)
        return b.constant(I64, 0)

    def counting_faults(self, number: int | None) -> AbstractContextManager[None]:
        """One more in a counter for each fault that leaves what is written within."""
        counts = self.module.counts
        if number is None or counts is None:
            return nullcontext()
        return self.builder.counting_faults(counts, number * 8)

    def condition_bit(self, value: nodes.ConditionBit) -> Operand:
        """Return a condition, which is a bit of a vector, too."""
        b, vector = self.builder, self._vectors[value.vector.number]
        condition = self.number(value.value)
        bit = b.multiply(b.convert(condition, I64), b.constant(I64, 1 << value.bit))
        b.set(vector, b.add(b.get(vector), bit))
        return condition

    def count_vector(self, value: nodes.CountVector) -> Operand:
        """Return a decision, and one more in the counter of its vector."""
        b, counts = self.builder, self.module.counts
        assert counts is not None
        vector = self._vectors[value.vector.number] = b.variable(I64)
        b.set(vector, b.constant(I64, 0))
        decision = self.number(value.value)
        place = b.address(counts, b.get(vector), 8, within=8 * value.first)
        b.increment(place)
        return decision

    def choice(self, value: nodes.LazyChoice) -> MachineValue:
        """One of two values; nothing of the other is evaluated."""
        b, yes, no = self.builder, value.yes, value.no
        for decided, other, is_and in ((no, yes, True), (yes, no, False)):
            if isinstance(decided, Known) and decided.value is (not is_and):
                return self._shortcut(value.condition, other, is_and=is_and)
        on_yes, on_no, end = b.label(), b.label(), b.label()
        b.branch(self.number(value.condition), on_yes, on_no)
        results: list[LocalVariable] = []
        values: list[MachineValue] = []
        for label, one in ((on_yes, yes), (on_no, no)):
            b.begin(label)
            branch = self.value(one)
            pieces = words_of(branch)
            results = results or [b.variable(piece.type) for piece in pieces]
            for variable, piece in zip(results, pieces, strict=True):
                b.set(variable, self.at_type(piece, variable.type))
            values.append(branch)
            b.jump(end)
        b.begin(end)
        first, *more = (b.get(variable) for variable in results)
        steady = all(getattr(one, "steady", True) for one in values)
        if more:
            return MachineText(first, more[0], steady)
        if isinstance(values[0], PackedBytes):
            return PackedBytes(first, values[0].size, steady)
        return first

    def _shortcut(
        self, condition: nodes.LoweredValue, other: nodes.LoweredValue, *, is_and: bool
    ) -> Operand:
        """Return the condition where it decides, else the other BOOL."""
        b = self.builder
        decided = b.variable(BOOL)
        b.set(decided, self.number(condition))
        more, end = b.label(), b.label()
        b.branch(b.get(decided), *((more, end) if is_and else (end, more)))
        b.begin(more)
        b.set(decided, self.number(other))
        b.begin(end)
        return b.get(decided)

    # conversions -----------------------------------------------------------------------------

    def converted(self, value: nodes.Convert) -> MachineValue:
        """Return a value at another type."""
        operand, type, b = value.operand, value.type, self.builder
        match value.rule:
            case Conversion.EXTEND | Conversion.CUT | Conversion.FROM_BOOL | Conversion.TO_BOOL:
                return b.convert(self.number(operand), machine_type(type))
            case Conversion.TO_REAL | Conversion.RESIZE_REAL:
                # Through 64 bits, as plain code: a large LINT is rounded twice.
                wide = b.convert(self.number(operand), F64)
                return b.convert(wide, machine_type(type))
            case Conversion.ROUND:
                wide = b.convert(self.number(operand), F64)
                (whole,) = b.call(self.module.support.rounded, wide)
                return b.convert(whole, machine_type(type))
            case Conversion.TRUNCATE:
                return self._truncated(b.convert(self.number(operand), F64), machine_type(type))
        assert isinstance(type, StringType)  # CUT_TEXT
        text = self.text(operand)
        limit = b.constant(I64, type.length * type.unit)
        fits = b.compare(Relation.LESS_EQUAL, text.length, limit)
        return MachineText(text.address, b.select(fits, text.length, limit), text.steady)

    def _truncated(self, value: Operand, type: MachineType) -> Operand:
        b = self.builder
        low = b.constant(F64, type.least - 1.0)
        high = b.constant(F64, -float(type.least))
        above = b.compare(Relation.GREATER, value, low)
        inside = b.bit_and(above, b.compare(Relation.LESS, value, high))
        return b.select(inside, b.convert(value, type), b.constant(type, type.least))

    # operators -------------------------------------------------------------------------------

    def computed(self, value: nodes.Compute) -> MachineValue:
        operator, operands, type, b = value.operator, value.operands, value.type, self.builder
        relation = _RELATIONS.get(operator)
        if relation is not None:
            return self._comparison(relation, operands)
        if operator in _TEXTS:
            return self._texts.computed(value)
        match operator:
            case Operator.SEL:
                which, no, yes = [self.value(one) for one in operands]
                assert isinstance(which, Operand)
                return self._one_of(which, yes, no)
            case Operator.MUX:
                return self._mux(operands)
            case Operator.LTIME:
                (clock,) = b.call(self.module.support.clock)
                return clock
            case Operator.TASK_INDEX:
                (number,) = b.call(self.module.support.task_index)
                return b.convert(number, machine_type(type))
            case Operator.RAISE:
                code = b.convert(self.number(operands[0]), I64)
                b.leave(self.site(FaultKind.RAISED), code)
                return code
        if isinstance(type, StringType):
            return self._best(operator, [self.value(one) for one in operands])
        if isinstance(type, BoolType):
            return self._logic(operator, [self.number(one) for one in operands])
        if isinstance(type, RealType):
            return self.reals.computed(value)
        kind = machine_type(type)
        if operator in _SHIFTS:
            number = self.at_type(self.number(operands[0]), kind)
            return self._shift(operator, number, self.number(operands[1]))
        return self._whole(operator, [self.at_type(self.number(one), kind) for one in operands])

    def _one_of(self, which: Operand, yes: MachineValue, no: MachineValue) -> MachineValue:
        """One of two values that are both there."""
        b = self.builder
        if isinstance(yes, Operand) and isinstance(no, Operand):
            return b.select(which, yes, self.at_type(no, yes.type))
        if isinstance(yes, MachineText) and isinstance(no, MachineText):
            return MachineText(
                b.select(which, yes.address, no.address),
                b.select(which, yes.length, no.length),
                yes.steady and no.steady,
            )
        assert isinstance(yes, PackedBytes)
        assert isinstance(no, PackedBytes)
        address = b.select(which, yes.address, no.address)
        return PackedBytes(address, yes.size, yes.steady and no.steady)

    def _mux(self, operands: Sequence[nodes.LoweredValue]) -> MachineValue:
        b = self.builder
        which, *values = [self.value(one) for one in operands]
        assert isinstance(which, Operand)
        selection = values[-1]
        for place in reversed(range(len(values) - 1)):
            here = b.compare(Relation.EQUAL, which, b.constant(which.type, place))
            selection = self._one_of(here, values[place], selection)
        return selection

    def _comparison(self, relation: Relation, operands: Sequence[nodes.LoweredValue]) -> Operand:
        b = self.builder
        left, right = [self.value(one) for one in operands]
        if isinstance(left, MachineText) and isinstance(right, MachineText):
            assert isinstance(operands[0].type, StringType)
            return self._texts.comparison(relation, left, right, operands[0].type.unit)
        if isinstance(left, PackedBytes) and isinstance(right, PackedBytes):
            return self._texts.comparison(relation, self._as_text(left), self._as_text(right), 1)
        assert isinstance(left, Operand)
        assert isinstance(right, Operand)
        if left.type is BOOL:
            left, right = b.convert(left, U8), b.convert(right, U8)
        return b.compare(relation, left, self.at_type(right, left.type))

    def _as_text(self, value: PackedBytes) -> MachineText:
        length = self.builder.constant(I64, value.size)
        return MachineText(value.address, length, value.steady)

    def _logic(self, operator: Operator, values: list[Operand]) -> Operand:
        b = self.builder
        if operator is Operator.NOT:
            return b.bit_not(values[0])
        return _folded(_ARITHMETIC[operator](b), values)

    def _whole(self, operator: Operator, values: list[Operand]) -> Operand:
        b = self.builder
        first = values[0]
        match operator:
            case Operator.NEG:
                return b.negate(first)
            case Operator.ABS:
                return b.absolute(first)
            case Operator.NOT:
                return b.bit_not(first)
            case Operator.MIN | Operator.MAX:
                return self.best(operator, values)
            case Operator.DIV:
                left, right = values
                if not (right.is_constant and int(right.text)):
                    there = b.compare(Relation.NOT_EQUAL, right, b.constant(right.type, 0))
                    b.require(there, self.site(FaultKind.DIVIDE))
                return b.divide(left, right)
            case Operator.MOD:
                return b.remainder(*values)
        return _folded(_ARITHMETIC[operator](b), values)

    def _shift(self, operator: Operator, value: Operand, count: Operand) -> Operand:
        b, type = self.builder, value.type
        return _SHIFTS[operator](b)(value, b.convert(count, type))

    def _best(self, operator: Operator, values: Sequence[MachineValue]) -> MachineValue:
        """MIN, MAX: the first of equals stays, as in plain code."""
        best = values[0]
        for one in values[1:]:
            best = self._better(operator, best, one)
        return best

    def _better(self, operator: Operator, best: MachineValue, new: MachineValue) -> MachineValue:
        relation = Relation.LESS if operator is Operator.MIN else Relation.GREATER
        if isinstance(best, MachineText) and isinstance(new, MachineText):
            return self._one_of(self._texts.comparison(relation, new, best, 1), new, best)
        assert isinstance(best, Operand)
        assert isinstance(new, Operand)
        return self._one_of(self.builder.compare(relation, new, best), new, best)

    def best(self, operator: Operator, values: Sequence[Operand]) -> Operand:
        """MIN and MAX of numbers."""
        operand = self._best(operator, values)
        assert isinstance(operand, Operand)
        return operand


def _folded(operation: Callable[[Operand, Operand], Operand], values: list[Operand]) -> Operand:
    result = values[0]
    for one in values[1:]:
        result = operation(result, one)
    return result


_ARITHMETIC: dict[Operator, Callable[[FunctionBuilder], Callable[..., Operand]]] = {
    Operator.ADD: lambda b: b.add,
    Operator.SUB: lambda b: b.subtract,
    Operator.MUL: lambda b: b.multiply,
    Operator.AND: lambda b: b.bit_and,
    Operator.OR: lambda b: b.bit_or,
    Operator.XOR: lambda b: b.bit_xor,
}
_SHIFTS: dict[Operator, Callable[[FunctionBuilder], Callable[..., Operand]]] = {
    Operator.SHL: lambda b: b.shift_left,
    Operator.SHR: lambda b: b.shift_right,
    Operator.ROL: lambda b: b.rotate_left,
    Operator.ROR: lambda b: b.rotate_right,
}


_TRANSLATIONS: dict[type[Any], Callable[[ExpressionTranslator, Any], MachineValue]] = {
    Known: ExpressionTranslator.known,
    nodes.Temporary: lambda of, value: of.temporaries[value.number],
    nodes.Keep: ExpressionTranslator.keep,
    nodes.LoadValue: lambda of, value: of.storages.read(value.place, spends=value.spends),
    nodes.PlaceAddress: ExpressionTranslator.address,
    nodes.Copy: lambda of, value: of.steady(of.value(value.value), value.type),
    nodes.Convert: ExpressionTranslator.converted,
    nodes.External: lambda of, value: of.outside.converted(value),
    nodes.Compute: ExpressionTranslator.computed,
    nodes.Check: lambda of, value: of.reals.check(value),
    nodes.LazyChoice: ExpressionTranslator.choice,
    nodes.Sequence: ExpressionTranslator.sequence,
    nodes.StoreValue: lambda of, value: of.storages.store(value),
    nodes.RoutineCall: lambda of, value: of.calls.call(value),
    nodes.RecordValue: ExpressionTranslator.record,
    nodes.Creation: lambda of, _: of.refuse("__NEW is done by Python"),
    nodes.RuntimeCall: lambda of, value: of.refuse(value.reason),
    nodes.ConditionBit: ExpressionTranslator.condition_bit,
    nodes.CountVector: ExpressionTranslator.count_vector,
    nodes.Count: lambda of, value: of.count(value.number),
}
